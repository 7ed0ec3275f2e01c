//! From a route to a motion.

use arcfeed_feedrate::{AxisState, FeedError};

use super::NODES;
use super::distinct::Distinct;
use super::guess::Guess;
use super::program::Program;
use super::route::Route;
use super::trajectory::{WayPointTrajectory, section};
use crate::error::SyncError;
#[cfg(not(feature = "std"))]
use num_traits::Float;

/// Plans motions through way-points. Holds the memory of the computation, some 450 kB for six axes:
/// nothing else is allocated.
///
/// The velocities and accelerations in the points come from a program in which every section has
/// three parts with constant jerk, solved by an interior-point method for all axes at once in at
/// most [`WayPointPlanner::DEFAULT_ROUNDS`] rounds, and as many again where these are too few (some 3 % of random routes);
/// [`WayPointPlanner::with_rounds`] bounds them.
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
    pub(super) program: Program<N>,
    rounds: usize,
    /// It goes on for as many rounds again where these were too few.
    goes_on: bool,
}

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
    /// Rounds of [`WayPointPlanner::new`], before it goes on for as many again.
    pub const DEFAULT_ROUNDS: usize = 12;

    /// With the default number of rounds, and as many again where the search has not converged by then.
    pub const fn new() -> Self {
        Self { program: Program::new(), rounds: Self::DEFAULT_ROUNDS, goes_on: true }
    }

    /// With at most so many rounds of improvement for each run of free sections, which bounds the time of a plan: one costs
    /// 0.03 ms for ten points and six axes, and up to ten times its usual time where the equations of the durations have to be
    /// mended. With [`WayPointPlanner::DEFAULT_ROUNDS`] it is [`WayPointPlanner::new`] that never goes on.
    pub const fn with_rounds(rounds: usize) -> Self {
        Self { program: Program::new(), rounds, goes_on: false }
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
        let mut motion = WayPointTrajectory::standing(start, route.limits(0));
        self.plan_into(start, route, &mut motion)?;
        Ok(motion)
    }

    /// As [`WayPointPlanner::plan`], into a motion that is there already: the stack has it once, not for each function that hands it
    /// on. After an error it is undefined.
    pub(crate) fn plan_into(
        &mut self,
        start: &[AxisState; N],
        route: &Route<'_, N>,
        motion: &mut WayPointTrajectory<N>,
    ) -> Result<(), SyncError> {
        route.check(start)?;
        self.whole(start, route, motion)?;
        match motion.duration().is_finite() {
            true => Ok(()),
            false => Err(SyncError::State { axis: 0, source: FeedError::OutOfRange { what: "duration of the route" } }),
        }
    }

    /// The motion along a route that has been checked.
    fn whole(
        &mut self,
        start: &[AxisState; N],
        route: &Route<'_, N>,
        motion: &mut WayPointTrajectory<N>,
    ) -> Result<(), SyncError> {
        if !(0..route.sections()).any(|i| route.is_straight(i)) {
            return self.pass(start, route, motion);
        }
        motion.stand(start, route.limits(0));
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
                self.add_free(&run, motion)?;
            }
            first = last + 1;
        }
        Ok(())
    }

    /// Appends sections that are all free. Not inlined: the stack has no place for them where there are none.
    #[inline(never)]
    fn add_free(&mut self, run: &Route<'_, N>, motion: &mut WayPointTrajectory<N>) -> Result<(), SyncError> {
        let begin = motion.states[motion.sections];
        let mut part = WayPointTrajectory::standing(&begin, run.limits(0));
        self.pass(&begin, run, &mut part)?;
        motion.append(&part);
        Ok(())
    }

    /// A motion whose sections are all free.
    fn pass(
        &mut self,
        start: &[AxisState; N],
        route: &Route<'_, N>,
        motion: &mut WayPointTrajectory<N>,
    ) -> Result<(), SyncError> {
        match Distinct::new(start, route) {
            Some(distinct) => {
                self.pass_distinct(start, &distinct.route(route), motion)?;
                distinct.expand(motion, route.sections());
                Ok(())
            }
            None => self.pass_distinct(start, route, motion),
        }
    }

    fn pass_distinct(
        &mut self,
        start: &[AxisState; N],
        route: &Route<'_, N>,
        motion: &mut WayPointTrajectory<N>,
    ) -> Result<(), SyncError> {
        let guess = Guess::new(start, route);
        guess.write(route, &mut self.program);
        self.program.begin_with_spline();
        let mu = self.program.start();
        let left = self.program.improve(self.rounds, mu);
        self.read(&guess, route, motion);
        let mut duration = self.settle(motion, route);
        self.take_best_if_shorter(&guess, route, (motion, &mut duration), SLACK);
        if let (Some(mu), true) = (left, self.goes_on) {
            // Once more where the rounds were too few. The motion is not always shorter then.
            self.program.improve(self.rounds, mu);
            self.take_if_shorter(&guess, route, (motion, &mut duration));
            self.take_best_if_shorter(&guess, route, (motion, &mut duration), 1.0);
        }
        // The guess is exact for an axis that no other one makes slower.
        if guess.has_leader(route.sections()) {
            guess.write(route, &mut self.program);
            // Between states at their bounds there is one motion, and none that is a little longer.
            self.program.slow_down(CLEAR_OF_BOUNDS);
            self.take_if_shorter(&guess, route, (motion, &mut duration));
        }
        // Never longer than with a stop in every point.
        if duration > stopping_bound(&guess.states, route) {
            self.rest_if_shorter(&guess, route, (motion, duration))?;
        }
        Ok(())
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
        let mut other = motion.clone();
        self.read(guess, route, &mut other);
        let there = self.settle(&mut other, route);
        if there < *duration {
            motion.clone_from(&other);
            *duration = there;
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
        let mut stopping = motion.clone();
        self.read(guess, route, &mut stopping);
        match rest(&mut stopping, route) {
            Ok(()) if stopping.duration() < duration => motion.clone_from(&stopping),
            Err(e) if duration == f64::INFINITY => return Err(e),
            _ => {}
        }
        Ok(())
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
