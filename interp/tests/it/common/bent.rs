//! Paths that bend evenly, for limits that bind everywhere.

use arcfeed_geometry::{ArcLengthCurve, NurbsCurve, OrientationPath, PosePath};
use arcfeed_interp::{JointSpline, MotionPath, PoseMove, ToolPath};
use arcfeed_kinematics::{Arm, Joints};
use nalgebra::{Isometry3, UnitQuaternion};

use crate::qb;

/// A half circle of the tool, pointing down: its curvature is the same everywhere.
pub fn half_circle(arm: &Arm<6>) -> ToolPath<'_> {
    let frame = Isometry3::translation(0.36, 0.0, 0.25);
    let arc = NurbsCurve::<3>::arc(&frame, 0.1, -0.5 * std::f64::consts::PI, std::f64::consts::PI);
    let curve = ArcLengthCurve::new(arc.expect("an arc"), 1e-15).expect("of some length");
    let down = UnitQuaternion::from_euler_angles(std::f64::consts::PI, 0.0, 0.0);
    ToolPath::new(arm, PosePath::new(curve, OrientationPath::Constant(down)), arm.range()).expect("in reach")
}

/// A spline through four points.
pub fn way_points() -> JointSpline<6> {
    JointSpline::through(&four_points()).expect("four points")
}

/// A spline through the same points, three times in turn.
pub fn rounds() -> JointSpline<6> {
    JointSpline::through(&[four_points(); 3].concat()).expect("neighbours differ")
}

fn four_points() -> [Joints<6>; 4] {
    let centre = Joints::from([0.0, -1.1, 1.5, 0.0, 0.9, 0.0]);
    let offsets = [
        [-0.4, 0.2, -0.1, 0.3, 0.2, -0.5],
        [0.1, -0.2, 0.2, -0.2, -0.3, 0.2],
        [0.4, 0.1, -0.3, 0.4, 0.1, 0.5],
        [0.0, 0.3, 0.1, -0.1, 0.4, -0.2],
    ];
    offsets.map(|offset| centre + Joints::from(offset))
}

/// Paths of every kind by their names, in reach of the arm of [`qb`](crate::qb).
pub fn paths_of_every_kind(arm: &Arm<6>) -> [(&'static str, Box<dyn MotionPath<6> + '_>); 3] {
    let pose_move = PoseMove::starting_near(arm, qb::to(), &Joints::from(qb::TO_NEAR)).expect("in reach");
    [
        ("tool path", Box::new(half_circle(arm))),
        ("pose move", Box::new(pose_move)),
        ("joint spline", Box::new(way_points())),
    ]
}
