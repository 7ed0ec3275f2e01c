//! The parts of a URDF file that an arm needs: its links, joints and inertials.
//!
//! One pass over the markup keeps the elements below and skips everything else: geometry,
//! materials, transmissions, simulator tags, names with a prefix. Nothing is opened: a mesh or
//! include is never followed. The pass does not call itself, and it takes time and memory in
//! proportion to the text.

use super::markup::{Attributes, Markup, Tag, unreadable};
use super::origin::{Origin, Version};
use crate::{
    dynamics::Inertial,
    error::{KinematicsError, Part},
};
use nalgebra::{Isometry3, Matrix3, Vector3};

/// The link that simulators take for granted as the parent of the first joint.
const WORLD: &str = "world";

/// A robot as the file describes it.
#[derive(Debug, Default)]
pub(super) struct Robot {
    pub(super) name: String,
    pub(super) links: Vec<Link>,
    pub(super) joints: Vec<Joint>,
}

#[derive(Debug)]
pub(super) struct Link {
    pub(super) name: String,
    inertial: Option<Mass>,
}

/// The `<inertial>` of a link.
#[derive(Debug, Default)]
struct Mass {
    origin: Option<Origin>,
    mass: Option<f64>,
    /// xx, xy, xz, yy, yz, zz.
    inertia: Option<[f64; 6]>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum JointType {
    Fixed,
    Revolute,
    Continuous,
    Prismatic,
    /// A type that an arm cannot have, by its name in the file.
    Other(&'static str),
}

/// The limits of the drive of a joint; 0 where the file does not say.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Limit {
    pub(super) lower: f64,
    pub(super) upper: f64,
    pub(super) velocity: f64,
    pub(super) effort: f64,
    pub(super) acceleration: f64,
    pub(super) jerk: f64,
}

#[derive(Debug)]
pub(super) struct Joint {
    pub(super) name: String,
    pub(super) kind: JointType,
    pub(super) parent: String,
    pub(super) child: String,
    origin: Option<Origin>,
    axis: Option<[f64; 3]>,
    limit: Option<Limit>,
    /// Damping and friction.
    pub(super) dynamics: Option<[f64; 2]>,
    /// The joint it follows.
    pub(super) mimic: Option<String>,
}

impl Joint {
    pub(super) fn origin(&self) -> Result<Isometry3<f64>, KinematicsError> {
        Origin::pose(self.origin).map_err(|error| self.wrong(error))
    }

    pub(super) fn axis(&self) -> Vector3<f64> {
        self.axis.map_or_else(Vector3::x, Vector3::from)
    }

    pub(super) fn limit(&self) -> Limit {
        self.limit.unwrap_or_default()
    }

    /// The error, told of this joint.
    pub(super) fn wrong(&self, source: KinematicsError) -> KinematicsError {
        source.in_part(Part::Joint, &self.name)
    }
}

/// What a file says of the mass of a link.
pub(super) enum LinkBody {
    /// Neither mass nor moments.
    Massless,
    /// A body in the frame of the link.
    Known(Inertial),
    /// Finite numbers that no body can have, and why.
    Impossible(KinematicsError),
}

impl Link {
    /// The link's body.
    pub(super) fn body(&self) -> Result<LinkBody, KinematicsError> {
        let in_link = |error: KinematicsError| error.in_part(Part::Link, &self.name);
        let Some(Mass { origin, mass: Some(mass), inertia: Some(inertia) }) = &self.inertial else {
            return Ok(LinkBody::Massless);
        };
        if *mass == 0.0 && inertia.iter().all(|v| *v == 0.0) {
            return Ok(LinkBody::Massless);
        }
        let [xx, xy, xz, yy, yz, zz] = *inertia;
        let tensor = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        let pose = Origin::pose(*origin).map_err(in_link)?;
        match Inertial::new(*mass, Vector3::zeros(), tensor) {
            Ok(body) => Ok(LinkBody::Known(body.seen_from(&pose))),
            Err(error) if mass.is_finite() && inertia.iter().all(|v| v.is_finite()) => {
                Ok(LinkBody::Impossible(in_link(error)))
            }
            Err(error) => Err(in_link(error)),
        }
    }
}

/// The element whose children are read.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Inside {
    Nothing,
    Robot,
    Link,
    Inertial,
    Joint,
    /// An element that is skipped with all it contains.
    Skipped,
}

impl Robot {
    /// Reads a URDF text.
    pub(super) fn read(text: &str) -> Result<Self, KinematicsError> {
        let mut reader = Reader { robot: Self::default(), version: Version::of(None), xacro: false };
        let mut markup = Markup::new(text);
        let mut inside = vec![Inside::Nothing];
        let mut roots = 0;
        while let Some(tag) = markup.next()? {
            let Tag::Open(element) = tag else {
                let closed = inside.pop();
                if closed == Some(Inside::Joint) {
                    reader.joint_ends().map_err(|reason| markup.refused(&reason))?;
                }
                if closed == Some(Inside::Inertial) {
                    reader.inertial_ends().map_err(|reason| markup.refused(&reason))?;
                }
                continue;
            };
            let parent = inside.last().copied().unwrap_or(Inside::Nothing);
            let opened = reader.open(parent, &element).map_err(|reason| markup.refused(&reason))?;
            roots += usize::from(parent == Inside::Nothing);
            if roots > 1 {
                return Err(markup.refused("there is a second element after <robot>"));
            }
            inside.push(opened);
        }
        if roots == 0 {
            return Err(unreadable("there is no <robot> element".to_owned()));
        }
        let Reader { mut robot, xacro, .. } = reader;
        if xacro && robot.joints.is_empty() {
            let reason = "it is a xacro file without joints of its own: run xacro on it and give its output";
            return Err(unreadable(reason.to_owned()));
        }
        let is_world = |name: &str| name == WORLD;
        if robot.joints.iter().any(|joint| is_world(&joint.parent)) && !robot.links.iter().any(|l| is_world(&l.name)) {
            robot.links.insert(0, Link { name: WORLD.to_owned(), inertial: None });
        }
        Ok(robot)
    }
}

struct Reader {
    robot: Robot,
    version: Version,
    /// True if there are elements that only the xacro program understands.
    xacro: bool,
}

impl Reader {
    /// Takes an element whose parent is `parent`, and says how its children are to be taken.
    fn open(&mut self, parent: Inside, element: &Attributes<'_>) -> Result<Inside, String> {
        self.xacro |= element.name().starts_with("xacro:");
        match (parent, element.name()) {
            (Inside::Nothing, "robot") => {
                self.robot.name = element.get("name")?.unwrap_or_default();
                self.version = Version::of(element.get("version")?.as_deref());
                Ok(Inside::Robot)
            }
            (Inside::Nothing, other) => Err(format!("the first element is <{other}>, it must be <robot>")),
            (Inside::Robot, "link") => {
                let name = element.need("name")?;
                self.robot.links.push(Link { name, inertial: None });
                Ok(Inside::Link)
            }
            (Inside::Robot, "joint") => {
                let joint = self.joint(element)?;
                self.robot.joints.push(joint);
                Ok(Inside::Joint)
            }
            (Inside::Link, "inertial") => {
                let Some(link) = self.robot.links.last_mut() else { return Ok(Inside::Skipped) };
                set(&mut link.inertial, "inertial", Mass::default())
                    .map_err(|reason| format!("link '{}': {reason}", link.name))?;
                Ok(Inside::Inertial)
            }
            (Inside::Inertial, _) => {
                self.part_of_inertial(element).map_err(|reason| self.in_link(&reason))?;
                Ok(Inside::Skipped)
            }
            (Inside::Joint, _) => {
                self.part_of_joint(element).map_err(|reason| self.in_joint(&reason))?;
                Ok(Inside::Skipped)
            }
            _ => Ok(Inside::Skipped),
        }
    }

    fn joint(&self, element: &Attributes<'_>) -> Result<Joint, String> {
        let name = element.need("name")?;
        let kind = match element.need("type").map_err(|reason| format!("joint '{name}': {reason}"))?.as_str() {
            "fixed" => JointType::Fixed,
            "revolute" => JointType::Revolute,
            "continuous" => JointType::Continuous,
            "prismatic" => JointType::Prismatic,
            "floating" => JointType::Other("floating"),
            "planar" => JointType::Other("planar"),
            "spherical" => JointType::Other("spherical"),
            other => return Err(format!("joint '{name}': its type '{other}' is none that URDF knows")),
        };
        let (parent, child) = (String::new(), String::new());
        Ok(Joint { name, kind, parent, child, origin: None, axis: None, limit: None, dynamics: None, mimic: None })
    }

    fn part_of_joint(&mut self, element: &Attributes<'_>) -> Result<(), String> {
        let version = self.version;
        let Some(joint) = self.robot.joints.last_mut() else { return Ok(()) };
        let link = |place: &mut String, what| {
            if !place.is_empty() {
                return Err(twice(what));
            }
            *place = element.need("link")?;
            Ok(())
        };
        match element.name() {
            "origin" => set(&mut joint.origin, "origin", Origin::of(element, version)?),
            "parent" => link(&mut joint.parent, "parent"),
            "child" => link(&mut joint.child, "child"),
            "axis" => {
                let xyz = element.vector("xyz")?.ok_or_else(|| element.without("xyz"))?;
                set(&mut joint.axis, "axis", xyz)
            }
            "limit" => set(&mut joint.limit, "limit", limit(element, version)?),
            "dynamics" => {
                let value = |name| Ok::<f64, String>(element.number(name)?.unwrap_or(0.0));
                set(&mut joint.dynamics, "dynamics", [value("damping")?, value("friction")?])
            }
            "mimic" => set(&mut joint.mimic, "mimic", element.need("joint")?),
            _ => Ok(()),
        }
    }

    fn part_of_inertial(&mut self, element: &Attributes<'_>) -> Result<(), String> {
        let version = self.version;
        let Some(Some(body)) = self.robot.links.last_mut().map(|link| link.inertial.as_mut()) else { return Ok(()) };
        let need = |name| element.number(name)?.ok_or_else(|| element.without(name));
        match element.name() {
            "origin" => set(&mut body.origin, "origin", Origin::of(element, version)?),
            "mass" => set(&mut body.mass, "mass", need("value")?),
            "inertia" => {
                let mut values = [0.0; 6];
                for (value, name) in values.iter_mut().zip(["ixx", "ixy", "ixz", "iyy", "iyz", "izz"]) {
                    *value = need(name)?;
                }
                set(&mut body.inertia, "inertia", values)
            }
            _ => Ok(()),
        }
    }

    fn joint_ends(&self) -> Result<(), String> {
        let Some(joint) = self.robot.joints.last() else { return Ok(()) };
        for (what, link) in [("parent", &joint.parent), ("child", &joint.child)] {
            if link.is_empty() {
                return Err(self.in_joint(&format!("there is no <{what} link=\"..\"/>")));
            }
        }
        Ok(())
    }

    fn inertial_ends(&self) -> Result<(), String> {
        let Some(Some(body)) = self.robot.links.last().map(|link| &link.inertial) else { return Ok(()) };
        match (body.mass, body.inertia) {
            (None, _) => Err(self.in_link("its <inertial> has no <mass>")),
            (_, None) => Err(self.in_link("its <inertial> has no <inertia>")),
            _ => Ok(()),
        }
    }

    fn in_joint(&self, reason: &str) -> String {
        format!("joint '{}': {reason}", self.robot.joints.last().map_or("", |joint| &joint.name))
    }

    fn in_link(&self, reason: &str) -> String {
        format!("link '{}': {reason}", self.robot.links.last().map_or("", |link| &link.name))
    }
}

fn twice(what: &str) -> String {
    format!("there are two <{what}> elements: leave one")
}

/// Fills a place that an element may fill once.
fn set<T>(place: &mut Option<T>, what: &str, value: T) -> Result<(), String> {
    match place.replace(value) {
        None => Ok(()),
        Some(_) => Err(twice(what)),
    }
}

/// `<limit>`: what a version does not know is ignored, what is absent counts as unknown.
fn limit(element: &Attributes<'_>, version: Version) -> Result<Limit, String> {
    let value = |name| Ok::<f64, String>(element.number(name)?.unwrap_or(0.0));
    let later = |name| if version >= Version(1, 2) { value(name) } else { Ok(0.0) };
    let absent = |name, unlimited: f64| match element.number(name)? {
        None if version >= Version(1, 2) => Ok::<f64, String>(unlimited),
        value => Ok(value.unwrap_or(0.0)),
    };
    Ok(Limit {
        lower: absent("lower", f64::NEG_INFINITY)?,
        upper: absent("upper", f64::INFINITY)?,
        velocity: value("velocity")?,
        effort: value("effort")?,
        acceleration: later("acceleration")?,
        jerk: later("jerk")?,
    })
}
