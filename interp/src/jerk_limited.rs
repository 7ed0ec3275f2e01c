//! The speed by the jerk-limited planner: limits of tool and joints as rows on the grid of the joint path.

use arcfeed_feedrate::constraint::{
    Feed, JointAcceleration, JointJerk, JointVelocity, PathConstraint, PathDerivatives, SpeedCap, Stop,
    TangentialAcceleration, TangentialJerk,
};
use arcfeed_feedrate::{FeedError, FeedPlanner, FeedProblem, GridPlan, JerkLimited, Quantity};

use crate::constraints::{Bounds, Reaches};
use crate::joint_path::JointPath;

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

/// The fastest speed within `bounds`, jerk included; at the grid points `stops` the tool stands.
///
/// Returns the plan and the cap on the speed at every grid point (m/s).
pub(crate) fn plan<const N: usize>(
    joints: &JointPath<N>,
    reaches: &Reaches<N>,
    stops: &[usize],
    bounds: &Bounds<'_, N>,
) -> Result<(GridPlan, Vec<f64>), FeedError> {
    let grid: Vec<f64> = joints.nodes().iter().map(|jet| jet.s).collect();
    let d = Derivatives::of(joints, stops);
    let path = PathDerivatives::new(N, &d.after[0], &d.after[1])?.with_third(&d.after[2])?.with_values_before(
        &d.before[0],
        &d.before[1],
        &d.before[2],
    )?;
    let (velocity, acceleration, jerk) = (
        bounds.joints.velocity() * bounds.scale,
        bounds.joints.acceleration() * bounds.scale,
        bounds.joints.jerk() * bounds.scale,
    );
    let feed = vec![bounds.tool.feed * bounds.scale; joints.intervals()];
    let feed = Feed::new(&feed)?;
    let bends = reaches.tool_speeds(bounds);
    let bends = SpeedCap::new(&bends, Quantity::NormalAcceleration)?;
    let tangential = TangentialAcceleration::new(bounds.tool.tangential_acceleration * bounds.scale)?;
    let tangential_jerk = TangentialJerk::new(bounds.tool.tangential_jerk * bounds.scale)?;
    let velocity = JointVelocity::new(path, velocity.as_slice())?;
    let acceleration = JointAcceleration::new(path, acceleration.as_slice())?;
    let jerk = JointJerk::new(path, jerk.as_slice())?;
    let stops: Vec<Stop> = stops.iter().map(|&at| Stop { at }).collect();
    let mut constraints: Vec<&dyn PathConstraint> =
        vec![&feed, &bends, &tangential, &tangential_jerk, &velocity, &acceleration, &jerk];
    constraints.extend(stops.iter().map(|stop| stop as &dyn PathConstraint));
    let problem = FeedProblem::between_points(&grid, &constraints)?;
    let caps = (0..grid.len()).map(|i| problem.cap(i).0.sqrt()).collect();
    Ok((JerkLimited::default().plan(&problem)?, caps))
}
