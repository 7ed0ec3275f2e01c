//! Torques of a KUKA KR 6: held, moving, with a payload; and what a torque limit leaves along a path.
//!
//! `cargo run -p arcfeed-kinematics --example 05_dynamics`

use arcfeed_kinematics::{Dynamics, Inertial, Joints, KinematicsError, models, nalgebra};
use nalgebra::{Matrix3, Vector3};

fn main() -> Result<(), KinematicsError> {
    let described = models::description("kr6_r700").ok_or(KinematicsError::Missing { what: "arm of that name" })?;
    println!("{}\nlicence: {}", described.source, described.licence);
    let arm = described.build::<6>()?;
    let bare = *arm.dynamics().ok_or(KinematicsError::Missing { what: "inertia of every link" })?;

    let q = Joints::from([0.2, -0.9, 1.1, 0.3, 0.8, -0.4]);
    let qd = Joints::from([1.0, -0.5, 0.8, 2.0, -1.0, 3.0]);
    let qdd = Joints::from([4.0, 2.0, -6.0, 10.0, 8.0, -20.0]);
    let loaded = bare.with_payload(Inertial::new(4.0, Vector3::new(0.0, 0.02, 0.08), Matrix3::identity() * 0.01)?)?;
    let print = |what: &str, torque: &Joints<6>| {
        let numbers: Vec<String> = torque.iter().map(|t| format!("{t:8.2}")).collect();
        println!("{what:<28}{} N m", numbers.join(" "));
    };
    print("held against gravity", &bare.gravity_torque(&q));
    print("the same with 4 kg", &loaded.gravity_torque(&q));
    print("in motion", &bare.torque(&q, &qd, &qdd));
    print("in motion with 4 kg", &loaded.torque(&q, &qd, &qdd));

    // The motion that these torques cause is the one that was asked for.
    let caused = loaded.acceleration(&q, &qd, &loaded.torque(&q, &qd, &qdd))?;
    println!("forward dynamics is off by {:.1e} rad/s^2", (caused - qdd).amax());

    // Along a path with q' = qd, q'' = qdd the torque is linear in acceleration and speed squared.
    let path = loaded.along_path(&q, &qd, &qdd);
    let limit = arm.drive_limits().torque.unwrap_or(Joints::repeat(f64::INFINITY));
    let fastest = (0..6)
        .map(|i| {
            let room = limit[i] - path.constant[i].abs();
            (room / path.velocity[i].abs()).sqrt()
        })
        .fold(f64::INFINITY, f64::min);
    println!("at constant path speed the drives allow {fastest:.2} times this speed");
    Ok(())
}
