//! Arms from URDF.
//!
//! The chain between two links is taken; fixed joints are folded into the joints and links around
//! them, as is whatever hangs on a link by fixed joints alone. Limits of 0 (and the absent ones,
//! which read as 0) count as unknown.

mod file;
mod markup;
mod origin;
mod tree;

use crate::{
    description::{ArmDescription, JointDescription, have_usable_names},
    error::KinematicsError,
    joint::JointKind,
};
pub use origin::urdf_origin;

use file::{Joint, JointType, Robot};
use nalgebra::Isometry3;
use std::collections::HashSet;
use tree::{Tip, Tree, broken, listed};

impl ArmDescription {
    /// Reads the chain from link `base` to link `tip` of a URDF text. Without a base the root is
    /// taken; without a tip, the end of the one chain of moving joints: its only last link, or `tool0`. Four joints or more
    /// that are followed by fingers alone end at the link that carries these, which a note says: joints that slide, follow
    /// others or are called fingers, at most three in a row. Where only one of several joints follows no other and leads to `tool0`
    /// or `flange`, the chain goes on with it: rods and cylinders of a linkage are left out, which a note says. A link `world` that joints
    /// start from need not be in the file.
    ///
    /// An inertia that no body can have (a negative mass, moments that break the triangle inequality) is taken as unknown, which a note says
    /// with the link: the arm has no dynamics then. Numbers that are not finite are refused.
    ///
    /// Only links, joints and inertials are read: what a file says of meshes, materials or
    /// simulators has no influence. No other file is opened.
    ///
    /// # Errors
    /// [`KinematicsError::Unreadable`] if the text is no URDF, with the line; otherwise what is wrong, with the name of
    /// the joint or link: [`KinematicsError::Structure`], [`KinematicsError::Mimic`],
    /// [`KinematicsError::UnsupportedJoint`], [`KinematicsError::InvalidInertial`] and others. Where the tree branches
    /// and no tip is named, the error lists the links at which the arm may end.
    pub fn from_urdf(text: &str, base: Option<&str>, tip: Option<&str>) -> Result<Self, KinematicsError> {
        let robot = Robot::read(text)?;
        let tree = Tree::new(&robot)?;
        let base = base.map_or_else(|| tree.root(), |name| tree.link(name))?;
        let tip = match tip {
            Some(name) => Tip { link: tree.link(name)?, fingers: Vec::new(), rods: Vec::new() },
            None => tree.tip(base)?,
        };
        let names = |joints: &[usize]| listed(joints.iter().map(|number| tree.joint(*number).name.as_str()));
        let rods = (!tip.rods.is_empty()).then(|| {
            let rods = names(&tip.rods);
            format!("beside the arm, the joints {rods} follow others: they and what they carry are left out, with their mass")
        });
        let hand = tip.fingers.first().map(|_| {
            let fingers = names(&tip.fingers);
            let hand = tree.name(tip.link);
            format!("the arm ends at the hand '{hand}': the joints {fingers} and what they carry are left out, with their mass")
        });
        let tip = tip.link;
        let ends = || format!("{}, {}", tree.name(base), tree.name(tip));
        let way = match tree.way(base, tip) {
            Some(way) if base != tip => way,
            _ => return Err(broken("the tip link must be below the base link", ends())),
        };
        let Folded { joints, flange, notes } = folded(&tree, &way)?;
        have_usable_names(&joints)?;
        if joints.is_empty() {
            return Err(broken("there must be a moving joint between base and tip", ends()));
        }
        Ok(Self {
            name: robot.name.clone(),
            source: format!("URDF, link '{}' to link '{}'", tree.name(base), tree.name(tip)),
            licence: String::new(),
            notes: rods.into_iter().chain(hand).chain(notes).collect(),
            base: Isometry3::identity(),
            joints,
            flange,
        })
    }
}

/// An arm whose fixed joints are folded into the moving ones.
struct Folded {
    joints: Vec<JointDescription>,
    /// What fixed joints add behind the last moving one.
    flange: Isometry3<f64>,
    /// Inertias that are taken as unknown.
    notes: Vec<String>,
}

/// The moving joints of a way, the fixed ones folded into them.
fn folded(tree: &Tree<'_>, way: &[usize]) -> Result<Folded, KinematicsError> {
    let on_way: HashSet<usize> = way.iter().copied().collect();
    let mut joints: Vec<JointDescription> = Vec::new();
    // Of each joint the first body that it carries and that cannot be.
    let mut impossible: Vec<Option<KinematicsError>> = Vec::new();
    // From the last moving joint on.
    let mut carried = Isometry3::identity();
    for number in way {
        let joint = tree.joint(*number);
        let origin = carried * joint.origin()?;
        carried = match moving(joint)? {
            None => origin,
            Some(described) => {
                joints.push(JointDescription { origin, ..described });
                impossible.push(None);
                Isometry3::identity()
            }
        };
        // The link moves with the last moving joint, if there is one.
        if let (Some(last), Some(impossible)) = (joints.last_mut(), impossible.last_mut()) {
            let why = tree.join_rigid(tree.child(*number), carried, &on_way, &mut last.inertial)?;
            *impossible = impossible.take().or(why);
        }
    }
    let mut notes = Vec::new();
    for (joint, why) in joints.iter_mut().zip(impossible) {
        if let Some(why) = why {
            joint.inertial = None;
            notes.push(format!(
                "{why}: the inertia behind joint '{}' is taken as unknown, and torques with it",
                joint.name
            ));
        }
    }
    Ok(Folded { joints, flange: carried, notes })
}

/// A moving joint, or none if it is fixed; its origin is the file's.
fn moving(joint: &Joint) -> Result<Option<JointDescription>, KinematicsError> {
    let fail = |error| Err(joint.wrong(error));
    if let Some(of) = &joint.mimic {
        return fail(KinematicsError::Mimic { of: of.clone() });
    }
    let (kind, limited) = match joint.kind {
        JointType::Fixed => return Ok(None),
        JointType::Revolute => (JointKind::Revolute, true),
        JointType::Continuous => (JointKind::Revolute, false),
        JointType::Prismatic => (JointKind::Prismatic, true),
        JointType::Other(kind) => return fail(KinematicsError::UnsupportedJoint { kind: kind.to_owned() }),
    };
    let limit = joint.limit();
    for (what, value) in [
        ("lower limit", limit.lower),
        ("upper limit", limit.upper),
        ("velocity", limit.velocity),
        ("effort", limit.effort),
        ("acceleration", limit.acceleration),
        ("jerk", limit.jerk),
    ] {
        if value.is_nan() {
            return fail(KinematicsError::InvalidSetting { what, value, rule: "a number" });
        }
    }
    let given = |value: f64| (value.is_finite() && value != 0.0).then_some(value);
    let known =
        limited && (limit.lower, limit.upper) != (0.0, 0.0) && limit.lower.is_finite() && limit.upper.is_finite();
    Ok(Some(JointDescription {
        name: joint.name.clone(),
        link: joint.child.clone(),
        origin: Isometry3::identity(),
        axis: joint.axis(),
        kind,
        range: known.then_some([limit.lower, limit.upper]),
        velocity: given(limit.velocity),
        acceleration: given(limit.acceleration),
        jerk: given(limit.jerk),
        torque: given(limit.effort),
        inertial: None,
        rotor_inertia: None,
        friction: joint.dynamics.map(|[damping, friction]| [damping, friction, friction]),
    }))
}
