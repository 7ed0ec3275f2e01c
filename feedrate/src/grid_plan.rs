//! A planned speed along a grid, executed with the planner's own interpolation.

use crate::error::FeedError;
use crate::plan::SpeedPlan;
use crate::scurve::phases::Phase;
use crate::state::{MotionLaw, MotionState};

/// What stays constant between two grid points.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Law {
    /// `w = du/ds`, so that `x = sdot^2` is quadratic in `s`; with `w = 0` the acceleration is constant.
    SlopeOf(f64),
    /// The jerk (m/s³): first and last interval of a motion from or to rest.
    Jerk(f64),
    /// The jerk (m/s³), for a duration (s) from any state to any other.
    Phase(f64, f64),
}

/// The motion from one grid point to the next, by its state at the first.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Piece {
    t: f64,
    s: f64,
    v: f64,
    u: f64,
    law: Law,
}

/// `cosh(r)`, `sinh(r) / r` and `(cosh(r) - 1) / r^2` for `r^2 = z`, of either sign of `z`.
fn hyperbolic(z: f64) -> (f64, f64, f64) {
    if z.abs() < 0.25 {
        // Taylor's series; the first term left out is below 1e-16.
        let sum = |f: [f64; 7]| f.iter().rev().fold(0.0, |sum, c| sum * z + c);
        let c = sum([1.0, 0.5, 1.0 / 24.0, 1.0 / 720.0, 1.0 / 40_320.0, 1.0 / 3_628_800.0, 1.0 / 479_001_600.0]);
        let s = sum([1.0, 1.0 / 6.0, 1.0 / 120.0, 1.0 / 5040.0, 1.0 / 362_880.0, 1.0 / 39_916_800.0, 0.0]);
        let d = sum([0.5, 1.0 / 24.0, 1.0 / 720.0, 1.0 / 40_320.0, 1.0 / 3_628_800.0, 1.0 / 479_001_600.0, 0.0]);
        return (c, s, d);
    }
    let r = z.abs().sqrt();
    let (c, s) = if z > 0.0 { (r.cosh(), r.sinh()) } else { (r.cos(), r.sin()) };
    (c, s / r, (c - 1.0) / z)
}

impl Piece {
    fn after(&self, dt: f64) -> MotionState {
        let Self { s, v, u, .. } = *self;
        match self.law {
            Law::SlopeOf(w) => {
                let (c, sh, d) = hyperbolic(w * dt * dt);
                let speed = v * c + u * dt * sh;
                MotionState { p: s + dt * (v * sh + u * dt * d), v: speed, a: u * c + w * v * dt * sh, j: w * speed }
            }
            Law::Jerk(j) | Law::Phase(j, _) => MotionState {
                p: s + dt * (v + dt * (u / 2.0 + dt * j / 6.0)),
                v: v + dt * (u + dt * j / 2.0),
                a: u + dt * j,
                j,
            },
        }
    }

    /// The state after a distance within the piece.
    fn after_distance(&self, ds: f64) -> MotionState {
        match self.law {
            Law::SlopeOf(w) => {
                let v = (self.v * self.v + ds * (2.0 * self.u + w * ds)).max(0.0).sqrt();
                MotionState { p: self.s + ds, v, a: self.u + w * ds, j: w * v }
            }
            Law::Phase(j, duration) => {
                let phase = Phase { t: 0.0, s: self.s, v: self.v, a: self.u, j };
                MotionState { p: self.s + ds, ..phase.after(phase.time_to_cover(ds, duration)) }
            }
            Law::Jerk(j) => {
                // From rest s = j t^3 / 6; to rest the same, backwards from the end.
                let dt = if self.v == 0.0 {
                    (6.0 * ds / j).max(0.0).cbrt()
                } else {
                    let total = -self.u / j;
                    let left = self.v * total / 3.0 - ds;
                    total - (6.0 * left.max(0.0) / j).cbrt()
                };
                MotionState { p: self.s + ds, ..self.after(dt) }
            }
        }
    }
}

/// A speed law on a grid: [`MotionLaw`] with the interpolation its planner certified.
///
/// Between two grid points either the acceleration is constant (second-order planners), or its slope by `s` is (the
/// jerk-limited planner), or, where the latter starts or ends at rest, the jerk. That of a scan with jerk has phases of constant
/// jerk, which do not begin at grid points.
#[derive(Debug, Clone, PartialEq)]
pub struct GridPlan {
    pieces: Vec<Piece>,
    end: MotionState,
    duration: f64,
}

impl GridPlan {
    /// Constant acceleration between grid points, from the squared speeds at them.
    pub(crate) fn from_squared_speeds(s: &[f64], x: &[f64]) -> Result<Self, FeedError> {
        let mut builder = Builder::with_capacity(s.len());
        let mut v = x[0].sqrt();
        for k in 0..s.len() - 1 {
            let h = s[k + 1] - s[k];
            let v_end = x[k + 1].sqrt();
            builder.push(s[k], v, 0.5 * (x[k + 1] - x[k]) / h, Law::SlopeOf(0.0), 2.0 * h / (v + v_end));
            v = v_end;
        }
        builder.finish(s[s.len() - 1], x[x.len() - 1].sqrt())
    }

    /// Phases of constant jerk along a path of a length, from the first to the last point of a grid.
    pub(crate) fn from_phases(plan: &SpeedPlan, grid: &[f64], length: f64) -> Result<Self, FeedError> {
        let (start, end) = (grid[0], grid[grid.len() - 1]);
        let mut builder = Builder::with_capacity(plan.phases().len());
        let ends = plan.phases().iter().skip(1).map(|phase| phase.t).chain([plan.duration()]);
        for (phase, until) in plan.phases().iter().zip(ends) {
            // Summing up lengths leaves round-off beside the grid, which must not put a phase on the wrong side of a point.
            let s = start + (end - start) * (phase.s / length);
            let i = grid.partition_point(|&point| point < s);
            let beside = [i.saturating_sub(1), i.min(grid.len() - 1)].map(|i| grid[i]);
            let s = beside.into_iter().find(|point| (s - point).abs() <= 1e-13 * (end - start)).unwrap_or(s);
            builder.push(s, phase.v, phase.a, Law::Phase(phase.j, until - phase.t), until - phase.t);
        }
        builder.finish(end, plan.end().v)
    }

    /// How long the motion takes (s).
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// Position at the start of the grid.
    pub fn start(&self) -> f64 {
        self.pieces.first().map_or(self.end.p, |piece| piece.s)
    }

    /// The state at the end of the path; acceleration and jerk are 0 there, the motion being over.
    pub fn end(&self) -> MotionState {
        self.end
    }

    /// Time and state at every grid point (or start of a phase), the last one excepted, which is [`GridPlan::end`].
    pub fn knots(&self) -> impl ExactSizeIterator<Item = (f64, MotionState)> + '_ {
        self.pieces.iter().map(|piece| (piece.t, piece.after(0.0)))
    }

    /// The state at position `s`, clamped to the path (NaN counts as its start).
    pub fn at_position(&self, s: f64) -> MotionState {
        if s >= self.end.p || self.pieces.is_empty() {
            return self.end;
        }
        let s = if s >= self.start() { s } else { self.start() };
        let i = self.pieces.partition_point(|piece| piece.s <= s).saturating_sub(1);
        self.pieces[i].after_distance(s - self.pieces[i].s)
    }

    /// A sampler that remembers its place: amortised constant time for increasing `t`, no allocation.
    pub fn cursor(&self) -> GridCursor<'_> {
        GridCursor { plan: self, i: 0 }
    }

    /// The state a distance `ds` past grid point `k`, in the interval behind it.
    pub(crate) fn within(&self, k: usize, ds: f64) -> MotionState {
        self.pieces[k].after_distance(ds)
    }

    fn state_in(&self, i: usize, t: f64) -> MotionState {
        match self.pieces.get(i) {
            Some(piece) => {
                let mut state = piece.after(t - piece.t);
                // Round-off may carry a full stop below 0 or a hair beyond the next grid point.
                state.v = state.v.max(0.0);
                state.p = state.p.min(self.pieces.get(i + 1).map_or(self.end.p, |next| next.s));
                state
            }
            None => self.end,
        }
    }
}

impl MotionLaw for GridPlan {
    fn duration(&self) -> f64 {
        self.duration
    }

    fn at(&self, t: f64) -> MotionState {
        if t >= self.duration {
            return self.end;
        }
        let t = if t.is_nan() { 0.0 } else { t.max(0.0) };
        self.state_in(self.pieces.partition_point(|piece| piece.t <= t).saturating_sub(1), t)
    }
}

/// A place in a [`GridPlan`] from which sampling goes on; see [`GridPlan::cursor`].
#[derive(Debug, Clone)]
pub struct GridCursor<'a> {
    plan: &'a GridPlan,
    i: usize,
}

impl GridCursor<'_> {
    /// The state at time `t` (s), the same as [`MotionLaw::at`] of the plan. Times may also go back; that costs a search.
    pub fn at(&mut self, t: f64) -> MotionState {
        let plan = self.plan;
        if t >= plan.duration {
            return plan.end;
        }
        let t = if t.is_nan() { 0.0 } else { t.max(0.0) };
        if plan.pieces.get(self.i).is_some_and(|piece| piece.t > t) {
            self.i = plan.pieces.partition_point(|piece| piece.t <= t).saturating_sub(1);
        }
        while plan.pieces.get(self.i + 1).is_some_and(|next| next.t <= t) {
            self.i += 1;
        }
        plan.state_in(self.i, t)
    }
}

/// Collects pieces, keeping time in compensated form.
#[derive(Debug)]
pub(crate) struct Builder {
    pieces: Vec<Piece>,
    time: f64,
    lost: f64,
}

impl Builder {
    pub fn with_capacity(n: usize) -> Self {
        Self { pieces: Vec::with_capacity(n), time: 0.0, lost: 0.0 }
    }

    fn push(&mut self, s: f64, v: f64, u: f64, law: Law, dt: f64) {
        self.pieces.push(Piece { t: self.time, s, v, u, law });
        let y = dt - self.lost;
        let sum = self.time + y;
        self.lost = (sum - self.time) - y;
        self.time = sum;
    }

    /// A piece of length `h` on which `w` is constant, by squared speed and acceleration at its start and squared speed at its end.
    pub fn push_slope(&mut self, s: f64, h: f64, x: f64, u: f64, w: f64, x_end: f64) {
        let (v, v_end) = (x.sqrt(), x_end.sqrt());
        // tanh(r T / 2) = r h / (v + v_end) with r^2 = w: the half-angle formulas, without cancellation.
        let z = w.abs().sqrt() * h / (v + v_end);
        let factor = if z < 1e-4 {
            1.0 + w.signum() * z * z / 3.0
        } else if w > 0.0 {
            z.atanh() / z
        } else {
            z.atan() / z
        };
        self.push(s, v, u, Law::SlopeOf(w), 2.0 * h / (v + v_end) * factor);
    }

    /// A piece of length `h` with constant jerk, from rest to squared speed `x`.
    pub fn push_from_rest(&mut self, s: f64, h: f64, x: f64) {
        let v = x.sqrt();
        // s = j t^3 / 6 and v = j t^2 / 2.
        let dt = 3.0 * h / v;
        self.push(s, 0.0, 0.0, Law::Jerk(2.0 * v / (dt * dt)), dt);
    }

    /// A piece of length `h` with constant jerk, from squared speed `x` to rest.
    pub fn push_to_rest(&mut self, s: f64, h: f64, x: f64) {
        let v = x.sqrt();
        let dt = 3.0 * h / v;
        let j = 2.0 * v / (dt * dt);
        self.push(s, v, -j * dt, Law::Jerk(j), dt);
    }

    pub fn finish(self, end: f64, v_end: f64) -> Result<GridPlan, FeedError> {
        let sound = self.time.is_finite() && self.pieces.iter().all(|p| (p.t + p.s + p.v + p.u).is_finite());
        let end = MotionState { p: end, v: v_end, a: 0.0, j: 0.0 };
        if sound {
            Ok(GridPlan { pieces: self.pieces, end, duration: self.time })
        } else {
            Err(FeedError::OutOfRange { what: "duration of the plan" })
        }
    }
}
