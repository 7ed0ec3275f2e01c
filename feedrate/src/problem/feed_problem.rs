//! The problem itself, and the interface of its planners.

use super::bound_table::BoundTable;
use super::row_table::RowTable;
use crate::constraint::{PathConstraint, Place, Within};
use crate::error::{FeedError, not_negative};
use crate::row::{JerkRow, LimitId, Quantity, Row};
use crate::speed_law::SpeedLaw;
use crate::state::MotionState;

/// Squared speeds of axes over an interval in units of their limits: Bernstein coefficients of a
/// polynomial of degree 4 in `s` that is above each of them, so that its product with `x(s)` must
/// stay below 1.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SpeedBound {
    pub coefficients: [f64; 5],
    pub source: LimitId,
}

/// Find the fastest `sdot(s)` along a path that keeps rows and caps: the input of every
/// [`FeedPlanner`].
///
/// The path parameter may have any unit; no planner depends on it.
#[derive(Debug, Clone)]
pub struct FeedProblem {
    pub(super) s: Vec<f64>,
    pub(super) points: RowTable,
    pub(super) middles: RowTable,
    pub(super) speed_bounds: Vec<SpeedBound>,
    pub(super) jerk_rows: Vec<JerkRow>,
    pub(super) jerk_rows_per_place: usize,
    pub(super) bounds: BoundTable,
    pub(super) v_start: f64,
    /// Acceleration at the start; 0 unless the problem goes on from a motion.
    pub(super) a_start: f64,
    pub(super) v_end: f64,
}

impl FeedProblem {
    /// The limits at the points of a strictly increasing grid, from rest to rest.
    ///
    /// # Errors
    /// [`FeedError::Empty`] for fewer than two points, [`FeedError::NotFinite`],
    /// [`FeedError::BadGrid`], [`FeedError::LengthMismatch`] for a constraint made for another
    /// grid, [`FeedError::BadRow`].
    pub fn at_points(s: &[f64], constraints: &[&dyn PathConstraint]) -> Result<Self, FeedError> {
        Self::new(s, constraints, false)
    }

    /// Like [`FeedProblem::at_points`], with what planners need that keep the limits between the
    /// points too.
    ///
    /// # Errors
    /// As [`FeedProblem::at_points`].
    pub fn between_points(s: &[f64], constraints: &[&dyn PathConstraint]) -> Result<Self, FeedError> {
        Self::new(s, constraints, true)
    }

    fn new(s: &[f64], constraints: &[&dyn PathConstraint], between: bool) -> Result<Self, FeedError> {
        if s.len() < 2 {
            return Err(FeedError::Empty { what: "grid intervals" });
        }
        if let Some(&value) = s.iter().find(|s| !s.is_finite()) {
            return Err(FeedError::NotFinite { what: "grid point", value });
        }
        if let Some(k) = (1..s.len()).find(|&k| s[k] <= s[k - 1]) {
            return Err(FeedError::BadGrid { index: k, s: s[k], previous: s[k - 1] });
        }
        if !(s[s.len() - 1] - s[0]).is_finite() {
            return Err(FeedError::OutOfRange { what: "length of the grid" });
        }
        for got in constraints.iter().filter_map(|constraint| constraint.points()) {
            if got != s.len() {
                return Err(FeedError::LengthMismatch { what: "a constraint (grid points)", got, expected: s.len() });
            }
        }
        let bad = |index: usize, row: LimitId| FeedError::BadRow { index, s: s[index], row };
        let mut points = RowTable::with_capacity(s.len());
        points.collect(Place::Point(0), constraints).map_err(|row| bad(0, row))?;
        points.rows.reserve((points.rows.len() + 1) * s.len());
        for i in 1..s.len() {
            points.collect(Place::Point(i), constraints).map_err(|row| bad(i, row))?;
        }
        let mut problem = Self {
            s: s.to_vec(),
            points,
            middles: RowTable::default(),
            speed_bounds: Vec::new(),
            jerk_rows: Vec::new(),
            jerk_rows_per_place: 0,
            bounds: BoundTable::default(),
            v_start: 0.0,
            a_start: 0.0,
            v_end: 0.0,
        };
        problem.collect_jerk(constraints)?;
        if between {
            problem.middles = problem.points.emptied(s.len() - 1);
            problem.speed_bounds.reserve(s.len() - 1);
            for k in 0..s.len() - 1 {
                let h = s[k + 1] - s[k];
                problem.middles.collect(Place::Middle { k, h }, constraints).map_err(|row| bad(k, row))?;
                problem.speed_bounds.push(speed_bound(constraints, k, h).map_err(|row| bad(k, row))?);
            }
            problem.bounds = BoundTable::collect(s, constraints);
        }
        Ok(problem)
    }

    fn collect_jerk(&mut self, constraints: &[&dyn PathConstraint]) -> Result<(), FeedError> {
        for k in 0..self.intervals() {
            let h = self.h(k);
            for within in [Within::Start, Within::Middle, Within::End] {
                let start = self.jerk_rows.len();
                for constraint in constraints {
                    constraint.jerk_rows(k, h, within, &mut self.jerk_rows);
                }
                let got = self.jerk_rows.len() - start;
                if k == 0 && within == Within::Start {
                    if got == 0 {
                        return Ok(());
                    }
                    self.jerk_rows_per_place = got;
                    self.jerk_rows.reserve(3 * got * self.intervals());
                }
                if got != self.jerk_rows_per_place {
                    let expected = self.jerk_rows_per_place;
                    return Err(FeedError::LengthMismatch { what: "jerk rows of an interval", got, expected });
                }
                let sound = |row: &JerkRow| (row.alpha + row.beta + row.gamma).is_finite() && row.limit > 0.0;
                if let Some(row) = self.jerk_rows[start..].iter().find(|row| !sound(row)) {
                    return Err(FeedError::BadRow { index: k, s: self.s[k], row: row.source });
                }
            }
        }
        Ok(())
    }

    /// Asks for speeds `ds/dt` at both ends.
    ///
    /// # Errors
    /// [`FeedError::NotFinite`], [`FeedError::Negative`].
    pub fn with_end_speeds(mut self, v_start: f64, v_end: f64) -> Result<Self, FeedError> {
        self.v_start = not_negative("start speed", v_start)?;
        self.v_end = not_negative("end speed", v_end)?;
        Ok(self)
    }

    /// Asks for a state at the start that a motion along the same path has there.
    pub(crate) fn going_on_from(mut self, state: MotionState) -> Self {
        (self.v_start, self.a_start) = (state.v, state.a);
        self
    }

    /// The grid, `intervals() + 1` points.
    pub fn grid(&self) -> &[f64] {
        &self.s
    }

    /// Number of intervals.
    pub fn intervals(&self) -> usize {
        self.s.len() - 1
    }

    /// Length of interval `k`.
    pub fn h(&self, k: usize) -> f64 {
        self.s[k + 1] - self.s[k]
    }

    /// The rows at grid point `i`.
    pub fn rows(&self, i: usize) -> &[Row] {
        self.points.rows(i)
    }

    /// Greatest `x = (ds/dt)^2` at grid point `i` that the caps allow, and which limit that is.
    pub fn cap(&self, i: usize) -> (f64, LimitId) {
        (self.points.x_max(i), self.points.source(i))
    }

    pub(crate) fn x_max(&self, i: usize) -> f64 {
        self.points.x_max(i)
    }

    /// The rows in the middle of interval `k`; none unless built by
    /// [`FeedProblem::between_points`].
    pub fn middle_rows(&self, k: usize) -> &[Row] {
        if self.middles.is_empty() { &[] } else { self.middles.rows(k) }
    }

    /// Greatest `x` in the middle of interval `k`; infinite unless built by
    /// [`FeedProblem::between_points`].
    pub(crate) fn middle_x_max(&self, k: usize) -> f64 {
        if self.middles.is_empty() { f64::INFINITY } else { self.middles.x_max(k) }
    }

    /// The jerk rows at one place of interval `k`.
    pub fn jerk_rows(&self, k: usize, within: Within) -> &[JerkRow] {
        let place = 3 * k + within as usize;
        &self.jerk_rows[place * self.jerk_rows_per_place..(place + 1) * self.jerk_rows_per_place]
    }

    /// Returns true if limits between the points are known.
    pub fn is_between_points(&self) -> bool {
        !self.middles.is_empty()
    }

    /// Returns true if any jerk is limited.
    pub fn has_jerk(&self) -> bool {
        self.jerk_rows_per_place > 0
    }

    pub(crate) fn speed_bound(&self, k: usize) -> &SpeedBound {
        &self.speed_bounds[k]
    }

    /// Speed asked for at the start (m/s).
    pub fn v_start(&self) -> f64 {
        self.v_start
    }

    /// Acceleration asked for at the start (m/s^2).
    pub(crate) fn a_start(&self) -> f64 {
        self.a_start
    }

    /// Speed asked for at the end (m/s).
    pub fn v_end(&self) -> f64 {
        self.v_end
    }
}

/// The coefficient-wise maximum over all axes, which is above each of them because Bernstein
/// polynomials are positive.
fn speed_bound(constraints: &[&dyn PathConstraint], k: usize, h: f64) -> Result<SpeedBound, LimitId> {
    let mut bound = SpeedBound { coefficients: [0.0; 5], source: LimitId::path(Quantity::Other) };
    let (mut worst, mut bad) = (0.0, None);
    for constraint in constraints {
        constraint.axis_speeds(k, h, &mut |[b0, b1, b2], limit, source| {
            // The square of a quadratic in Bernstein form.
            let square = [b0 * b0, b0 * b1, (b0 * b2 + 2.0 * b1 * b1) / 3.0, b1 * b2, b2 * b2];
            let inverse = 1.0 / (limit * limit);
            let (mut most, mut lost) = (0.0, false);
            for (sum, value) in bound.coefficients.iter_mut().zip(square) {
                // A limit of 0 makes this infinite, or NaN for an axis that stands still.
                let scaled = if value == 0.0 { 0.0 } else { value * inverse };
                lost |= scaled.is_nan();
                most = if scaled > most { scaled } else { most };
                *sum = if scaled > *sum { scaled } else { *sum };
            }
            if lost {
                bad = Some(source);
            }
            if most > worst {
                (worst, bound.source) = (most, source);
            }
        });
    }
    bad.map_or(Ok(bound), Err)
}

/// Plans the speed along a path.
pub trait FeedPlanner {
    /// The law of motion this planner finds for the problem.
    ///
    /// # Errors
    /// Why there is none: where, which row and by how much.
    fn plan(&self, problem: &FeedProblem) -> Result<SpeedLaw, FeedError>;
}
