//! Limits of tool and joints as rows on the grid of the joint path: what the planners of the feedrate crate take.

use arcfeed_feedrate::constraint::{
    Feed, JointAcceleration, JointJerk, JointVelocity, PathConstraint, PathDerivatives, Place, RowSink, SpeedCap, Stop,
    TangentialAcceleration, TangentialJerk, Within,
};
use arcfeed_feedrate::{FeedError, FeedProblem, JerkRow, Quantity, RowSource};
use arcfeed_geometry::PosePath;
use arcfeed_kinematics::Joints;

use crate::arm::PathArm;
use crate::constraints::{Bounds, Reaches};
use crate::joint_path::{JointJet, JointPath, joint_jet};

/// Part of the joints' jerk that is left for what three places of an interval do not tell of the rest of it: so much less than the
/// grid costs that it does not show, and a second round of planning is seldom needed.
const BETWEEN: f64 = 2e-4;

/// Joint derivatives of a path, one row per grid point, as the planner takes them.
struct Derivatives {
    after: [Vec<f64>; 3],
    before: [Vec<f64>; 3],
}

impl Derivatives {
    fn of<const N: usize>(joints: &JointPath<N>, stops: &[usize]) -> Self {
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
        Self { after, before }
    }
}

/// Joint values and derivatives in the middle of every interval.
pub(crate) fn middles<A, const N: usize>(arm: &A, path: &PosePath, joints: &JointPath<N>) -> Vec<JointJet<N>>
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

/// Jerk of the joints with the third derivatives in the middle of every interval as they are: in between three places bend
/// less than two foretell.
struct JerkThrough<'a, const N: usize> {
    ends: JointJerk<'a>,
    middles: &'a [JointJet<N>],
    limits: &'a Joints<N>,
}

impl<const N: usize> PathConstraint for JerkThrough<'_, N> {
    fn points(&self) -> Option<usize> {
        self.ends.points()
    }

    fn rows(&self, place: Place, out: &mut RowSink<'_>) {
        self.ends.rows(place, out);
    }

    fn jerk_rows(&self, k: usize, h: f64, within: Within, out: &mut Vec<JerkRow>) {
        if within != Within::Middle {
            return self.ends.jerk_rows(k, h, within, out);
        }
        let jet = &self.middles[k];
        out.extend((0..N).filter(|&j| self.limits[j].is_finite()).map(|j| JerkRow {
            alpha: jet.d1[j],
            beta: 3.0 * jet.d2[j],
            gamma: jet.d3[j],
            limit: self.limits[j],
            source: RowSource::joint(Quantity::JointJerk, j),
        }));
    }
}

/// The limits of `bounds` as rows on the grid of the joint path; at the grid points `stops` the tool stands.
///
/// Without `jerk` there are no limits on jerk, and a jump of a joint's acceleration is no matter. With squared speeds `near` no row
/// has a term in the speed itself: see [`crate::torque::TorquePath::rows`].
pub(crate) fn problem<const N: usize>(
    joints: &JointPath<N>,
    middles: &[JointJet<N>],
    reaches: &Reaches<N>,
    stops: &[usize],
    bounds: &Bounds<'_, N>,
    jerk: bool,
    near: Option<&[f64]>,
) -> Result<FeedProblem, FeedError> {
    let grid: Vec<f64> = joints.nodes().iter().map(|jet| jet.s).collect();
    let d = Derivatives::of(joints, stops);
    let path = PathDerivatives::new(N, &d.after[0], &d.after[1])?.with_third(&d.after[2])?.with_values_before(
        &d.before[0],
        &d.before[1],
        &d.before[2],
    )?;
    let flat = |of: fn(&JointJet<N>) -> &Joints<N>| -> Vec<f64> {
        middles.iter().flat_map(|jet| of(jet).iter().copied()).collect()
    };
    let (first, second) = (flat(|jet| &jet.d1), flat(|jet| &jet.d2));
    let path = path.with_middles(&first, &second)?;
    let (velocity, acceleration, joint_jerk) = (
        bounds.joints.velocity() * bounds.scale,
        bounds.joints.acceleration() * bounds.scale,
        bounds.joints.jerk() * (bounds.scale * (1.0 - BETWEEN)),
    );
    let feed: Vec<f64> = bounds.feeds.iter().map(|feed| feed * bounds.scale).collect();
    let feed = Feed::new(&feed)?;
    let bends = reaches.tool_speeds(bounds);
    let bends = SpeedCap::new(&bends, Quantity::NormalAcceleration)?;
    let turns = reaches.turn_speeds(bounds);
    let turns = turns.as_deref().map(|turns| SpeedCap::new(turns, Quantity::AngularSpeed)).transpose()?;
    let tangential = TangentialAcceleration::new(bounds.tool.tangential_acceleration * bounds.scale)?;
    let tangential_jerk = TangentialJerk::new(bounds.tool.tangential_jerk * bounds.scale)?;
    let velocity = JointVelocity::new(path, velocity.as_slice())?;
    let acceleration = JointAcceleration::new(path, acceleration.as_slice())?;
    let ends = JointJerk::new(path, joint_jerk.as_slice())?;
    let joint_jerk = JerkThrough { ends, middles, limits: &joint_jerk };
    let torque = bounds.torque.map(|torque| torque.rows(bounds.scale, bounds.feeds, near));
    let stops: Vec<Stop> = stops.iter().map(|&at| Stop { at }).collect();
    let mut constraints: Vec<&dyn PathConstraint> = vec![&feed, &bends, &tangential, &velocity, &acceleration];
    if jerk {
        constraints.extend([&tangential_jerk as &dyn PathConstraint, &joint_jerk]);
    }
    constraints.extend(turns.iter().map(|turns| turns as &dyn PathConstraint));
    constraints.extend(torque.iter().map(|torque| torque as &dyn PathConstraint));
    constraints.extend(stops.iter().map(|stop| stop as &dyn PathConstraint));
    FeedProblem::between_points(&grid, &constraints)?.with_end_speeds(bounds.ends[0], bounds.ends[1])
}

/// The greatest speed at every grid point by its caps alone (m/s).
pub(crate) fn caps(problem: &FeedProblem) -> Vec<f64> {
    (0..problem.grid().len()).map(|i| problem.cap(i).0.sqrt()).collect()
}
