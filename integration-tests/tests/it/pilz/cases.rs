//! The data of the Pilz cases: poses, commands, sequences, and the paths that commands of the tool describe.

use std::collections::BTreeMap;

use arcfeed_geometry::{ArcLengthCurve, ArcTo, JoinedPath, JoinedPathBuilder, OrientationPath, PosePath};
use arcfeed_interp::Limits;
use arcfeed_kinematics::{Arm, ArmDescription, JointRange, Joints, models};
use nalgebra::{Isometry3, Quaternion, Translation3, Unit, UnitQuaternion, Vector3};
use serde::Deserialize;

const CASES: &str = include_str!("../../data/pilz_cases.json");
/// The planner there knows no jerk: here the full acceleration is reached in a twentieth of a second.
pub const RISE: f64 = 0.05;

#[derive(Deserialize)]
pub struct File {
    pub cartesian: Cartesian,
    pub panda: Robot,
    pub prbt: Robot,
}

/// Limits of the tool point.
#[derive(Deserialize, Clone, Copy)]
pub struct Cartesian {
    pub v: f64,
    pub a: f64,
}

#[derive(Deserialize)]
pub struct Robot {
    arm: Option<serde_json::Value>,
    pub v: Vec<f64>,
    pub a: Vec<f64>,
    /// How far joints and poses, printed with six digits, may lie apart.
    pub precision: f64,
    pub poses: BTreeMap<String, Pose>,
    pub commands: BTreeMap<String, Command>,
    pub sequences: BTreeMap<String, Vec<(String, f64)>>,
}

#[derive(Deserialize)]
pub struct Pose {
    pub joints: Vec<f64>,
    pub xyz: Option<[f64; 3]>,
    xyzw: Option<[f64; 4]>,
}

#[derive(Deserialize)]
pub struct Command {
    pub kind: String,
    pub from: String,
    pub to: String,
    interim: Option<String>,
    centre: Option<String>,
    pub vel: f64,
    pub acc: f64,
}

pub fn cases() -> File {
    serde_json::from_str(CASES).expect("valid cases")
}

pub fn panda() -> Arm<7> {
    models::description("panda").expect("built in").build().expect("seven joints")
}

pub fn prbt(robot: &Robot) -> Arm<6> {
    let text = robot.arm.as_ref().expect("an arm").to_string();
    ArmDescription::from_json(&text).and_then(|arm| arm.build()).expect("six joints")
}

impl Robot {
    pub fn joints<const N: usize>(&self, pose: &str) -> Joints<N> {
        Joints::from_column_slice(&self.poses[pose].joints)
    }

    pub fn pose(&self, name: &str) -> Isometry3<f64> {
        let pose = &self.poses[name];
        let ([x, y, z, w], xyz) = (pose.xyzw.expect("a pose"), pose.xyz.expect("a pose"));
        Isometry3::from_parts(Translation3::from(xyz), UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)))
    }

    /// Limits of the joints, of which commands of joints take a share.
    pub fn limits<const N: usize>(&self, range: &JointRange<N>, (v, a): (f64, f64)) -> Limits<'static, N> {
        let v = Joints::from_column_slice(&self.v) * v;
        let a = Joints::from_column_slice(&self.a) * a;
        Limits::new(range.with_rates(v, a, a / RISE).expect("valid limits"))
    }

    /// The path of the tool point for commands that follow one another.
    pub fn programmed(&self, commands: &[&Command]) -> JoinedPath {
        let at = |name: &str| self.pose(name).translation.vector;
        let mut path = JoinedPathBuilder::new(at(&commands[0].from), 1e-6).expect("a start");
        for (i, command) in commands.iter().enumerate() {
            let (from, to) = (at(&command.from), at(&command.to));
            let piece = match (&command.interim, &command.centre) {
                (Some(interim), _) => path.arc(&through(from, at(interim), to), i),
                (_, Some(centre)) => {
                    let centre = at(centre);
                    let normal = Unit::new_normalize((from - centre).cross(&(to - centre)));
                    path.arc(&ArcTo::new(centre, normal, to), i)
                }
                _ => path.line_to(to, i),
            };
            piece.unwrap_or_else(|error| panic!("{} to {}: {error}", command.from, command.to));
        }
        path.build().expect("a path")
    }

    /// The way of the tool along `path`, through the orientations of the poses that the commands name.
    pub fn pose_path(&self, path: &JoinedPath, commands: &[&Command]) -> PosePath {
        let curve = ArcLengthCurve::new(path.to_curve().expect("a curve"), 1e-12).expect("of some length");
        let ends = commands.iter().map(|command| &command.to);
        let poses: Vec<_> = std::iter::once(&commands[0].from).chain(ends).map(|name| self.pose(name)).collect();
        let turns = poses.windows(2).any(|w| w[0].rotation.angle_to(&w[1].rotation) > 1e-9);
        if !turns {
            return PosePath::new(curve, OrientationPath::Constant(poses[0].rotation));
        }
        let length = curve.length();
        let nearest = |pose: &Isometry3<f64>| {
            let places = (0..=1000).map(|k| length * f64::from(k) / 1000.0);
            let away = |s: &f64| (curve.point(*s) - pose.translation.vector).norm();
            places.min_by(|a, b| away(a).total_cmp(&away(b))).expect("not empty")
        };
        let last = poses.len() - 1;
        let place = |i: usize| match i {
            0 => 0.0,
            i if i == last => length,
            i => nearest(&poses[i]),
        };
        let keys: Vec<_> = poses.iter().enumerate().map(|(i, pose)| (place(i), pose.rotation)).collect();
        PosePath::new(curve, OrientationPath::through(&keys).expect("increasing"))
    }
}

/// The arc from `a` over `b` to `c`.
fn through(a: Vector3<f64>, b: Vector3<f64>, c: Vector3<f64>) -> ArcTo {
    let (u, w) = (b - a, c - a);
    let normal = u.cross(&w);
    let centre =
        a + (w.norm_squared() * normal.cross(&u) - u.norm_squared() * normal.cross(&w)) / (2.0 * normal.norm_squared());
    ArcTo::new(centre, Unit::new_normalize(normal), c)
}
