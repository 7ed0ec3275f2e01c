//! A path with an arm of seven joints.

use crate::common;

use arcfeed_interp::{Limits, LockedArm, PathArm, Planner, ToolPath};
use arcfeed_kinematics::{Arm, ForwardKinematics, InverseKinematics, Joints, ToolDerivatives, models};
use common::{knotted, tool, tool_down};

#[test]
fn a_seventh_joint_stands_still_and_the_tool_follows_the_path() {
    let arm = Arm::from(models::panda());
    let path = tool_down(knotted());
    let (locked, start) = LockedArm::for_path(&arm, &path).expect("in reach");
    let (joint, value) = locked.held();
    let limits =
        arm.range().with_rates(Joints::repeat(2.0), Joints::repeat(8.0), Joints::repeat(200.0)).expect("valid limits");
    let curve = path.curve().clone();
    let followed = ToolPath::starting_near(&locked, path, &start).expect("in reach");
    let planner = Planner::new(&locked, Limits::new(limits).with_tool(tool()));
    let plan = planner.plan(&followed).expect("it can be followed");
    let mut worst = 0.0f64;
    for setpoint in plan.setpoints(1e-3).expect("a period") {
        let at = setpoint.expect("on the path");
        assert_eq!((at.q[joint], at.qd[joint], at.jerk[joint]), (value, 0.0, 0.0));
        // The whole arm, not the six joints that were planned with.
        let tool = arm.forward(&at.q);
        worst = worst.max((tool.translation.vector - curve.point(at.s)).norm());
        assert!(arm.range().contains(&at.q));
    }
    assert!(worst < 1e-9, "{worst}");
}

#[test]
fn derivatives_are_those_of_the_inverse() {
    let arm = Arm::from(models::panda());
    let path = tool_down(knotted());
    let (locked, start) = LockedArm::for_path(&arm, &path).expect("in reach");
    let (s, h) = (0.4 * path.length(), 1e-4);
    let q = |s: f64| locked.inverse(&path.jet(s).pose, &start).expect("in reach");
    let jet = path.jet(s);
    let at = q(s);
    let d = locked
        .derivatives(&at, &ToolDerivatives { first: jet.d1, second: jet.d2, third: jet.d3 })
        .expect("no singular pose");
    let first = (q(s + h) - q(s - h)) / (2.0 * h);
    let second = (q(s + h) - at * 2.0 + q(s - h)) / (h * h);
    assert!((first - d.first).amax() < 1e-5 * (1.0 + d.first.amax()), "{first} {}", d.first);
    assert!((second - d.second).amax() < 1e-3 * (1.0 + d.second.amax()), "{second} {}", d.second);
}
