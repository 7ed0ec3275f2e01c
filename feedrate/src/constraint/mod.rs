//! Limits on joints and tool, each turned into rows along a path.
//!
//! A constraint states its limit once and answers for every use of it. It yields rows at every place of the grid: at the grid points,
//! in the middle between two, and (jerk) at both ends of every interval, where the third derivatives of a spline jump; and it yields
//! bounds that hold on a whole interval ([`IntervalBound`]). [`crate::FeedProblem`] collects them; nothing past that knows which
//! constraint a row came from but by its [`LimitId`].

mod hull;
mod joint;
mod path;
mod tool;
mod torque;

pub use joint::{JointAcceleration, JointJerk, JointVelocity};
pub use path::PathDerivatives;
pub use tool::{Feed, SpeedCap, Stop, TangentialAcceleration, TangentialJerk};
pub use torque::JointTorque;

use crate::row::{IntervalBound, JerkRow, LimitId, Row};

/// A place on the grid at which rows are asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Place {
    /// Grid point `i`.
    Point(usize),
    /// The middle between grid points `k` and `k + 1`, which lie `h` apart.
    Middle {
        /// Index of the interval.
        k: usize,
        /// Its length.
        h: f64,
    },
}

/// A place in an interval at which jerk rows are asked for; the middle is the one of [`Place::Middle`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Within {
    /// Just after its first point.
    Start,
    /// In the middle.
    Middle,
    /// Just before its last point.
    End,
}

/// A limit that yields rows along a path.
pub trait PathConstraint {
    /// Number of grid points it was made for; `None` if it suits any grid.
    fn points(&self) -> Option<usize>;

    /// Appends its rows and caps at one place.
    fn rows(&self, place: Place, out: &mut RowSink<'_>);

    /// Appends its jerk rows at one place of interval `k` of length `h`, always the same number and in the same order.
    fn jerk_rows(&self, _k: usize, _h: f64, _within: Within, _out: &mut Vec<JerkRow>) {}

    /// Appends what bounds the motion on the whole of interval `k` of length `h`: what the scans with S-profiles and motion that is
    /// changed while it runs are planned by.
    ///
    /// Without an answer of its own a constraint gives the hulls of its rows through both ends and the middle of the interval.
    fn interval_bounds(&self, k: usize, h: f64, out: &mut Vec<IntervalBound>) {
        hull::of_rows(self, k, h, out);
    }

    /// Speeds of axes by `s`, as Bernstein coefficients of a quadratic over interval `k` of length `h` that holds where
    /// the path is piecewise cubic; each with the limit (> 0) on the magnitude of the axis speed.
    fn axis_speeds(&self, _k: usize, _h: f64, _out: &mut dyn FnMut([f64; 3], f64, LimitId)) {}
}

/// Takes the rows and the speed cap of one place.
#[derive(Debug)]
pub struct RowSink<'a> {
    pub(crate) rows: &'a mut Vec<Row>,
    /// Whether all rows are finite, with bounds that leave something.
    pub(crate) sound: bool,
    pub(crate) x_max: f64,
    pub(crate) source: LimitId,
}

impl RowSink<'_> {
    /// Demands `x <= x_max`.
    pub fn cap(&mut self, x_max: f64, source: LimitId) {
        // NaN must not be lost in a comparison that is false.
        if !(x_max >= self.x_max) {
            self.x_max = x_max;
            self.source = source;
        }
    }

    /// Demands a row. One that can never bind (both bounds infinite) is dropped.
    pub fn row(&mut self, row: Row) {
        if !(row.lo == f64::NEG_INFINITY && row.hi == f64::INFINITY) {
            self.sound &= row.is_sound();
            self.rows.push(row);
        }
    }

    /// The same for rows that are known to be sound and to bind.
    pub(crate) fn sound_rows(&mut self, rows: impl Iterator<Item = Row>) {
        self.rows.extend(rows);
    }
}
