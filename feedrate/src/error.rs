//! Errors of a request, with the numbers that explain them.

use crate::row::LimitId;

/// An end of a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PathEnd {
    /// The start.
    Start,
    /// The end.
    End,
}

impl std::fmt::Display for PathEnd {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Start => "start",
            Self::End => "end",
        })
    }
}

/// Why a profile or a plan was refused.
///
/// Every variant carries the quantity, its value and the bound it broke, so that a caller can add
/// the place and print one line that says what to change.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FeedError {
    /// A quantity that must be finite is NaN or infinite.
    #[error("{what} is {value}; it must be a finite number")]
    NotFinite {
        /// Name of the argument or field.
        what: &'static str,
        /// The value given.
        value: f64,
    },
    /// A quantity that must be above zero is not.
    #[error("{what} is {value}; it must be greater than 0")]
    NotPositive {
        /// Name of the argument or field.
        what: &'static str,
        /// The value given.
        value: f64,
    },
    /// A number of a blend does not follow from the others.
    #[error("{what} is {value}; a blend with this start, velocity and duration needs {needed}")]
    NoBlend {
        /// Name of the argument or field.
        what: &'static str,
        /// The value given.
        value: f64,
        /// The value that the blend needs.
        needed: f64,
    },
    /// A quantity that must not be below zero is.
    #[error("{what} is {value}; it must not be negative")]
    Negative {
        /// Name of the argument or field.
        what: &'static str,
        /// The value given.
        value: f64,
    },
    /// A requested speed is above the limit it has to respect.
    #[error("{what} is {value}, above the limit {limit}; lower it or raise the limit")]
    AboveLimit {
        /// Name of the argument or field.
        what: &'static str,
        /// The value given.
        value: f64,
        /// The limit.
        limit: f64,
    },
    /// A quantity that must be below zero is not.
    #[error("{what} is {value}; it must be less than 0")]
    NotBelowZero {
        /// Name of the argument or field.
        what: &'static str,
        /// The value given.
        value: f64,
    },
    /// A requested value is below the least one possible.
    #[error("{what} is {value}, below the limit {limit}; raise it or lower the limit")]
    BelowLimit {
        /// Name of the argument or field.
        what: &'static str,
        /// The value given.
        value: f64,
        /// The limit.
        limit: f64,
    },
    /// The end of the path cannot be reached from here without running backwards.
    #[error(
        "the end is {remaining} ahead and cannot be reached there with v = {v} and a = {a} without running backwards: the \
         shortest change of speed covers {needed}; move the end, bring its speed closer to the present one, or \
         allow more acceleration and jerk"
    )]
    EndTooClose {
        /// Displacement left (m).
        remaining: f64,
        /// Displacement of the shortest change of speed (m).
        needed: f64,
        /// Speed asked for at the end (m/s).
        v: f64,
        /// Acceleration asked for at the end (m/s²).
        a: f64,
    },
    /// The displacement does not suffice to change the speed as asked.
    #[error(
        "going from {v_start} to {v_end} takes a displacement of {required}, only {length} is given; \
         bring the two speeds closer, or let one of them be adjusted"
    )]
    TooShort {
        /// Displacement given (m).
        length: f64,
        /// Displacement the change of speed takes (m).
        required: f64,
        /// Start speed (m/s).
        v_start: f64,
        /// End speed (m/s).
        v_end: f64,
    },
    /// The arguments are valid one by one, but their combination leaves the range of `f64`.
    #[error(
        "{what} is not representable as a finite number for these arguments; use units in which the numbers are closer to 1"
    )]
    OutOfRange {
        /// The quantity that overflowed.
        what: &'static str,
    },
    /// A list that must hold something is empty.
    #[error("the list of {what} is empty; give at least one")]
    Empty {
        /// Name of the entries of the list.
        what: &'static str,
    },
    /// Two lists that belong together differ in length.
    #[error("{what} has {got} entries, {expected} are needed")]
    LengthMismatch {
        /// Name of the argument.
        what: &'static str,
        /// Entries found.
        got: usize,
        /// Entries needed.
        expected: usize,
    },
    /// One segment of a path carries an invalid number.
    #[error("segment {index}: {what} is {value}; it must be finite and greater than 0")]
    BadSegment {
        /// Index of the segment, from 0.
        index: usize,
        /// Name of the field.
        what: &'static str,
        /// The value given.
        value: f64,
    },
    /// The start speed is too high to keep what lies ahead.
    #[error(
        "start speed {speed} is too high: segment {segment} allows {allowed} where braking from it reaches {lowest} \
         at the least; start at {highest_start} or slower"
    )]
    StartTooFast {
        /// Start speed given (m/s).
        speed: f64,
        /// Index of the segment at whose start the limit cannot be met (the number of segments: the
        /// end of the path).
        segment: usize,
        /// Speed that would be needed there (m/s).
        allowed: f64,
        /// Lowest speed that can be reached there (m/s).
        lowest: f64,
        /// Highest start speed from which the path can be run (m/s).
        highest_start: f64,
    },
    /// A problem too large for the memory it would take.
    #[error("{got} {what}, more than {most}; use a coarser grid, or plan the path in parts")]
    TooMany {
        /// Name of the quantity that is too large.
        what: &'static str,
        /// The number given.
        got: usize,
        /// Largest number allowed.
        most: usize,
    },
    /// The grid of a path does not increase.
    #[error(
        "grid point {index} lies at {s}, which is not after the one before it at {previous}; drop duplicate points"
    )]
    BadGrid {
        /// Index of the grid point.
        index: usize,
        /// Its position (m).
        s: f64,
        /// Position of the one before (m).
        previous: f64,
    },
    /// A row holds a number that is not finite, or bounds that exclude each other.
    #[error("at s = {s} (grid point {index}): the row for {row} is not finite, or its bounds exclude each other")]
    BadRow {
        /// Index of the grid point, or of the interval that starts there.
        index: usize,
        /// Position (m).
        s: f64,
        /// The row.
        row: LimitId,
    },
    /// Standing still breaks a limit.
    #[error(
        "at s = {s} (grid point {index}): holding still already needs {row} of {value}, above its limit {limit}; \
         raise it, or use the reachability planner, which may pass in motion"
    )]
    StaticallyInfeasible {
        /// Index of the grid point.
        index: usize,
        /// Position (m).
        s: f64,
        /// The limit that is broken.
        row: LimitId,
        /// Value at rest, in the unit of the limit.
        value: f64,
        /// The limit.
        limit: f64,
    },
    /// No motion passes a point: two limits exclude each other at every speed.
    #[error(
        "at s = {s} (grid point {index}): no speed keeps {row} together with {against}; \
         the limit {limit} on the first is exceeded by {excess} at the least"
    )]
    Infeasible {
        /// Index of the grid point.
        index: usize,
        /// Position (m).
        s: f64,
        /// The limit that is broken.
        row: LimitId,
        /// The limit that stands against it.
        against: LimitId,
        /// Least excess over the first limit while the other is kept, in its own unit.
        excess: f64,
        /// The limit.
        limit: f64,
    },
    /// The motion comes to rest and cannot leave.
    #[error("at s = {s} (grid point {index}): {row} holds the motion at rest there; raise that limit")]
    Standstill {
        /// Index of the grid point.
        index: usize,
        /// Position (m).
        s: f64,
        /// The limit that holds it.
        row: LimitId,
    },
    /// Two neighbouring knots of a speed law are both at rest: the motion does not get from one to
    /// the other.
    #[error(
        "knot {index} at s = {s} and the next at s = {next} are both at rest; give one of them a speed, or drop one"
    )]
    StandsStill {
        /// Index of the first knot.
        index: usize,
        /// Position (m).
        s: f64,
        /// Position of the next knot (m).
        next: f64,
    },
    /// No limit bounds the speed.
    #[error("at s = {s} (grid point {index}): nothing limits the speed; give a feed or a limit on velocity")]
    Unbounded {
        /// Index of the grid point.
        index: usize,
        /// Position (m).
        s: f64,
    },
    /// The speed asked for at an end of the path cannot be had.
    #[error(
        "{end} speed {speed} is out of reach: feasible is {lowest} to {highest}, because of {row} at s = {s} or later limits"
    )]
    SpeedOutOfReach {
        /// At which end.
        end: PathEnd,
        /// The speed asked for (m/s).
        speed: f64,
        /// Lowest speed that works (m/s).
        lowest: f64,
        /// Highest speed that works (m/s).
        highest: f64,
        /// The limit that is met first.
        row: LimitId,
        /// Position (m).
        s: f64,
    },
    /// The solver did not arrive at its tolerance.
    #[error("{what} did not converge: {residual} is left after {iterations} iterations")]
    NotConverged {
        /// The algorithm.
        what: &'static str,
        /// Iterations made.
        iterations: usize,
        /// Remaining violation of optimality or feasibility (relative).
        residual: f64,
    },
    /// A scan with a look-ahead window does not know the end of the path in time to reach a speed
    /// there.
    #[error(
        "end speed {speed} is asked for, but a scan with a look-ahead window always plans to rest; remove the window or the end speed"
    )]
    WindowEndSpeed {
        /// End speed asked for (m/s).
        speed: f64,
    },
    /// The look-ahead window of a stream has no place for another segment.
    #[error("{most} segments wait already, as many as the look-ahead window holds; push again after a cycle")]
    StreamFull {
        /// Segments that the window holds.
        most: usize,
    },
    /// A segment was pushed after the end of a stream.
    #[error("the stream has ended; push every segment before finish")]
    StreamEnded,
    /// Limits that must be the same in both directions differ.
    #[error(
        "the limits {lower} and {upper} on {what} differ in size; this motion needs the same limit in both directions"
    )]
    NotSymmetric {
        /// `"v"`, `"a"` or `"j"`.
        what: &'static str,
        /// The lower limit.
        lower: f64,
        /// The upper limit.
        upper: f64,
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
        "no motion takes exactly {duration} s; {}{}",
        LastBelow(*.below),
        NextAbove(*.above)
    )]
    DurationImpossible {
        /// The duration asked for (s).
        duration: f64,
        /// The longest possible duration below it (s), if there is one.
        below: Option<f64>,
        /// The shortest possible duration above it (s); infinite where none is known.
        above: f64,
    },
    /// The motion leaves the range of positions.
    #[error("at t = {time} s the position is {position}, beyond the limit {limit}; move the limit or slow down before")]
    LeavesPositions {
        /// The farthest position (m).
        position: f64,
        /// Time of that position (s).
        time: f64,
        /// The limit it breaks (m).
        limit: f64,
    },
    /// A range of positions is no interval.
    #[error("the positions are limited to [{lower}, {upper}]; the lower end must be below the upper one")]
    EmptyRange {
        /// The lower end given (m).
        lower: f64,
        /// The upper end given (m).
        upper: f64,
    },
    /// The hardest braking from the start leaves the range of positions.
    #[error(
        "from v = {v} and a = {a} even the hardest braking goes to {position}, beyond the limit {limit}; \
         start slower or farther from it, or allow more acceleration and jerk"
    )]
    StartTrapped {
        /// Velocity of the start (m/s).
        v: f64,
        /// Acceleration of the start (m/s²).
        a: f64,
        /// Where the hardest braking turns (m).
        position: f64,
        /// The limit it breaks (m).
        limit: f64,
    },
    /// Every motion to the target comes from outside the range of positions.
    #[error(
        "to arrive with v = {v} and a = {a} a motion must have turned at {position} or farther out, beyond the limit \
         {limit}; move the target away from that limit or lower its velocity"
    )]
    TargetTrapped {
        /// Velocity of the target (m/s).
        v: f64,
        /// Acceleration of the target (m/s²).
        a: f64,
        /// Where the shortest run-up turns (m).
        position: f64,
        /// The limit it breaks (m).
        limit: f64,
    },
    /// No motion from the start to the target was found inside the range of positions.
    #[error(
        "no motion between the two states stays within [{lower}, {upper}]; widen the range, or lower the velocities \
         and accelerations of both states"
    )]
    NoMotionInside {
        /// The lower end (m).
        lower: f64,
        /// The upper end (m).
        upper: f64,
    },
    /// The end speed cannot be reached.
    #[error("end speed {speed} is out of reach: the fastest motion arrives at {highest}; ask for that or less")]
    EndTooFast {
        /// End speed asked for (m/s).
        speed: f64,
        /// Speed at which the fastest motion arrives (m/s).
        highest: f64,
    },
}

/// The part of a text about the last duration below, if there is one.
struct LastBelow(Option<f64>);

impl std::fmt::Display for LastBelow {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.0 {
            Some(t) => write!(f, "{t} s is the last one below, "),
            None => Ok(()),
        }
    }
}

/// The next duration that is possible, if one is known.
struct NextAbove(f64);

impl std::fmt::Display for NextAbove {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.0.is_finite() {
            write!(f, "{} s is the next one that is possible", self.0)
        } else {
            write!(f, "no longer one is known: take a shorter one, or widen the range of positions")
        }
    }
}

pub(crate) fn finite(what: &'static str, value: f64) -> Result<f64, FeedError> {
    if value.is_finite() { Ok(value) } else { Err(FeedError::NotFinite { what, value }) }
}

pub(crate) fn positive(what: &'static str, value: f64) -> Result<f64, FeedError> {
    finite(what, value)?;
    if value > 0.0 { Ok(value) } else { Err(FeedError::NotPositive { what, value }) }
}

pub(crate) fn not_negative(what: &'static str, value: f64) -> Result<f64, FeedError> {
    finite(what, value)?;
    if value >= 0.0 { Ok(value) } else { Err(FeedError::Negative { what, value }) }
}

pub(crate) fn below_zero(what: &'static str, value: f64) -> Result<f64, FeedError> {
    finite(what, value)?;
    if value < 0.0 { Ok(value) } else { Err(FeedError::NotBelowZero { what, value }) }
}
