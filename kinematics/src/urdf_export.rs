//! URDF from arms.

use crate::{description::ArmDescription, joint::JointKind};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use std::fmt::Write;

impl ArmDescription {
    /// The arm as a URDF text, from link `base_link` to link `tool0` at the flange. What is unknown is written as 0.
    pub fn to_urdf(&self) -> String {
        let mut text = String::from("<?xml version=\"1.0\"?>\n");
        // Writing into a string cannot fail.
        let _ = self.write_urdf(&mut text);
        text
    }

    fn write_urdf(&self, out: &mut String) -> std::fmt::Result {
        writeln!(
            out,
            "<robot name=\"{}\">\n  <link name=\"base_link\"/>\n  <link name=\"base\"/>",
            escaped(&self.name)
        )?;
        write_joint(out, "base_joint", "fixed", ["base_link", "base"], &self.base, "")?;
        let mut parent = "base".to_owned();
        for joint in &self.joints {
            let link = escaped(&joint.link);
            writeln!(out, "  <link name=\"{link}\">")?;
            if let Some(body) = &joint.inertial {
                let (c, t) = (body.centre(), body.tensor());
                writeln!(
                    out,
                    "    <inertial>\n      <origin xyz=\"{:?} {:?} {:?}\"/>\n      <mass value=\"{:?}\"/>",
                    c.x,
                    c.y,
                    c.z,
                    body.mass()
                )?;
                let [xx, xy, xz, yy, yz, zz] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].map(|place| t[place]);
                writeln!(
                    out,
                    "      <inertia ixx=\"{xx:?}\" ixy=\"{xy:?}\" ixz=\"{xz:?}\" iyy=\"{yy:?}\" iyz=\"{yz:?}\" izz=\"{zz:?}\"/>\n    </inertial>"
                )?;
            }
            writeln!(out, "  </link>")?;
            let kind = match (joint.kind, joint.range) {
                (JointKind::Prismatic, _) => "prismatic",
                (JointKind::Revolute, Some(_)) => "revolute",
                (JointKind::Revolute, None) => "continuous",
            };
            let [lower, upper] = joint.range.unwrap_or_default();
            let (velocity, effort) = (joint.velocity.unwrap_or(0.0), joint.torque.unwrap_or(0.0));
            let a = &joint.axis;
            let mut more = format!(
                "    <axis xyz=\"{:?} {:?} {:?}\"/>\n    <limit lower=\"{lower:?}\" upper=\"{upper:?}\" effort=\"{effort:?}\" velocity=\"{velocity:?}\"/>\n",
                a.x, a.y, a.z
            );
            if let Some([viscous, forward, backward]) = joint.friction {
                writeln!(
                    more,
                    "    <dynamics damping=\"{viscous:?}\" friction=\"{:?}\"/>",
                    0.5 * (forward + backward)
                )?;
            }
            write_joint(out, &escaped(&joint.name), kind, [&parent, &link], &joint.origin, &more)?;
            parent = link;
        }
        writeln!(out, "  <link name=\"tool0\"/>")?;
        write_joint(out, "flange_joint", "fixed", [&parent, "tool0"], &self.flange, "")?;
        writeln!(out, "</robot>")
    }
}

fn escaped(name: &str) -> String {
    name.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

fn write_joint(
    out: &mut String,
    name: &str,
    kind: &str,
    [parent, child]: [&str; 2],
    origin: &Isometry3<f64>,
    more: &str,
) -> std::fmt::Result {
    let (t, [roll, pitch, yaw]) = (&origin.translation, roll_pitch_yaw(&origin.rotation));
    writeln!(out, "  <joint name=\"{name}\" type=\"{kind}\">")?;
    writeln!(out, "    <origin xyz=\"{:?} {:?} {:?}\" rpy=\"{roll:?} {pitch:?} {yaw:?}\"/>", t.x, t.y, t.z)?;
    writeln!(out, "    <parent link=\"{parent}\"/>\n    <child link=\"{child}\"/>\n{more}  </joint>")
}

/// Fixed-axis angles, each from an arc tangent of what the one before leaves over: exact at a pitch of a right angle too.
fn roll_pitch_yaw(rotation: &UnitQuaternion<f64>) -> [f64; 3] {
    let r = rotation.to_rotation_matrix().into_inner();
    let across = r[(0, 0)].hypot(r[(1, 0)]);
    let yaw = if across < 1e-9 { 0.0 } else { r[(1, 0)].atan2(r[(0, 0)]) };
    let level = nalgebra::Rotation3::from_axis_angle(&Vector3::z_axis(), -yaw) * r;
    let pitch = (-level[(2, 0)]).atan2(level[(0, 0)]);
    let upright = nalgebra::Rotation3::from_axis_angle(&Vector3::y_axis(), -pitch) * level;
    [upright[(2, 1)].atan2(upright[(1, 1)]), pitch, yaw]
}
