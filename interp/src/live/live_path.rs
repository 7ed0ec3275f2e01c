//! A path made ready for a motion that is changed while it runs.

use std::sync::Arc;

use arcfeed_feedrate::{
    FeedError, FeedProblem, IntervalBound, LimitId, Quantity, Segment, SpeedLaw, VelocityLimitCurve, live_speed,
    plan_continuous_at_once,
};
use arcfeed_kinematics::{JointLimits, Joints};

use super::error::LiveError;
use crate::error::{PlanError, SpeedError};
use crate::limits::ToolLimits;
use crate::path::{JointJet, JointPath, KnownJoints, MotionPath, ToolPath};
use crate::planner::Planner;
use crate::problem::{Held, LimitFractions, PathGrid, PathProblem, RowsNeeded, suits};

/// Part of every limit that the curve uses: what is left is for rounding.
const USED: f64 = 0.9999;
/// Parts of the largest tangential acceleration and jerk that are tried; the fastest choice is kept.
const PARTS: [f64; 4] = [0.15, 0.3, 0.5, 0.7];
/// An interval is halved where its cap has to be lowered to less than this part of what was foretold,
const FORETOLD: f64 = 0.97;
/// so often at most.
const ROUNDS: usize = 7;
/// Places inside an interval at which its cap is held against the path itself.
const LOOKS: [f64; 3] = [0.25, 0.5, 0.75];

/// A tool path with joints, and the limit curve under which it may be run whatever an operator does.
///
/// Tangential acceleration and tangential jerk have one bound each for the whole path. The speed has a bound at every place, such that
/// every limit of joints and tool holds for all accelerations and jerks inside those two. A plan made once ([`Planner::plan`]) is faster,
/// because it knows the motion ahead; here the motion may change in every cycle.
#[derive(Debug, Clone)]
pub struct LivePath<'p, const N: usize = 6> {
    path: Arc<ToolPath<'p, N>>,
    problem: PathProblem<'p, N>,
    curve: VelocityLimitCurve,
}

impl<'p, const N: usize> LivePath<'p, N> {
    /// The path of the tool.
    pub fn path(&self) -> &ToolPath<'p, N> {
        &self.path
    }

    /// The path on its grid with its limits.
    pub fn problem(&self) -> &PathProblem<'p, N> {
        &self.problem
    }

    /// Joint values and derivatives on the planning grid.
    pub fn joint_path(&self) -> &JointPath<N> {
        self.problem.joint_path()
    }

    /// Start and end of the part of the path that this is, m.
    pub fn range(&self) -> (f64, f64) {
        (self.curve.start(), self.curve.end())
    }

    /// The limit curve.
    pub fn curve(&self) -> &VelocityLimitCurve {
        &self.curve
    }

    /// Limits of the joints.
    pub fn joints(&self) -> &JointLimits<N> {
        self.problem.limits().joints()
    }

    /// Limits of the tool; `feed` is the highest speed that any override leads to.
    pub fn tool(&self) -> &ToolLimits {
        self.problem.limits().tool()
    }

    /// Largest distance of the path from the straight line between two setpoints, m.
    pub fn chord_tolerance(&self) -> f64 {
        self.problem.settings.chord_tolerance
    }

    /// Control period, s.
    pub fn period(&self) -> f64 {
        self.problem.settings.period
    }
}

impl<'a, const N: usize> Planner<'a, N> {
    /// Makes `path` ready for [`HybridMotion`](crate::HybridMotion), from rest to rest.
    ///
    /// # Errors
    /// [`PathError::Arm`](crate::PathError::Arm) or [`PathError::BranchChange`](crate::PathError::BranchChange) where the arm cannot follow, [`PathError::JointRange`](crate::PathError::JointRange) where a joint leaves its
    /// range; [`Planner::route`] goes round such places. [`SpeedError::Feed`](crate::SpeedError::Feed) for a planner that was asked for speeds at the ends.
    pub fn live<'p>(&self, path: ToolPath<'p, N>) -> Result<LivePath<'p, N>, LiveError>
    where
        'a: 'p,
    {
        let (start, to) = (path.start(), path.length());
        self.live_between(Arc::new(path), &start, 0.0, to)
    }

    /// The part of `path` between two arc lengths (m), made ready; `start` are the joints where it begins.
    pub(super) fn live_between<'p>(
        &self,
        path: Arc<ToolPath<'p, N>>,
        start: &Joints<N>,
        from: f64,
        to: f64,
    ) -> Result<LivePath<'p, N>, LiveError>
    where
        'a: 'p,
    {
        let settings = self.settings();
        if let Some(&value) = settings.ends.iter().find(|v| **v > 0.0) {
            let what = "speed at an end of a path that may be changed while it runs, from rest to rest";
            return Err(SpeedError::from(FeedError::AboveLimit { what, value, limit: 0.0 }).into());
        }
        suits(settings, &*path)?;
        let whole = PathGrid::lay(settings, &*path, true)?;
        let close = 1e-9 * path.length();
        let mut grid = whole.grid.clone();
        grid.retain(|&s| from + close < s && s < to - close);
        grid.insert(0, from);
        grid.push(to);
        let (used, limits) = (LimitFractions::uniform(USED), settings.limits.joints());
        let (lower, upper) = (limits.lower(), limits.upper());
        let mut chosen = None;
        let mut round = 0;
        loop {
            let joints = JointPath::follow_from(&*path, start, &grid).map_err(|e| e.within(lower, upper))?;
            joints.check_range(&*path, limits.range())?;
            let layout = PathGrid { grid: grid.clone(), ..whole.clone() };
            let held = Held::Shared(Arc::clone(&path) as Arc<dyn MotionPath<N> + 'p>);
            let problem = PathProblem::of(settings, held, layout, joints, RowsNeeded::Jerk, KnownJoints::none());
            let rows = problem.rows_within(&used, RowsNeeded::Jerk)?;
            let explained = |error| LiveError::from(problem.explained(error));
            let tangential = match chosen {
                Some(known) => known,
                None => choose(&rows, problem.stop_points()).map_err(explained)?,
            };
            chosen = Some(tangential);
            let mut caps = rows.live_caps(tangential.0, tangential.1).map_err(explained)?;
            let coarse = look_between(&path, &problem, tangential, &mut caps)?;
            round += 1;
            if coarse.is_empty() || round == ROUNDS {
                let (acceleration, jerk) = tangential;
                let curve = VelocityLimitCurve::new(&grid, &caps, problem.stop_points(), acceleration, jerk);
                return Ok(LivePath { path, curve: curve.map_err(explained)?, problem });
            }
            for &i in coarse.iter().rev() {
                grid.insert(i + 1, 0.5 * (grid[i] + grid[i + 1]));
            }
        }
    }
}

/// Lowers caps where the path itself, between two grid points, allows less than its ends foretold. Returns the intervals where that is
/// much: the grid is too coarse there.
fn look_between<const N: usize>(
    path: &ToolPath<'_, N>,
    problem: &PathProblem<'_, N>,
    (acceleration, jerk): (f64, f64),
    caps: &mut [f64],
) -> Result<Vec<usize>, PlanError> {
    let mut coarse = Vec::new();
    let bends = problem.bend_limits(&LimitFractions::uniform(USED));
    for (i, cap) in caps.iter_mut().enumerate() {
        let (start, end) = problem.joint_path().interval(i);
        let foretold = *cap;
        for part in LOOKS {
            let h = part * (end.s - start.s);
            let jet = path.jet(start.s + h, &start.ahead(h))?;
            let curvature = path.pose_path().jet(start.s + h).d2.fixed_rows::<3>(0).norm();
            let by_joints = live_speed(&bounds_at(&jet, problem.limits().joints()), acceleration, jerk);
            *cap = cap.min(bends.speed(curvature)).min(by_joints);
        }
        if *cap < FORETOLD * foretold {
            coarse.push(i);
        }
    }
    Ok(coarse)
}

/// The limits of the joints at one place, as bounds.
fn bounds_at<const N: usize>(jet: &JointJet<N>, limits: &JointLimits<N>) -> Vec<IntervalBound> {
    let mut bounds = Vec::with_capacity(3 * N);
    for k in 0..N {
        let [d1, d2, d3] = [jet.d1[k].abs(), jet.d2[k].abs(), jet.d3[k].abs()];
        let [velocity, acceleration, jerk] =
            [limits.velocity()[k], limits.acceleration()[k], limits.jerk()[k]].map(|limit| limit * USED);
        let source = |quantity| LimitId::joint(quantity, k);
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

/// The duration of the path under `caps`, or `None` where that is not known at once.
fn duration(grid: &[f64], caps: &[f64], stops: &[usize], acceleration: f64, jerk: f64) -> Option<f64> {
    let segments: Vec<Segment> = grid
        .windows(2)
        .zip(caps)
        .map(|(pair, &v)| Segment::new(pair[1] - pair[0], v, acceleration, jerk).ok())
        .collect::<Option<_>>()?;
    let starts = std::iter::once(0).chain(stops.iter().copied());
    let ends = stops.iter().copied().chain(std::iter::once(caps.len()));
    let parts: Option<Vec<SpeedLaw>> = starts
        .zip(ends)
        .map(|(from, to)| plan_continuous_at_once(&segments[from..to], 0.0, 0.0).ok().flatten())
        .collect();
    Some(SpeedLaw::chain(0.0, parts?).duration())
}
