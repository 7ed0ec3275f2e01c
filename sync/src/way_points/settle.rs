//! From the states of the program to exact sections.

use arcfeed_feedrate::{AxisLimits, AxisState};

use super::guess::Guess;
use super::planner::WayPointPlanner;
use super::route::Route;
use super::trajectory::{SectionKind, WayPointTrajectory, section};
use super::{NODES, SECTIONS};
#[cfg(not(feature = "std"))]
use num_traits::Float;

/// Times that the motion is made slower around impossible sections.
const SLOWINGS: usize = 3;

/// Times after that, in which points come to rest.
const RESTS: usize = 4;

/// The least factor of one such time, and the part of it that a section farther away gets.
const SLOWER: f64 = 1.03;
const FADING: f64 = 0.6;

/// A section counts as impossible if it takes that much longer than in the program.
const LONGER: f64 = 1.25;

/// Part of an acceleration that the limits of the velocity allow.
const CLEAR: f64 = 1.0 - 1e-12;

impl<const N: usize> WayPointPlanner<N> {
    /// Takes the states and durations of the program.
    pub(super) fn read(&self, guess: &Guess<N>, route: &Route<'_, N>, motion: &mut WayPointTrajectory<N>) {
        let n = route.sections();
        motion.sections = n;
        motion.states = guess.states;
        motion.durations = self.program.durations;
        motion.limits = [*route.limits(0); SECTIONS];
        motion.kinds = [SectionKind::Free; SECTIONS];
        for (i, limits) in motion.limits[..n].iter_mut().enumerate() {
            *limits = *route.limits(i);
        }
        for (i, state) in motion.states[..n].iter_mut().enumerate().skip(1) {
            for (k, s) in state.iter_mut().enumerate() {
                let wanted = AxisState { p: s.p, ..self.program.node(i, k) };
                *s = within(&within(&wanted, &route.limits(i - 1)[k]), &route.limits(i)[k]);
            }
        }
    }

    /// Replaces the durations of the program by the exact ones. Where a section is impossible or
    /// longer, the motion around it is made slower. Returns the duration, which is infinite if that
    /// does not help.
    pub(super) fn settle(&self, motion: &mut WayPointTrajectory<N>, route: &Route<'_, N>) -> f64 {
        let n = motion.sections;
        let (planned, expected) = (motion.states, motion.durations);
        let mut factors = [1.0_f64; NODES];
        let mut changed = [true; SECTIONS];
        for round in 0..=SLOWINGS + RESTS {
            // At last only the points beside impossible sections are brought to rest.
            let slowing = round < SLOWINGS;
            let mut wanted = factors;
            for i in 0..n {
                let last = std::mem::take(&mut changed[i]);
                if !last {
                    continue;
                }
                let made = section(
                    (i == 0, &motion.states[i], &motion.states[i + 1]),
                    &motion.limits[i],
                    route.least_duration(i),
                );
                match made {
                    Ok(made) if !slowing || made.duration() <= LONGER * expected[i] => {
                        motion.durations[i] = made.duration();
                    }
                    _ => {
                        changed[i] = true;
                        let slower = factors[i].max(factors[i + 1]) * self.program.excess(i).max(SLOWER);
                        let factor = if slowing { slower } else { f64::INFINITY };
                        (wanted[i], wanted[i + 1]) = (wanted[i].max(factor), wanted[i + 1].max(factor));
                    }
                }
            }
            if !changed[..n].iter().any(|&x| x) {
                return motion.duration();
            }
            if slowing {
                fade(&mut wanted[..=n]);
            }
            for i in 1..n {
                if wanted[i] > factors[i] {
                    factors[i] = wanted[i];
                    slow(&mut motion.states[i], &planned[i], (route, i, wanted[i]));
                    (changed[i - 1], changed[i]) = (true, true);
                }
            }
        }
        f64::INFINITY
    }
}

/// The state inside its limits, and inside them before and after it: velocity first, then an
/// acceleration that can come from zero and go back to it.
fn within(s: &AxisState, l: &AxisLimits) -> AxisState {
    let v = s.v.max(l.v_min()).min(l.v_max());
    let (up, down) = (l.v_max() - v, v - l.v_min());
    // Before a rise the velocity was lower, and after it, it is higher. A little less, so that no
    // round-off is left that would have to be taken from the acceleration.
    let most = CLEAR * (2.0 * f64::min(down * l.j_max(), up * -l.j_min())).sqrt();
    let (highest, lowest) = (l.a_max().min(most), l.a_min().max(-most));
    AxisState::new(s.p, v, s.a.max(lowest).min(highest))
}

/// Neighbours of slower points become slower, too, less and less.
fn fade(factors: &mut [f64]) {
    for i in 1..factors.len() {
        factors[i] = factors[i].max(1.0 + FADING * (factors[i - 1] - 1.0));
    }
    for i in (1..factors.len()).rev() {
        factors[i - 1] = factors[i - 1].max(1.0 + FADING * (factors[i] - 1.0));
    }
}

/// The states of a way-point in a motion that is slower by a factor.
fn slow<const N: usize>(
    states: &mut [AxisState; N],
    planned: &[AxisState; N],
    (route, node, factor): (&Route<'_, N>, usize, f64),
) {
    for ((s, was), given) in states.iter_mut().zip(planned).zip(route.points[node - 1].velocity()) {
        *s = AxisState::new(s.p, given.unwrap_or(was.v / factor), was.a / (factor * factor));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Before an acceleration that rises from zero and after one that falls to it the velocity is inside its limits, and no
    /// acceleration is smaller than that asks for.
    #[test]
    fn states_are_inside_before_and_after() {
        let l = AxisLimits::new((-1.0, 2.0), (-4.0, 6.0), (-30.0, 50.0)).expect("on both sides of zero");
        let (mut kept, mut lowered) = (0, 0);
        for (v, a) in (-30..60).flat_map(|v| (-9..9).map(move |a| (0.1 * f64::from(v), f64::from(a)))) {
            let s = within(&AxisState::new(0.0, v, a), &l);
            let way = |jerk: f64| 0.5 * s.a * s.a / jerk;
            let (before, after) = if s.a > 0.0 {
                (s.v - way(l.j_max()), s.v + way(-l.j_min()))
            } else {
                (s.v + way(-l.j_min()), s.v - way(l.j_max()))
            };
            let inside = |v: f64| v >= l.v_min() - 1e-12 && v <= l.v_max() + 1e-12;
            assert!(inside(before) && inside(after) && s.a.abs() <= a.abs(), "{v} {a}: {s:?} {before} {after}");
            assert_eq!((s.p, s.v), (0.0, v.clamp(l.v_min(), l.v_max())));
            let bound = |v: f64| (v - l.v_min()).abs() < 1e-9 || (v - l.v_max()).abs() < 1e-9;
            let binds = s.a == l.a_min() || s.a == l.a_max() || bound(before) || bound(after);
            assert!(s.a == a || binds, "{v} {a}: {s:?} {before} {after}");
            kept += usize::from(s.a == a && a != 0.0);
            lowered += usize::from(s.a != a && s.a != 0.0);
        }
        assert!(kept > 200 && lowered > 200, "{kept} {lowered}");
    }
}
