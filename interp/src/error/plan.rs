//! Reasons why a path does not become a motion.

use arcfeed_feedrate::LimitId;
use arcfeed_geometry::GeometryError;
use thiserror::Error;

use super::cause::Cause;
use super::limit::LimitError;
use super::path::PathError;
use super::speed::SpeedError;
use crate::place::PathPlace;

/// Everything that can go wrong between a path and a verified trajectory, by what a caller can do about it.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum PlanError {
    /// The arm cannot follow the path.
    #[error(transparent)]
    Path(#[from] PathError),
    /// A limit or a setting cannot be used.
    #[error(transparent)]
    Limit(#[from] LimitError),
    /// No speed keeps the limits.
    #[error(transparent)]
    Speed(#[from] SpeedError),
    /// The finished trajectory breaks a limit; it must not be executed.
    #[error(
        "the finished trajectory breaks a limit and is withheld: {} reaches {:.4} % of its limit at {place}, t = {t:.4} s; {cause}",
        limit, 100.0 * ratio
    )]
    Unverified {
        /// Which limit.
        limit: LimitId,
        /// Value over limit.
        ratio: f64,
        /// The place.
        place: PathPlace,
        /// The time, s.
        t: f64,
        /// The feature of the path there.
        cause: Cause,
    },
}

impl PlanError {
    /// The place on the path at which it fails, where it is one place.
    pub fn place(&self) -> Option<&PathPlace> {
        match self {
            Self::Path(error) => error.place(),
            Self::Speed(SpeedError::Infeasible { place, .. }) | Self::Unverified { place, .. } => Some(place),
            _ => None,
        }
    }
}

impl From<GeometryError> for PlanError {
    fn from(error: GeometryError) -> Self {
        Self::Path(error.into())
    }
}
