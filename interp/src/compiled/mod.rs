//! Compiled joint trajectories: polynomials of the time, and a certificate of what they do between samples.

mod bernstein;
mod certificate;
mod certified_limit;
mod compile;
mod error;
mod fit;
mod joint_trajectory;
#[cfg(feature = "json")]
mod json;
mod magnitude_certificate;
mod motion_certificate;
mod nodes;
mod piece;
mod plan;
mod points;
mod reach;
mod sampling;
mod steps;
mod table_certificate;
mod tool_certificate;
mod tool_search;
mod torque_certificate;

pub use certificate::{Certificate, CertifiedBound, CertifiedJump, certify};
pub use certified_limit::CertifiedLimit;
pub use error::{CompileError, JointTrajectoryError};
pub use joint_trajectory::{Deviation, Interpolation, JointSetpoint, JointTrajectory};
pub use motion_certificate::{CertifiedFeed, MotionCertificate};
pub use plan::CompiledPlan;
pub use points::JointPoint;
pub use sampling::{JointCursor, JointSetpoints};
pub use table_certificate::{TableBound, TableCertificate};
pub use tool_certificate::ToolCertificate;
pub use tool_search::ToolBound;
pub use torque_certificate::{TorqueBound, TorqueCertificate};
