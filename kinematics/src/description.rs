//! An arm as files describe it: any number of joints, with names, and with gaps.

use crate::{
    arm::{Arm, DriveLimits},
    chain::Chain,
    dynamics::{ArmDynamics, Friction, Inertial},
    error::{KinematicsError, Part},
    joint::{Joint, JointKind, JointRange, Joints},
};
use nalgebra::{Isometry3, Vector3};
use std::f64::consts::TAU;

/// Range of a turning joint for which no limits are known, rad: +- one turn.
pub const ASSUMED_RANGE: f64 = TAU;

/// An arm as a file or a table describes it. What is unknown is `None`; [`ArmDescription::missing`] lists it.
#[derive(Debug, Clone, PartialEq)]
pub struct ArmDescription {
    /// Its short name.
    pub name: String,
    /// The source of the numbers.
    pub source: String,
    /// Under which licence.
    pub licence: String,
    /// Assumptions and notes.
    pub notes: Vec<String>,
    /// The place of the arm in the working frame.
    pub base: Isometry3<f64>,
    /// The joints from the base outwards, with the links they move.
    pub joints: Vec<JointDescription>,
    /// The mounting face in the frame of the last joint.
    pub flange: Isometry3<f64>,
}

/// One joint and the link it moves.
#[derive(Debug, Clone, PartialEq)]
pub struct JointDescription {
    /// Name of the joint.
    pub name: String,
    /// Name of the link it moves.
    pub link: String,
    /// Its frame at value 0 in that of the joint before, m.
    pub origin: Isometry3<f64>,
    /// Its axis in its own frame, of unit length.
    pub axis: Vector3<f64>,
    /// Turning or sliding.
    pub kind: JointKind,
    /// Least and greatest value, rad (m).
    pub range: Option<[f64; 2]>,
    /// Greatest speed, rad/s (m/s).
    pub velocity: Option<f64>,
    /// Greatest acceleration, rad/s^2 (m/s^2).
    pub acceleration: Option<f64>,
    /// Greatest jerk, rad/s^3 (m/s^3).
    pub jerk: Option<f64>,
    /// Greatest torque, N m (N).
    pub torque: Option<f64>,
    /// The link, in the frame of the joint after its motion.
    pub inertial: Option<Inertial>,
    /// Rotor inertia at the joint, kg m^2 (kg).
    pub rotor_inertia: Option<f64>,
    /// Viscous friction (N m s/rad) and Coulomb friction forward and backward (N m, magnitudes).
    pub friction: Option<[f64; 3]>,
}

impl ArmDescription {
    /// Unknown quantities, one entry per kind, with the names of the joints it is missing for: "torque: a1, a2".
    pub fn missing(&self) -> Vec<String> {
        type Known = fn(&JointDescription) -> bool;
        let kinds: [(&str, Known); 6] = [
            ("range (taken as +- one turn)", |joint| joint.range.is_some()),
            ("velocity", |joint| joint.velocity.is_some()),
            ("acceleration", |joint| joint.acceleration.is_some()),
            ("jerk", |joint| joint.jerk.is_some()),
            ("torque", |joint| joint.torque.is_some()),
            ("link inertia", |joint| joint.inertial.is_some()),
        ];
        let mut missing = Vec::new();
        for (what, known) in kinds {
            let names: Vec<&str> = self.joints.iter().filter(|j| !known(j)).map(|j| j.name.as_str()).collect();
            if !names.is_empty() {
                missing.push(format!("{what}: {}", names.join(", ")));
            }
        }
        missing
    }

    /// The arm, if it has `N` joints. Drive limits and dynamics are those that are known for every joint.
    ///
    /// # Errors
    /// [`KinematicsError::JointCount`], or what is wrong with a joint or link, by name.
    pub fn build<const N: usize>(&self) -> Result<Arm<N>, KinematicsError> {
        let count = || KinematicsError::JointCount { given: self.joints.len(), expected: N };
        let described: &[JointDescription; N] = self.joints.as_slice().try_into().map_err(|_| count())?;
        let mut joints = [Joint::revolute(Isometry3::identity(), Vector3::z())?; N];
        let (mut lower, mut upper) = (Joints::<N>::zeros(), Joints::<N>::zeros());
        for (i, joint) in described.iter().enumerate() {
            joints[i] = joint.geometry()?;
            [lower[i], upper[i]] = joint.checked_range()?;
        }
        let named = |error| match error {
            KinematicsError::InvalidLimit { joint, .. } => described[joint].in_joint(error),
            other => other,
        };
        let chain = Chain::new(joints)?.with_base(self.base)?.with_flange(self.flange)?;
        let range = JointRange::new(lower, upper).map_err(named)?;
        let drives = DriveLimits {
            velocity: every(described, |joint| joint.velocity),
            acceleration: every(described, |joint| joint.acceleration),
            jerk: every(described, |joint| joint.jerk),
            torque: every(described, |joint| joint.torque),
        };
        let arm = Arm::new(chain, range).with_drive_limits(drives).map_err(named)?;
        let mut bodies = [Inertial::none(); N];
        for (body, joint) in bodies.iter_mut().zip(described) {
            match joint.inertial {
                Some(inertial) => *body = inertial,
                None => return Ok(arm),
            }
        }
        let rotor = Joints::from_fn(|i, _| described[i].rotor_inertia.unwrap_or(0.0));
        let friction = |k: usize| Joints::from_fn(|i, _| described[i].friction.map_or(0.0, |friction| friction[k]));
        let friction = Friction::new(friction(0), friction(1), friction(2)).map_err(named)?;
        let dynamics = ArmDynamics::new(&chain, bodies)?.with_rotor_inertia(rotor).map_err(named)?;
        Ok(arm.with_dynamics(dynamics.with_friction(friction)))
    }
}

/// The values of all joints, if all are known.
fn every<const N: usize>(
    joints: &[JointDescription; N],
    value: impl Fn(&JointDescription) -> Option<f64>,
) -> Option<Joints<N>> {
    let mut values = Joints::zeros();
    for (i, joint) in joints.iter().enumerate() {
        values[i] = value(joint)?;
    }
    Some(values)
}

/// Refuses names of joints that cannot be told apart, or that a table of text would not give back.
#[cfg(any(feature = "json", feature = "urdf"))]
pub(crate) fn have_usable_names(joints: &[JointDescription]) -> Result<(), KinematicsError> {
    let refused = |rule, name: &str| Err(KinematicsError::Structure { rule, found: name.escape_debug().to_string() });
    for (k, JointDescription { name, .. }) in joints.iter().enumerate() {
        if name.is_empty() {
            return refused("every joint must have a name", name);
        }
        if name.trim() != name || name.contains(char::is_control) {
            return refused(
                "the name of a joint must not begin or end with a blank, nor hold a control character",
                name,
            );
        }
        if joints[..k].iter().any(|before| before.name == *name) {
            return refused("every joint must have a name of its own", name);
        }
    }
    Ok(())
}

/// Largest difference from 1 of the length of an axis in a file: digits cut off, not another meaning.
const AXIS_ROUNDING: f64 = 1e-3;

impl JointDescription {
    fn in_joint(&self, source: KinematicsError) -> KinematicsError {
        source.in_part(Part::Joint, &self.name)
    }

    fn geometry(&self) -> Result<Joint, KinematicsError> {
        let length = self.axis.norm();
        if length > f64::MIN_POSITIVE && (length - 1.0).abs() > AXIS_ROUNDING {
            return Err(self.in_joint(KinematicsError::NotUnitAxis { length }));
        }
        Joint::new(self.origin, self.axis, self.kind).map_err(|error| self.in_joint(error))
    }

    fn checked_range(&self) -> Result<[f64; 2], KinematicsError> {
        match (self.range, self.kind) {
            (Some(range), _) => {
                let one = |value: f64| Joints::<1>::new(value);
                let checked = JointRange::new(one(range[0]), one(range[1]));
                checked.map(|_| range).map_err(|error| match error {
                    KinematicsError::InvalidLimit { what, value, rule, .. } => {
                        self.in_joint(KinematicsError::InvalidSetting { what, value, rule })
                    }
                    other => self.in_joint(other),
                })
            }
            (None, JointKind::Revolute) => Ok([-ASSUMED_RANGE, ASSUMED_RANGE]),
            (None, JointKind::Prismatic) => {
                Err(self.in_joint(KinematicsError::Missing { what: "range, which a sliding joint must have" }))
            }
        }
    }
}
