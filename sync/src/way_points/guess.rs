//! Where the search for durations begins: what every axis needs that only stops where it turns.

use arcfeed_feedrate::{AxisLimits, AxisState};

use super::program::Program;
use super::route::Route;
use super::{NODES, SECTIONS};
#[cfg(not(feature = "std"))]
use num_traits::Float;

/// A section as short as this part of the whole is not made shorter.
const SHORTEST: f64 = 1e-6;

/// The constant acceleration of the shortest motion over a distance `d` under a jerk limit `j`
/// alone is this number times `cbrt(d j^2)`.
const MEAN_ACCELERATION: f64 = 0.396_850_262_992_049_9;

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
            for (k, (s, v)) in state.iter_mut().zip(point.velocity()).enumerate() {
                *s = AxisState::new(point.position()[k], v.unwrap_or(0.0), 0.0);
            }
        }
        let mut all = Self { states, durations: [0.0; SECTIONS] };
        for k in 0..N {
            let mut begin = 0;
            while begin < n {
                let mut end = begin + 1;
                while end < n && all.way(end, k) * all.way(begin, k) > 0.0 {
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
        all
    }

    fn way(&self, i: usize, k: usize) -> f64 {
        self.states[i + 1][k].p - self.states[i][k].p
    }

    /// Makes the durations of sections in which an axis moves in one direction as long as it needs.
    fn pass(&mut self, (begin, end): (usize, usize), k: usize, route: &Route<'_, N>) {
        let sign = if self.way(begin, k) < 0.0 { -1.0 } else { 1.0 };
        let length = (self.states[end][k].p - self.states[begin][k].p).abs();
        let acceleration = |i: usize| {
            let l = &route.limits(i)[k];
            let j = l.j_max().min(-l.j_min());
            let within_jerk = MEAN_ACCELERATION * (length * j * j).cbrt();
            let a = l.a_max().min(-l.a_min());
            // Both at once, and above 0.
            (a / (a + within_jerk) * within_jerk).max(f64::MIN_POSITIVE)
        };
        let fastest = |i: usize| if sign > 0.0 { route.limits(i)[k].v_max() } else { -route.limits(i)[k].v_min() };
        let at_rest = |node: usize| (sign * self.states[node][k].v).max(0.0);
        let highest = |node: usize| {
            let free = node > begin && node < end && route.points[node - 1].velocity()[k].is_none();
            if free { f64::INFINITY } else { at_rest(node) }
        };
        let mut speeds = [0.0_f64; NODES];
        speeds[begin] = highest(begin);
        for i in begin..end {
            let way = self.way(i, k).abs();
            let reached = (speeds[i] * speeds[i] + 2.0 * acceleration(i) * way).sqrt();
            speeds[i + 1] = reached.min(fastest(i)).min(highest(i + 1));
        }
        for i in (begin..end).rev() {
            let (a, way, v) = (acceleration(i), self.way(i, k).abs(), speeds[i + 1]);
            speeds[i] = speeds[i].min((v * v + 2.0 * a * way).sqrt());
            let squares = speeds[i] * speeds[i] + v * v;
            let peak = (a * way + 0.5 * squares).sqrt().min(fastest(i)).max(speeds[i]).max(v);
            let cruise = way - (peak * peak - 0.5 * squares) / a;
            let time = (2.0 * peak - speeds[i] - v) / a + if cruise > 0.0 { cruise / peak } else { 0.0 };
            self.durations[i] = self.durations[i].max(time);
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

/// The state inside the limits.
fn inside(s: &AxisState, l: &AxisLimits) -> AxisState {
    let v = s.v.max(l.v_min()).min(l.v_max());
    AxisState::new(s.p, v, s.a.max(l.a_min()).min(l.a_max()))
}
