//! What can be wrong with a state-to-state request.

/// Why a state-to-state motion was refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StateToStateError {
    /// A number that must be finite is NaN or infinite.
    #[error("{what} is {value}; it must be a finite number")]
    NotFinite {
        /// Name of the field.
        what: &'static str,
        /// The value given.
        value: f64,
    },
    /// A limit lies on the wrong side of zero, or on it.
    #[error("{what} is {value}; an upper limit must be greater and a lower limit less than 0")]
    LimitSign {
        /// Name of the limit.
        what: &'static str,
        /// The value given.
        value: f64,
    },
    /// The target lies outside a limit.
    #[error("{what} of the target is {value}, outside the limit {limit}; move the target inside or widen the limit")]
    TargetOutside {
        /// `"v"` or `"a"`.
        what: &'static str,
        /// The value given.
        value: f64,
        /// The limit it breaks.
        limit: f64,
    },
    /// Every motion that arrives in the target state breaks a velocity limit right before it.
    #[error(
        "to arrive at v = {v} with a = {a} the velocity must have been {before} just before, outside the limit {limit}; \
         lower the target's acceleration or move its velocity away from that limit"
    )]
    TargetUnreachable {
        /// Velocity of the target (m/s).
        v: f64,
        /// Acceleration of the target (m/s²).
        a: f64,
        /// Velocity no motion towards the target can avoid (m/s).
        before: f64,
        /// The limit it breaks (m/s).
        limit: f64,
    },
    /// Every motion that has arrived in the target state breaks a velocity limit right after it.
    #[error(
        "after arriving at v = {v} with a = {a} the velocity goes on to {after}, outside the limit {limit}; \
         lower the target's acceleration or move its velocity away from that limit"
    )]
    TargetOvershoots {
        /// Velocity of the target (m/s).
        v: f64,
        /// Acceleration of the target (m/s²).
        a: f64,
        /// Velocity no motion on from the target can avoid (m/s).
        after: f64,
        /// The limit it breaks (m/s).
        limit: f64,
    },
    /// No motion takes this long: too short, or inside a blocked interval.
    #[error(
        "no motion takes exactly {duration} s; {}{above} s is the next one that is possible",
        below_text(.below)
    )]
    DurationImpossible {
        /// The duration asked for (s).
        duration: f64,
        /// The longest possible duration below it (s), if there is one.
        below: Option<f64>,
        /// The shortest possible duration above it (s).
        above: f64,
    },
    /// The motion leaves the range of positions.
    #[error("at t = {time} s the position is {position}, beyond the limit {limit}; move the limit or slow down before")]
    LeavesPositions {
        /// The farthest position (m).
        position: f64,
        /// When it is there (s).
        time: f64,
        /// The limit it breaks (m).
        limit: f64,
    },
    /// The numbers are valid one by one, but the motion between them leaves the range of `f64`.
    #[error(
        "the motion is not representable in finite numbers for these arguments; \
         use units in which the numbers are closer to 1"
    )]
    OutOfRange,
}

fn below_text(below: &Option<f64>) -> String {
    below.map_or_else(String::new, |t| format!("{t} s is the last one below, "))
}

pub(super) fn finite(what: &'static str, value: f64) -> Result<f64, StateToStateError> {
    if value.is_finite() { Ok(value) } else { Err(StateToStateError::NotFinite { what, value }) }
}
