//! Where is the tool, and how does it move? A built-in arm, no file needed.
//!
//! `cargo run --release -p arcfeed-kinematics --example 01_forward`

use arcfeed_kinematics::{ForwardKinematics, Joints, KinematicsError, models, singular_values};
use nalgebra::Isometry3;

fn main() -> Result<(), KinematicsError> {
    // A Dobot CR7 with a pen of 120 mm.
    let arm = models::cr7().with_tool(Isometry3::translation(0.0, 0.0, 0.120))?;
    let q = Joints::from([20.0, -10.0, 80.0, 20.0, -90.0, 0.0].map(f64::to_radians));

    let (pose, jacobian) = arm.forward_jacobian(&q);
    let p = pose.translation.vector;
    let (roll, pitch, yaw) = pose.rotation.euler_angles();
    println!("tool point   {:9.4} {:9.4} {:9.4} m", p.x, p.y, p.z);
    println!(
        "orientation  {:9.3} {:9.3} {:9.3} deg (roll, pitch, yaw)",
        roll.to_degrees(),
        pitch.to_degrees(),
        yaw.to_degrees()
    );

    println!("\nJacobian (rows vx vy vz wx wy wz, a column per joint)");
    for row in jacobian.row_iter() {
        println!("{}", row.iter().map(|v| format!("{v:9.4}")).collect::<Vec<_>>().join(" "));
    }
    println!("singular values {:.4?}", singular_values(&jacobian));

    // Joint 1 alone at 30 deg/s: the pen goes round the base, and is pulled inwards.
    let qd = Joints::from([30.0_f64.to_radians(), 0.0, 0.0, 0.0, 0.0, 0.0]);
    let (velocity, acceleration) = (jacobian * qd, arm.jacobian_dot_qd(&q, &qd));
    println!("\njoint 1 at 30 deg/s: pen speed {:.4} m/s", velocity.fixed_rows::<3>(0).norm());
    println!("                     pulled inwards by {:.4} m/s^2", acceleration.fixed_rows::<3>(0).norm());
    Ok(())
}
