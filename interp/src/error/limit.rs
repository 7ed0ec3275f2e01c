//! Errors in the limits of a motion.

use arcfeed_kinematics::KinematicsError;
use thiserror::Error;

/// Why limits, sections or settings cannot be used. The way out is another number.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum LimitError {
    /// A limit is not a finite number above 0.
    #[error("{what} is {value}, but has to be a finite number above 0")]
    NotPositive {
        /// Which limit.
        what: &'static str,
        /// The value given.
        value: f64,
    },
    /// A limit of a joint is unusable.
    #[error("limits: {0}")]
    Joint(#[from] KinematicsError),
    /// A row of a table of limits is unusable.
    #[error("table of limits, row {}: {value}, but {rule}", row + 1)]
    Table {
        /// Which row, from 0.
        row: usize,
        /// The value given.
        value: f64,
        /// The rule and the remedy.
        rule: &'static str,
    },
    /// Something is said of a joint that the arm has not.
    #[error("{what} is for joint {}, but the arm has {joints} joints: give the number of one of them", joint + 1)]
    NoSuchJoint {
        /// What is for that joint.
        what: &'static str,
        /// Which joint, from 0.
        joint: usize,
        /// Number of joints.
        joints: usize,
    },
    /// A natural frequency or a damping is unusable.
    #[error("oscillator: {value}, but {rule}")]
    Oscillator {
        /// The value given.
        value: f64,
        /// The rule.
        rule: &'static str,
    },
    /// A payload is beyond those of a table.
    #[error(
        "the payload is {payload} kg, but the table of limits is for 0 to {most} kg: add a column, or take off load"
    )]
    Payload {
        /// The payload, kg.
        payload: f64,
        /// The greatest payload of the table, kg.
        most: f64,
    },
    /// A path of this kind cannot be planned without a limit, or not with it.
    #[error("{limit} {problem}: {remedy}")]
    Unsuited {
        /// Which limit.
        limit: &'static str,
        /// Why it does not suit.
        problem: &'static str,
        /// The remedy.
        remedy: &'static str,
    },
    /// The grid of a path is too coarse or too fine.
    #[error("{intervals} intervals: a plan takes 4 to {most}; 200 to 2000 are usual")]
    Intervals {
        /// Intervals asked for.
        intervals: usize,
        /// The most that are taken.
        most: usize,
    },
    /// A path needs more points than a plan takes.
    #[error(
        "the path needs {intervals} intervals, a plan takes {most} at most; divide the path and plan its parts one after the other"
    )]
    TooFine {
        /// Intervals that the knots and bends of the path ask for.
        intervals: usize,
        /// The most that are taken.
        most: usize,
    },
    /// The windows in which long paths are planned are too short or too long.
    #[error("windows of {intervals} intervals: a window takes {fewest} to {most}; 2000 to 20000 are usual")]
    Window {
        /// Intervals asked for.
        intervals: usize,
        /// The fewest that are taken.
        fewest: usize,
        /// The most.
        most: usize,
    },
    /// A section with a feed of its own is not a part of the path.
    #[error("feed section {}, {from} to {to} {unit}: {rule}", index + 1)]
    Section {
        /// Which one, from 0.
        index: usize,
        /// The start.
        from: f64,
        /// The end.
        to: f64,
        /// The kind of the two.
        unit: &'static str,
        /// The rule that is broken.
        rule: &'static str,
    },
    /// Two sections with feeds of their own overlap.
    #[error(
        "feed sections {} and {} overlap at s = {s:.6} m: let one end where the other begins",
        first + 1,
        second + 1
    )]
    SectionsOverlap {
        /// The one that begins first, from 0.
        first: usize,
        /// The other one, from 0.
        second: usize,
        /// The start of the overlap, m.
        s: f64,
    },
    /// A speed law does not run over the whole path.
    #[error(
        "the speed law runs from {start} to {end}, the path from 0 to {length}: a law has to run over the whole path"
    )]
    Law {
        /// The start of the law.
        start: f64,
        /// The end.
        end: f64,
        /// The end of the path.
        length: f64,
    },
    /// A motion takes longer than can be verified.
    #[error(
        "the motion takes {duration:.3e} s, more than the {longest:.3e} s that are planned at this control period: raise the limits, lengthen the period, or split the path"
    )]
    TooLong {
        /// Duration, s.
        duration: f64,
        /// Longest duration that is taken at the control period, s.
        longest: f64,
    },
}

/// A finite number above 0.
pub(crate) fn positive(what: &'static str, value: f64) -> Result<f64, LimitError> {
    if value.is_finite() && value > 0.0 { Ok(value) } else { Err(LimitError::NotPositive { what, value }) }
}
