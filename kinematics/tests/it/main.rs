//! Tests of poses, derivatives, inverse, dynamics and readers, in one binary.

mod allocation;
mod common;
mod derivatives;
mod dynamics;
mod input_validation;
mod inverse;
#[cfg(feature = "json")]
mod json;
mod models;
mod nearest_branch;
mod numeric;
mod oracle;
mod posture;
mod singular_pose;
mod spherical_wrist;
#[cfg(feature = "urdf")]
mod urdf;

#[cfg(feature = "urdf")]
#[path = "common/damaged_urdf.rs"]
mod damaged_urdf;
