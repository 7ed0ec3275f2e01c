//! Every way to reach a pose, the one nearest to where the arm stands, and what happens where there is none.
//!
//! `cargo run --release -p arcfeed-kinematics --example 02_inverse`

use arcfeed_kinematics::{
    AnalyticInverse, Candidate, ForwardKinematics, InverseKinematics, Joints, KinematicsError, models,
};

fn degrees(q: &Joints<6>) -> String {
    q.iter().map(|v| format!("{:8.2}", v.to_degrees())).collect()
}

fn main() -> Result<(), KinematicsError> {
    let arm = models::cr7();
    let now = Joints::from([0.3, -0.2, 1.4, 0.3, -1.5, 0.1]);
    let mut target = arm.forward(&now);
    target.translation.z -= 0.05;

    println!("all solutions, deg");
    for q in &arm.inverse_all(&target)? {
        println!("{}", degrees(q));
    }
    println!("\nfrom where the arm stands, with turns of 360 deg inside the limits");
    for candidate in arm.candidates(&target, &now)? {
        match candidate {
            Candidate::Usable { q, joint, step } => {
                println!("{}  moves joint {} by {:.1}", degrees(&q), joint + 1, step.to_degrees());
            }
            Candidate::OutsideLimits { q, excess } => {
                println!("{}  joint {} is {:.1} outside", degrees(&q), excess.joint + 1, excess.excess.to_degrees());
            }
        }
    }
    println!("\nnearest\n{}", degrees(&arm.inverse(&target, &now)?));

    // Wrist lined up: joints 4 and 6 turn the tool alike, and a whole circle of solutions exists. Joint 6 stays.
    let singular = Joints::from([0.3, -0.2, 1.4, 0.3, 0.0, 0.1]);
    let pose = arm.forward(&singular);
    println!("\nin a singular pose (wrist singular: {})", arm.inverse_all(&pose)?.wrist_singular());
    println!("{}", degrees(&arm.inverse(&pose, &singular)?));

    // A metre too far: the error says so.
    target.translation.x += 1.0;
    if let Err(error) = arm.inverse(&target, &now) {
        println!("\n{error}");
    }
    Ok(())
}
