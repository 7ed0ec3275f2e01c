//! A Franka Panda draws a circle: followed pose by pose, with its elbow drawn towards a posture, and with a joint held.
//!
//! `cargo run -p arcfeed-kinematics --example 07_seven_joints`

use arcfeed_kinematics::{
    Arm, BranchTracker, ForwardKinematics, InverseKinematics, Joints, KinematicsError, NullSpace, NumericSettings,
    models, nalgebra::Isometry3,
};
use std::f64::consts::TAU;

fn main() -> Result<(), KinematicsError> {
    let arm = models::panda();
    let start = Joints::from([0.1, -0.4, 0.2, -2.0, 0.1, 1.6, 0.7]);
    let centre = arm.forward(&start);
    let circle = |k: u32| {
        let angle = TAU * f64::from(k) / 400.0;
        Isometry3::translation(0.0, 0.08 * angle.sin(), 0.08 * (1.0 - angle.cos())) * centre
    };

    let mut tracker = BranchTracker::new(&arm, start).with_max_step(0.05);
    for k in 0..=400 {
        tracker.next(&circle(k))?;
    }
    println!(
        "least motion: after one turn the joints are {:.4} rad from where they began",
        (tracker.joints() - start).amax()
    );

    let posture = start;
    let settings =
        NumericSettings { null_space: NullSpace::Towards { posture, gain: 0.05 }, ..NumericSettings::default() };
    let drawn = arm.with_settings(settings)?;
    let mut tracker = BranchTracker::new(&drawn, start).with_max_step(0.05);
    for k in 0..=400 {
        tracker.next(&circle(k))?;
    }
    println!("drawn to a posture: {:.4} rad", (tracker.joints() - start).amax());

    // With joint 3 held six joints are left, and the circle closes.
    let six: Arm<6> = Arm::from(arm).locked(2, start[2])?;
    let begin = Joints::<6>::from_fn(|i, _| start[i + usize::from(i >= 2)]);
    let mut tracker = BranchTracker::new(&six, begin).with_max_step(0.05);
    for k in 0..=400 {
        tracker.next(&circle(k))?;
    }
    println!("joint 3 held ({}): {:.1e} rad", six.method(), (tracker.joints() - begin).amax());

    // Out of reach is told, with what the best attempt left over.
    let far = Isometry3::translation(1.5, 0.0, 0.0) * centre;
    if let Err(error) = arm.inverse(&far, &start) {
        println!("{error}");
    }
    Ok(())
}
