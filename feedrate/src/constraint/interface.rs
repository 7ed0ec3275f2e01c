//! The interface of a limit: rows at places of the grid, and bounds over whole intervals.

use crate::row::{IntervalBound, JerkRow, LimitId, Quantity, Row};

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

/// A place in an interval at which jerk rows are asked for; the middle is the one of
/// [`Place::Middle`].
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

    /// Appends its jerk rows at one place of interval `k` of length `h`, always the same number and
    /// in the same order.
    fn jerk_rows(&self, _k: usize, _h: f64, _within: Within, _out: &mut Vec<JerkRow>) {}

    /// Appends what bounds the motion on the whole of interval `k` of length `h`: what the scans
    /// with S-profiles and motion that is changed while it runs are planned by.
    ///
    /// Without an answer of its own a constraint gives the hulls of its rows through both ends and
    /// the middle of the interval.
    fn interval_bounds(&self, k: usize, h: f64, out: &mut Vec<IntervalBound>) {
        hulls_of_rows(self, k, h, out);
    }

    /// Speeds of axes by `s`, as Bernstein coefficients of a quadratic over interval `k` of length
    /// `h` that holds where the path is piecewise cubic; each with the limit (> 0) on the magnitude
    /// of the axis speed.
    fn axis_speeds(&self, _k: usize, _h: f64, _out: &mut dyn FnMut([f64; 3], f64, LimitId)) {}
}

/// Takes the rows and the speed cap of one place.
#[derive(Debug)]
pub struct RowSink<'a> {
    pub(crate) rows: &'a mut Vec<Row>,
    /// True if all rows are finite, with bounds that leave something.
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

// Bounds over a whole interval from the rows at three places of it.

/// Least and greatest Bernstein coefficient of the quadratic through values at both ends and in the
/// middle, which enclose it.
fn hull([p, m, q]: [f64; 3]) -> [f64; 2] {
    let inner = 2.0 * m - 0.5 * (p + q);
    [p.min(q).min(inner), p.max(q).max(inner)]
}

fn magnitude(values: [f64; 3]) -> f64 {
    let [least, most] = hull(values);
    most.max(-least)
}

/// Appends the bounds of a constraint on interval `k` of length `h`: of its caps the least, of the
/// coefficients of its rows the hulls.
fn hulls_of_rows<C: PathConstraint + ?Sized>(constraint: &C, k: usize, h: f64, out: &mut Vec<IntervalBound>) {
    let [near, middle, far] = [Place::Point(k), Place::Middle { k, h }, Place::Point(k + 1)].map(|place| {
        let mut rows = Vec::new();
        let source = LimitId::path(Quantity::Other);
        let mut sink = RowSink { rows: &mut rows, sound: true, x_max: f64::INFINITY, source };
        constraint.rows(place, &mut sink);
        // A cap of 0 is a stop, which is made anyway.
        if sink.x_max > 0.0 && sink.x_max.is_finite() {
            out.push(IntervalBound::Speed { most: sink.x_max.sqrt(), source: sink.source });
        }
        rows
    });
    constraint.axis_speeds(k, h, &mut |speeds, limit, source| {
        let most = speeds.iter().fold(0.0, |most: f64, speed| most.max(speed.abs()));
        if most > 0.0 {
            out.push(IntervalBound::Speed { most: limit / most, source });
        }
    });
    for m in &middle {
        // At a point there may be rows of both sides.
        let same = |rows: &[Row]| rows.iter().filter(|row| row.source == m.source).copied().collect::<Vec<_>>();
        for p in same(&near) {
            for q in same(&far) {
                out.push(of_three(&p, m, &q));
            }
        }
    }
    let [near, middle, far] = [Within::Start, Within::Middle, Within::End].map(|within| {
        let mut rows: Vec<JerkRow> = Vec::new();
        constraint.jerk_rows(k, h, within, &mut rows);
        rows
    });
    out.extend(middle.iter().zip(near.iter().zip(&far)).map(|(m, (p, q))| {
        let most = |of: fn(&JerkRow) -> f64| magnitude([of(p), of(m), of(q)]);
        let (alpha, beta, gamma) = (most(|row| row.alpha), most(|row| row.beta), most(|row| row.gamma));
        IntervalBound::Jerk { alpha, beta, gamma, step: 0.0, limit: m.limit, source: m.source }
    }));
}

fn of_three(p: &Row, m: &Row, q: &Row) -> IntervalBound {
    let three = |of: fn(&Row) -> f64| [of(p), of(m), of(q)];
    let [least, most] = hull(three(|row| row.d));
    // What is left above and below what remains at rest.
    let limit = (m.hi - most).min(least - m.lo);
    let [a, b, c] = [magnitude(three(|row| row.a)), magnitude(three(|row| row.b)), magnitude(three(|row| row.c))];
    IntervalBound::Acceleration { a, b, c, rest: 0.0, limit, source: m.source }
}
