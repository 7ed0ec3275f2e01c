//! From a route to a motion.

use arcfeed_feedrate::{AxisLimits, AxisState, FeedError};

use super::distinct::Distinct;
use super::guess::Guess;
use super::program::Program;
use super::route::Route;
use super::trajectory::{SectionKind, WayPointTrajectory, section};
use super::{NODES, SECTIONS};
use crate::error::SyncError;
#[cfg(not(feature = "std"))]
use num_traits::Float;

/// Plans motions through way-points. Holds the memory of the computation, some 450 kB for six axes:
/// nothing else is allocated.
///
/// The velocities and accelerations in the points come from a program in which every section has
/// three parts with constant jerk, solved by an interior-point method for all axes at once in at
/// most [`WayPointPlanner::DEFAULT_ROUNDS`] rounds, and as many again where these are too few (some 3 % of random routes).
/// The sections are then the exact shortest motions between these states. Where one is impossible, the motion is made slower
/// around it; where a stop in every point is shorter, or nothing else is left, the axes rest in the points. The limits of the
/// motion are checked at the extremes of every phase before it is handed out.
///
/// Sections that have to be straight ([`WayPoint::with_straight_section`](crate::WayPoint::with_straight_section))
/// are lines, with blends at the corners where they are asked for. They are computed corner by corner,
/// within all limits but not in the least time: a share of the speed of both lines is passed on to the next.
///
/// The motion through free sections is near the shortest one, not exactly it. On random routes it is in the median up to
/// 0.7 % longer than a local optimum on a fine grid, and 5 % at the worst of 500 routes (example `way_point_gap` of the
/// integration tests). It is never longer than one that stops in every point.
///
/// ```
/// use arcfeed_sync::feedrate::{AxisLimits, AxisState};
/// use arcfeed_sync::{Route, WayPoint, WayPointPlanner};
/// let limits = [AxisLimits::symmetric(1.0, 5.0, 50.0)?; 2];
/// let points = [WayPoint::new([0.4, 0.1]), WayPoint::new([0.8, 0.5])];
/// let route = Route::new(&points, [1.0, 1.0].map(AxisState::rest), limits);
/// let motion = WayPointPlanner::new().plan(&[0.0, 0.0].map(AxisState::rest), &route)?;
/// let passing = motion.at(motion.section_durations()[0]);
/// assert!((passing.q[0] - 0.4).abs() < 1e-12 && passing.qd[0] > 0.5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct WayPointPlanner<const N: usize> {
    program: Program<N>,
    rounds: usize,
}

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

/// Motions are made slower by this factor to be clear of their bounds.
const CLEAR_OF_BOUNDS: f64 = 1.002;

/// The other motion is tried if the first is that much longer than expected.
const SLACK: f64 = 1.02;

impl<const N: usize> std::fmt::Debug for WayPointPlanner<N> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("WayPointPlanner").field("rounds", &self.rounds).finish_non_exhaustive()
    }
}

impl<const N: usize> Default for WayPointPlanner<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> WayPointPlanner<N> {
    /// Rounds of [`WayPointPlanner::new`].
    pub const DEFAULT_ROUNDS: usize = 12;

    /// With the default number of rounds.
    pub const fn new() -> Self {
        Self::with_rounds(Self::DEFAULT_ROUNDS)
    }

    /// With at most so many rounds of improvement, and as many again where the search has not converged by then: one costs
    /// 0.03 ms for ten points and six axes, and up to ten times its usual time where the equations of the durations have to be
    /// mended.
    pub const fn with_rounds(rounds: usize) -> Self {
        Self { program: Program::new(), rounds }
    }

    /// A motion from `start` along `route`, in nearly the shortest time.
    ///
    /// The start may move, and may be outside its limits: it is brought back inside.
    ///
    /// # Errors
    /// [`SyncError::TooManyWayPoints`], [`SyncError::WayPoint`] naming point and axis,
    /// [`SyncError::Blend`], [`SyncError::NotStraight`] for a target that moves off its straight section,
    /// [`SyncError::LineExceeds`], [`SyncError::SectionExceeds`] and [`SyncError::OutOfRange`] where round-off leaves no motion,
    /// [`SyncError::Duration`], and [`SyncError::State`] naming the axis, as
    /// [`Trajectory::new`](crate::Trajectory::new) for start and target.
    pub fn plan(&mut self, start: &[AxisState; N], route: &Route<'_, N>) -> Result<WayPointTrajectory<N>, SyncError> {
        route.check(start)?;
        let motion = self.whole(start, route)?;
        match motion.duration().is_finite() {
            true => Ok(motion),
            false => Err(SyncError::State { axis: 0, source: FeedError::OutOfRange { what: "duration of the route" } }),
        }
    }

    /// The motion along a route that has been checked.
    fn whole(&mut self, start: &[AxisState; N], route: &Route<'_, N>) -> Result<WayPointTrajectory<N>, SyncError> {
        if !(0..route.sections()).any(|i| route.is_straight(i)) {
            return self.pass(start, route);
        }
        let mut motion = WayPointTrajectory::standing(start, route.limits(0));
        motion.states[0] = *start;
        let mut first = 0;
        while first < route.sections() {
            let straight = route.is_straight(first);
            let last = (first..route.sections()).take_while(|&i| route.is_straight(i) == straight).last();
            let last = last.unwrap_or(first);
            let run = route.part(first, last);
            if straight {
                motion.add_lines(&run)?;
            } else {
                let begin = motion.states[motion.sections];
                motion.append(&self.pass(&begin, &run)?);
            }
            first = last + 1;
        }
        Ok(motion)
    }

    /// A motion whose sections are all free.
    fn pass(&mut self, start: &[AxisState; N], route: &Route<'_, N>) -> Result<WayPointTrajectory<N>, SyncError> {
        match Distinct::new(start, route) {
            Some(distinct) => {
                let short = self.pass_distinct(start, &distinct.route(route))?;
                Ok(distinct.expand(&short, route.sections()))
            }
            None => self.pass_distinct(start, route),
        }
    }

    fn pass_distinct(
        &mut self,
        start: &[AxisState; N],
        route: &Route<'_, N>,
    ) -> Result<WayPointTrajectory<N>, SyncError> {
        let guess = Guess::new(start, route);
        guess.write(route, &mut self.program);
        self.program.begin_with_spline();
        let mu = self.program.start();
        let left = self.program.improve(self.rounds, mu);
        let mut motion = self.read(&guess, route);
        let mut duration = self.settle(&mut motion, route);
        self.take_best_if_shorter(&guess, route, (&mut motion, &mut duration), SLACK);
        if let Some(mu) = left {
            // Once more where the rounds were too few. The motion is not always shorter then.
            self.program.improve(self.rounds, mu);
            self.take_if_shorter(&guess, route, (&mut motion, &mut duration));
            self.take_best_if_shorter(&guess, route, (&mut motion, &mut duration), 1.0);
        }
        // The guess is exact for an axis that no other one makes slower.
        if guess.has_leader(route.sections()) {
            guess.write(route, &mut self.program);
            // Between states at their bounds there is one motion, and none that is a little longer.
            self.program.slow_down(CLEAR_OF_BOUNDS);
            self.take_if_shorter(&guess, route, (&mut motion, &mut duration));
        }
        // Never longer than with a stop in every point.
        if duration > stopping_bound(&guess.states, route) {
            self.rest_if_shorter(&guess, route, (&mut motion, duration))?;
        }
        Ok(motion)
    }

    /// Takes the motion that the program kept apart where the other one is longer than that by a factor and this one is
    /// shorter. The program goes on as if it had not.
    fn take_best_if_shorter(
        &mut self,
        guess: &Guess<N>,
        route: &Route<'_, N>,
        (motion, duration): (&mut WayPointTrajectory<N>, &mut f64),
        slack: f64,
    ) {
        if *duration > slack * self.program.best_total() {
            self.program.keep_round();
            self.program.take_best();
            self.take_if_shorter(guess, route, (motion, duration));
            self.program.return_to_round();
        }
    }

    /// Takes the motion of the program where it is shorter. Not inlined: the stack has the other motion
    /// once, not for each call.
    #[inline(never)]
    fn take_if_shorter(
        &self,
        guess: &Guess<N>,
        route: &Route<'_, N>,
        (motion, duration): (&mut WayPointTrajectory<N>, &mut f64),
    ) {
        let mut other = self.read(guess, route);
        let there = self.settle(&mut other, route);
        if there < *duration {
            (*motion, *duration) = (other, there);
        }
    }

    /// Rests in every point where that is shorter; an error if there is no motion at all.
    #[inline(never)]
    fn rest_if_shorter(
        &self,
        guess: &Guess<N>,
        route: &Route<'_, N>,
        (motion, duration): (&mut WayPointTrajectory<N>, f64),
    ) -> Result<(), SyncError> {
        let mut stopping = self.read(guess, route);
        match rest(&mut stopping, route) {
            Ok(()) if stopping.duration() < duration => *motion = stopping,
            Err(e) if duration == f64::INFINITY => return Err(e),
            _ => {}
        }
        Ok(())
    }

    /// The states and durations of the program.
    fn read(&self, guess: &Guess<N>, route: &Route<'_, N>) -> WayPointTrajectory<N> {
        let n = route.sections();
        let mut motion = WayPointTrajectory {
            sections: n,
            states: guess.states,
            durations: self.program.durations,
            limits: [*route.limits(0); SECTIONS],
            kinds: [SectionKind::Free; SECTIONS],
        };
        for (i, limits) in motion.limits[..n].iter_mut().enumerate() {
            *limits = *route.limits(i);
        }
        for (i, state) in motion.states[..n].iter_mut().enumerate().skip(1) {
            for (k, s) in state.iter_mut().enumerate() {
                let wanted = AxisState { p: s.p, ..self.program.node(i, k) };
                *s = within(&within(&wanted, &route.limits(i - 1)[k]), &route.limits(i)[k]);
            }
        }
        motion
    }

    /// Replaces the durations of the program by the exact ones. Where a section is impossible or
    /// longer, the motion around it is made slower. Returns the duration, which is infinite if that
    /// does not help.
    fn settle(&self, motion: &mut WayPointTrajectory<N>, route: &Route<'_, N>) -> f64 {
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

/// A motion that stops in every point takes at least that long (s).
fn stopping_bound<const N: usize>(states: &[[AxisState; N]; NODES], route: &Route<'_, N>) -> f64 {
    let rests = |node: usize, k: usize| match node.checked_sub(1).and_then(|i| route.points.get(i)) {
        Some(point) => point.velocity()[k].is_none_or(|v| v == 0.0),
        None => states[node][k].v == 0.0 && states[node][k].a == 0.0,
    };
    let mut sum = 0.0;
    for i in 0..route.sections() {
        let mut longest = route.least_duration(i);
        for (k, l) in route.limits(i).iter().enumerate() {
            let (from, to) = (states[i][k].p, states[i + 1][k].p);
            if rests(i, k) && rests(i + 1, k) {
                let way = (to - from).abs();
                let v = if to > from { l.v_max() } else { -l.v_min() };
                let (a, j) = (l.a_max().max(-l.a_min()), l.j_max().max(-l.j_min()));
                longest = longest.max(way / v).max(2.0 * (way / a).sqrt()).max((32.0 * way / j).cbrt());
            }
        }
        sum += longest;
    }
    sum
}

/// All axes rest in the points, as far as no velocity is given.
fn rest<const N: usize>(motion: &mut WayPointTrajectory<N>, route: &Route<'_, N>) -> Result<(), SyncError> {
    for (state, point) in motion.states[1..].iter_mut().zip(route.points) {
        for (s, given) in state.iter_mut().zip(point.velocity()) {
            *s = AxisState::new(s.p, given.unwrap_or(0.0), 0.0);
        }
    }
    for i in 0..motion.sections {
        let made =
            section((i == 0, &motion.states[i], &motion.states[i + 1]), &motion.limits[i], route.least_duration(i))?;
        motion.durations[i] = made.duration();
    }
    Ok(())
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
