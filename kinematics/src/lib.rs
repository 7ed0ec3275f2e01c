//! Serial robot arms: kinematics forward, differential and inverse (closed-form and numeric), and rigid-body dynamics.
//!
//! # Frames and conventions
//!
//! * SI throughout: m, rad, s, kg, N m.
//! * An arm is `base * prod_i (origin_i * motion_i(q_i)) * flange * tool`, see [`Chain`]. Poses are **tool in base**
//!   (`Isometry3`); the flange's z points out of the mounting face.
//! * A twist or Jacobian has the rows **linear x y z, then angular x y z**, along the axes of the **base**, at the
//!   **tool point**. Its derivatives are plain derivatives of these numbers.
//! * The zero position belongs to the arm (the CR7's is the maker's, arm upright); nothing here assumes one.
//! * Joint indices count from 0 in code and from 1 in messages.
//! * `inverse_all` gives angles in (-pi, pi] and ignores joint limits; `inverse` keeps them and uses every turn of 2 pi.
//!
//! # What to take
//!
//! | you want | take |
//! |---|---|
//! | a ready arm | [`models::cr7`], [`models::ur5e`], [`models::kr6_r700`], [`models::puma560`], [`models::panda`], [`models::planar_2r`] |
//! | one with its limits, links and source | [`models::description`], [`ArmDescription::build`] |
//! | your own arm | [`Chain::new`], [`Chain::from_dh`], [`Chain::from_modified_dh`]; [`Arm::new`] |
//! | an arm from a file | `ArmDescription::from_urdf` (feature `urdf`), `ArmDescription::from_json` (feature `json`) |
//! | the pose of another element of a URDF | `urdf_origin` (feature `urdf`) |
//! | an arm whose number of joints the file decides | [`ArmDescription::build_any`], [`AnyArm`] |
//! | its tables and files | [`Chain::to_dh`], [`Chain::to_modified_dh`], [`ArmDescription::to_urdf`], `ArmDescription::to_json` (feature `json`) |
//! | pose, Jacobian, J' qd | [`ForwardKinematics`] |
//! | all inverse solutions | [`AnalyticInverse`]: [`ParallelAxisArm`], [`SphericalWristArm`], [`Arm`] |
//! | the solution near known joints | [`InverseKinematics`], [`BranchTracker`] |
//! | the inverse of any geometry, redundant joints | [`NumericArm`], [`Arm::locked`] |
//! | q', q'', q''' along a tool path | [`joint_derivatives`], [`least_norm_derivatives`] |
//! | the distance from singular poses | [`SingularityDistances`], [`Arm::nearest_singular_pose`], [`weakest_motion`], [`smallest_singular_value`], [`condition_number`], [`manipulability`] |
//! | torques, masses, what torque limits need along a path | [`Dynamics`], [`ArmDynamics`], [`PathTorque`], [`TorqueBounds`] |
//!
//! Nothing allocates once an arm is made, except [`AnyArm`], whose results are vectors. Without the feature `std`, which is
//! on by default, the crate needs neither standard library nor heap: arms of a fixed number of joints are there, descriptions
//! and [`AnyArm`] are not.
//!
//! ```
//! use arcfeed_kinematics::{AnalyticInverse, ForwardKinematics, InverseKinematics, Joints, models};
//! let arm = models::cr7();
//! let q = Joints::<6>::from([0.3, -0.2, 1.4, 0.3, -1.5, 0.0]);
//! let (pose, jacobian) = arm.forward_jacobian(&q);
//! for solution in &arm.inverse_all(&pose)? {
//!     assert!((arm.forward(solution).translation.vector - pose.translation.vector).norm() < 1e-12);
//! }
//! assert!((arm.inverse(&pose, &q)? - q).amax() < 1e-12);
//! # Ok::<(), arcfeed_kinematics::KinematicsError>(())
//! ```
#![cfg_attr(not(feature = "std"), no_std)]
#![forbid(unsafe_code)]

// Without the standard library `std::` is what `core` has of it.
#[cfg(not(feature = "std"))]
extern crate core as std;

mod analytic;
#[cfg(feature = "std")]
mod any_arm;
mod arm;
mod branch;
mod chain;
mod closed_form;
#[cfg(feature = "std")]
mod description;
mod dh;
mod differential;
mod dynamics;
mod error;
mod jacobian;
mod joint;
#[cfg(feature = "json")]
mod json;
mod lu;
pub mod models;
mod normalised;
mod numeric;
mod posture;
mod singular_pose;
mod singularity;
mod singularity_kind;
mod traits;
mod trig;
mod turns;
#[cfg(feature = "urdf")]
mod urdf;
#[cfg(feature = "std")]
mod urdf_export;

pub use nalgebra;

pub use analytic::{ClosedForm, Solutions};
#[cfg(feature = "std")]
pub use any_arm::{AnyArm, AnySingularPose, Dexterity};
pub use arm::{Arm, DriveLimits, InverseMethod};
pub use branch::{BranchTracker, Candidate, largest_step, nearest_solution};
pub use chain::Chain;
pub use closed_form::{ClosedFormArm, ParallelAxisArm, SphericalWristArm};
#[cfg(feature = "std")]
pub use description::{ASSUMED_RANGE, ArmDescription, JointDescription};
pub use dh::{DhRow, DhTable};
pub use differential::{
    JointDerivatives, MIN_SINGULAR_VALUE, ToolDerivatives, joint_derivatives, least_norm_derivatives,
};
pub use dynamics::{ArmDynamics, Dynamics, Friction, GRAVITY, Inertial, PathTorque, TorqueBounds};
pub use error::{KinematicsError, Part, ReachSide};
pub use jacobian::{Configuration, Jacobian, Twist};
pub use joint::{Joint, JointKind, JointLimits, JointRange, Joints};
pub use numeric::{NullSpace, NumericArm, NumericSettings, NumericSolution};
#[cfg(feature = "std")]
pub use posture::NoPosture;
pub use posture::Posture;
pub use singular_pose::{SingularPose, WeakestMotion, weakest_motion};
pub use singularity::{
    SingularityDistances, condition_number, manipulability, singular_values, smallest_singular_value,
};
pub use singularity_kind::SingularityKind;
pub use traits::{AnalyticInverse, ForwardKinematics, InverseKinematics, PoseResidual};
pub use turns::{LimitExcess, nearest_turns};
#[cfg(feature = "urdf")]
pub use urdf::urdf_origin;
