//! Where the program begins: velocities that do not overshoot, and durations that allow them.

use arcfeed_feedrate::{AxisLimits, AxisState};

use super::program::Program;
use super::route::Route;
use super::{NODES, SECTIONS};
#[cfg(not(feature = "std"))]
use num_traits::Float;

/// The first durations, relative to what the limits demand one by one.
const GENEROUS: f64 = 1.2;

/// Sweeps that make sections longer where the velocity changes too fast.
const SWEEPS: usize = 8;

/// Parts of the acceleration and of the jerk that a change of velocity may take.
const PART_A: f64 = 0.6;
const PART_J: f64 = 0.5;

/// A section as short as this part of the whole is not made shorter (relative to the mean duration).
const SHORTEST: f64 = 1e-6;

/// States at the way-points and durations of the sections.
pub(super) struct Guess<const N: usize> {
    pub states: [[AxisState; N]; NODES],
    pub durations: [f64; SECTIONS],
}

impl<const N: usize> Guess<N> {
    pub fn new(start: &[AxisState; N], route: &Route<'_, N>) -> Self {
        let n = route.sections();
        let mut states = [[AxisState::default(); N]; NODES];
        (states[0], states[n]) = (*start, route.target);
        for (state, point) in states[1..].iter_mut().zip(route.points) {
            *state = point.position().map(AxisState::rest);
        }
        let mut durations = [0.0; SECTIONS];
        let mut sum = 0.0;
        for i in 0..n {
            durations[i] = GENEROUS * least_duration(&states[i], &states[i + 1], route.limits(i));
            durations[i] = f64::max(durations[i], GENEROUS * route.least_duration(i));
            sum += durations[i];
        }
        for t in &mut durations[..n] {
            *t = t.max(if sum > 0.0 { SHORTEST * sum } else { 1.0 });
        }
        let mut all = Self { states, durations };
        for _ in 0..SWEEPS {
            all.lengthen(route);
        }
        all.choose_velocities(route);
        all
    }

    /// Makes the sections next to a point longer where the velocity changes too fast.
    fn lengthen(&mut self, route: &Route<'_, N>) {
        let n = route.sections();
        for i in 0..=n {
            let mut factor = 1.0_f64;
            let time =
                0.5 * (if i > 0 { self.durations[i - 1] } else { 0.0 } + if i < n { self.durations[i] } else { 0.0 });
            let l = route.limits(i.min(n - 1));
            for k in 0..N {
                let s = &self.states[i][k];
                let before = if i > 0 { self.slope(i - 1, k) } else { s.v };
                let after = if i < n { self.slope(i, k) } else { s.v };
                let change = (after - before) / time;
                let a = if change > 0.0 { l[k].a_max() } else { -l[k].a_min() };
                let j = l[k].j_max().min(-l[k].j_min());
                factor =
                    factor.max((change.abs() / (PART_A * a)).sqrt()).max((change.abs() / (PART_J * j * time)).cbrt());
            }
            if factor > 1.0 {
                let factor = factor.min(2.0);
                if i > 0 {
                    self.durations[i - 1] *= factor;
                }
                if i < n {
                    self.durations[i] *= factor;
                }
            }
        }
    }

    fn slope(&self, i: usize, k: usize) -> f64 {
        (self.states[i + 1][k].p - self.states[i][k].p) / self.durations[i]
    }

    /// Velocities and accelerations of the parabola through a point and its neighbours.
    fn choose_velocities(&mut self, route: &Route<'_, N>) {
        for (i, point) in route.points.iter().enumerate().map(|(i, p)| (i + 1, p)) {
            let (x, y) = (self.durations[i - 1], self.durations[i]);
            for k in 0..N {
                let (before, after) = (self.slope(i - 1, k), self.slope(i, k));
                let l = &route.limits(i)[k];
                let v = (before * y + after * x) / (x + y);
                let a = 2.0 * (after - before) / (x + y);
                self.states[i][k].v = point.velocity()[k].unwrap_or(v);
                self.states[i][k].a = a.max(0.9 * l.a_min()).min(0.9 * l.a_max());
            }
        }
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

/// What the limits demand of the duration of a section, one by one.
fn least_duration<const N: usize>(from: &[AxisState; N], to: &[AxisState; N], limits: &[AxisLimits; N]) -> f64 {
    let mut least = 0.0_f64;
    for ((from, to), l) in from.iter().zip(to).zip(limits) {
        let way = to.p - from.p;
        let (v, a) = if way > 0.0 { (l.v_max(), l.a_max()) } else { (-l.v_min(), -l.a_min()) };
        let j = l.j_max().min(-l.j_min());
        least = least.max(way.abs() / v).max((way.abs() / a).sqrt()).max((way.abs() / j).cbrt());
    }
    least
}

/// The state inside the limits.
fn inside(s: &AxisState, l: &AxisLimits) -> AxisState {
    let v = s.v.max(l.v_min()).min(l.v_max());
    AxisState::new(s.p, v, s.a.max(l.a_min()).min(l.a_max()))
}
