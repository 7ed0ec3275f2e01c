//! The rules of the geometry of a family of arms, held against one arm.

use crate::{error::KinematicsError, jacobian::Configuration, joint::JointKind, singularity::SingularityDistances};
use nalgebra::Vector3;

/// Largest deviation of a chain from the ideal geometry, rad and m; above [`EXACT`] its solutions are polished.
pub(super) const ACCEPTED: f64 = 1e-4;
/// Deviation that is nothing but rounding, rad and m.
const EXACT: f64 = 1e-14;
/// Sine of the angle between axes 4 and 6 below which the wrist is taken as singular, rad. Then one joint is free, and
/// the orientation may be off by that much.
pub(super) const WRIST_SINGULAR: f64 = 1e-10;

/// The rules that were checked so far.
pub(super) struct Rules {
    worst: f64,
}

impl Rules {
    /// The rules of an arm that looks like `zero` at zero joint values. The first one: all its joints turn.
    ///
    /// # Errors
    /// The first rule is broken.
    pub(super) fn new(zero: &Configuration<6>) -> Result<Self, KinematicsError> {
        let mut rules = Self { worst: 0.0 };
        let sliding = zero.kinds.iter().filter(|kind| **kind != JointKind::Revolute).count();
        rules.hold("all six joints must be revolute", sliding as f64)?;
        Ok(rules)
    }

    /// Holds one rule against its deviation, rad or m.
    ///
    /// # Errors
    /// The deviation is larger than what is accepted.
    pub(super) fn hold(&mut self, rule: &'static str, deviation: f64) -> Result<(), KinematicsError> {
        self.worst = self.worst.max(deviation);
        if deviation <= ACCEPTED {
            return Ok(());
        }
        Err(KinematicsError::NoClosedForm { rule, deviation, tolerance: ACCEPTED })
    }

    /// Holds that a link, which has this length (m), is no point.
    ///
    /// # Errors
    /// The link is too short.
    pub(super) fn has_length(&mut self, rule: &'static str, length: f64) -> Result<(), KinematicsError> {
        self.hold(rule, if length > ACCEPTED { 0.0 } else { 1.0 })
    }

    /// True if an arm of this size (m) is ideal to rounding.
    pub(super) fn exact(&self, size: f64) -> bool {
        self.worst <= EXACT * size.max(1.0)
    }
}

/// Distances from the singular poses of an arm with axes 2 and 3 parallel. `wrist` is the wrist point, `lined_up` the two
/// axes that line up where the wrist is singular, `elbow_end` the end of the forearm.
pub(super) fn distances(
    at: &Configuration<6>,
    wrist: &Vector3<f64>,
    lined_up: [&Vector3<f64>; 2],
    elbow_end: &Vector3<f64>,
    size: f64,
) -> SingularityDistances {
    let (z, o) = (&at.axes, &at.points);
    let n = &z[1];
    let across = |vector: Vector3<f64>| vector - n * n.dot(&vector);
    SingularityDistances::new(
        SingularityDistances::between_lines(lined_up[0], lined_up[1]),
        SingularityDistances::between_lines(&across(o[2] - o[1]), &across(elbow_end - o[2])),
        z[0].cross(n).dot(&(wrist - o[0])).abs(),
        size,
    )
}
