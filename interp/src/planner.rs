//! From a tool path to a verified plan.

use std::time::Instant;

use arcfeed_feedrate::{
    BothEndsScan, FeedError, FeedPlanner, FeedProblem, JerkLimited, MotionLaw, Segment, SpeedPlan, plan_joined,
    plan_joined_at_once, plan_per_segment, plan_windowed,
};
use arcfeed_geometry::{PosePath, SegmentationMethod};
use arcfeed_kinematics::{Dynamics, JointLimits, Joints};

use crate::arm::PathArm;
use crate::constraints::{Bounds, Reaches, Shares};
use crate::error::PlanError;
use crate::grid;
use crate::joint_path::{JointJet, JointPath};
use crate::limits::{ToolLimits, positive};
use crate::plan::{Fallback, MadeBy, Method, Plan, Timings};
use crate::rows;
use crate::sections::{self, FeedSection, Feeds};
use crate::speed::SpeedLaw;
use crate::torque::{TorqueLimits, TorquePath};
use crate::verify::{Requirement, Verification};
use crate::withheld;

/// Directions that turn by less than this at a knot (rad) count as smooth.
pub(crate) const CORNER: f64 = 1e-6;
/// By how much a limit may seem to be exceeded in verification through rounding.
const VERIFY_TOLERANCE: f64 = 1e-6;
/// A motion has at most this many setpoints: 1.4 hours at 1 ms, some 1.5 GB for whoever collects them all.
const MOST_SETPOINTS: f64 = 5e6;
/// What a joint's jerk means at the tool, m/rad, times the part of it that is left for a step of acceleration: a low estimate.
const STEP: f64 = 0.03;
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
///     angular_speed: None,
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
    pub(crate) torque: Option<TorqueLimits<'a, N>>,
    pub(crate) sections: Vec<FeedSection>,
    /// Speeds at the start and at the end, m/s.
    pub(crate) ends: [f64; 2],
    pub(crate) chord_tolerance: f64,
    pub(crate) period: f64,
    scan: Scan,
}

impl<'a, A, const N: usize> Planner<'a, A, N>
where
    A: PathArm<N> + ?Sized,
{
    /// A planner for `arm` under limits of its joints and of the tool, from rest to rest, with a chord tolerance of 1 um, a
    /// control period of 1 ms and the jerk-limited planner.
    ///
    /// # Errors
    /// When a limit is not a finite number above 0.
    pub fn new(arm: &'a A, joints: JointLimits<N>, tool: ToolLimits) -> Result<Self, PlanError> {
        tool.check()?;
        Ok(Self {
            arm,
            joints,
            tool,
            torque: None,
            sections: Vec::new(),
            ends: [0.0; 2],
            chord_tolerance: 1e-6,
            period: 1e-3,
            scan: Scan::JerkLimited,
        })
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

    /// Adds torque limits: the drives give at most `torque` (N m, either sign; infinite means no limit), and `dynamics` says
    /// what a motion takes, payload and friction included.
    ///
    /// ```
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// use arcfeed_interp::{Planner, ToolLimits};
    /// use arcfeed_kinematics::{Joints, models};
    ///
    /// let robot = models::description("ur5e").ok_or("built in")?.build::<6>()?;
    /// let (Some(limits), Some(dynamics), Some(torque)) =
    ///     (robot.range().with_rates(Joints::repeat(3.0), Joints::repeat(10.0), Joints::repeat(100.0)).ok(), robot.dynamics(), robot.drive_limits().torque)
    /// else {
    ///     return Err("not known".into());
    /// };
    /// let tool = ToolLimits {
    ///     feed: 0.1,
    ///     tangential_acceleration: 1.0,
    ///     tangential_jerk: 20.0,
    ///     normal_acceleration: 1.0,
    ///     normal_jerk: None,
    ///     angular_speed: None,
    /// };
    /// let planner = Planner::new(&robot, limits, tool)?.with_dynamics(dynamics, torque)?;
    /// # let _ = planner; Ok(()) }
    /// ```
    ///
    /// # Errors
    /// When a torque is not above 0.
    pub fn with_dynamics(mut self, dynamics: &'a dyn Dynamics<N>, torque: Joints<N>) -> Result<Self, PlanError> {
        self.torque = Some(TorqueLimits::new(dynamics, torque)?);
        Ok(self)
    }

    /// Gives parts of the path a feed of their own; they must not overlap. Whether they lie on the path shows when it is planned.
    pub fn with_sections(mut self, sections: Vec<FeedSection>) -> Self {
        self.sections = sections;
        self
    }

    /// Sets the speeds along the path at its start and at its end, m/s, both with no tangential acceleration; 0 is rest.
    ///
    /// # Errors
    /// [`PlanError::Feed`] for a number that is negative or not finite.
    pub fn with_end_speeds(mut self, v_start: f64, v_end: f64) -> Result<Self, PlanError> {
        for (what, value) in [("start speed", v_start), ("end speed", v_end)] {
            if !value.is_finite() {
                return Err(FeedError::NotFinite { what, value }.into());
            }
            if value < 0.0 {
                return Err(FeedError::Negative { what, value }.into());
            }
        }
        self.ends = [v_start, v_end];
        Ok(self)
    }

    /// Plans the motion along `path`, starting from the solution of the inverse nearest to `start`, and verifies it on
    /// dense samples. A plan that is returned keeps every limit.
    ///
    /// # Errors
    /// [`PlanError::Arm`] or [`PlanError::BranchChange`] where the arm cannot follow; [`PlanError::Infeasible`] where no
    /// speed keeps the limits, [`PlanError::EndSpeed`] for speeds at the ends that cannot be had, [`PlanError::Section`] and
    /// [`PlanError::SectionsOverlap`]; [`PlanError::TooLong`] for a motion of more than 5e6 setpoints;
    /// [`PlanError::Unverified`] when no plan passes verification.
    pub fn plan(&self, path: PosePath, start: &Joints<N>) -> Result<Plan<N>, PlanError> {
        let mut plan = self.draft(path, start)?;
        let longest = MOST_SETPOINTS * self.period;
        if plan.duration() > longest {
            return Err(PlanError::TooLong { duration: plan.duration(), longest });
        }
        let mut scale = 1.0;
        for round in 1..=ROUNDS {
            let begin = Instant::now();
            let verification = self.verify(&plan)?;
            plan.timings.verification += begin.elapsed();
            plan.made_by.rounds = round;
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
            self.set_speed(&mut plan, scale)?;
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
            cause: withheld::cause(self.arm, &plan, w.s, plan.feed_at(w.s, self.tool.feed)),
        }))
    }

    /// Like [`Planner::plan`], without the verification: for benchmarks, and for callers who run [`Planner::verify`]
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
        let mut sections = sections::resolve(&self.sections, &path, &breaks)?;
        timings.segmentation = begin.elapsed();

        let begin = Instant::now();
        let knots = path.knots();
        let feed =
            Feeds { elsewhere: self.tool.feed, sections: &sections }.highest().min(self.reachable(path.length()));
        // Chord segments matter to the scans, which know one box for each interval.
        let mut places = if self.scan == Scan::JerkLimited { Vec::new() } else { breaks.clone() };
        places.extend(sections.iter().flat_map(|section| [section.from, section.to]));
        let grid = grid::build(&path, &knots, &places, &self.tool.at_feed(feed), self.acceleration_step());
        sections::snap(&mut sections, &grid);
        let joint_path = JointPath::new(self.arm, &path, start, &grid, &knots)
            .map_err(|e| e.within(self.joints.lower(), self.joints.upper()))?;
        timings.joint_path = begin.elapsed();

        let stops = grid::stops(&grid, path.corners(CORNER).iter().map(|corner| corner.s));
        let mut plan = Plan {
            path,
            joint_path,
            segmentation,
            breaks,
            stops,
            sections,
            caps: Vec::new(),
            speed: SpeedLaw::Phases(SpeedPlan::chain([])),
            made_by: MadeBy { method: Method::Given, fallback: None, rounds: 0, scale: 1.0 },
            end_speeds: self.ends,
            chord_tolerance: self.chord_tolerance,
            period: self.period,
            verification: None,
            timings,
        };
        let begin = Instant::now();
        self.set_speed(&mut plan, 1.0)?;
        plan.timings.scan = begin.elapsed();
        Ok(plan)
    }

    /// Holds the setpoints of a plan, whoever made it, against all limits of this planner; see [`verify`](crate::verify).
    ///
    /// # Errors
    /// [`PlanError::Arm`] where a setpoint cannot be computed.
    pub fn verify(&self, plan: &Plan<N>) -> Result<Verification, PlanError> {
        let requirement = Requirement { torque: self.torque, ..plan.requirement(&self.tool, &self.joints) };
        plan.verify_against(self.arm, &requirement)
    }

    /// All limits of this planner as rows on the grid of `plan`: what its own jerk-limited planner takes. Without `jerk` those
    /// on jerk are left out, for planners of second order.
    ///
    /// # Errors
    /// [`PlanError::Feed`] for rows that are not finite.
    pub fn problem(&self, plan: &Plan<N>, jerk: bool) -> Result<FeedProblem, PlanError> {
        let ground = self.ground(plan);
        let bounds = self.bounds(&ground, SHARES[0], 1.0);
        Ok(rows::problem(&plan.joint_path, &ground.middles, &ground.reaches, &plan.stops, &bounds, jerk, None)?)
    }

    fn ground(&self, plan: &Plan<N>) -> Ground<N> {
        let middles = rows::middles(self.arm, &plan.path, &plan.joint_path);
        let reachable = self.reachable(plan.path.length());
        Ground {
            reaches: Reaches::of(&plan.path, &plan.joint_path, &plan.stops),
            torque: self.torque.map(|torque| TorquePath::of(&plan.joint_path, &middles, &torque)),
            middles,
            feeds: plan.feeds(self.tool.feed).into_iter().map(|feed| feed.min(reachable)).collect(),
        }
    }

    /// About the step of acceleration that the joints' jerk limits allow within a control period, at the tool, m/s^2.
    pub(crate) fn acceleration_step(&self) -> f64 {
        STEP * self.joints.jerk().min() * self.period
    }

    /// A speed that is not reached on a path of `length` (m) by accelerating over all of it, m/s. A higher feed limits
    /// nothing, and its size must not spoil the measures that are taken relative to it.
    pub(crate) fn reachable(&self, length: f64) -> f64 {
        let fastest_end = self.ends[0].max(self.ends[1]);
        2.0 * fastest_end.hypot((2.0 * self.tool.tangential_acceleration * length).sqrt())
    }

    fn bounds<'b>(&'b self, ground: &'b Ground<N>, shares: Shares, scale: f64) -> Bounds<'b, N> {
        Bounds {
            tool: &self.tool,
            joints: &self.joints,
            chord: self.chord_tolerance,
            period: self.period,
            shares,
            scale,
            feeds: &ground.feeds,
            torque: ground.torque.as_ref(),
            ends: self.ends,
        }
    }

    /// Gives the plan a motion law that uses the fraction `scale` of each limit, and the caps on the speed that go with it.
    fn set_speed(&self, plan: &mut Plan<N>, scale: f64) -> Result<(), PlanError> {
        let ground = self.ground(plan);
        let (caps, speed, method, fallback) = self.speed(plan, &ground, scale).map_err(|error| {
            let grid = |i: usize| plan.joint_path.nodes().get(i).map_or(plan.path.length(), |node| node.s);
            match error {
                PlanError::Feed(error) => PlanError::explained(error, &plan.path, grid),
                other => other,
            }
        })?;
        (plan.caps, plan.speed) = (caps, speed);
        plan.made_by = MadeBy { method, fallback, scale, ..plan.made_by };
        Ok(())
    }

    fn speed(&self, plan: &Plan<N>, ground: &Ground<N>, scale: f64) -> Result<Law, PlanError> {
        let scanned = self.scan(ground, &plan.stops, scale);
        let own = |(boxes, speed): (Vec<Segment>, SpeedPlan), fallback| {
            let method = match self.scan {
                Scan::PerSegment { .. } => Method::PerSegment,
                Scan::JerkLimited | Scan::Joined => Method::Joined,
            };
            (boxes.iter().map(Segment::v_max).collect(), SpeedLaw::Phases(speed), method, fallback)
        };
        let rows = |jerk: bool| {
            let bounds = self.bounds(ground, SHARES[0], scale);
            let make = |near: Option<&[f64]>, jerk: bool| {
                rows::problem(&plan.joint_path, &ground.middles, &ground.reaches, &plan.stops, &bounds, jerk, near)
            };
            if !(jerk && ground.torque.as_ref().is_some_and(TorquePath::is_viscous)) {
                return make(None, jerk);
            }
            // Friction that grows with the speed is made straight where the speed will be.
            let fastest = BothEndsScan.plan(&make(None, false)?)?;
            let square = |v: f64| v * v;
            let mut near: Vec<f64> = fastest.knots().map(|(_, state)| square(state.v)).collect();
            near.push(square(fastest.end().v));
            make(Some(&near), jerk)
        };
        let step = ground.reaches.first_step();
        if self.scan != Scan::JerkLimited || step.is_some() {
            // A box holds for a whole interval; the rows say it for a place.
            let scanned = scanned.map_err(|error| match error {
                PlanError::Feed(FeedError::StaticallyInfeasible { .. }) => {
                    rows(false).and_then(|rows| BothEndsScan.plan(&rows)).err().map_or(error, PlanError::Feed)
                }
                error => error,
            })?;
            let wanted = step.filter(|_| self.scan == Scan::JerkLimited);
            return Ok(own(scanned, wanted.map(|i| Fallback::AccelerationStep { s: plan.joint_path.nodes()[i].s })));
        }
        // It may not do: a stretch too short for its grid, a method that does not converge. The scan always does, and
        // where a profile of seven phases is the best there is (a straight line) it is a little faster.
        let limited = rows(true).and_then(|rows| Ok((JerkLimited::default().plan(&rows)?, rows::caps(&rows))));
        match (limited, scanned) {
            (Ok((law, _)), Ok(scanned)) if law.duration() >= scanned.1.duration() => {
                Ok(own(scanned, Some(Fallback::Slower { duration: law.duration() })))
            }
            (Ok((law, caps)), _) => Ok((caps, SpeedLaw::Grid(law), Method::JerkLimited, None)),
            (Err(error), Ok(scanned)) => Ok(own(scanned, Some(Fallback::Failed(error)))),
            // Where neither finds a motion, the rows name the limit.
            (Err(error), Err(_)) => {
                let still = rows(false).and_then(|rows| BothEndsScan.plan(&rows)).err();
                let still = still.filter(|error| matches!(error, FeedError::StaticallyInfeasible { .. }));
                Err(still.unwrap_or(error).into())
            }
        }
    }

    /// The fastest of the scans over the ways to share the limits, using the fraction `scale` of each.
    fn scan(&self, ground: &Ground<N>, stops: &[usize], scale: f64) -> Result<(Vec<Segment>, SpeedPlan), PlanError> {
        let with = |shares| ground.reaches.boxes(&self.bounds(ground, shares, scale));
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
        for (part, [v_start, v_end]) in between_stops(boxes, stops, self.ends) {
            let Some(plan) = plan_joined_at_once(part, v_start, v_end)? else { return Ok(None) };
            parts.push(plan);
        }
        Ok(Some(SpeedPlan::chain(parts)))
    }

    fn scan_thoroughly(&self, boxes: &[Segment], stops: &[usize]) -> Result<SpeedPlan, PlanError> {
        if let (Scan::PerSegment { window: Some(_) }, true) = (self.scan, self.ends[1] > 0.0) {
            return Err(PlanError::WindowEndSpeed { speed: self.ends[1] });
        }
        let parts = between_stops(boxes, stops, self.ends).map(|(part, [v_start, v_end])| match self.scan {
            Scan::Joined | Scan::JerkLimited => plan_joined(part, v_start, v_end),
            Scan::PerSegment { window: None } => plan_per_segment(part, v_start, v_end),
            Scan::PerSegment { window: Some(n) } => plan_windowed(part, v_start, n),
        });
        Ok(SpeedPlan::chain(parts.collect::<Result<Vec<_>, _>>()?))
    }
}

/// Caps on the speed, the motion law, and who made it.
type Law = (Vec<f64>, SpeedLaw, Method, Option<Fallback>);

/// What the limits of a planner are made from along one path.
struct Ground<const N: usize> {
    /// The joints in the middle of every interval.
    middles: Vec<JointJet<N>>,
    reaches: Reaches<N>,
    torque: Option<TorquePath<N>>,
    /// Programmed feed on every interval, m/s.
    feeds: Vec<f64>,
}

/// At a corner of the path the tool has to stand: the stretches between stops, each with the speeds at its ends.
fn between_stops<'b>(
    boxes: &'b [Segment],
    stops: &'b [usize],
    [v_start, v_end]: [f64; 2],
) -> impl Iterator<Item = (&'b [Segment], [f64; 2])> {
    let starts = std::iter::once((0, v_start)).chain(stops.iter().map(|&i| (i, 0.0)));
    let ends = stops.iter().map(|&i| (i, 0.0)).chain(std::iter::once((boxes.len(), v_end)));
    starts.zip(ends).map(|((from, v_start), (to, v_end))| (&boxes[from..to], [v_start, v_end]))
}
