//! From a tool path to a verified plan.

use std::time::{Duration, Instant};

use arcfeed_feedrate::{
    MotionLaw, Segment, SpeedPlan, plan_joined, plan_joined_at_once, plan_per_segment, plan_windowed,
};
use arcfeed_geometry::{PosePath, Segmentation, SegmentationMethod};
use arcfeed_kinematics::{JointLimits, Joints};

use crate::arm::PathArm;
use crate::constraints::{Bounds, Reaches, Shares};
use crate::error::PlanError;
use crate::grid;
use crate::jerk_limited;
use crate::joint_path::JointPath;
use crate::limits::{ToolLimits, positive};
use crate::sampler::Sampler;
use crate::speed::SpeedLaw;
use crate::verify::{Requirement, Verification, verify};

/// Directions that turn by less than this at a knot (rad) count as smooth.
pub(crate) const CORNER: f64 = 1e-6;
/// By how much a limit may seem to be exceeded in verification through rounding.
const VERIFY_TOLERANCE: f64 = 1e-6;
/// How often a plan that fails its verification is planned again with tighter bounds.
const ROUNDS: usize = 4;

/// Ways to share the coupled limits between speed, acceleration and jerk; the planner tries all and keeps the fastest
/// plan. They cost one scan each.
const SHARES: [Shares; 4] = [
    Shares { acceleration: 0.4, jerk: 0.3, speed: 0.6 },
    Shares { acceleration: 0.4, jerk: 0.4, speed: 0.5 },
    Shares { acceleration: 0.4, jerk: 0.3, speed: 0.8 },
    Shares { acceleration: 0.4, jerk: 0.5, speed: 0.5 },
];

/// How the speed is scanned along the path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Scan {
    /// The least time under all limits at once, by an interior-point method: the default. Where the joints' accelerations
    /// have to step (the curvature of the path jumps, or the turning of the tool) [`Scan::Joined`] is used.
    JerkLimited,
    /// One jerk-limited profile between the speed minima, each limit shared out between speed, acceleration and jerk
    /// by fixed parts: a third of the computing time, a longer motion.
    Joined,
    /// One S-profile per segment with zero acceleration at each boundary (Liu et al. 2023, algorithm 2), looking
    /// `window` segments ahead, or to the end of the path.
    PerSegment {
        /// Look-ahead in segments; `None` for the whole path.
        window: Option<usize>,
    },
}

/// Plans motions of one arm along tool paths.
///
/// ```no_run
/// # fn example(path: arcfeed_geometry::PosePath) -> Result<(), Box<dyn std::error::Error>> {
/// use arcfeed_interp::{Planner, ToolLimits, best_start};
/// use arcfeed_kinematics::{Joints, models};
///
/// let arm = models::ur5e();
/// let limits = arm.range().with_rates(Joints::repeat(3.0), Joints::repeat(10.0), Joints::repeat(100.0))?;
/// let tool = ToolLimits {
///     feed: 0.1,
///     tangential_acceleration: 1.0,
///     tangential_jerk: 20.0,
///     normal_acceleration: 1.0,
///     normal_jerk: None,
/// };
/// let planner = Planner::new(&arm, limits, tool)?;
/// let start = best_start(&arm, &path, limits.lower(), limits.upper())?;
/// let plan = planner.plan(path, &start)?;
/// for setpoint in plan.sampler(&arm, 1e-3)? {
///     let q = setpoint?.q;
///     // send q to the controller
/// }
/// # Ok(()) }
/// ```
#[derive(Debug, Clone)]
pub struct Planner<'a, A: ?Sized, const N: usize = 6> {
    pub(crate) arm: &'a A,
    pub(crate) joints: JointLimits<N>,
    pub(crate) tool: ToolLimits,
    pub(crate) chord_tolerance: f64,
    pub(crate) period: f64,
    scan: Scan,
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

impl<'a, A, const N: usize> Planner<'a, A, N>
where
    A: PathArm<N> + ?Sized,
{
    /// A planner for `arm` under limits of its joints and of the tool, with a chord tolerance of 1 um, a control period
    /// of 1 ms and the jerk-limited planner.
    ///
    /// # Errors
    /// When a limit is not a finite number above 0.
    pub fn new(arm: &'a A, joints: JointLimits<N>, tool: ToolLimits) -> Result<Self, PlanError> {
        tool.check()?;
        Ok(Self { arm, joints, tool, chord_tolerance: 1e-6, period: 1e-3, scan: Scan::JerkLimited })
    }

    /// Sets the chord tolerance, m: how far the straight line between two setpoints, and the chord of a segment, may lie
    /// from the path.
    ///
    /// # Errors
    /// When it is not a finite number above 0.
    pub fn with_chord_tolerance(mut self, tolerance: f64) -> Result<Self, PlanError> {
        positive("chord tolerance", tolerance)?;
        self.chord_tolerance = tolerance;
        Ok(self)
    }

    /// Sets the control period, s.
    ///
    /// # Errors
    /// When it is not a finite number above 0.
    pub fn with_period(mut self, period: f64) -> Result<Self, PlanError> {
        positive("control period", period)?;
        self.period = period;
        Ok(self)
    }

    /// Sets the way the speed is scanned.
    pub fn with_scan(mut self, scan: Scan) -> Self {
        self.scan = scan;
        self
    }

    /// Plans the motion along `path` from rest to rest, starting from the solution of the inverse nearest to `start`, and
    /// verifies it on dense samples. A plan that is returned keeps every limit.
    ///
    /// # Errors
    /// [`PlanError::Arm`] or [`PlanError::BranchChange`] where the arm cannot follow; [`PlanError::Unverified`] when no
    /// plan passes verification.
    pub fn plan(&self, path: PosePath, start: &Joints<N>) -> Result<Plan<N>, PlanError> {
        let mut plan = self.draft(path, start)?;
        let mut scale = 1.0;
        for _ in 0..ROUNDS {
            let begin = Instant::now();
            let verification = plan.verify(self.arm, &self.tool, &self.joints)?;
            plan.timings.verification += begin.elapsed();
            if verification.holds(VERIFY_TOLERANCE) {
                plan.verification = Some(verification);
                return Ok(plan);
            }
            let worst = verification.worst();
            plan.verification = Some(verification);
            if !(worst.ratio.is_finite() && scale > 0.5) {
                break;
            }
            // Bounds between grid points are estimates; where they were too wide all are tightened by as much.
            scale *= 0.999 / worst.ratio.min(1.5);
            let begin = Instant::now();
            let reaches = Reaches::of(&plan.path, &plan.joint_path, &plan.stops);
            (plan.caps, plan.speed) = self.speed(&plan.joint_path, &reaches, &plan.stops, scale)?;
            plan.timings.scan += begin.elapsed();
        }
        let worst = plan.verification.as_ref().map(Verification::worst);
        Err(worst.map_or(PlanError::Limit { what: "verification", value: f64::NAN }, |w| PlanError::Unverified {
            quantity: match w.joint {
                Some(joint) => format!("{} of joint {}", w.quantity.name(), joint + 1),
                None => w.quantity.name().to_owned(),
            },
            ratio: w.ratio,
            s: w.s,
            t: w.t,
        }))
    }

    /// Like [`Planner::plan`], without the verification: for benchmarks, and for callers who run [`Plan::verify`]
    /// themselves.
    ///
    /// # Errors
    /// As [`Planner::plan`].
    pub fn draft(&self, path: PosePath, start: &Joints<N>) -> Result<Plan<N>, PlanError> {
        let mut timings = Timings::default();
        let begin = Instant::now();
        let segmentation =
            path.curve().curve().segment(SegmentationMethod::Longest { across_knots: false }, self.chord_tolerance)?;
        let breaks: Vec<f64> = segmentation.breaks().iter().map(|&u| path.curve().arc_length_at(u)).collect();
        timings.segmentation = begin.elapsed();

        let begin = Instant::now();
        let knots = path.knots();
        let grid = grid::build(&path, &knots, &breaks, &self.tool);
        let joint_path = JointPath::new(self.arm, &path, start, &grid, &knots)
            .map_err(|e| e.within(self.joints.lower(), self.joints.upper()))?;
        timings.joint_path = begin.elapsed();

        let stops: Vec<usize> =
            path.corners(CORNER).iter().map(|corner| grid.partition_point(|&s| s < corner.s)).collect();
        let begin = Instant::now();
        let reaches = Reaches::of(&path, &joint_path, &stops);
        let (caps, speed) = self.speed(&joint_path, &reaches, &stops, 1.0)?;
        timings.scan = begin.elapsed();
        Ok(Plan {
            path,
            joint_path,
            segmentation,
            breaks,
            stops,
            caps,
            speed,
            chord_tolerance: self.chord_tolerance,
            period: self.period,
            verification: None,
            timings,
        })
    }

    fn bounds(&self, shares: Shares, scale: f64) -> Bounds<'_, N> {
        Bounds {
            tool: &self.tool,
            joints: &self.joints,
            chord: self.chord_tolerance,
            period: self.period,
            shares,
            scale,
        }
    }

    /// The motion law using the fraction `scale` of each limit, and the cap on the speed on each interval.
    fn speed(
        &self,
        joint_path: &JointPath<N>,
        reaches: &Reaches<N>,
        stops: &[usize],
        scale: f64,
    ) -> Result<(Vec<f64>, SpeedLaw), PlanError> {
        let (boxes, scanned) = self.scan(reaches, stops, scale)?;
        if self.scan == Scan::JerkLimited && !reaches.have_steps() {
            // It may not do: a stretch too short for its grid, a method that does not converge. The scan always does, and
            // where a profile of seven phases is the best there is (a straight line) it is a little faster.
            let bounds = self.bounds(SHARES[0], scale);
            if let Ok((plan, caps)) = jerk_limited::plan(joint_path, reaches, stops, &bounds)
                && plan.duration() < scanned.duration()
            {
                return Ok((caps, SpeedLaw::Grid(plan)));
            }
        }
        Ok((boxes.iter().map(Segment::v_max).collect(), SpeedLaw::Phases(scanned)))
    }

    /// The fastest of the scans over the ways to share the limits, using the fraction `scale` of each.
    fn scan(&self, reaches: &Reaches<N>, stops: &[usize], scale: f64) -> Result<(Vec<Segment>, SpeedPlan), PlanError> {
        let with = |shares| reaches.boxes(&self.bounds(shares, scale));
        // The joined scans that go through at once are the quick ones, and the fastest plans are among them; the thorough
        // scan is for where none does.
        let mut best: Option<(Vec<Segment>, SpeedPlan)> = None;
        for shares in SHARES {
            let boxes = with(shares)?;
            if let Some(speed) = self.scan_at_once(&boxes, stops)?
                && best.as_ref().is_none_or(|b| speed.duration() < b.1.duration())
            {
                best = Some((boxes, speed));
            }
        }
        if let Some(best) = best {
            return Ok(best);
        }
        let boxes = with(SHARES[0])?;
        let speed = self.scan_thoroughly(&boxes, stops)?;
        Ok((boxes, speed))
    }

    fn scan_at_once(&self, boxes: &[Segment], stops: &[usize]) -> Result<Option<SpeedPlan>, PlanError> {
        if matches!(self.scan, Scan::PerSegment { .. }) {
            return self.scan_thoroughly(boxes, stops).map(Some);
        }
        let mut parts = Vec::with_capacity(stops.len() + 1);
        for part in between_stops(boxes, stops) {
            let Some(plan) = plan_joined_at_once(part, 0.0, 0.0)? else { return Ok(None) };
            parts.push(plan);
        }
        Ok(Some(SpeedPlan::chain(parts)))
    }

    fn scan_thoroughly(&self, boxes: &[Segment], stops: &[usize]) -> Result<SpeedPlan, PlanError> {
        let parts = between_stops(boxes, stops).map(|part| match self.scan {
            Scan::Joined | Scan::JerkLimited => plan_joined(part, 0.0, 0.0),
            Scan::PerSegment { window: None } => plan_per_segment(part, 0.0, 0.0),
            Scan::PerSegment { window: Some(n) } => plan_windowed(part, 0.0, n),
        });
        Ok(SpeedPlan::chain(parts.collect::<Result<Vec<_>, _>>()?))
    }
}

/// At a corner of the path the tool has to stand: the stretches from rest to rest.
fn between_stops<'b>(boxes: &'b [Segment], stops: &'b [usize]) -> impl Iterator<Item = &'b [Segment]> {
    let starts = std::iter::once(0).chain(stops.iter().copied());
    let ends = stops.iter().copied().chain(std::iter::once(boxes.len()));
    starts.zip(ends).map(|(from, to)| &boxes[from..to])
}

/// A motion along a path: where, how fast, and with which joints.
#[derive(Debug, Clone)]
pub struct Plan<const N: usize = 6> {
    path: PosePath,
    joint_path: JointPath<N>,
    segmentation: Segmentation,
    breaks: Vec<f64>,
    stops: Vec<usize>,
    /// Highest speed from each grid point to the next.
    caps: Vec<f64>,
    speed: SpeedLaw,
    chord_tolerance: f64,
    period: f64,
    verification: Option<Verification>,
    timings: Timings,
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

    /// The limit curve: arc length at which an interval starts (m), highest speed on it (m/s).
    pub fn limit_curve(&self) -> impl ExactSizeIterator<Item = (f64, f64)> + '_ {
        self.joint_path.nodes().iter().zip(&self.caps).map(|(node, &cap)| (node.s, cap))
    }

    /// The motion law s(t).
    pub fn speed(&self) -> &SpeedLaw {
        &self.speed
    }

    /// Duration, s.
    pub fn duration(&self) -> f64 {
        self.speed.duration()
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

    /// Holds the plan's setpoints against limits; see [`verify`].
    ///
    /// # Errors
    /// [`PlanError::Arm`] where a setpoint cannot be computed.
    pub fn verify<A>(&self, arm: &A, tool: &ToolLimits, joints: &JointLimits<N>) -> Result<Verification, PlanError>
    where
        A: PathArm<N> + ?Sized,
    {
        let requirement =
            Requirement { path: &self.path, tool, joints, chord_tolerance: self.chord_tolerance, period: self.period };
        let mut sampler = self.sampler(arm, self.period)?;
        verify(arm, &requirement, self.duration(), |t| sampler.at(t))
    }
}
