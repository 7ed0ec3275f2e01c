//! An arm of your own: from a Denavit-Hartenberg table, or from joint origins and axes.
//!
//! `cargo run --release -p arcfeed-kinematics --example 03_your_own_arm`

use arcfeed_kinematics::{
    AnalyticInverse, Chain, DhRow, ForwardKinematics, Joint, JointRange, Joints, KinematicsError, ParallelAxisArm,
};
use nalgebra::{Isometry3, Vector3};
use std::f64::consts::{FRAC_PI_2, PI};

fn main() -> Result<(), KinematicsError> {
    // Standard parameters: a (m), alpha (rad), d (m), theta at joint value 0 (rad).
    let table = Chain::from_dh(&[
        DhRow::revolute(0.0, FRAC_PI_2, 0.152, 0.0),
        DhRow::revolute(-0.244, 0.0, 0.0, 0.0),
        DhRow::revolute(-0.213, 0.0, 0.0, 0.0),
        DhRow::revolute(0.0, FRAC_PI_2, 0.131, 0.0),
        DhRow::revolute(0.0, -FRAC_PI_2, 0.085, 0.0),
        DhRow::revolute(0.0, 0.0, 0.092, 0.0),
    ])?;
    // Three parallel axes: the closed form applies. It is found from the geometry.
    let arm = ParallelAxisArm::new(table, JointRange::new(Joints::repeat(-PI), Joints::repeat(PI))?)?
        .with_base(Isometry3::translation(0.0, 0.0, 0.8))?
        .with_tool(Isometry3::translation(0.0, 0.0, 0.15))?;
    let q = Joints::from([0.4, -1.2, 1.5, -0.6, -1.3, 0.2]);
    let pose = arm.forward(&q);
    println!("on a table of 0.8 m: tool at {:.4?}", pose.translation.vector.as_slice());
    println!("solutions: {}", arm.inverse_all(&pose)?.len());

    // Any number of joints, sliding ones too: a gantry with a wrist, from origins and axes.
    let at = |x, y, z| Isometry3::translation(x, y, z);
    let gantry = Chain::new([
        Joint::prismatic(at(0.0, 0.0, 1.5), Vector3::x())?,
        Joint::prismatic(at(0.0, 0.0, 0.0), Vector3::y())?,
        Joint::prismatic(at(0.0, 0.0, 0.0), -Vector3::z())?,
        Joint::revolute(at(0.0, 0.0, -0.2), Vector3::z())?,
        Joint::revolute(at(0.0, 0.0, -0.1), Vector3::x())?,
    ])?;
    let pose = gantry.forward(&Joints::<5>::from([0.5, 0.2, 0.7, 0.3, 0.1]));
    println!("gantry: tool at {:.4?}", pose.translation.vector.as_slice());

    // An arm the closed form is not for says which rule it breaks.
    let skew = Chain::from_dh(&[DhRow::revolute(0.1, 0.7, 0.2, 0.0); 6])?;
    if let Err(error) = ParallelAxisArm::new(skew, *arm.range()) {
        println!("{error}");
    }
    Ok(())
}
