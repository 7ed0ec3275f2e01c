//! A path made ready for a motion that is changed while it runs.

use arcfeed_feedrate::{
    FeedError, FeedProblem, IntervalBound, LiveCurve, Quantity, RowSource, Segment, SpeedLaw, live_speed,
    plan_joined_at_once,
};
use arcfeed_geometry::{PosePath, SegmentationMethod};
use arcfeed_kinematics::{JointLimits, Joints};

use crate::arm::PathArm;
use crate::derivative_bounds::bend_speed;
use crate::error::PlanError;
use crate::grid;
use crate::joint_path::{JointJet, JointPath, joint_jet};
use crate::limits::ToolLimits;
use crate::path_problem::PathProblem;
use crate::planner::{CORNER, Planner};
use crate::sections::{self, Feeds};

/// Part of every limit that the curve uses: what is left is for rounding.
const USED: f64 = 0.9999;
/// Parts of the largest tangential acceleration and jerk that are tried; the fastest choice is kept.
const PARTS: [f64; 4] = [0.15, 0.3, 0.5, 0.7];
/// Where a cap has to be lowered to less than this part of what was foretold, the interval is halved,
const FORETOLD: f64 = 0.97;
/// so often at most.
const ROUNDS: usize = 7;
/// Places inside an interval at which its cap is held against the path itself.
const LOOKS: [f64; 3] = [0.25, 0.5, 0.75];

/// A tool path with joints, and the limit curve under which it may be run whatever an operator does.
///
/// Tangential acceleration and jerk are bounded by two constants for the whole path, and at every place the speed by what leaves room for
/// both in every limit of joints and tool. That is slower than a plan made once ([`Planner::plan`]), which knows what it will do next; the
/// price buys that anything may happen in the next cycle.
#[derive(Debug, Clone)]
pub struct LivePath<const N: usize = 6> {
    path: PosePath,
    joint_path: JointPath<N>,
    curve: LiveCurve,
    joints: JointLimits<N>,
    tool: ToolLimits,
    chord_tolerance: f64,
    period: f64,
}

impl<const N: usize> LivePath<N> {
    /// The tool path.
    pub fn path(&self) -> &PosePath {
        &self.path
    }

    /// Joint values and derivatives on the planning grid.
    pub fn joint_path(&self) -> &JointPath<N> {
        &self.joint_path
    }

    /// Where the part of the path that this is begins, and where it ends, m.
    pub fn range(&self) -> (f64, f64) {
        (self.curve.start(), self.curve.end())
    }

    /// The limit curve.
    pub fn curve(&self) -> &LiveCurve {
        &self.curve
    }

    /// Limits of the joints.
    pub fn joints(&self) -> &JointLimits<N> {
        &self.joints
    }

    /// Limits of the tool; `feed` is the highest speed that any override leads to.
    pub fn tool(&self) -> &ToolLimits {
        &self.tool
    }

    /// Largest distance of the path from the straight line between two setpoints, m.
    pub fn chord_tolerance(&self) -> f64 {
        self.chord_tolerance
    }

    /// Control period, s.
    pub fn period(&self) -> f64 {
        self.period
    }
}

impl<A, const N: usize> Planner<'_, A, N>
where
    A: PathArm<N> + ?Sized,
{
    /// Makes `path` ready for [`HybridMotion`](crate::HybridMotion), from rest to rest, starting from the solution of the inverse nearest to `start`.
    ///
    /// # Errors
    /// [`PlanError::Arm`] or [`PlanError::BranchChange`] where the arm cannot follow, [`PlanError::JointRange`] where a joint leaves its
    /// range; [`Planner::route`] goes round such places. [`PlanError::Feed`] for a planner that was asked for speeds at the ends.
    pub fn live(&self, path: PosePath, start: &Joints<N>) -> Result<LivePath<N>, PlanError> {
        let to = path.length();
        self.live_between(path, start, 0.0, to)
    }

    /// The part of `path` between two arc lengths (m), made ready.
    pub(crate) fn live_between(
        &self,
        path: PosePath,
        start: &Joints<N>,
        from: f64,
        to: f64,
    ) -> Result<LivePath<N>, PlanError> {
        if let Some(&value) = self.ends.iter().find(|v| **v > 0.0) {
            let what = "speed at an end of a path that may be changed while it runs, from rest to rest";
            return Err(FeedError::AboveLimit { what, value, limit: 0.0 }.into());
        }
        let segmentation =
            path.curve().curve().segment(SegmentationMethod::Longest { across_knots: false }, self.chord_tolerance)?;
        let mut breaks: Vec<f64> = segmentation.breaks().iter().map(|&u| path.curve().arc_length_at(u)).collect();
        let sections = sections::resolve(&self.sections, &path, &breaks)?;
        let feeds = Feeds { elsewhere: self.tool.feed, sections: &sections };
        breaks.extend(sections.iter().flat_map(|section| [section.from, section.to]));
        let knots = path.knots();
        let reachable = self.reachable(path.length());
        let limits = self.tool.at_feed(feeds.highest().min(reachable));
        let mut grid = grid::build(&path, &knots, &breaks, &limits, self.acceleration_step());
        let close = 1e-9 * path.length();
        grid.retain(|&s| from + close < s && s < to - close);
        grid.insert(0, from);
        grid.push(to);
        let (lower, upper) = (self.joints.lower(), self.joints.upper());
        let mut chosen = None;
        let mut round = 0;
        let (joint_path, stops, caps, (acceleration, jerk)) = loop {
            let joint_path =
                JointPath::new(self.arm, &path, start, &grid, &knots).map_err(|e| e.within(lower, upper))?;
            check_range(&joint_path, lower, upper)?;
            let corners = path.corners(CORNER);
            let inside = corners.iter().filter(|corner| from + close < corner.s && corner.s < to - close);
            let stops = grid::stops(&grid, inside.map(|corner| corner.s));
            // At a border the lower feed counts, as borders may stand beside a grid point.
            let feed = |pair: &[f64]| feeds.at(pair[0]).min(feeds.at(pair[1])).min(feeds.at(0.5 * (pair[0] + pair[1])));
            let programmed: Vec<f64> = grid.windows(2).map(|pair| feed(pair).min(reachable)).collect();
            let terms = PathProblem::new(self.arm, &path, &joint_path, &stops, programmed, self.torque.as_ref());
            let explain = |error| PlanError::explained(error, &path, |i| grid.get(i).copied().unwrap_or(to));
            let problem = terms.rows(&self.limits(USED), true).map_err(explain)?;
            let tangential = match chosen {
                Some(known) => known,
                None => choose(&problem, &stops).map_err(explain)?,
            };
            chosen = Some(tangential);
            let mut caps = problem.live_caps(tangential.0, tangential.1).map_err(explain)?;
            let coarse = self.look_between(&path, &joint_path, tangential, &mut caps)?;
            round += 1;
            if coarse.is_empty() || round == ROUNDS {
                break (joint_path, stops, caps, tangential);
            }
            for &i in coarse.iter().rev() {
                grid.insert(i + 1, 0.5 * (grid[i] + grid[i + 1]));
            }
        };
        let curve = LiveCurve::new(&grid, &caps, &stops, acceleration, jerk)?;
        Ok(LivePath {
            path,
            joint_path,
            curve,
            joints: self.joints,
            tool: self.tool,
            chord_tolerance: self.chord_tolerance,
            period: self.period,
        })
    }

    /// Lowers caps where the path itself, between two grid points, allows less than its ends foretold. Returns the intervals where that is
    /// much: the grid is too coarse there.
    fn look_between(
        &self,
        path: &PosePath,
        joint_path: &JointPath<N>,
        (acceleration, jerk): (f64, f64),
        caps: &mut [f64],
    ) -> Result<Vec<usize>, PlanError> {
        let mut coarse = Vec::new();
        for (i, cap) in caps.iter_mut().enumerate() {
            let (start, end) = joint_path.interval(i);
            let foretold = *cap;
            for part in LOOKS {
                let h = part * (end.s - start.s);
                let tool = path.jet(start.s + h);
                let jet = joint_jet(self.arm, start.s + h, &tool, &start.ahead(h))?;
                let curvature = tool.d2.fixed_rows::<3>(0).norm();
                let bend = bend_speed(curvature, &self.tool, self.chord_tolerance, self.period, USED);
                *cap = cap.min(bend).min(live_speed(&self.bounds_at(&jet), acceleration, jerk));
            }
            if *cap < FORETOLD * foretold {
                coarse.push(i);
            }
        }
        Ok(coarse)
    }

    /// The limits of the joints at one place, as bounds.
    fn bounds_at(&self, jet: &JointJet<N>) -> Vec<IntervalBound> {
        let mut bounds = Vec::with_capacity(3 * N);
        for k in 0..N {
            let [d1, d2, d3] = [jet.d1[k].abs(), jet.d2[k].abs(), jet.d3[k].abs()];
            let limits = [self.joints.velocity()[k], self.joints.acceleration()[k], self.joints.jerk()[k]];
            let [velocity, acceleration, jerk] = limits.map(|limit| limit * USED);
            let source = |quantity| RowSource::joint(quantity, k);
            bounds.extend([
                IntervalBound::Speed { most: velocity / d1, source: source(Quantity::JointVelocity) },
                IntervalBound::Acceleration {
                    a: d1,
                    b: d2,
                    c: 0.0,
                    rest: 0.0,
                    limit: acceleration,
                    source: source(Quantity::JointAcceleration),
                },
                IntervalBound::Jerk {
                    alpha: d1,
                    beta: 3.0 * d2,
                    gamma: d3,
                    step: 0.0,
                    limit: jerk,
                    source: source(Quantity::JointJerk),
                },
            ]);
        }
        bounds
    }
}

/// Bounds of tangential acceleration and jerk for the whole path: of several choices that with the shortest motion.
fn choose(problem: &FeedProblem, stops: &[usize]) -> Result<(f64, f64), FeedError> {
    let (acceleration, jerk) = problem.rest_limits()?;
    let mut best = (f64::INFINITY, 0.5 * acceleration, 0.5 * jerk);
    for a in PARTS.map(|part| part * acceleration) {
        for j in PARTS.map(|part| part * jerk) {
            let caps = problem.live_caps(a, j)?;
            if let Some(time) = duration(problem.grid(), &caps, stops, a, j)
                && time < best.0
            {
                best = (time, a, j);
            }
        }
    }
    Ok((best.1, best.2))
}

/// How long the path takes under `caps`, or `None` where that is not known at once.
fn duration(grid: &[f64], caps: &[f64], stops: &[usize], acceleration: f64, jerk: f64) -> Option<f64> {
    let segments: Vec<Segment> = grid
        .windows(2)
        .zip(caps)
        .map(|(pair, &v)| Segment::new(pair[1] - pair[0], v, acceleration, jerk).ok())
        .collect::<Option<_>>()?;
    let starts = std::iter::once(0).chain(stops.iter().copied());
    let ends = stops.iter().copied().chain(std::iter::once(caps.len()));
    let parts: Option<Vec<SpeedLaw>> =
        starts.zip(ends).map(|(from, to)| plan_joined_at_once(&segments[from..to], 0.0, 0.0).ok().flatten()).collect();
    Some(SpeedLaw::chain(0.0, parts?).duration())
}

fn check_range<const N: usize>(
    joint_path: &JointPath<N>,
    lower: &Joints<N>,
    upper: &Joints<N>,
) -> Result<(), PlanError> {
    for jet in joint_path.nodes() {
        for joint in 0..N {
            let value = jet.q[joint];
            if !(lower[joint]..=upper[joint]).contains(&value) {
                return Err(PlanError::JointRange { s: jet.s, joint, value, lower: lower[joint], upper: upper[joint] });
            }
        }
    }
    Ok(())
}
