//! What can be wrong with a request, with the numbers that say why.

/// Why a synchronised motion was refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SyncError {
    /// A number of one axis breaks a rule.
    #[error("axis {}: {what} is {value}; it must be {rule}", axis + 1)]
    Axis {
        /// Index of the axis, from 0.
        axis: usize,
        /// Name of the argument.
        what: &'static str,
        /// The value given.
        value: f64,
        /// What the value must be.
        rule: &'static str,
    },
    /// A requested duration is NaN, infinite or negative.
    #[error("the least duration is {value} s; it must be finite and not negative")]
    Duration {
        /// The value given (s).
        value: f64,
    },
    /// A number of a tool's state or limits breaks a rule.
    #[error("{what} is {value}; it must be {rule}")]
    Tool {
        /// Name of the argument.
        what: &'static str,
        /// The value given.
        value: f64,
        /// What the value must be.
        rule: &'static str,
    },
    /// A control cycle is NaN, infinite, zero or negative.
    #[error("the control cycle is {value} s; it must be finite and greater than 0")]
    Cycle {
        /// The value given (s).
        value: f64,
    },
    /// The motion of one axis between two states is impossible.
    #[error("axis {}: {source}", axis + 1)]
    State {
        /// Index of the axis, from 0.
        axis: usize,
        /// What is wrong with it.
        source: arcfeed_feedrate::StateToStateError,
    },
    /// There is no axis with this index.
    #[error("there is no axis {}: there are {count}", axis + 1)]
    NoSuchAxis {
        /// The index given.
        axis: usize,
        /// How many axes there are.
        count: usize,
    },
    /// A motion that has to be straight cannot be.
    #[error(
        "axis {} leaves the straight line: displacement, velocities and accelerations of both states must all \
         point along one line; start and end at rest, or synchronise by time",
        axis + 1
    )]
    NotStraight {
        /// Index of the first axis that is off the line, from 0.
        axis: usize,
    },
    /// The period of a cycle is NaN, infinite or negative.
    #[error("the period is {value} s; it must be finite and not negative")]
    Period {
        /// The value given (s).
        value: f64,
    },
    /// The numbers are valid one by one, but the motion between them leaves the range of `f64`.
    #[error(
        "the motion is not representable in finite numbers for these arguments; use units in which the numbers are closer to 1"
    )]
    OutOfRange,
    /// The scalar motion along the line cannot be built.
    #[error("along the line: {0}")]
    Line(#[from] arcfeed_feedrate::FeedError),
}
