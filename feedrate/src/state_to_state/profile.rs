//! The motion itself: phases, sampling, position extrema.

use super::error::{StateToStateError, finite};
use super::family::{Jerks, Problem};
use super::limits::{AxisLimits, AxisState};
use super::outside::brake_to_limit;
use super::scale::Units;
use super::solve::{Shape, solve};
use crate::scurve::phases::Phase;
use crate::state::{MotionLaw, MotionState};

/// At most two phases to bring acceleration and velocity inside their limits, three to the peak velocity, one at it, three to
/// the target.
const PHASES: usize = 9;

/// The shortest motion of one axis between two states.
///
/// ```
/// use arcfeed_feedrate::{AxisLimits, AxisState, MotionLaw, StateToState};
/// let limits = AxisLimits::new((-1.0, 2.0), (-8.0, 5.0), (-80.0, 50.0))?;
/// let start = AxisState::new(0.0, 0.3, -1.0);
/// let target = AxisState::new(1.2, 0.5, 0.0);
/// let motion = StateToState::new(&start, &target, &limits)?;
/// let end = motion.at(motion.duration());
/// assert_eq!((end.p, end.v, end.a), (1.2, 0.5, 0.0));
/// assert!(motion.position_range().max <= 1.2);
/// # Ok::<(), arcfeed_feedrate::StateToStateError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StateToState {
    phases: [Phase; PHASES],
    /// How long each phase lasts: the difference of two start times would have the round-off of the whole duration.
    lasting: [f64; PHASES],
    count: usize,
    duration: f64,
    target: MotionState,
}

/// Lowest and highest position of a motion, and when it is there first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PositionRange {
    /// Lowest position (m).
    pub min: f64,
    /// Time of the lowest position (s).
    pub t_min: f64,
    /// Highest position (m).
    pub max: f64,
    /// Time of the highest position (s).
    pub t_max: f64,
}

impl StateToState {
    /// The shortest motion from `start` to `target` within `limits`.
    ///
    /// A start may be outside the limits. An acceleration beyond its bound is first taken back with the largest
    /// jerk; a velocity beyond its bound (or bound to get there) is brought to the bound, or further
    /// inside, without undershooting it.
    ///
    /// # Errors
    /// [`StateToStateError::NotFinite`] naming the field; [`StateToStateError::TargetOutside`] and
    /// [`StateToStateError::TargetUnreachable`] if the target breaks a limit or forces to break one right
    /// before it; [`StateToStateError::OutOfRange`] if the motion has no finite representation.
    pub fn new(start: &AxisState, target: &AxisState, limits: &AxisLimits) -> Result<Self, StateToStateError> {
        let fields = [
            ("start.p", start.p),
            ("start.v", start.v),
            ("start.a", start.a),
            ("target.p", target.p),
            ("target.v", target.v),
            ("target.a", target.a),
        ];
        for (what, value) in fields {
            finite(what, value)?;
        }
        check_inside("v", target.v, limits.v)?;
        check_inside("a", target.a, limits.a)?;
        match Units::choose(start, target, limits) {
            // Nothing can leave the range of numbers here.
            None => Self::within_range(start, target, limits),
            Some(units) => {
                let (s, t) = (units.state_into(start), units.state_into(target));
                let motion = Self::within_range(&s, &t, &units.limits_into(limits))
                    .map_err(|e| rescaled_error(e, units))?
                    .rescaled(units, target);
                if motion.is_sound() { Ok(motion) } else { Err(StateToStateError::OutOfRange) }
            }
        }
    }

    /// As [`StateToState::new`], for numbers whose products stay finite.
    fn within_range(s: &AxisState, t: &AxisState, l: &AxisLimits) -> Result<Self, StateToStateError> {
        let j = Jerks::new(l.j.1, -l.j.0);
        check_entry(t, l, &j)?;
        let target = MotionState { p: t.p, v: t.v, a: t.a, j: 0.0 };
        let mut writer = Writer::new();
        let mut s = *s;
        // Acceleration outside its bounds.
        let bound = s.a.clamp(l.a.0, l.a.1);
        if bound != s.a {
            let jerk = if s.a > bound { l.j.0 } else { l.j.1 };
            let dt = (bound - s.a) / jerk;
            writer.push(dt, s.p, s.v, s.a, jerk);
            s = AxisState {
                p: s.p + dt * (s.v + dt * (0.5 * s.a + dt * jerk / 6.0)),
                v: s.v + 0.5 * dt * (s.a + bound),
                a: bound,
            };
        }
        let problem = Problem {
            d: t.p - s.p,
            v0: s.v,
            a0: s.a,
            vf: t.v,
            af: t.a,
            v_min: l.v.0,
            v_max: l.v.1,
            rise: l.a.1,
            fall: -l.a.0,
            j,
        };
        let noise = 2.0 * f64::EPSILON * (s.p.abs() + t.p.abs());
        let (shape, mirrored) = solve(&problem, noise);
        let (count, time) = (writer.count, writer.t);
        writer.write(&problem, &shape, mirrored, s.p, t.p);
        if shape.squeezed {
            let mut other = Writer { count, t: time, side: 1.0, ..writer };
            other.brake_first(&problem, mirrored, s.p, t.p);
            if other.t < writer.t {
                writer = other;
            }
        }
        Ok(Self { phases: writer.phases, lasting: writer.lasting, count: writer.count, duration: writer.t, target })
    }

    fn rescaled(mut self, units: Units, target: &AxisState) -> Self {
        for (p, dt) in self.phases.iter_mut().zip(&mut self.lasting) {
            *dt = units.time_back(*dt);
            *p = Phase {
                t: units.time_back(p.t),
                s: units.back(p.s, 0),
                v: units.back(p.v, 1),
                a: units.back(p.a, 2),
                j: units.back(p.j, 3),
            };
        }
        self.duration = units.time_back(self.duration);
        self.target = MotionState { p: target.p, v: target.v, a: target.a, j: 0.0 };
        self
    }

    fn is_sound(&self) -> bool {
        let sum: f64 = self.phases[..self.count].iter().map(|p| 0.0 * (p.t + p.s + p.v + p.a + p.j)).sum();
        sum == 0.0 && self.duration.is_finite()
    }

    /// The phases in order, each with its duration (s), which is not zero.
    pub fn phases(&self) -> impl ExactSizeIterator<Item = (Phase, f64)> + '_ {
        self.phases[..self.count].iter().copied().zip(self.lasting.iter().copied())
    }

    /// Lowest and highest position on the way, both ends included.
    pub fn position_range(&self) -> PositionRange {
        let end = self.target.p;
        let mut range = PositionRange { min: end, t_min: self.duration, max: end, t_max: self.duration };
        let mut visit = |t: f64, p: f64| {
            if p < range.min || (p == range.min && t < range.t_min) {
                (range.min, range.t_min) = (p, t);
            }
            if p > range.max || (p == range.max && t < range.t_max) {
                (range.max, range.t_max) = (p, t);
            }
        };
        for (phase, dt) in self.phases() {
            visit(phase.t, phase.s);
            for root in turning_times(&phase) {
                if root > 0.0 && root < dt {
                    visit(phase.t + root, phase.after(root).p);
                }
            }
        }
        range
    }
}

impl MotionLaw for StateToState {
    fn duration(&self) -> f64 {
        self.duration
    }

    #[inline]
    fn at(&self, t: f64) -> MotionState {
        if t >= self.duration {
            return self.target;
        }
        let t = if t > 0.0 { t } else { 0.0 };
        let i = (1..self.count).take_while(|&i| self.phases[i].t <= t).count();
        let phase = &self.phases[i];
        phase.after((t - phase.t).min(self.lasting[i]))
    }
}

/// Times from the start of a phase at which its velocity is zero; NaN where there is none.
fn turning_times(p: &Phase) -> [f64; 2] {
    // v + a t + j/2 t² = 0 without cancellation.
    let root = (p.a * p.a - 2.0 * p.j * p.v).sqrt();
    let w = -(p.a + root.copysign(p.a));
    [w / p.j, 2.0 * p.v / w]
}

/// How far beyond a limit, relative to the larger of the two, a target may be: it must not be refused for round-off in the
/// caller's arithmetic.
const SLACK: f64 = 1e-13;

fn check_inside(what: &'static str, value: f64, (lower, upper): (f64, f64)) -> Result<(), StateToStateError> {
    let slack = SLACK * upper.max(-lower);
    let limit = if value < lower { lower } else { upper };
    if value >= lower - slack && value <= upper + slack {
        Ok(())
    } else {
        Err(StateToStateError::TargetOutside { what, value, limit })
    }
}

/// Whether the target can be entered at all: its acceleration cannot have come from nowhere.
fn check_entry(t: &AxisState, l: &AxisLimits, j: &Jerks) -> Result<(), StateToStateError> {
    let slack = SLACK * l.v.1.max(-l.v.0);
    let change = 0.5 * t.a * t.a;
    let (before, limit) = if t.a > 0.0 { (t.v - change * j.inv_up, l.v.0) } else { (t.v + change * j.inv_down, l.v.1) };
    let excess = if t.a > 0.0 { limit - before } else { before - limit };
    if excess > slack { Err(StateToStateError::TargetUnreachable { v: t.v, a: t.a, before, limit }) } else { Ok(()) }
}

fn rescaled_error(e: StateToStateError, units: Units) -> StateToStateError {
    match e {
        StateToStateError::TargetUnreachable { v, a, before, limit } => StateToStateError::TargetUnreachable {
            v: units.back(v, 1),
            a: units.back(a, 2),
            before: units.back(before, 1),
            limit: units.back(limit, 1),
        },
        other => other,
    }
}

/// Collects phases; `side` is -1 while the problem is written in the mirrored frame.
#[derive(Clone, Copy)]
struct Writer {
    phases: [Phase; PHASES],
    lasting: [f64; PHASES],
    count: usize,
    t: f64,
    side: f64,
}

impl Writer {
    fn new() -> Self {
        Self { phases: [Phase::default(); PHASES], lasting: [0.0; PHASES], count: 0, t: 0.0, side: 1.0 }
    }

    #[inline]
    fn push(&mut self, dt: f64, p: f64, v: f64, a: f64, j: f64) {
        if dt > 0.0 && self.count < PHASES {
            self.lasting[self.count] = dt;
            self.phases[self.count] =
                Phase { t: self.t, s: self.side * p, v: self.side * v, a: self.side * a, j: self.side * j };
            self.count += 1;
            self.t += dt;
        }
    }

    /// Brakes as hard as possible until the velocity is at its limit and takes the shortest way from there. Writes an
    /// endless motion if that leaves the other velocity limit.
    fn brake_first(&mut self, problem: &Problem, mirrored: bool, from: f64, to: f64) {
        let (p, from, to) = if mirrored {
            self.side = -self.side;
            (problem.mirrored(), -from, -to)
        } else {
            (*problem, from, to)
        };
        let brake = brake_to_limit(&p);
        if p.v_max - 0.5 * brake.a * brake.a * p.j.inv_up < p.v_min {
            self.t = f64::INFINITY;
            return;
        }
        let t1 = ((p.a0 - brake.a) * p.j.inv_down).max(0.0);
        let v1 = p.v_max - brake.a * brake.hold;
        let p1 = t1 * (p.v0 + t1 * (2.0 * p.a0 + brake.a) / 6.0);
        let p2 = p1 + 0.5 * brake.hold * (v1 + p.v_max);
        if self.count > 0 && t1 > 0.0 {
            // The acceleration was above its bound: the same phase goes on.
            self.lasting[self.count - 1] += t1;
            self.t += t1;
        } else {
            self.push(t1, from, p.v0, p.a0, -p.j.down);
        }
        self.push(brake.hold, from + p1, v1, brake.a, 0.0);
        let rest = Problem { d: p.d - p2, v0: p.v_max, a0: brake.a, ..p };
        let (shape, flipped) = solve(&rest, 0.0);
        self.write(&rest, &shape, flipped, from + p2, to);
    }

    /// Writes a shape given in the frame of the problem, or in the mirrored one.
    fn write(&mut self, problem: &Problem, shape: &Shape, mirrored: bool, from: f64, to: f64) {
        if mirrored {
            self.side = -self.side;
            self.write_halves(&problem.mirrored(), shape, -from, -to);
        } else {
            self.write_halves(problem, shape, from, to);
        }
    }

    /// The first half forward from the start, the second backward from the target: round-off meets in the middle.
    fn write_halves(&mut self, p: &Problem, shape: &Shape, from: f64, to: f64) {
        let Shape { first, second, cruise, v_peak, joined, up, .. } = *shape;
        let jerk = |up: bool| if up { (p.j.up, p.j.inv_up) } else { (-p.j.down, -p.j.inv_down) };
        let ((j1, i1), (j3, i3)) = (jerk(up.0), jerk(!up.0));
        let ((j5, i5), (j7, i7)) = (jerk(up.1), jerk(!up.1));
        let (a1, a2) = (first.a, second.a);

        let t1 = ((a1 - p.a0) * i1).max(0.0);
        let v1 = p.v0 + 0.5 * t1 * (p.a0 + a1);
        let p1 = from + t1 * (p.v0 + t1 * (2.0 * p.a0 + a1) / 6.0);
        let v2 = v1 + a1 * first.hold;
        let p2 = p1 + 0.5 * first.hold * (v1 + v2);

        let t7 = ((p.af - a2) * i7).max(0.0);
        let v7 = p.vf - 0.5 * t7 * (p.af + a2);
        let p7 = to - t7 * (p.vf - t7 * (2.0 * p.af + a2) / 6.0);
        let v6 = v7 - a2 * second.hold;
        let p6 = p7 - 0.5 * second.hold * (v6 + v7);

        self.push(t1, from, p.v0, p.a0, j1);
        self.push(first.hold, p1, v1, a1, 0.0);
        if joined {
            self.push(((a2 - a1) * i5).max(0.0), p2, v2, a1, j5);
        } else {
            let t3 = (-a1 * i3).max(0.0);
            let t5 = (a2 * i5).max(0.0);
            self.push(t3, p2, v2, a1, j3);
            self.push(cruise, p2 + t3 * (v2 + t3 * a1 / 3.0), v_peak, 0.0, 0.0);
            self.push(t5, p6 - t5 * (v_peak + t5 * a2 / 6.0), v_peak, 0.0, j5);
        }
        self.push(second.hold, p6, v6, a2, 0.0);
        self.push(t7, p7, v7, a2, j7);
    }
}
