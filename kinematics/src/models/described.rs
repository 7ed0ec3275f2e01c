//! The built-in arms with everything that is known of them.

use nalgebra::{Isometry3, Matrix3, Vector3};
use std::f64::consts::PI;

use super::{frame, planar_2r, tables};
use crate::{ArmDescription, Inertial, Joint, JointDescription, JointKind};

/// The names under which [`description`] knows arms.
pub const NAMES: [&str; 6] = ["cr7", "ur5e", "kr6_r700", "puma560", "panda", "planar_2r"];

/// A built-in arm with everything that is known of it: limits, links, friction, source, licence and what is assumed.
///
/// ```
/// use arcfeed_kinematics::{Dynamics, Joints, models};
/// let described = models::description("kr6_r700").expect("one of models::NAMES");
/// assert_eq!(described.licence, "Apache-2.0");
/// assert_eq!(described.missing(), ["jerk: joint_1, joint_2, joint_3, joint_4, joint_5, joint_6"]);
/// let arm = described.build::<6>()?;
/// let held = arm.dynamics().expect("its links are known").gravity_torque(&Joints::<6>::zeros());
/// assert!(held[0].abs() < 1e-9 && held[1].abs() > 10.0);
/// # Ok::<(), arcfeed_kinematics::KinematicsError>(())
/// ```
pub fn description(name: &str) -> Option<ArmDescription> {
    let tables = [tables::CR7, tables::UR5E, tables::KR6_R700, tables::PUMA560, tables::PANDA];
    match tables.into_iter().find(|table| table.name == name) {
        Some(table) => Some(describe(&table)),
        None => (name == "planar_2r").then(describe_planar),
    }
}

fn describe(table: &tables::Table) -> ArmDescription {
    let joint = |row: &tables::Row| {
        let [mass, x, y, z, xx, xy, xz, yy, yz, zz] = row.link;
        let tensor = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        JointDescription {
            name: row.name.to_owned(),
            link: format!("{}_link", row.name),
            origin: frame(&row.origin),
            axis: Vector3::z(),
            kind: JointKind::Revolute,
            range: Some(row.range),
            velocity: row.velocity,
            acceleration: row.acceleration,
            jerk: None,
            torque: row.torque,
            inertial: Inertial::identified(mass, Vector3::new(x, y, z), tensor).ok(),
            rotor_inertia: row.rotor,
            friction: row.friction,
        }
    };
    ArmDescription {
        name: table.name.to_owned(),
        source: format!("{}: {}", table.model, table.source),
        licence: table.licence.to_owned(),
        notes: table.notes.iter().map(|note| (*note).to_owned()).collect(),
        base: Isometry3::identity(),
        joints: table.joints.iter().map(joint).collect(),
        flange: frame(&table.flange),
    }
}

fn describe_planar() -> ArmDescription {
    let arm = planar_2r();
    let joint = |(i, joint): (usize, &Joint)| JointDescription {
        name: format!("joint{}", i + 1),
        link: format!("link{}", i + 1),
        origin: *joint.origin(),
        axis: joint.axis().into_inner(),
        kind: joint.kind(),
        range: Some([-PI, PI]),
        velocity: Some(PI),
        acceleration: Some(10.0),
        jerk: Some(100.0),
        torque: None,
        inertial: None,
        rotor_inertia: None,
        friction: None,
    };
    ArmDescription {
        name: "planar_2r".to_owned(),
        source: "made up".to_owned(),
        licence: "as this library".to_owned(),
        notes: vec!["An arm to think with: all numbers are made up.".to_owned()],
        base: Isometry3::identity(),
        joints: arm.joints().iter().enumerate().map(joint).collect(),
        flange: *arm.tool(),
    }
}
