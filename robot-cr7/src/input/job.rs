//! Jobs: what is to be done with a path, in SI units, checked.
//!
//! The file format is TOML with the units in the names of the keys; `jobs/butterfly.toml` ([`Job::EXAMPLE`]) shows every
//! key with its default.

use std::path::PathBuf;

use arcfeed_interp::{FeedSection, LimitTable, Method, Oscillator, TableKind};
use arcfeed_kinematics::Posture;
use nalgebra::{Isometry3, Unit, UnitQuaternion, Vector3};

use super::joint_values::{JointOverrides, JointValues};
use super::rapid_moves::RapidMoves;
use super::toml_check::rotation;
use super::unit::LengthUnit;

/// The orientation of the tool along the path, in the workpiece frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ToolOrientation {
    /// The same all the way.
    Constant(UnitQuaternion<f64>),
    /// From one orientation to another, in step with the arc length, by the shorter way.
    Slerp {
        /// At the start of the path.
        from: UnitQuaternion<f64>,
        /// At its end.
        to: UnitQuaternion<f64>,
    },
    /// The tool's z axis along `axis`, its x axis as near to the path's tangent as that allows.
    Tangent {
        /// Direction of the tool's z axis.
        axis: Unit<Vector3<f64>>,
    },
}

/// Limits of the tool tip along the path, all above 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FeedLimits {
    /// Feed in m/s.
    pub feed: f64,
    /// Tangential acceleration in m/s^2.
    pub tangential_acceleration: f64,
    /// Tangential jerk in m/s^3.
    pub tangential_jerk: f64,
    /// Normal (centripetal) acceleration in m/s^2.
    pub normal_acceleration: f64,
    /// Normal jerk in m/s^3, if it is limited.
    pub normal_jerk: Option<f64>,
    /// Magnitude of the acceleration vector in m/s^2, if it is limited.
    pub tool_acceleration: Option<f64>,
    /// Magnitude of the jerk vector in m/s^3, if it is limited.
    pub tool_jerk: Option<f64>,
    /// Angular speed of the tool in rad/s, if it is limited.
    pub angular_speed: Option<f64>,
    /// Speeds at the start and at the end of the path in m/s; 0 is rest.
    pub end_speeds: [f64; 2],
}

/// Torque in a job: that it is limited at all, by what, and the load of the arm.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TorqueJob {
    /// Greatest torques in N m, where they replace those of the arm's model.
    pub limit: Option<JointValues>,
    /// Torques in N m that the drives give for ever, if they are known.
    pub rated: Option<JointValues>,
    /// The load at the flange.
    pub payload: Option<Payload>,
}

/// A limit of joints that depends on their speed or their position.
#[derive(Debug, Clone, PartialEq)]
pub struct TableJob {
    /// Which joint, from 0; all where there is none.
    pub joint: Option<usize>,
    /// What it limits, and by what.
    pub kind: TableKind,
    /// The limits, for the payload of the job.
    pub table: LimitTable,
}

/// A structure that a motion excites.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VibrationJob {
    /// The joint that carries it, from 0; the tool where there is none.
    pub joint: Option<usize>,
    /// Its natural frequency and damping.
    pub oscillator: Oscillator,
    /// Largest deflection after the end of the motion, rad or m, if it is limited.
    pub limit: Option<f64>,
}

/// A body at the flange.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Payload {
    /// Mass in kg.
    pub mass: f64,
    /// Centre of mass in the frame of the flange in m.
    pub centre: Vector3<f64>,
}

/// A checked job, in SI units.
#[derive(Debug, Clone, PartialEq)]
pub struct Job {
    /// Path file, relative names taken from the folder of the job file; `None` where the job names none.
    pub path_file: Option<PathBuf>,
    /// Unit of CSV files whose header names none, of programs before G20 or G21, and of drawings that name none.
    pub csv_unit: Option<LengthUnit>,
    /// Largest distance between the points of a CSV file and the curve laid through them, in m.
    pub fit_tolerance: f64,
    /// True where the points of a CSV file are the corners of a polyline, and not those of a smooth curve.
    pub polyline: bool,
    /// By how much a smooth curve may leave the lines between its points, in m; a quarter of their length where the job does not say.
    pub bulge: Option<f64>,
    /// Runs of short lines in a program become smooth curves within this distance of them, in m; `None` for that of blends. A program that
    /// states its own (G64 P Q) overrules it.
    pub smooth: Option<f64>,
    /// Largest distance of a blended corner from the programmed path, in m; `None` where the tool stops in corners. A program that states
    /// its own (G61, G64 P) overrules it.
    pub blend: Option<f64>,
    /// Largest turn of the tool away from the programmed orientation where its rate would jump, in rad.
    pub blend_angle: f64,
    /// The layers of a drawing that are followed; empty for all of them.
    pub layers: Vec<String>,
    /// How far the tool goes up between two contours of a drawing, in m.
    pub lift: f64,
    /// The arm starts in the configuration nearest to these joint values, in rad. Without them it starts in the one that stays farthest from singular poses and the ends of joint ranges along
    /// the path.
    pub start_near: Option<JointValues>,
    /// The arm starts in a configuration of this posture.
    pub start_posture: Option<Posture>,
    /// Workpiece frame (the frame of the path) in the base frame.
    pub workpiece: Isometry3<f64>,
    /// Tool tip in the flange frame.
    pub tool: Isometry3<f64>,
    /// Orientation of the tool along the path, in the workpiece frame.
    pub orientation: ToolOrientation,
    /// Limits of the tool tip.
    pub feed: FeedLimits,
    /// How the rapid moves of a program are made.
    pub rapid: RapidMoves,
    /// Parts of the path with a feed of their own.
    pub sections: Vec<FeedSection>,
    /// Limits of the joints, where they differ from the model's.
    pub joints: JointOverrides,
    /// Limits of the joints that depend on their speed or their position, beside the others.
    pub tables: Vec<TableJob>,
    /// Structures that the motion excites.
    pub vibrations: Vec<VibrationJob>,
    /// Limits of the torque; `None` leaves it out of account.
    pub torque: Option<TorqueJob>,
    /// Chord tolerance in m.
    pub chord_tolerance: f64,
    /// Control period in s.
    pub period: f64,
    /// Whether the motion lasts a whole number of control periods.
    pub whole_cycles: bool,
    /// Which planner finds the speed.
    pub method: Method,
    /// Values that are allowed but look like a slip of the unit.
    pub warnings: Vec<String>,
}

impl Default for Job {
    /// The job of the first run: tool down, butterfly-sized paths 0.4 m in front of the base; the values stand in
    /// `jobs/butterfly.toml`.
    fn default() -> Self {
        Self {
            path_file: None,
            csv_unit: None,
            fit_tolerance: 1e-6,
            polyline: false,
            bulge: None,
            layers: Vec::new(),
            lift: 5e-3,
            start_near: None,
            start_posture: None,
            smooth: None,
            blend: None,
            blend_angle: 0.05 / (180.0 / std::f64::consts::PI),
            workpiece: Isometry3::translation(0.4, -0.05, 0.2),
            tool: Isometry3::identity(),
            orientation: ToolOrientation::Constant(rotation([180.0, 0.0, 0.0])),
            feed: FeedLimits {
                feed: 0.1,
                tangential_acceleration: 1.0,
                tangential_jerk: 20.0,
                normal_acceleration: 1.0,
                normal_jerk: None,
                tool_acceleration: None,
                tool_jerk: None,
                angular_speed: None,
                end_speeds: [0.0; 2],
            },
            rapid: RapidMoves::default(),
            sections: Vec::new(),
            joints: JointOverrides::default(),
            tables: Vec::new(),
            vibrations: Vec::new(),
            torque: None,
            chord_tolerance: 1e-6,
            period: 1e-3,
            whole_cycles: false,
            method: Method::JerkLimited,
            warnings: Vec::new(),
        }
    }
}
