//! Nothing on the way from joints to poses and back allocates, errors included.

use arcfeed_kinematics::{
    AnalyticInverse, Arm, BranchTracker, Dynamics, ForwardKinematics, InverseKinematics, Joints, MIN_SINGULAR_VALUE,
    ToolDerivatives, Twist, joint_derivatives, least_norm_derivatives, models, smallest_singular_value, weakest_motion,
};
use std::hint::black_box;

use arcfeed_testing::Counting;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn nothing_allocates() {
    let arm = models::cr7();
    let tool = ToolDerivatives { first: Twist::repeat(0.1), second: Twist::repeat(0.2), third: Twist::repeat(0.3) };
    let before = Counting::count();
    for k in 0..100 {
        let q = Joints::from([0.3, -0.2, 1.4, 0.3, 0.02 * f64::from(k), 0.1]);
        let pose = black_box(arm.forward(&q));
        let jacobian = black_box(arm.jacobian(&q));
        black_box(arm.forward_jacobian(&q));
        black_box(arm.jacobian_dot_qd(&q, &q));
        black_box(arm.jerk_bias(&q, &q, &q));
        black_box(smallest_singular_value(&jacobian));
        let _ = black_box(joint_derivatives(&arm, &q, &tool, MIN_SINGULAR_VALUE));
        assert!(!black_box(arm.inverse_all(&pose)).is_ok_and(|all| all.is_empty()));
        assert!(black_box(arm.inverse(&pose, &q)).is_ok());
        assert!(BranchTracker::new(&arm, q).next(&pose).is_ok());
        let mut far = pose;
        far.translation.x += 5.0;
        assert!(black_box(arm.inverse(&far, &q)).is_err());
    }
    assert_eq!(Counting::count() - before, 0);
}

#[test]
fn other_arms_and_their_dynamics_do_not_allocate() {
    let build = |name: &str| models::description(name).expect("built in").build::<6>().expect("six joints");
    let arms = [build("kr6_r700"), build("puma560"), build("ur5e")];
    let panda: Arm<7> = models::description("panda").expect("built in").build().expect("seven joints");
    let locked: Arm<6> = panda.locked(2, 0.2).expect("inside the range");
    let tool = ToolDerivatives { first: Twist::repeat(0.1), second: Twist::repeat(0.2), third: Twist::repeat(0.3) };
    let before = Counting::count();
    for k in 0..20 {
        let q = Joints::from([0.3, -1.0, 1.4, 0.3, 0.05 * f64::from(k), 0.1]);
        for arm in &arms {
            let pose = arm.forward(&q);
            assert!(black_box(arm.inverse_all(&pose)).is_ok());
            assert!(black_box(arm.inverse(&pose, &q)).is_ok());
            black_box(arm.singularity_distances(&q));
            let Some(dynamics) = arm.dynamics() else { panic!("known") };
            let torque = black_box(dynamics.torque(&q, &q, &q));
            black_box(dynamics.mass_matrix(&q));
            black_box(dynamics.bias(&q, &q));
            black_box(dynamics.along_path(&q, &q, &q));
            assert!(arm.inverse(&pose, &q.map(|_| f64::NAN)).is_err());
            let _ = black_box(dynamics.acceleration(&q, &q, &torque));
        }
        let q = Joints::from([0.1, -0.4, 0.2, -2.0, 0.1, 1.6, 0.02 * f64::from(k)]);
        let pose = panda.forward(&q);
        assert!(black_box(panda.inverse(&pose, &q.map(|v| v + 0.01))).is_ok());
        assert!(black_box(panda.inverse_all(&pose)).is_ok());
        let mut far = pose;
        far.translation.x += 5.0;
        assert!(black_box(panda.inverse(&far, &q)).is_err());
        black_box(weakest_motion(&panda.jacobian(&q)));
        assert!(k > 0 || black_box(panda.nearest_singular_pose(&q)).is_some());
        let _ = black_box(least_norm_derivatives(&panda, &q, &tool, 1e-3));
        let six = Joints::from([q[0], q[1], q[3], q[4], q[5], q[6]]);
        assert!(black_box(locked.inverse(&pose, &six)).is_ok());
    }
    assert_eq!(Counting::count() - before, 0);
    // The counter works.
    black_box(Vec::<f64>::with_capacity(10));
    assert!(Counting::count() > before);
}
