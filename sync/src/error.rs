//! Errors of a request, with the numbers that explain them.

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
        /// The rule that the value must keep.
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
        /// The rule that the value must keep.
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
        /// The error of the axis.
        source: arcfeed_feedrate::FeedError,
    },
    /// A number of a way-point breaks a rule.
    #[error("way-point {}, axis {}: the {what} is {value}; it must be {rule}", index + 1, axis + 1)]
    WayPoint {
        /// Index of the way-point, from 0.
        index: usize,
        /// Index of the axis, from 0.
        axis: usize,
        /// Name of the number.
        what: &'static str,
        /// The value given.
        value: f64,
        /// The rule that the value must keep.
        rule: &'static str,
    },
    /// A blend is not possible at a way-point.
    #[error("way-point {} has a blend of {value}; it must be {rule}", index + 1)]
    Blend {
        /// Index of the way-point, from 0.
        index: usize,
        /// The deviation given (rad or m).
        value: f64,
        /// The rule that the blend must keep.
        rule: &'static str,
    },
    /// There are more way-points than one motion can have.
    #[error(
        "there are {count} way-points, blends counted as one more each; at most {most} can be planned at once: send the others later"
    )]
    TooManyWayPoints {
        /// Number of way-points given, and of their blends.
        count: usize,
        /// The most there can be.
        most: usize,
    },
    /// There is no section with this index.
    #[error("there is no section {}: there are {count}", index + 1)]
    NoSuchSection {
        /// The index given.
        index: usize,
        /// Number of sections.
        count: usize,
    },
    /// Limits were set on a route, which is followed or on which the axes stop.
    #[error(
        "the limits on a route are those of the route: set a route with other limits, or wait until the axes stand; `stop` ends the route at once"
    )]
    LimitsOfRoute,
    /// Round-off takes an axis over a limit.
    #[error("axis {} would exceed a limit between two way-points by round-off: use units in which the numbers are closer to 1", axis + 1)]
    SectionExceeds {
        /// Index of the axis, from 0.
        axis: usize,
    },
    /// There is no axis with this index.
    #[error("there is no axis {}: there are {count}", axis + 1)]
    NoSuchAxis {
        /// The index given.
        axis: usize,
        /// Number of axes.
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
    /// A motion that has to be straight would exceed the limits of an axis.
    #[error(
        "axis {} would exceed its limits on the straight line: together the axes have less jerk to take back its \
         acceleration than it has alone; wait until its acceleration is lower, or synchronise by time",
        axis + 1
    )]
    LineExceeds {
        /// Index of the first such axis, from 0.
        axis: usize,
    },
    /// The range of an axis is no interval.
    #[error("axis {}: its range is [{lower}, {upper}]; the lower end must be below the upper one", axis + 1)]
    Range {
        /// Index of the axis, from 0.
        axis: usize,
        /// The lower end given.
        lower: f64,
        /// The upper end given.
        upper: f64,
    },
    /// A start or a target lies outside the range of an axis.
    #[error(
        "axis {}: the {what} is at {position}, outside its range [{lower}, {upper}]; move it inside",
        axis + 1
    )]
    OutsideRange {
        /// Index of the axis, from 0.
        axis: usize,
        /// `"start"` or `"target"`.
        what: &'static str,
        /// The position given (rad or m).
        position: f64,
        /// Lower end of the range.
        lower: f64,
        /// Upper end of the range.
        upper: f64,
    },
    /// The motion to the target leaves the range of an axis between.
    #[error(
        "axis {} would be at {position} after {time} s, beyond {limit}, the end of its range; \
         stop it first, move its target away from that end, or raise its acceleration and jerk limits",
        axis + 1
    )]
    LeavesRange {
        /// Index of the axis, from 0.
        axis: usize,
        /// The farthest position (rad or m).
        position: f64,
        /// Time of that position, from now on (s).
        time: f64,
        /// The end of the range it passes.
        limit: f64,
    },
    /// An axis that goes on after its target, or where it is now, cannot stop before its range
    /// ends.
    #[error(
        "axis {} goes on from its {what} and cannot stop before {limit}, the end of its range: it would be at \
         {position}; lower the velocity of its {what} or move that away from the end",
        axis + 1
    )]
    CannotStop {
        /// Index of the axis, from 0.
        axis: usize,
        /// `"present state"` or `"target"`.
        what: &'static str,
        /// The farthest position (rad or m).
        position: f64,
        /// The end of the range it passes.
        limit: f64,
    },
    /// The period of a cycle is NaN, infinite or negative.
    #[error("the period is {value} s; it must be finite and not negative")]
    Period {
        /// The value given (s).
        value: f64,
    },
    /// The time after which a jog ends is NaN, infinite or negative.
    #[error("the time-out of the jog is {value} s; it must be finite and not negative")]
    Timeout {
        /// The value given (s).
        value: f64,
    },
    /// A scale of time is NaN or outside its range.
    #[error("the scale of time is {value}; it must be from 0 to 1.5")]
    Scale {
        /// The value given.
        value: f64,
    },
    /// The numbers are valid one by one, but the motion between them leaves the range of `f64`.
    #[error(
        "the motion is not representable in finite numbers for these arguments; use units in which the numbers are closer to 1"
    )]
    OutOfRange,
}

impl SyncError {
    /// The same error where the axes have other indices.
    pub(crate) fn of_axis(mut self, index: impl Fn(usize) -> usize) -> Self {
        if let Self::State { axis, .. } | Self::NotStraight { axis } | Self::LineExceeds { axis } = &mut self {
            *axis = index(*axis);
        }
        self
    }
}
