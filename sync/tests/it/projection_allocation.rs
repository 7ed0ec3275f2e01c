//! Neither a cycle nor a new target allocates, counted by the allocator.
#![allow(clippy::unwrap_used)]

use std::hint::black_box;

use arcfeed_sync::nalgebra::{Isometry3, Vector3};
use arcfeed_sync::{JointState, PoseLimits, PoseProjectionSync, PoseState, ProjectionSync, symmetric_limits};
use arcfeed_testing::allocations_in;

#[test]
fn stepping_and_retargeting_allocate_nothing() {
    let limits = symmetric_limits(Vector3::repeat(2.0), Vector3::repeat(10.0), Vector3::repeat(200.0)).unwrap();
    let tool = PoseLimits::new([0.5, 3.0, 40.0], [1.5, 8.0, 100.0]).unwrap();
    let mut fast = JointState::rest(Vector3::zeros());
    fast.qd.x = 3.0;
    let count = allocations_in(|| {
        let mut joints = ProjectionSync::new(&fast, Vector3::repeat(1.0), &limits).unwrap();
        let mut pose =
            PoseProjectionSync::new(&PoseState::rest(Isometry3::identity()), Isometry3::identity(), &tool).unwrap();
        for k in 0..2000 {
            if k % 7 == 0 {
                let x = (f64::from(k) * 0.01).sin();
                joints.set_target(Vector3::new(x, 1.0, -x)).unwrap();
                pose.set_target(Isometry3::new(Vector3::new(x, 0.1, 0.0), Vector3::new(0.0, x, 1.0))).unwrap();
            }
            black_box(joints.step(1e-3)).unwrap();
            black_box(pose.step(1e-3)).unwrap();
        }
    });
    assert_eq!(count, 0);
}
