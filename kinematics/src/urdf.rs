//! Arms from URDF.
//!
//! The chain between two links is taken; fixed joints are folded into the joints and links around them, as is whatever
//! hangs on a link by fixed joints alone. Limits of 0 (and the absent ones, which read as 0) count as unknown.

use crate::{
    description::{ArmDescription, JointDescription},
    dynamics::Inertial,
    error::{KinematicsError, Part},
    joint::{JointKind, checked_pose},
};
use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};
use std::collections::HashMap;
use urdf_rs::{JointType, Robot};

/// How deep elements may be nested; a URDF's are six deep at most.
const MAX_NESTING: usize = 100;

/// How deep the elements of an XML text are nested, comments left out.
fn nesting(text: &str) -> usize {
    let (mut depth, mut deepest, mut rest) = (0_usize, 0, text);
    while let Some(start) = rest.find('<') {
        rest = &rest[start + 1..];
        if rest.starts_with("!--") {
            rest = rest.find("-->").map_or("", |end| &rest[end..]);
        } else if rest.starts_with('/') {
            depth = depth.saturating_sub(1);
        } else if !rest.starts_with(['?', '!']) {
            let end = rest.find('>').unwrap_or(rest.len());
            if !rest[..end].ends_with('/') {
                depth += 1;
                deepest = deepest.max(depth);
            }
        }
    }
    deepest
}

/// The joints and links of a file, which make a tree.
struct Tree<'a> {
    robot: &'a Robot,
    links: HashMap<&'a str, &'a urdf_rs::Link>,
    /// The joint above each link.
    parent: HashMap<&'a str, &'a urdf_rs::Joint>,
}

fn broken(rule: &'static str, found: impl Into<String>) -> KinematicsError {
    KinematicsError::Structure { rule, found: found.into() }
}

fn in_joint(joint: &urdf_rs::Joint, source: KinematicsError) -> KinematicsError {
    source.in_part(Part::Joint, &joint.name)
}

fn pose(what: &'static str, pose: &urdf_rs::Pose) -> Result<Isometry3<f64>, KinematicsError> {
    let [roll, pitch, yaw] = pose.rpy.0;
    let turn = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
    checked_pose(what, &Isometry3::from_parts(pose.xyz.0.into(), turn))
}

impl<'a> Tree<'a> {
    fn new(robot: &'a Robot) -> Result<Self, KinematicsError> {
        let mut links = HashMap::new();
        for link in &robot.links {
            if links.insert(link.name.as_str(), link).is_some() {
                return Err(broken("each link must have a name of its own", &link.name));
            }
        }
        let mut names = std::collections::HashSet::new();
        let mut parent = HashMap::<&str, &urdf_rs::Joint>::new();
        for joint in &robot.joints {
            if !names.insert(joint.name.as_str()) {
                return Err(broken("each joint must have a name of its own", &joint.name));
            }
            for link in [&joint.parent.link, &joint.child.link] {
                if !links.contains_key(link.as_str()) {
                    let rule = "the links that a joint connects must be in the file";
                    return Err(in_joint(joint, broken(rule, link)));
                }
            }
            if let Some(other) = parent.insert(joint.child.link.as_str(), joint) {
                let source = broken("a link must have one parent joint", format!("{}, {}", other.name, joint.name));
                return Err(source.in_part(Part::Link, &joint.child.link));
            }
        }
        let tree = Self { robot, links, parent };
        for link in tree.links.keys() {
            tree.way_up(link)?;
        }
        Ok(tree)
    }

    /// The joints from the root to `link`.
    fn way_up(&self, link: &str) -> Result<Vec<&'a urdf_rs::Joint>, KinematicsError> {
        let mut way = Vec::new();
        let mut at = link;
        while let Some(joint) = self.parent.get(at) {
            way.push(*joint);
            at = &joint.parent.link;
            if way.len() > self.robot.joints.len() {
                let source = broken("the links must not form a loop", at);
                return Err(in_joint(joint, source));
            }
        }
        way.reverse();
        Ok(way)
    }

    fn root(&self) -> Result<&'a str, KinematicsError> {
        let roots: Vec<&str> = self
            .robot
            .links
            .iter()
            .map(|link| link.name.as_str())
            .filter(|link| !self.parent.contains_key(link))
            .collect();
        match roots[..] {
            [root] => Ok(root),
            _ => Err(broken("there must be one link without parent, or the base link must be named", roots.join(", "))),
        }
    }

    /// The link at the end of the one chain of moving joints: the only one, or else `tool0`, the customary name of the
    /// mounting face.
    fn tip(&self, base: &str) -> Result<&'a str, KinematicsError> {
        let is_end = |link: &str| !self.robot.joints.iter().any(|joint| joint.parent.link == link);
        let mut ends: Vec<(&'a str, &'a str)> = Vec::new();
        for link in self.robot.links.iter().filter(|link| is_end(&link.name)) {
            let way = self.way_up(&link.name)?;
            let below = base_index(&way, base).map_or(&way[..0], |start| &way[start..]);
            if let Some(last) = below.iter().rfind(|joint| joint.joint_type != JointType::Fixed) {
                ends.push((&link.name, &last.name));
            }
        }
        let one_chain = ends.iter().all(|(_, last)| *last == ends[0].1);
        match (&ends[..], ends.iter().find(|(link, _)| *link == "tool0")) {
            ([(tip, _)], _) => Ok(tip),
            (_, Some((tool0, _))) if one_chain => Ok(tool0),
            _ => {
                let names: Vec<&str> = ends.iter().map(|(link, _)| *link).collect();
                Err(broken("there must be one link at the end, or the tip link must be named", names.join(", ")))
            }
        }
    }

    /// Joins to `found` what hangs on `link` by fixed joints, `way` not followed; `link` stands at `at` in the frame of the
    /// body.
    fn join_rigid(
        &self,
        link: &'a str,
        at: Isometry3<f64>,
        way: &[&urdf_rs::Joint],
        found: &mut Option<Inertial>,
    ) -> Result<(), KinematicsError> {
        let mut open = vec![(link, at)];
        while let Some((link, at)) = open.pop() {
            if let Some(body) = self.links.get(link).map(|link| inertial(link)).transpose()?.flatten() {
                let body = body.seen_from(&at);
                *found = Some(found.map_or(body, |found| found.joined(&body)));
            }
            for joint in self.robot.joints.iter().filter(|joint| joint.parent.link == link) {
                let on_way = way.iter().any(|other| other.name == joint.name);
                if joint.joint_type == JointType::Fixed && !on_way {
                    let origin = pose("the origin", &joint.origin).map_err(|error| in_joint(joint, error))?;
                    open.push((&joint.child.link, at * origin));
                }
            }
        }
        Ok(())
    }
}

/// Where on a way from the root link `base` is.
fn base_index(way: &[&urdf_rs::Joint], base: &str) -> Option<usize> {
    way.iter().position(|joint| joint.parent.link == base)
}

/// The link's body in the link's frame; none if it has neither mass nor moments.
fn inertial(link: &urdf_rs::Link) -> Result<Option<Inertial>, KinematicsError> {
    let (mass, i) = (link.inertial.mass.value, &link.inertial.inertia);
    if [mass, i.ixx, i.ixy, i.ixz, i.iyy, i.iyz, i.izz].iter().all(|v| *v == 0.0) {
        return Ok(None);
    }
    let tensor = Matrix3::new(i.ixx, i.ixy, i.ixz, i.ixy, i.iyy, i.iyz, i.ixz, i.iyz, i.izz);
    let read = || {
        Ok(Some(Inertial::new(mass, Vector3::zeros(), tensor)?.seen_from(&pose("the origin", &link.inertial.origin)?)))
    };
    read().map_err(|error: KinematicsError| error.in_part(Part::Link, &link.name))
}

impl ArmDescription {
    /// Reads the chain from link `base` to link `tip` of a URDF text. Without a base the root is taken; without a tip,
    /// the last link if there is only one.
    ///
    /// # Errors
    /// [`KinematicsError::Unreadable`] if the text is no URDF; otherwise what is wrong, with the name of the joint or
    /// link: [`KinematicsError::Structure`], [`KinematicsError::Mimic`], [`KinematicsError::UnsupportedJoint`],
    /// [`KinematicsError::InvalidInertial`] and others.
    pub fn from_urdf(text: &str, base: Option<&str>, tip: Option<&str>) -> Result<Self, KinematicsError> {
        // The reader calls itself for every level: a text made for that would overflow the stack.
        if nesting(text) > MAX_NESTING {
            let reason = format!("elements are nested more than {MAX_NESTING} deep");
            return Err(KinematicsError::Unreadable { format: "URDF", reason });
        }
        let robot = urdf_rs::read_from_string(text)
            .map_err(|error| KinematicsError::Unreadable { format: "URDF", reason: error.to_string() })?;
        let tree = Tree::new(&robot)?;
        let known = |link: &str| {
            let names: Vec<&str> = robot.links.iter().map(|link| link.name.as_str()).collect();
            match tree.links.contains_key(link) {
                true => Ok(()),
                false => Err(broken("the link must be one of the file's", names.join(", ")).in_part(Part::Link, link)),
            }
        };
        let base = base.map_or_else(|| tree.root(), Ok)?;
        known(base)?;
        let tip = tip.map_or_else(|| tree.tip(base), Ok)?;
        known(tip)?;
        let way = tree.way_up(tip)?;
        let way = match base_index(&way, base) {
            Some(start) => &way[start..],
            None => return Err(broken("the tip link must be below the base link", format!("{base}, {tip}"))),
        };
        let mut carried = Isometry3::identity();
        let mut joints: Vec<JointDescription> = Vec::new();
        for (k, joint) in way.iter().enumerate() {
            let origin = carried * pose("the origin", &joint.origin).map_err(|error| in_joint(joint, error))?;
            let Some(mut described) = moving(joint)? else {
                carried = origin;
                continue;
            };
            described.origin = origin;
            // The link, and those that fixed joints of the chain add to it.
            let mut at = Isometry3::identity();
            tree.join_rigid(&joint.child.link, at, way, &mut described.inertial)?;
            for fixed in way[k + 1..].iter().take_while(|joint| joint.joint_type == JointType::Fixed) {
                at *= pose("the origin", &fixed.origin).map_err(|error| in_joint(fixed, error))?;
                tree.join_rigid(&fixed.child.link, at, way, &mut described.inertial)?;
            }
            carried = Isometry3::identity();
            joints.push(described);
        }
        if joints.is_empty() {
            return Err(broken("there must be a moving joint between base and tip", format!("{base}, {tip}")));
        }
        Ok(Self {
            name: robot.name.clone(),
            source: format!("URDF, link '{base}' to link '{tip}'"),
            licence: String::new(),
            notes: Vec::new(),
            base: Isometry3::identity(),
            joints,
            flange: carried,
        })
    }
}

/// A moving joint, or none if it is fixed; its origin is the file's.
fn moving(joint: &urdf_rs::Joint) -> Result<Option<JointDescription>, KinematicsError> {
    let fail = |error| Err(in_joint(joint, error));
    if let Some(mimic) = &joint.mimic {
        return fail(KinematicsError::Mimic { of: mimic.joint.clone() });
    }
    let (kind, limited) = match &joint.joint_type {
        JointType::Fixed => return Ok(None),
        JointType::Revolute => (JointKind::Revolute, true),
        JointType::Continuous => (JointKind::Revolute, false),
        JointType::Prismatic => (JointKind::Prismatic, true),
        other => return fail(KinematicsError::UnsupportedJoint { kind: format!("{other:?}").to_lowercase() }),
    };
    let limit = &joint.limit;
    for (what, value) in [
        ("lower limit", limit.lower),
        ("upper limit", limit.upper),
        ("velocity", limit.velocity),
        ("effort", limit.effort),
    ] {
        if value.is_nan() {
            return fail(KinematicsError::InvalidSetting { what, value, rule: "a number" });
        }
    }
    let given = |value: f64| (value.is_finite() && value != 0.0).then_some(value);
    let known =
        limited && (limit.lower, limit.upper) != (0.0, 0.0) && limit.lower.is_finite() && limit.upper.is_finite();
    let friction = joint.dynamics.as_ref().map(|dynamics| [dynamics.damping, dynamics.friction, dynamics.friction]);
    Ok(Some(JointDescription {
        name: joint.name.clone(),
        link: joint.child.link.clone(),
        origin: Isometry3::identity(),
        axis: Vector3::from(joint.axis.xyz.0),
        kind,
        range: known.then_some([limit.lower, limit.upper]),
        velocity: given(limit.velocity),
        acceleration: given(limit.acceleration),
        jerk: given(limit.jerk),
        torque: given(limit.effort),
        inertial: None,
        rotor_inertia: None,
        friction,
    }))
}
