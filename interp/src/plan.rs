//! A planned motion: where, how fast, with which joints, and who planned it.

use std::fmt;
use std::time::Duration;

use arcfeed_feedrate::{Fallback, SpeedLaw};
use arcfeed_geometry::{PosePath, Segmentation};
use arcfeed_kinematics::JointLimits;

use crate::arm::PathArm;
use crate::error::PlanError;
use crate::joint_path::JointPath;
use crate::limits::{ToolLimits, positive};
use crate::sampler::Sampler;
use crate::sections::{Feeds, Section};
use crate::verify::{Requirement, Verification, verify};

/// Who made the speed law of a plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Method {
    /// The least time under all limits at once, jerk included.
    JerkLimited,
    /// The scan that joins jerk-limited profiles between the speed minima.
    Joined,
    /// One S-profile per segment.
    PerSegment,
    /// A law from elsewhere: [`Plan::with_speed`].
    Given,
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::JerkLimited => "jerk-limited",
            Self::Joined => "joined scan",
            Self::PerSegment => "scan per segment",
            Self::Given => "given law",
        })
    }
}

/// Who made a plan, and how.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MadeBy {
    /// The planner whose law it is.
    pub method: Method,
    /// Why it is not the jerk-limited planner's; `None` where it is, or where another one was asked for.
    pub fallback: Option<Fallback>,
    /// How often it was planned until its verification passed.
    pub rounds: usize,
    /// The fraction of every limit that the last round planned with.
    pub scale: f64,
}

impl fmt::Display for MadeBy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.method)?;
        match &self.fallback {
            Some(reason) => write!(f, " instead of jerk-limited: {reason}"),
            None => Ok(()),
        }
    }
}

/// How long the parts of planning took.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Timings {
    /// Cutting the path into chord segments.
    pub segmentation: Duration,
    /// Inverse kinematics and derivatives along the path.
    pub joint_path: Duration,
    /// Bounds and scans.
    pub scan: Duration,
    /// Verification on dense samples.
    pub verification: Duration,
}

/// A motion along a path: where, how fast, and with which joints.
#[derive(Debug, Clone)]
pub struct Plan<const N: usize = 6> {
    pub(crate) path: PosePath,
    pub(crate) joint_path: JointPath<N>,
    pub(crate) segmentation: Segmentation,
    pub(crate) breaks: Vec<f64>,
    pub(crate) stops: Vec<usize>,
    pub(crate) sections: Vec<Section>,
    /// Highest speed from each grid point to the next.
    pub(crate) caps: Vec<f64>,
    pub(crate) speed: SpeedLaw,
    pub(crate) made_by: MadeBy,
    pub(crate) end_speeds: [f64; 2],
    pub(crate) chord_tolerance: f64,
    pub(crate) period: f64,
    pub(crate) verification: Option<Verification>,
    pub(crate) timings: Timings,
}

impl<const N: usize> Plan<N> {
    /// The tool path.
    pub fn path(&self) -> &PosePath {
        &self.path
    }

    /// Joint values and derivatives on the planning grid.
    pub fn joint_path(&self) -> &JointPath<N> {
        &self.joint_path
    }

    /// The chord segments of the curve, by its own parameter.
    pub fn segmentation(&self) -> &Segmentation {
        &self.segmentation
    }

    /// Arc lengths where the chord segments begin and end, m.
    pub fn breaks(&self) -> &[f64] {
        &self.breaks
    }

    /// Arc lengths of the corners inside the path, where the tool stops, m.
    pub fn stops(&self) -> impl ExactSizeIterator<Item = f64> + '_ {
        self.stops.iter().map(|&i| self.joint_path.nodes()[i].s)
    }

    /// Sections with a feed of their own, in their order on the path.
    pub fn sections(&self) -> &[Section] {
        &self.sections
    }

    /// The limit curve: arc length at which an interval starts (m), highest speed on it (m/s).
    pub fn limit_curve(&self) -> impl ExactSizeIterator<Item = (f64, f64)> + '_ {
        self.joint_path.nodes().iter().zip(&self.caps).map(|(node, &cap)| (node.s, cap))
    }

    /// The motion law s(t).
    pub fn speed(&self) -> &SpeedLaw {
        &self.speed
    }

    /// Which planner made the motion law, and why not the one that was asked for.
    pub fn made_by(&self) -> MadeBy {
        self.made_by
    }

    /// The same path with another motion law, not verified: for the comparison of planners. The law has to run from 0 to
    /// the length of the path.
    pub fn with_speed(&self, speed: SpeedLaw) -> Self {
        let made_by = MadeBy { method: Method::Given, fallback: None, ..self.made_by };
        Self { speed, made_by, verification: None, ..self.clone() }
    }

    /// Duration, s.
    pub fn duration(&self) -> f64 {
        self.speed.duration()
    }

    /// Speeds at the start and at the end of the path that were asked for, m/s.
    pub fn end_speeds(&self) -> [f64; 2] {
        self.end_speeds
    }

    /// Chord tolerance that was planned for, m.
    pub fn chord_tolerance(&self) -> f64 {
        self.chord_tolerance
    }

    /// Control period that was planned for, s.
    pub fn period(&self) -> f64 {
        self.period
    }

    /// The verification that the plan passed; `None` for a draft.
    pub fn verification(&self) -> Option<&Verification> {
        self.verification.as_ref()
    }

    /// How long the parts of planning took.
    pub fn timings(&self) -> Timings {
        self.timings
    }

    /// Setpoints for `arm` (the one the plan was made for) at the control `period`, s.
    ///
    /// # Errors
    /// When the period is not a finite number above 0.
    pub fn sampler<'a, A>(&'a self, arm: &'a A, period: f64) -> Result<Sampler<'a, A, N>, PlanError>
    where
        A: PathArm<N> + ?Sized,
    {
        positive("control period", period)?;
        Ok(Sampler::new(self, arm, period))
    }

    /// Holds the plan's setpoints against limits; see [`verify`]. Torque is not looked at: [`crate::Planner::verify`] does.
    ///
    /// # Errors
    /// [`PlanError::Arm`] where a setpoint cannot be computed.
    pub fn verify<A>(&self, arm: &A, tool: &ToolLimits, joints: &JointLimits<N>) -> Result<Verification, PlanError>
    where
        A: PathArm<N> + ?Sized,
    {
        self.verify_against(arm, &self.requirement(tool, joints))
    }

    /// What the plan has to keep beside limits of tool and joints: path, sections, speeds at the ends, tolerances.
    pub(crate) fn requirement<'a>(&'a self, tool: &'a ToolLimits, joints: &'a JointLimits<N>) -> Requirement<'a, N> {
        Requirement {
            sections: &self.sections,
            end_speeds: self.end_speeds,
            ..Requirement::new(&self.path, tool, joints, self.chord_tolerance, self.period)
        }
    }

    pub(crate) fn verify_against<A>(&self, arm: &A, requirement: &Requirement<'_, N>) -> Result<Verification, PlanError>
    where
        A: PathArm<N> + ?Sized,
    {
        let mut sampler = self.sampler(arm, self.period)?;
        verify(arm, requirement, self.duration(), |t| sampler.at(t))
    }

    /// Programmed feed at the arc length `s` (m), where it is `elsewhere` (m/s) outside the sections.
    pub fn feed_at(&self, s: f64, elsewhere: f64) -> f64 {
        Feeds { elsewhere, sections: &self.sections }.at(s)
    }

    /// Programmed feed on every interval of the grid, `elsewhere` (m/s) outside the sections.
    pub(crate) fn feeds(&self, elsewhere: f64) -> Vec<f64> {
        let feeds = Feeds { elsewhere, sections: &self.sections };
        let nodes = self.joint_path.nodes();
        nodes.windows(2).map(|pair| feeds.at(0.5 * (pair[0].s + pair[1].s))).collect()
    }
}
