//! An arm whose number of joints is known at run time only.

use crate::{
    arm::{Arm, InverseMethod},
    description::ArmDescription,
    dynamics::Dynamics,
    error::{KinematicsError, Part},
    joint::Joints,
    singular_pose::{SingularPose, weakest_motion},
    singularity::{SingularityDistances, condition_number, manipulability, smallest_singular_value},
    singularity_kind::SingularityKind,
    traits::{AnalyticInverse, ForwardKinematics, InverseKinematics},
};
use nalgebra::Isometry3;
use std::any::Any;

/// An arm from a file: joint vectors are slices whose length is checked. [`AnyArm::get`] gives the [`Arm`] inside, for
/// everything else and for speed.
///
/// ```
/// use arcfeed_kinematics::{Arm, Joints, models};
/// let arm = models::description("panda").expect("built in").build_any()?;
/// assert_eq!(arm.joints(), 7);
/// let q = [0.0, -0.4, 0.0, -2.0, 0.0, 1.6, 0.7];
/// let found = arm.inverse(&arm.forward(&q)?, &q)?;
/// let inside: &Arm<7> = arm.get().expect("seven joints");
/// assert!(inside.range().contains(&Joints::from_column_slice(&found)));
/// assert_eq!(arm.forward(&[0.0; 6]).unwrap_err().to_string(), "6 joint values were given, but the arm has 7 joints");
/// # Ok::<(), arcfeed_kinematics::KinematicsError>(())
/// ```
#[derive(Debug, Clone)]
pub struct AnyArm {
    name: String,
    joint_names: Vec<String>,
    arm: Box<dyn Erased>,
}

/// The results of the differential kinematics at one place.
#[derive(Debug, Clone, PartialEq)]
pub struct Dexterity {
    /// Columns of the Jacobian: linear x y z, angular x y z.
    pub jacobian: Vec<[f64; 6]>,
    /// Smallest singular value.
    pub sigma_min: f64,
    /// The direction in which the tool moves that little: linear x y z, angular x y z, of norm 1.
    pub weakest: [f64; 6],
    /// Largest over smallest singular value.
    pub condition: f64,
    /// Yoshikawa's manipulability.
    pub manipulability: f64,
    /// Distances to the singular poses, for arms with a closed form.
    pub singularities: Option<SingularityDistances>,
}

/// [`SingularPose`] of an [`AnyArm`].
#[derive(Debug, Clone, PartialEq)]
pub struct AnySingularPose {
    /// Its joint values, inside the joint range.
    pub q: Vec<f64>,
    /// Its distance from the given joint values, rad (sliding joints: m): no less than that of the nearest of all.
    pub distance: f64,
    /// The direction in which the tool cannot move there: linear x y z, angular x y z.
    pub lost: [f64; 6],
    /// The kind, where geometry tells: see [`SingularPose::kind`].
    pub kind: Option<SingularityKind>,
}

impl AnyArm {
    /// The greatest number of joints.
    pub const MAX_JOINTS: usize = 10;

    fn new(description: &ArmDescription) -> Result<Self, KinematicsError> {
        let arm: Box<dyn Erased> = match description.joints.len() {
            1 => Box::new(description.build::<1>()?),
            2 => Box::new(description.build::<2>()?),
            3 => Box::new(description.build::<3>()?),
            4 => Box::new(description.build::<4>()?),
            5 => Box::new(description.build::<5>()?),
            6 => Box::new(description.build::<6>()?),
            7 => Box::new(description.build::<7>()?),
            8 => Box::new(description.build::<8>()?),
            9 => Box::new(description.build::<9>()?),
            10 => Box::new(description.build::<10>()?),
            given => return Err(KinematicsError::JointCount { given, expected: given.clamp(1, Self::MAX_JOINTS) }),
        };
        let joint_names = description.joints.iter().map(|joint| joint.name.clone()).collect();
        Ok(Self { name: description.name.clone(), joint_names, arm })
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The names of its joints.
    pub fn joint_names(&self) -> &[String] {
        &self.joint_names
    }

    /// The number of joints.
    pub fn joints(&self) -> usize {
        self.joint_names.len()
    }

    /// The arm itself, if it has `N` joints.
    pub fn get<const N: usize>(&self) -> Option<&Arm<N>> {
        self.arm.as_any().downcast_ref()
    }

    /// The method of its inverse.
    pub fn method(&self) -> InverseMethod {
        self.arm.method()
    }

    /// Least and greatest joint values, rad (m).
    pub fn range(&self) -> (&[f64], &[f64]) {
        self.arm.range()
    }

    /// The same arm with its tool point at `tool` in the frame of the flange.
    ///
    /// # Errors
    /// [`KinematicsError::NotFinite`] or [`KinematicsError::NotUnit`].
    pub fn with_tool(&self, tool: Isometry3<f64>) -> Result<Self, KinematicsError> {
        Ok(Self { arm: self.arm.with_tool(tool)?, ..self.clone() })
    }

    /// One ordinary number per joint, or the name of the joint for which it is none.
    fn check(&self, values: &[f64]) -> Result<(), KinematicsError> {
        if values.len() != self.joints() {
            return Err(KinematicsError::JointCount { given: values.len(), expected: self.joints() });
        }
        match values.iter().zip(&self.joint_names).find(|(value, _)| !value.is_finite()) {
            Some((value, name)) => {
                let rule = "an ordinary number";
                let source = KinematicsError::InvalidSetting { what: "its value", value: *value, rule };
                Err(source.in_part(Part::Joint, name))
            }
            None => Ok(()),
        }
    }

    /// Pose of the tool in the base.
    ///
    /// # Errors
    /// [`KinematicsError::JointCount`]; [`KinematicsError::InPart`] names a joint whose value is not finite.
    pub fn forward(&self, q: &[f64]) -> Result<Isometry3<f64>, KinematicsError> {
        self.check(q)?;
        self.arm.forward(q)
    }

    /// Jacobian and what follows from it.
    ///
    /// # Errors
    /// As [`AnyArm::forward`].
    pub fn dexterity(&self, q: &[f64]) -> Result<Dexterity, KinematicsError> {
        self.check(q)?;
        self.arm.dexterity(q)
    }

    /// The nearest singular pose that a search around `q` finds, see [`Arm::nearest_singular_pose`].
    ///
    /// # Errors
    /// As [`AnyArm::forward`].
    pub fn nearest_singular_pose(&self, q: &[f64]) -> Result<Option<AnySingularPose>, KinematicsError> {
        self.check(q)?;
        self.arm.nearest_singular_pose(q)
    }

    /// Joint values near `seed` that put the tool at `target`, see [`InverseKinematics::inverse`].
    ///
    /// # Errors
    /// As [`AnyArm::forward`] for the seed; those of [`InverseKinematics::inverse`].
    pub fn inverse(&self, target: &Isometry3<f64>, seed: &[f64]) -> Result<Vec<f64>, KinematicsError> {
        self.check(seed)?;
        self.arm.inverse(target, seed)
    }

    /// All joint values that put the tool at `target` or, for a numeric inverse, several; and whether these are all.
    ///
    /// # Errors
    /// Those of [`AnalyticInverse::inverse_all`].
    pub fn inverse_all(&self, target: &Isometry3<f64>) -> Result<(Vec<Vec<f64>>, bool), KinematicsError> {
        self.arm.inverse_all(target)
    }

    /// The torques of a motion, if the arm's links are known.
    ///
    /// # Errors
    /// As [`AnyArm::forward`]; [`KinematicsError::Missing`] if a link's inertia is unknown.
    pub fn torque(&self, q: &[f64], qd: &[f64], qdd: &[f64]) -> Result<Vec<f64>, KinematicsError> {
        [q, qd, qdd].into_iter().try_for_each(|values| self.check(values))?;
        self.arm.torque(q, qd, qdd)
    }
}

impl ArmDescription {
    /// The arm, whatever its number of joints.
    ///
    /// # Errors
    /// [`KinematicsError::JointCount`] for none or more than [`AnyArm::MAX_JOINTS`]; as [`ArmDescription::build`].
    pub fn build_any(&self) -> Result<AnyArm, KinematicsError> {
        AnyArm::new(self)
    }
}

/// [`Arm`] without its number of joints.
trait Erased: std::fmt::Debug + Send + Sync {
    fn as_any(&self) -> &dyn Any;
    fn boxed(&self) -> Box<dyn Erased>;
    fn method(&self) -> InverseMethod;
    fn range(&self) -> (&[f64], &[f64]);
    fn with_tool(&self, tool: Isometry3<f64>) -> Result<Box<dyn Erased>, KinematicsError>;
    fn forward(&self, q: &[f64]) -> Result<Isometry3<f64>, KinematicsError>;
    fn dexterity(&self, q: &[f64]) -> Result<Dexterity, KinematicsError>;
    fn nearest_singular_pose(&self, q: &[f64]) -> Result<Option<AnySingularPose>, KinematicsError>;
    fn inverse(&self, target: &Isometry3<f64>, seed: &[f64]) -> Result<Vec<f64>, KinematicsError>;
    fn inverse_all(&self, target: &Isometry3<f64>) -> Result<(Vec<Vec<f64>>, bool), KinematicsError>;
    fn torque(&self, q: &[f64], qd: &[f64], qdd: &[f64]) -> Result<Vec<f64>, KinematicsError>;
}

impl Clone for Box<dyn Erased> {
    fn clone(&self) -> Self {
        self.boxed()
    }
}

fn joints<const N: usize>(values: &[f64]) -> Result<Joints<N>, KinematicsError> {
    let count = |_| KinematicsError::JointCount { given: values.len(), expected: N };
    <[f64; N]>::try_from(values).map(Joints::from).map_err(count)
}

impl<const N: usize> Erased for Arm<N> {
    fn as_any(&self) -> &dyn Any {
        self
    }

    fn boxed(&self) -> Box<dyn Erased> {
        Box::new(*self)
    }

    fn method(&self) -> InverseMethod {
        self.method()
    }

    fn range(&self) -> (&[f64], &[f64]) {
        (self.range().lower().as_slice(), self.range().upper().as_slice())
    }

    fn with_tool(&self, tool: Isometry3<f64>) -> Result<Box<dyn Erased>, KinematicsError> {
        Ok(Box::new(self.with_tool(tool)?))
    }

    fn forward(&self, q: &[f64]) -> Result<Isometry3<f64>, KinematicsError> {
        Ok(ForwardKinematics::forward(self, &joints(q)?))
    }

    fn dexterity(&self, q: &[f64]) -> Result<Dexterity, KinematicsError> {
        let q = joints(q)?;
        let jacobian = self.jacobian(&q);
        Ok(Dexterity {
            sigma_min: smallest_singular_value(&jacobian),
            weakest: weakest_motion(&jacobian).tool.into(),
            condition: condition_number(&jacobian),
            manipulability: manipulability(&jacobian),
            singularities: self.singularity_distances(&q),
            jacobian: jacobian.column_iter().map(|column| column.into_owned().into()).collect(),
        })
    }

    fn nearest_singular_pose(&self, q: &[f64]) -> Result<Option<AnySingularPose>, KinematicsError> {
        let any = |SingularPose { q, distance, lost, kind }: SingularPose<N>| AnySingularPose {
            q: q.as_slice().to_vec(),
            distance,
            lost: lost.into(),
            kind,
        };
        Ok(self.nearest_singular_pose(&joints(q)?).map(any))
    }

    fn inverse(&self, target: &Isometry3<f64>, seed: &[f64]) -> Result<Vec<f64>, KinematicsError> {
        Ok(InverseKinematics::inverse(self, target, &joints(seed)?)?.as_slice().to_vec())
    }

    fn inverse_all(&self, target: &Isometry3<f64>) -> Result<(Vec<Vec<f64>>, bool), KinematicsError> {
        let all = AnalyticInverse::inverse_all(self, target)?;
        Ok((all.iter().map(|q| q.as_slice().to_vec()).collect(), all.is_complete()))
    }

    fn torque(&self, q: &[f64], qd: &[f64], qdd: &[f64]) -> Result<Vec<f64>, KinematicsError> {
        let (q, qd, qdd) = (joints(q)?, joints(qd)?, joints(qdd)?);
        let dynamics = self.dynamics().ok_or(KinematicsError::Missing { what: "inertia of every link" })?;
        Ok(dynamics.torque(&q, &qd, &qdd).as_slice().to_vec())
    }
}
