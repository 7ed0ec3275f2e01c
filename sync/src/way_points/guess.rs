//! Where the search for durations begins: what every axis needs that only stops where it turns.

use arcfeed_feedrate::{AxisLimits, AxisState, MotionLaw, Phase, StateToState};

use super::program::Program;
use super::route::Route;
use super::{NODES, SECTIONS};

/// A section as short as this part of the whole is not made shorter.
const SHORTEST: f64 = 1e-6;

/// Steps that find when a place is passed in a phase.
const STEPS: usize = 12;

/// States at the way-points and durations of the sections.
pub(super) struct Guess<const N: usize> {
    pub states: [[AxisState; N]; NODES],
    pub durations: [f64; SECTIONS],
    /// What each axis needs by itself.
    own: [[f64; N]; SECTIONS],
}

impl<const N: usize> Guess<N> {
    pub fn new(start: &[AxisState; N], route: &Route<'_, N>) -> Self {
        let n = route.sections();
        let mut states = [[AxisState::default(); N]; NODES];
        (states[0], states[n]) = (*start, route.target);
        for (state, point) in states[1..].iter_mut().zip(route.points) {
            for (k, (s, v)) in state.iter_mut().zip(point.velocity()).enumerate() {
                *s = AxisState::new(point.position()[k], v.unwrap_or(0.0), 0.0);
            }
        }
        let mut all = Self { states, durations: [0.0; SECTIONS], own: [[0.0; N]; SECTIONS] };
        for k in 0..N {
            let mut begin = 0;
            while begin < n {
                let mut end = begin + 1;
                let given = |node: usize| route.points[node - 1].velocity()[k].is_some();
                while end < n && all.way(end, k) * all.way(begin, k) > 0.0 && !given(end) {
                    end += 1;
                }
                all.pass((begin, end), k, route);
                begin = end;
            }
        }
        let mut sum = 0.0;
        for (i, t) in all.durations[..n].iter_mut().enumerate() {
            *t = t.max(route.least_duration(i));
            sum += *t;
        }
        for t in &mut all.durations[..n] {
            *t = t.max(if sum > 0.0 { SHORTEST * sum } else { 1.0 });
        }
        all.slow_down(route);
        all
    }

    fn way(&self, i: usize, k: usize) -> f64 {
        self.states[i + 1][k].p - self.states[i][k].p
    }

    /// Makes the durations of sections in which an axis moves in one direction as long as its
    /// shortest motion through all of them takes there.
    fn pass(&mut self, (begin, end): (usize, usize), k: usize, route: &Route<'_, N>) {
        let sign = if self.way(begin, k) < 0.0 { -1.0 } else { 1.0 };
        let forwards = |s: &AxisState| AxisState::new(s.p, sign * (sign * s.v).max(0.0), 0.0);
        let (from, to) = (forwards(&self.states[begin][k]), forwards(&self.states[end][k]));
        let limits = (begin + 1..end).fold(route.limits(begin)[k], |all, i| tighter(&all, &route.limits(i)[k]));
        let Ok(motion) = StateToState::new(&from, &to, &limits) else { return };
        let (mut phases, mut now) = (motion.phases().peekable(), 0.0);
        for i in begin..end {
            let place = self.states[i + 1][k].p;
            let mut passed = motion.duration();
            while i + 1 < end
                && let Some((phase, dt)) = phases.peek()
            {
                if sign * (phase.after(*dt).p - place) >= 0.0 {
                    let t = when(phase, *dt, sign * place, sign);
                    let s = phase.after(t);
                    self.states[i + 1][k] = AxisState::new(place, s.v, s.a);
                    passed = phase.t + t;
                    break;
                }
                phases.next();
            }
            self.own[i][k] = passed - now;
            self.durations[i] = self.durations[i].max(passed - now);
            now = passed.max(now);
        }
    }

    /// Every axis passes the points in its own motion, made slower to the durations of all.
    fn slow_down(&mut self, route: &Route<'_, N>) {
        for node in 1..route.sections() {
            let time = self.durations[node - 1] + self.durations[node];
            for k in 0..N {
                let part = (self.own[node - 1][k] + self.own[node][k]) / time;
                let given = route.points[node - 1].velocity()[k];
                let s = &mut self.states[node][k];
                *s = AxisState::new(s.p, given.unwrap_or(part * s.v), part * part * s.a);
            }
        }
    }

    /// Returns true if one axis is the slowest in all sections.
    pub fn has_leader(&self, sections: usize) -> bool {
        (0..N).any(|k| (0..sections).all(|i| self.own[i][k] >= self.durations[i]))
    }

    /// Writes the guess into a program.
    pub fn write(&self, route: &Route<'_, N>, program: &mut Program<N>) {
        let n = route.sections();
        program.sections = n;
        for i in 0..n {
            program.durations[i] = self.durations[i];
            program.least[i] = route.least_duration(i);
            for k in 0..N {
                let l = &route.limits(i)[k];
                program.set_limits(i, k, l);
                program.set_node(i, k, &inside(&self.states[i][k], l));
                let given = i > 0 && route.points[i - 1].velocity()[k].is_some();
                program.free[i][k] = !given;
            }
        }
        for k in 0..N {
            program.set_node(n, k, &inside(&self.states[n][k], &route.limits(n - 1)[k]));
        }
    }
}

/// The time in a phase of at most `dt` seconds at which an axis that moves by `sign` passes a place.
fn when(phase: &Phase, dt: f64, place: f64, sign: f64) -> f64 {
    let (mut early, mut late) = (0.0, dt);
    let mut t = 0.5 * dt;
    for _ in 0..STEPS {
        let s = phase.after(t);
        let left = place - sign * s.p;
        if left > 0.0 {
            early = t
        } else {
            late = t
        }
        // Newton's step, if it stays between.
        let next = t + left / (sign * s.v);
        t = if next >= early && next <= late { next } else { 0.5 * (early + late) };
    }
    t
}

/// The tighter one of each limit.
fn tighter(x: &AxisLimits, y: &AxisLimits) -> AxisLimits {
    let bounds = |x: (f64, f64), y: (f64, f64)| (x.0.max(y.0), x.1.min(y.1));
    let v = bounds((x.v_min(), x.v_max()), (y.v_min(), y.v_max()));
    let a = bounds((x.a_min(), x.a_max()), (y.a_min(), y.a_max()));
    let j = bounds((x.j_min(), x.j_max()), (y.j_min(), y.j_max()));
    AxisLimits::new(v, a, j).unwrap_or(*x)
}

/// The state inside the limits.
fn inside(s: &AxisState, l: &AxisLimits) -> AxisState {
    let v = s.v.max(l.v_min()).min(l.v_max());
    AxisState::new(s.p, v, s.a.max(l.a_min()).min(l.a_max()))
}
