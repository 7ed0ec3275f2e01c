//! The errors of this crate.

use crate::singularity_kind::SingularityKind;

/// On which side of its reach an arm misses a target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReachSide {
    /// The target is farther away than the stretched arm reaches.
    TooFar,
    /// The target is closer to the arm's own body than the folded arm (or its shoulder offset) allows.
    TooNear,
}

impl std::fmt::Display for ReachSide {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::TooFar => "too far",
            Self::TooNear => "too near",
        })
    }
}

/// A part of an arm that has a name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// A joint.
    Joint,
    /// A link.
    Link,
}

impl std::fmt::Display for Part {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Joint => "joint",
            Self::Link => "link",
        })
    }
}

/// The part of a text about a joint at its limit, if there is one.
struct AtLimit(Option<usize>);

impl std::fmt::Display for AtLimit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.0 {
            Some(joint) => write!(f, " with joint {} at its limit", joint + 1),
            None => Ok(()),
        }
    }
}

/// A text from a file, of a long one its beginning and its end, where readers say what they expect and where.
#[cfg(feature = "std")]
struct Clipped<'a>(&'a str);

#[cfg(feature = "std")]
impl Clipped<'_> {
    /// Characters of the beginning and of the end of a text that is longer than both.
    const BEGINNING: usize = 1500;
    const END: usize = 500;
}

#[cfg(feature = "std")]
impl std::fmt::Display for Clipped<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let at = |i: usize| self.0.char_indices().nth(i).map(|(byte, _)| byte);
        let length = self.0.chars().count();
        match (at(Self::BEGINNING), at(length.saturating_sub(Self::END))) {
            (Some(first), Some(last)) if first < last => write!(f, "{} ... {}", &self.0[..first], &self.0[last..]),
            _ => f.write_str(self.0),
        }
    }
}

#[cfg(feature = "std")]
impl KinematicsError {
    /// This error, told of a named part.
    pub(crate) fn in_part(self, part: Part, name: &str) -> Self {
        Self::InPart { part, name: name.to_owned(), source: Box::new(self) }
    }
}

/// Everything that can go wrong in this crate.
///
/// Joint indices in the fields count from 0, in the texts from 1 (as makers number their joints).
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum KinematicsError {
    /// A number that describes an arm, a target or a path is NaN or infinite.
    #[error("{what} is not finite: every number in it must be an ordinary number")]
    NotFinite {
        /// The field that holds the number.
        what: &'static str,
    },

    /// The rotation part of a transform is not a unit quaternion.
    #[error("the quaternion of {what} has norm {norm}, not 1: normalise it")]
    NotUnit {
        /// The field that holds the quaternion.
        what: &'static str,
        /// Its norm.
        norm: f64,
    },

    /// A joint value is NaN or infinite.
    #[error("joint {}: {what} is {value}: it must be an ordinary number", .joint + 1)]
    JointNotFinite {
        /// Which joint, from 0.
        joint: usize,
        /// The name of the value.
        what: &'static str,
        /// The value.
        value: f64,
    },

    /// A joint axis has no direction.
    #[error("the axis of a joint has length {length}: it must be finite and greater than 0")]
    ZeroAxis {
        /// The length of the axis that was given.
        length: f64,
    },

    /// A joint limit breaks a rule.
    #[error("joint {}: {what} limit {value} must be {rule}", .joint + 1)]
    InvalidLimit {
        /// Which joint, from 0.
        joint: usize,
        /// Which limit: "lower", "upper", "velocity", "acceleration" or "jerk".
        what: &'static str,
        /// The value that was given, rad (m), and per s, s^2, s^3.
        value: f64,
        /// The rule it breaks.
        rule: &'static str,
    },

    /// The chain is not of the family of arms that the closed form is for.
    #[error(
        "no closed-form inverse for this arm: {rule}, but it is off by {deviation:.3e} (at most {tolerance:.1e} is corrected)"
    )]
    NoClosedForm {
        /// The rule of the family.
        rule: &'static str,
        /// By how much the arm misses it, rad or m.
        deviation: f64,
        /// The tolerance, rad or m.
        tolerance: f64,
    },

    /// The target is outside the reach of the arm, in every branch.
    #[error(
        "target is out of reach, {side} by {distance:.6} m: move it {} the shoulder by about that much, or turn the tool", if *.side == ReachSide::TooFar { "towards" } else { "away from" }
    )]
    Unreachable {
        /// Distance of the end of the forearm from where the best branch needs it, m. A target too far away comes into
        /// reach when it is moved by this (orientation kept) towards the second axis.
        distance: f64,
        /// Too far or too near.
        side: ReachSide,
    },

    /// Every solution of the inverse lies outside the joint limits; the least bad one is told.
    #[error(
        "all {solutions} inverse solutions break a joint limit; the best one has joint {} at {value:.6}, outside [{lower}, {upper}] by {excess:.6}", .joint + 1
    )]
    OutsideLimits {
        /// Which joint, from 0.
        joint: usize,
        /// The value in the best solution, rad (m).
        value: f64,
        /// Its lower limit, rad (m).
        lower: f64,
        /// Its upper limit, rad (m).
        upper: f64,
        /// By how much the limit is exceeded, rad (m).
        excess: f64,
        /// The number of rejected solutions. `ParallelAxisArm::candidates` tells each one's reason.
        solutions: usize,
    },

    /// The nearest solution is farther from the previous one than the bound allows.
    #[error(
        "joint {} would jump by {step:.6} in one step, more than the bound {bound:.6} by {:.6}: sample finer, or avoid the singular pose or branch change here", .joint + 1, .step - .bound
    )]
    StepTooLarge {
        /// The joint with the largest step, from 0.
        joint: usize,
        /// Its step, rad (m).
        step: f64,
        /// The bound, rad (m).
        bound: f64,
    },

    /// The arm is too close to a singular pose: some tool velocity would need joint velocities beyond any bound.
    #[error(
        "the arm is {}: smallest singular value {sigma_min:.3e} is below {required:.1e} (condition {condition:.3e}); move the path or change the branch",
        match .kind { Some(kind) => kind.describe(), None => "nearly singular" }
    )]
    Singular {
        /// Which kind, when the arm knows.
        kind: Option<SingularityKind>,
        /// Smallest singular value of the Jacobian (rows in m and rad, unscaled).
        sigma_min: f64,
        /// The least value that was asked for.
        required: f64,
        /// Largest over smallest singular value.
        condition: f64,
    },

    /// A body that cannot exist, or numbers that are none.
    #[error("{what} of a body is {value}: it must be {rule} ({bound})")]
    InvalidInertial {
        /// Which of its numbers.
        what: &'static str,
        /// The value that was given, kg, m or kg m^2.
        value: f64,
        /// The rule it breaks.
        rule: &'static str,
        /// The bound of the rule.
        bound: f64,
    },

    /// The mass matrix is not positive definite.
    #[error(
        "the mass matrix is not positive definite: some joint moves no mass, or the bodies' parameters contradict each other; give the links mass or the joints rotor inertia"
    )]
    MassMatrix,

    /// A setting breaks a rule.
    #[error("{what} is {value}: it must be {rule}")]
    InvalidSetting {
        /// Which setting.
        what: &'static str,
        /// The value that was given.
        value: f64,
        /// The rule it breaks.
        rule: &'static str,
    },

    /// No attempt of a numeric inverse ended at the target.
    #[error(
        "no joint values found: the best of {attempts} attempts stays {position:.3e} m and {orientation:.3e} rad from the target{}; it may be out of reach, or reachable only outside the joint range",
        AtLimit(*.at_limit)
    )]
    NotConverged {
        /// Distance of the tool point from the target in the best attempt, m.
        position: f64,
        /// Angle between tool and target there, rad.
        orientation: f64,
        /// The number of attempts.
        attempts: usize,
        /// A joint that stands at a limit there, from 0.
        at_limit: Option<usize>,
    },

    /// A joint that cannot be held there.
    #[error(
        "joint {} cannot be held at {value}: the value must be inside its range, and an arm of {joints} joints leaves {} (not {left})", .joint + 1, .joints - 1
    )]
    InvalidLock {
        /// Which joint, from 0.
        joint: usize,
        /// The value at which it was to be held, rad (m).
        value: f64,
        /// The number of joints of the arm.
        joints: usize,
        /// The number that the other one was to have.
        left: usize,
    },

    /// Joint values for another number of joints, or an arm with none or too many.
    #[error("{given} joint values were given, but the arm has {expected} joints")]
    JointCount {
        /// The number there are.
        given: usize,
        /// The number there should be.
        expected: usize,
    },

    /// Something is wrong with a joint or link that has a name.
    #[cfg(feature = "std")]
    #[error("{part} '{}': {source}", Clipped(name))]
    InPart {
        /// Joint or link.
        part: Part,
        /// Its name.
        name: String,
        /// The fault.
        source: Box<KinematicsError>,
    },

    /// An axis in a file whose length is not 1.
    #[error("the axis has length {length}, not 1: divide it by its length")]
    NotUnitAxis {
        /// Its length.
        length: f64,
    },

    /// Something that is needed is not there.
    #[error("there is no {what}")]
    Missing {
        /// The missing part.
        what: &'static str,
    },

    /// A text that is not what it should be.
    #[cfg(feature = "std")]
    #[error("not a valid {format} description of an arm: {}", Clipped(reason))]
    Unreadable {
        /// The format: "URDF" or "JSON".
        format: &'static str,
        /// The error of the reader.
        reason: String,
    },

    /// A joint of a kind that no arm here has.
    #[cfg(feature = "std")]
    #[error("joints of type '{}' are not supported: revolute, continuous, prismatic and fixed are", Clipped(kind))]
    UnsupportedJoint {
        /// Its type.
        kind: String,
    },

    /// A joint that copies another one.
    #[cfg(feature = "std")]
    #[error("it mimics joint '{}': coupled joints are not supported", Clipped(of))]
    Mimic {
        /// The joint it follows.
        of: String,
    },

    /// The links and joints do not make a tree, or not the chain that was asked for.
    #[cfg(feature = "std")]
    #[error("{rule} (found: '{}')", Clipped(found))]
    Structure {
        /// The rule that is broken.
        rule: &'static str,
        /// The names that break it.
        found: String,
    },

    /// The chain has no Denavit-Hartenberg form that gives it back.
    #[error(
        "no Denavit-Hartenberg table gives this arm back: the best is off by {deviation:.3e} m or rad, as axes are nearly parallel"
    )]
    NoDhForm {
        /// By how much, m or rad.
        deviation: f64,
    },
}

#[cfg(all(test, feature = "std"))]
mod tests {
    use super::*;

    #[test]
    fn of_a_long_text_both_ends_are_told() {
        let long = format!("unknown field {}, expected `name` at line 3", "\u{e4}".repeat(10_000));
        let text = KinematicsError::Unreadable { format: "JSON", reason: long }.to_string();
        assert!(text.starts_with("not a valid JSON description of an arm: unknown field \u{e4}"), "{text}");
        assert!(text.ends_with("expected `name` at line 3") && text.chars().count() < 2100, "{text}");
        let short = KinematicsError::UnsupportedJoint { kind: "floating".to_owned() }.to_string();
        assert!(short.contains("'floating'"), "{short}");
    }
}
