//! A path on its grid with everything that its limits are made from: computed once, asked for rows as often as it takes.

use arcfeed_feedrate::constraint::{
    Feed, JointAcceleration, JointJerk, JointVelocity, PathConstraint, PathDerivatives, SpeedCap, Stop,
    TangentialAcceleration, TangentialJerk,
};
use arcfeed_feedrate::{FeedError, FeedProblem, Quantity};
use arcfeed_geometry::PosePath;
use arcfeed_kinematics::{JointLimits, Joints};

use crate::arm::PathArm;
use crate::derivative_bounds::{DerivativeBounds, bend_speed};
use crate::joint_path::{JointJet, JointPath, joint_jet};
use crate::limits::ToolLimits;
use crate::torque::{TorqueLimits, TorquePath};

/// Part of the joints' jerk that is left for what three places of an interval do not tell of the rest of it: so much less than the
/// grid costs that it does not show, and a second round of planning is seldom needed.
const BETWEEN: f64 = 2e-4;

/// The limits along a path.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PathLimits<'a, const N: usize> {
    pub tool: &'a ToolLimits,
    pub joints: &'a JointLimits<N>,
    /// Chord error between two control cycles, m.
    pub chord: f64,
    /// Control period, s.
    pub period: f64,
    /// Speeds at both ends of the path, m/s.
    pub ends: [f64; 2],
    /// Fraction of every limit that is used (1, or a little less when a check asks for it).
    pub scale: f64,
}

/// What does not depend on how much of the limits is used.
#[derive(Debug, Clone)]
pub(crate) struct PathProblem<const N: usize> {
    grid: Vec<f64>,
    stops: Vec<usize>,
    /// Programmed feed on every interval, m/s.
    feeds: Vec<f64>,
    /// Derivatives of the joints by arc length, joint by joint: just after every grid point, just before it, in the middle of every
    /// interval; first, second, third.
    after: [Vec<f64>; 3],
    before: [Vec<f64>; 3],
    middle: [Vec<f64>; 3],
    bounds: DerivativeBounds<N>,
    torque: Option<TorquePath<N>>,
}

impl<const N: usize> PathProblem<N> {
    /// `joints` follow `path`; at the grid points `stops` the tool stands.
    pub fn new<A>(
        arm: &A,
        path: &PosePath,
        joints: &JointPath<N>,
        stops: &[usize],
        feeds: Vec<f64>,
        torque: Option<&TorqueLimits<'_, N>>,
    ) -> Self
    where
        A: PathArm<N> + ?Sized,
    {
        let middles = middles(arm, path, joints);
        let [after, before] = sides(joints, stops);
        let flat = |of: fn(&JointJet<N>) -> &Joints<N>| -> Vec<f64> {
            middles.iter().flat_map(|jet| of(jet).iter().copied()).collect()
        };
        Self {
            grid: joints.nodes().iter().map(|jet| jet.s).collect(),
            stops: stops.to_vec(),
            feeds,
            after,
            before,
            middle: [flat(|jet| &jet.d1), flat(|jet| &jet.d2), flat(|jet| &jet.d3)],
            bounds: DerivativeBounds::of(path, joints, stops),
            torque: torque.map(|torque| TorquePath::of(joints, &middles, torque)),
        }
    }

    /// The limits as rows, caps and interval bounds on the grid. Without `jerk` there are none on jerk, and a jump of a joint's
    /// acceleration is no matter.
    ///
    /// # Errors
    /// [`FeedError::BadRow`] for numbers that are not finite.
    pub fn rows(&self, limits: &PathLimits<'_, N>, jerk: bool) -> Result<FeedProblem, FeedError> {
        let (tool, scale) = (limits.tool, limits.scale);
        let [d1, d2, d3] = self.bounds.joints();
        let steps = self.bounds.steps(limits.period);
        let [after, before, middle] = [&self.after, &self.before, &self.middle];
        let path = PathDerivatives::new(N, &after[0], &after[1])?
            .with_third(&after[2])?
            .with_values_before(&before[0], &before[1], &before[2])?
            .with_middles(&middle[0], &middle[1])?
            .with_third_in_middles(&middle[2])?
            .with_bounds([&d1, &d2, &d3])?
            .with_steps(&steps)?;
        let velocity = limits.joints.velocity() * scale;
        let acceleration = limits.joints.acceleration() * scale;
        let joint_jerk = limits.joints.jerk() * scale;
        let feeds: Vec<f64> = self.feeds.iter().map(|feed| feed * scale).collect();
        let bends =
            self.bounds.bend_speeds(&self.feeds, |kappa| bend_speed(kappa, tool, limits.chord, limits.period, scale));
        let turns = tool.angular_speed.map(|limit| self.bounds.turn_speeds(&self.feeds, limit * scale));

        let feed = Feed::new(&feeds)?;
        let bends = SpeedCap::new(&bends[0], Quantity::NormalAcceleration)?.with_intervals(&bends[1])?;
        let turns = match &turns {
            Some([points, intervals]) => {
                Some(SpeedCap::new(points, Quantity::AngularSpeed)?.with_intervals(intervals)?)
            }
            None => None,
        };
        let tangential = TangentialAcceleration::new(tool.tangential_acceleration * scale)?;
        let tangential_jerk = TangentialJerk::new(tool.tangential_jerk * scale)?;
        let velocity = JointVelocity::new(path, velocity.as_slice())?;
        let acceleration = JointAcceleration::new(path, acceleration.as_slice())?;
        let joint_jerk = JointJerk::new(path, joint_jerk.as_slice())?.with_margin(BETWEEN)?;
        let torque = self.torque.as_ref().map(|torque| torque.rows(scale));
        let stops: Vec<Stop> = self.stops.iter().map(|&at| Stop { at }).collect();

        let mut constraints: Vec<&dyn PathConstraint> = vec![&feed, &bends, &tangential, &velocity, &acceleration];
        if jerk {
            constraints.extend([&tangential_jerk as &dyn PathConstraint, &joint_jerk]);
        }
        constraints.extend(turns.iter().map(|turns| turns as &dyn PathConstraint));
        constraints.extend(torque.iter().map(|torque| torque as &dyn PathConstraint));
        constraints.extend(stops.iter().map(|stop| stop as &dyn PathConstraint));
        FeedProblem::between_points(&self.grid, &constraints)?.with_end_speeds(limits.ends[0], limits.ends[1])
    }
}

/// Joint derivatives just after and just before every grid point.
fn sides<const N: usize>(joints: &JointPath<N>, stops: &[usize]) -> [[Vec<f64>; 3]; 2] {
    let points = joints.nodes().len();
    let empty = || std::array::from_fn(|_| Vec::with_capacity(points * N));
    let (mut after, mut before): ([Vec<f64>; 3], [Vec<f64>; 3]) = (empty(), empty());
    for i in 0..points {
        let (left, right) = joints.sides(i);
        // At a smooth knot both sides are the same but for rounding, which must not count as a corner or a jump.
        let (first, second) = if stops.contains(&i) { (&left.d1, &left.d2) } else { (&right.d1, &right.d2) };
        for (list, values) in after.iter_mut().zip([&right.d1, &right.d2, &right.d3]) {
            list.extend_from_slice(values.as_slice());
        }
        for (list, values) in before.iter_mut().zip([first, second, &left.d3]) {
            list.extend_from_slice(values.as_slice());
        }
    }
    [after, before]
}

/// Joint values and derivatives in the middle of every interval.
fn middles<A, const N: usize>(arm: &A, path: &PosePath, joints: &JointPath<N>) -> Vec<JointJet<N>>
where
    A: PathArm<N> + ?Sized,
{
    let one = |k: usize| {
        let (a, b) = joints.interval(k);
        let h = 0.5 * (b.s - a.s);
        let q = (a.ahead(h) + b.ahead(-h)) / 2.0;
        joint_jet(arm, a.s + h, &path.jet(a.s + h), &q).unwrap_or_else(|_| {
            // The arm stands at both ends; where the solution in between is lost, what they foretell will do.
            let first = |jet: &JointJet<N>, h: f64| jet.d1 + (jet.d2 + jet.d3 * (h / 2.0)) * h;
            let d2 = (a.d2 + a.d3 * h + b.d2 - b.d3 * h) / 2.0;
            JointJet { s: a.s + h, q, d1: (first(a, h) + first(b, -h)) / 2.0, d2, d3: (a.d3 + b.d3) / 2.0 }
        })
    };
    (0..joints.intervals()).map(one).collect()
}
