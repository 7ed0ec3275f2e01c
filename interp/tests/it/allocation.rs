//! Sampling allocates nothing, from the first setpoint on.

use crate::common;
use crate::qb;

use std::hint::black_box;

use arcfeed_testing::Counting;

use arcfeed_interp::{JointSpline, Method, MotionPath, Planner, PoseMove};
use arcfeed_kinematics::Joints;
use common::{analytic, arm, by_length, down, knotted, line_and_arc, plan_path, tool_down};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn sampling_allocates_nothing() {
    use arcfeed_geometry::{OrientationPath, PosePath};
    use nalgebra::{UnitQuaternion, Vector3};

    let arm = arm();
    let slerp = {
        let curve = by_length(analytic());
        let last = UnitQuaternion::from_scaled_axis(Vector3::z() * 0.5) * down();
        let turning = OrientationPath::slerp(curve.length(), down(), last).expect("a length above 0");
        PosePath::new(curve, turning)
    };
    for path in [tool_down(knotted()), slerp, tool_down(line_and_arc(0.05, 0.04))] {
        let plan = plan_path(&arm, path, common::tool()).expect("in reach");
        // The sampler itself, its first setpoint, all the others, the `None` at the end.
        let before = Counting::count();
        let mut sampler = plan.setpoints(1e-3).expect("a valid period");
        let mut sum = 0.0;
        for setpoint in sampler.by_ref() {
            sum += black_box(setpoint).expect("on the path").q.sum();
        }
        assert!(sampler.next().is_none());
        for i in (0..100).rev() {
            sum += black_box(sampler.at(plan.duration() * f64::from(i) / 99.0)).expect("on the path").q.sum();
        }
        assert_eq!(Counting::count() - before, 0);
        assert!(sum.is_finite());
    }
    // The counter works.
    let before = Counting::count();
    black_box(Vec::<f64>::with_capacity(10));
    assert!(Counting::count() > before);
}

#[test]
fn a_step_of_motion_in_both_spaces_allocates_nothing() {
    use arcfeed_interp::{
        Command, Excursion, HybridMotion, HybridState, JointMoveBy, LeaveBy, Limits, MotionPath, Planner, ToolPath,
    };
    use arcfeed_kinematics::Joints;

    let arm = arm();
    let path = ToolPath::new(&arm, tool_down(knotted()), arm.range()).expect("in reach");
    let start = path.start();
    let limits = Limits::new(common::limits(&arm)).with_tool(common::tool());
    let live = Planner::new(&arm, limits).live(path).expect("in reach");
    let points = [start + Joints::repeat(0.2), start + Joints::repeat(-0.1)];
    let [braking, at_once] =
        [LeaveBy::Braking, LeaveBy::AtOnce].map(|leave| Excursion::new(&points, leave).expect("two points"));
    let braking = braking.with_passing(0.05).expect("a distance").with_joint_moves(JointMoveBy::Projection);
    let before = Counting::count();
    let mut motion = HybridMotion::new(&live, 0.1).expect("a valid feed");
    let mut refused = 0;
    for cycle in 0.. {
        let command = match cycle {
            300 => Command::Override(1.5),
            500 => Command::Hold,
            700 => Command::StepBack(0.01),
            1500 => Command::Resume,
            1900 => Command::Leave(at_once),
            2000 => Command::Leave(braking),
            2400 => Command::Hold,
            2700 => Command::Resume,
            6000 => Command::Return,
            6100 => Command::StepBack(0.0), // refused
            9000 => Command::Leave(braking),
            12_000 => Command::Return,
            _ => Command::None,
        };
        let step = black_box(motion.step(&command));
        refused += usize::from(step.refused.is_some());
        if step.state == HybridState::Done {
            break;
        }
        assert!(cycle < 100_000, "no end");
    }
    assert_eq!(Counting::count() - before, 0);
    assert!(refused >= 1);
}

fn samples_without_allocating(path: &dyn MotionPath<6>) {
    let arm = qb::arm();
    let planner = Planner::new(&arm, qb::with_torque(&arm)).with_method(Method::InterpolatedReachability);
    let plan = planner.with_intervals(100).expect("a grid").plan(path).expect("a plan");
    let before = Counting::count();
    let mut sum = 0.0;
    let mut sampler = plan.setpoints(1e-3).expect("a period");
    for setpoint in sampler.by_ref() {
        let setpoint = black_box(setpoint).expect("on the path");
        sum += setpoint.q.sum() + plan.torque(&setpoint).expect("known").sum();
    }
    assert!(sampler.next().is_none());
    assert_eq!(Counting::count() - before, 0);
    assert!(sum.is_finite());
    // The counter works.
    black_box(Vec::<f64>::with_capacity(10));
    assert!(Counting::count() > before);
}

#[test]
fn sampling_pose_moves_and_way_points_allocates_nothing() {
    let arm = qb::arm();
    let motion = PoseMove::starting_near(&arm, qb::to(), &Joints::from(qb::TO_NEAR)).expect("in reach");
    let (from, to) = (motion.start(), motion.start() + Joints::repeat(0.2));
    samples_without_allocating(&motion);
    samples_without_allocating(&JointSpline::through(&[from, to]).expect("two points"));
}
