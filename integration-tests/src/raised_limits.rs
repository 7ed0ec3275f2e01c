//! Random paths and limits, by seed, planned before and after one limit is raised: the motion must not get longer.

use std::f64::consts::PI;

use arcfeed_geometry::{ArcLengthCurve, NurbsCurve, OrientationPath, PosePath};
use arcfeed_interp::{JointSpline, Limits, PlanError, Planner, ToolLimits, ToolPath};
use arcfeed_kinematics::{JointLimits, Joints, ParallelAxisArm, models};
use nalgebra::{UnitQuaternion, Vector3};

use arcfeed_testing::Random;

use crate::hybrid_scenario::vector;

/// The path of a case.
#[derive(Debug, Clone)]
enum Shape {
    /// Through joint values, rad.
    Joints(Vec<Joints<6>>),
    /// A B-spline of the tool with its degree, m.
    Tool(usize, Vec<Vector3<f64>>),
}

/// Limits of the joints one by one (rad/s, rad/s^2, rad/s^3) and of the tool: feed, tangential acceleration, tangential jerk and
/// normal acceleration, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Values {
    joints: [[f64; 6]; 3],
    tool: [f64; 4],
}

/// A path, limits, and which of them is raised by which factor.
#[derive(Debug, Clone)]
pub struct RaisedLimit {
    shape: Shape,
    values: Values,
    raised: Values,
}

impl RaisedLimit {
    /// The case that belongs to `seed`.
    pub fn random(seed: u64) -> Self {
        let r = &mut Random::new(seed ^ 0x5EED_0F11);
        let of_tool = r.below(3) > 0;
        let shape = if of_tool {
            let centre = Vector3::new(r.between(0.35, 0.45), r.between(-0.15, 0.15), r.between(0.2, 0.35));
            let (size, points) = (r.log(0.004, 0.2), 5 + r.below(8));
            Shape::Tool(2 + r.below(4), (0..points).map(|_| centre + vector(r, size)).collect())
        } else {
            let middle = Joints::from_column_slice(&[0.0, -1.2, 1.4, -1.5, -1.4, 0.0]);
            let points = 3 + r.below(6);
            Shape::Joints((0..points).map(|_| middle + Joints::from_fn(|_, _| r.between(-0.6, 0.6))).collect())
        };
        let each = |r: &mut Random, from: f64, to: f64| std::array::from_fn(|_| r.log(from, to));
        let joints = [each(r, 1.0, 4.0), each(r, 4.0, 20.0), each(r, 40.0, 800.0)];
        let values = Values { joints, tool: [r.log(0.01, 1.0), r.log(0.5, 5.0), r.log(5.0, 100.0), r.log(0.5, 5.0)] };
        let (mut raised, factor, joint) = (values, r.between(1.0, 3.0), r.below(6));
        match r.below(if of_tool { 10 } else { 6 }) {
            i @ 0..3 => raised.joints[i] = raised.joints[i].map(|limit| limit * factor),
            i @ 3..6 => raised.joints[i - 3][joint] *= factor,
            i => raised.tool[i - 6] *= factor,
        }
        Self { shape, values, raised }
    }

    /// The durations before and after, s, or why there is none; `None` for a path or limits that are refused.
    pub fn durations(&self) -> Option<Result<[f64; 2], PlanError>> {
        let arm = models::ur5e();
        let before = match self.duration(&arm, &self.values)? {
            Err(PlanError::Path(_) | PlanError::Limit(_)) => return None,
            before => before,
        };
        let after = self.duration(&arm, &self.raised)?;
        Some(before.and_then(|before| Ok([before, after?])))
    }

    fn duration(&self, arm: &ParallelAxisArm, values: &Values) -> Option<Result<f64, PlanError>> {
        let [v, a, j] = values.joints.map(|limits| Joints::from_column_slice(&limits));
        let limits = arm.range().with_rates(v, a, j).ok()?;
        Some(match &self.shape {
            Shape::Joints(points) => {
                let path = JointSpline::through(points).ok()?;
                Planner::new(arm, Limits::new(limits)).plan(&path).map(|plan| plan.duration())
            }
            Shape::Tool(degree, points) => {
                let path = tool_path(arm, &limits, *degree, points)?;
                let tool = tool_limits(values.tool)?;
                Planner::new(arm, Limits::new(limits).with_tool(tool)).plan(&path).map(|plan| plan.duration())
            }
        })
    }
}

fn tool_limits([feed, tangential, tangential_jerk, normal]: [f64; 4]) -> Option<ToolLimits> {
    ToolLimits::new()
        .with_feed(feed)
        .and_then(|tool| tool.with_tangential_acceleration(tangential))
        .and_then(|tool| tool.with_tangential_jerk(tangential_jerk))
        .and_then(|tool| tool.with_normal_acceleration(normal))
        .ok()
}

fn tool_path<'a>(
    arm: &'a ParallelAxisArm,
    limits: &JointLimits<6>,
    degree: usize,
    points: &[Vector3<f64>],
) -> Option<ToolPath<'a>> {
    let pieces = points.len().checked_sub(degree)?.max(1);
    let degree = points.len() - pieces;
    let mut knots = vec![0.0; degree + 1];
    knots.extend((1..pieces).map(|i| i as f64));
    knots.extend(vec![pieces as f64; degree + 1]);
    let curve = NurbsCurve::bspline(degree, points.to_vec(), knots).ok()?;
    let down = UnitQuaternion::from_euler_angles(PI, 0.0, 0.0);
    let path = PosePath::new(ArcLengthCurve::new(curve, 1e-15).ok()?, OrientationPath::Constant(down));
    ToolPath::new(arm, path, limits.range()).ok()
}
