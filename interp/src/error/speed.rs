//! Why no speed along a path keeps the limits, and where.

use arcfeed_feedrate::{FeedError, LimitId, PathEnd, Quantity};
use thiserror::Error;

use crate::place::PathPlace;

/// Why there is no speed law. The way out is a higher limit, or another path at the place named.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SpeedError {
    /// No speed along the path keeps the limits at one place of it.
    #[error("{}", infeasible(place, *row, *why, *value, *limit))]
    Infeasible {
        /// The place.
        place: PathPlace,
        /// The limit that is broken, and of which joint.
        row: LimitId,
        /// In which way.
        why: Infeasibility,
        /// The value that cannot be avoided, SI.
        value: f64,
        /// Its limit, SI.
        limit: f64,
    },
    /// The speed asked for at an end of the path cannot be had.
    #[error("{}", end_speed(*end, *speed, [*lowest, *highest], *row, place))]
    EndSpeed {
        /// Which end.
        end: PathEnd,
        /// The speed asked for, units of the parameter per s.
        speed: f64,
        /// Lowest speed that can be had.
        lowest: f64,
        /// Highest speed that can be had.
        highest: f64,
        /// The limit that is in the way; none where it is how the rest of the path has to be run.
        row: Option<LimitId>,
        /// The place where the limit is met.
        place: PathPlace,
    },
    /// A look-ahead window and a speed at the end of the path exclude each other.
    #[error(
        "an end speed of {speed} m/s needs the whole path in view, but a look-ahead window plans as if the path ended at rest at its end: leave out one of the two"
    )]
    WindowEndSpeed {
        /// The speed asked for at the end, m/s.
        speed: f64,
    },
    /// The planner says so.
    #[error("speed along the path: {0}")]
    Feed(#[from] FeedError),
}

/// In which way a limit cannot be kept.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Infeasibility {
    /// Holding still breaks it already.
    AtRest,
    /// It is broken at every speed at which this other limit is kept.
    Against(LimitId),
    /// The motion comes to rest there and cannot go on.
    Standstill,
}

/// The change that a person can make about a limit.
fn way_out(row: LimitId) -> &'static str {
    match row.quantity {
        Quantity::JointTorque => {
            "raise the torque limit, carry less, move the path to where the arm reaches out less, or start from another configuration"
        }
        Quantity::JointVelocity | Quantity::JointAcceleration | Quantity::JointJerk => {
            "raise the joint's limit, or move the path away from singular poses"
        }
        Quantity::Corner => "round the corner off, or let the tool stop there",
        _ => "raise that limit",
    }
}

fn infeasible(place: &PathPlace, row: LimitId, why: Infeasibility, value: f64, limit: f64) -> String {
    let (unit, way_out) = (row.quantity.unit(), way_out(row));
    let (size, most) = (value.abs(), limit.abs());
    let over = format!("{:.4} {unit} over its limit of {most:.4} {unit}", size - most);
    match why {
        Infeasibility::AtRest => {
            format!("at {place} holding still needs a {row} of {size:.4} {unit}, {over}: {way_out}")
        }
        Infeasibility::Against(other) => format!(
            "at {place} no speed keeps {row} together with {other}: the least is {size:.4} {unit}, {over}: {way_out}"
        ),
        Infeasibility::Standstill => format!("at {place} {row} holds the motion at rest: {way_out}"),
    }
}

fn end_speed(end: PathEnd, speed: f64, [lowest, highest]: [f64; 2], row: Option<LimitId>, place: &PathPlace) -> String {
    let unit = place.parameter.unit();
    let because = match row.filter(|row| row.quantity != Quantity::ControllableSet) {
        Some(row) => row.to_string(),
        None if end == PathEnd::Start => "what the path ahead leaves room for".to_owned(),
        None => "what the path before leaves room for".to_owned(),
    };
    format!(
        "{end} speed {speed} {unit}/s cannot be had: {lowest:.6} to {highest:.6} {unit}/s is possible, because of {because} \
         at {place}: ask for a speed in between, or raise the limits there"
    )
}

impl SpeedError {
    /// The error of a planner of the feedrate crate, with its place; `grid` are the values of the parameter it planned on.
    pub(crate) fn explained(error: FeedError, grid: &[f64], place: impl Fn(f64) -> PathPlace) -> Self {
        let last = grid.last().copied().unwrap_or(0.0);
        match error {
            FeedError::StaticallyInfeasible { s, row, value, limit, .. } => {
                Self::Infeasible { place: place(s), row, why: Infeasibility::AtRest, value, limit }
            }
            FeedError::Infeasible { s, row, against, excess, limit, .. } => {
                let value = limit + excess.copysign(limit);
                Self::Infeasible { place: place(s), row, why: Infeasibility::Against(against), value, limit }
            }
            FeedError::Standstill { s, row, .. } => {
                Self::Infeasible { place: place(s), row, why: Infeasibility::Standstill, value: 0.0, limit: 0.0 }
            }
            FeedError::SpeedOutOfReach { end, speed, lowest, highest, row, s } => {
                Self::EndSpeed { end, speed, lowest, highest, row: Some(row), place: place(s) }
            }
            FeedError::StartTooFast { speed, segment, highest_start: highest, .. } => {
                let place = place(grid.get(segment).copied().unwrap_or(last));
                Self::EndSpeed { end: PathEnd::Start, speed, lowest: 0.0, highest, row: None, place }
            }
            FeedError::EndTooFast { speed, highest } => {
                Self::EndSpeed { end: PathEnd::End, speed, lowest: 0.0, highest, row: None, place: place(last) }
            }
            FeedError::WindowEndSpeed { speed } => Self::WindowEndSpeed { speed },
            error => Self::Feed(error),
        }
    }

    /// True if the planner gave up without saying that there is no motion.
    pub(crate) fn is_not_converged(&self) -> bool {
        matches!(
            self,
            Self::Feed(FeedError::NotConverged { .. } | FeedError::LengthMismatch { .. } | FeedError::TooMany { .. })
        )
    }
}
