//! Several axes from state to state in a common time.

use arcfeed_feedrate::{AxisLimits, AxisProblem, AxisState, Durations, FeedError, MotionLaw, StateToState};

use nalgebra::SVector;

use crate::error::SyncError;
use crate::joint_state::JointState;
use crate::mode::{MotionOptions, Synchronisation};
use crate::straight::Line;

/// The shortest common motion of `N` axes, each from a state to a state within its own limits.
///
/// With [`Synchronisation::Time`] the duration is the smallest one that every axis can meet.
/// Between moving states that may be more than the slowest axis needs: a faster axis may be unable
/// to take just a little longer (see [`Durations`](arcfeed_feedrate::Durations)). All other axes
/// stretch their motion to it with one cruise velocity (Liu et al. 2024, section 4.1, corrected:
/// see [`AxisProblem::with_duration`]).
///
/// ```
/// use arcfeed_sync::feedrate::{AxisLimits, AxisState};
/// use arcfeed_sync::{MotionOptions, Synchronisation, Trajectory};
/// let limits = [AxisLimits::symmetric(2.0, 10.0, 200.0)?; 3];
/// let start = [AxisState::new(0.0, 0.5, 0.0), AxisState::rest(1.0), AxisState::new(-1.0, 0.0, -2.0)];
/// let target = [1.0, 0.8, -1.5].map(AxisState::rest);
/// let options = MotionOptions::new(Synchronisation::Time).with_cycle(1e-3)?;
/// let motion = Trajectory::new(&start, &target, &limits, &options)?;
/// let end = motion.at(motion.duration());
/// assert_eq!(end.q.as_slice(), [1.0, 0.8, -1.5]);
/// assert_eq!((motion.duration() * 1e3).round() * 1e-3, motion.duration());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trajectory<const N: usize> {
    axes: [StateToState; N],
    duration: f64,
    straight: bool,
}

impl<const N: usize> Trajectory<N> {
    /// The shortest motion from `start` to `target` within `limits`, as told by `options`.
    ///
    /// # Errors
    /// [`SyncError::State`] naming the axis; with [`Synchronisation::None`] also if an axis that
    /// arrives before the others cannot go on within its velocity limits; with
    /// [`Synchronisation::ForcedStraight`] [`SyncError::NotStraight`] and
    /// [`SyncError::LineExceeds`].
    pub fn new(
        start: &[AxisState; N],
        target: &[AxisState; N],
        limits: &[AxisLimits; N],
        options: &MotionOptions,
    ) -> Result<Self, SyncError> {
        match options.synchronisation() {
            Synchronisation::None => Self::each(start, target, limits, options),
            Synchronisation::Time => Self::together(start, target, limits, options),
            Synchronisation::ForcedStraight => Self::straight(start, target, limits, options),
            Synchronisation::StraightLine => Self::straight(start, target, limits, options)
                .or_else(|_| Self::together(start, target, limits, options)),
        }
    }

    /// The fastest motion from rest to rest on the straight line between two positions (rad),
    /// lasting at least `least_duration` (s). Between equal positions the duration is 0.
    ///
    /// On the line every limit of an axis is a limit of the axis that moves farthest, so that its
    /// shortest motion within the tightest of them is time-optimal among all motions on that line.
    ///
    /// ```
    /// use arcfeed_sync::{Trajectory, symmetric_limits};
    /// use nalgebra::Vector3;
    /// let limits = symmetric_limits(Vector3::repeat(2.0), Vector3::repeat(10.0), Vector3::repeat(200.0))?;
    /// let goal = Vector3::new(1.0, -0.5, 0.0);
    /// let motion = Trajectory::rest_to_rest(Vector3::zeros(), goal, &limits, 0.0)?;
    /// assert_eq!(motion.at(motion.duration()).q, goal);
    /// # Ok::<(), arcfeed_sync::SyncError>(())
    /// ```
    ///
    /// # Errors
    /// [`SyncError::Axis`] if a position is not finite; [`SyncError::Duration`] if `least_duration`
    /// is negative or not finite; [`SyncError::State`] if the numbers leave the range of `f64`.
    pub fn rest_to_rest(
        start: SVector<f64, N>,
        goal: SVector<f64, N>,
        limits: &[AxisLimits; N],
        least_duration: f64,
    ) -> Result<Self, SyncError> {
        let options = MotionOptions::new(Synchronisation::ForcedStraight).with_least_duration(least_duration)?;
        for (what, vector) in [("start", start), ("goal", goal), ("distance", goal - start)] {
            for (axis, &value) in vector.iter().enumerate() {
                if !value.is_finite() {
                    return Err(SyncError::Axis { axis, what, value, rule: "finite" });
                }
            }
        }
        let options = if start == goal { MotionOptions::new(Synchronisation::ForcedStraight) } else { options };
        let at_rest = |q: SVector<f64, N>| std::array::from_fn(|k| AxisState::rest(q[k]));
        Self::straight(&at_rest(start), &at_rest(goal), limits, &options)
    }

    /// The shortest stop on the line through `start` and `target`; `None` if they are on none, or an
    /// axis would exceed its limits.
    pub(crate) fn stop_on_line(
        start: &[AxisState; N],
        target: &[AxisState; N],
        limits: &[AxisLimits; N],
    ) -> Option<Self> {
        let line = Line::new(start, target, limits).ok()?;
        let m = line.reference;
        let motion = StateToState::stop(&start[m], &line.limits(limits)?).ok()?;
        let way = motion.at(motion.duration()).p - start[m].p;
        let axes = std::array::from_fn(|k| {
            motion.in_proportion(line.ratios[k], &start[k], &AxisState::rest(start[k].p + line.ratios[k] * way))
        });
        let keeps = (0..N).all(|k| keeps_what_holds(&axes[k], &start[k], &limits[k]));
        keeps.then(|| Self { axes, duration: motion.duration(), straight: true })
    }

    /// Combines motions that belong to no line.
    pub(crate) fn of(axes: [StateToState; N]) -> Self {
        let duration = axes.iter().fold(0.0, |t: f64, a| t.max(a.duration()));
        Self { axes, duration, straight: false }
    }

    /// The same motion, which is known to be on a straight line or not.
    pub(crate) const fn on_line(mut self, straight: bool) -> Self {
        self.straight = straight;
        self
    }

    /// Another motion for one axis.
    pub(crate) fn replace(&mut self, axis: usize, motion: &StateToState) {
        self.take(&[axis], &Trajectory::of([*motion]));
    }

    /// The motions of another plan for those axes.
    pub(crate) fn take<const M: usize>(&mut self, axes: &[usize; M], plan: &Trajectory<M>) {
        for (&k, motion) in axes.iter().zip(&plan.axes) {
            self.axes[k] = *motion;
        }
        self.duration = self.axes.iter().fold(0.0, |t: f64, a| t.max(a.duration()));
        self.straight = plan.straight && M == N;
    }

    fn each(
        start: &[AxisState; N],
        target: &[AxisState; N],
        limits: &[AxisLimits; N],
        options: &MotionOptions,
    ) -> Result<Self, SyncError> {
        let mut axes = [StateToState::default(); N];
        for axis in 0..N {
            axes[axis] = AxisProblem::new(&start[axis], &target[axis], &limits[axis])
                .and_then(|problem| with_least_duration(&problem, options))
                // The others may arrive later.
                .and_then(|motion| limits[axis].check_leaving(&target[axis]).map(|()| motion))
                .map_err(|source| SyncError::State { axis, source })?;
        }
        let all = Self::of(axes);
        // What goes on after its end may be beyond all numbers when the last one arrives.
        let end = all.at(all.duration);
        match (0..N).find(|&axis| !end.q[axis].is_finite()) {
            Some(axis) => Err(SyncError::State {
                axis,
                source: FeedError::OutOfRange { what: "way on to the end of the others" },
            }),
            None => Ok(all),
        }
    }

    fn together(
        start: &[AxisState; N],
        target: &[AxisState; N],
        limits: &[AxisLimits; N],
        options: &MotionOptions,
    ) -> Result<Self, SyncError> {
        let problems: [_; N] = std::array::from_fn(|k| AxisProblem::new(&start[k], &target[k], &limits[k]));
        let mut shortest = 0.0_f64;
        for (axis, problem) in problems.iter().enumerate() {
            match problem {
                Ok(p) => shortest = shortest.max(p.shortest_duration()),
                Err(source) => return Err(SyncError::State { axis, source: *source }),
            }
        }
        let mut all =
            Self { axes: [StateToState::default(); N], duration: options.round_up(shortest), straight: false };
        // Every axis has a few blocked intervals at most, and every round passes one. The axis that had one comes first the next time: what
        // was made for the others is made anew.
        let (mut last, mut known) = (0, [None; N]);
        for _ in 0..ROUNDS * (N + 1) {
            match all.fill(&problems, last, &mut known) {
                Ok(()) => return Ok(all),
                Err(SyncError::State { axis, source: FeedError::DurationImpossible { above, .. } })
                    if above > all.duration =>
                {
                    last = axis;
                    all.duration = options.round_up(above);
                }
                Err(e) => return Err(e),
            }
        }
        Err(SyncError::State { axis: last, source: FeedError::OutOfRange { what: "duration of the motion" } })
    }

    /// Every axis in the common duration, from one of them on; `known` are possible durations that were needed before.
    fn fill(
        &mut self,
        problems: &[Result<AxisProblem, FeedError>; N],
        first: usize,
        known: &mut [Option<Durations>; N],
    ) -> Result<(), SyncError> {
        for axis in (first..N).chain(0..first) {
            if let Ok(problem) = &problems[axis] {
                problem
                    .with_duration_knowing(self.duration, &mut known[axis], &mut self.axes[axis])
                    .map_err(|source| SyncError::State { axis, source })?;
            }
        }
        Ok(())
    }

    fn straight(
        start: &[AxisState; N],
        target: &[AxisState; N],
        limits: &[AxisLimits; N],
        options: &MotionOptions,
    ) -> Result<Self, SyncError> {
        let line = Line::new(start, target, limits).map_err(|axis| SyncError::NotStraight { axis })?;
        let m = line.reference;
        let out_of_range =
            SyncError::State { axis: m, source: FeedError::OutOfRange { what: "duration of the motion" } };
        let motion = line.limits(limits).ok_or(out_of_range).and_then(|shared| {
            AxisProblem::new(&start[m], &target[m], &shared)
                .and_then(|problem| with_least_duration(&problem, options))
                .map_err(|source| SyncError::State { axis: m, source })
        });
        let motion = match motion {
            Ok(motion) => motion,
            // If an axis is to blame by itself, name that one.
            Err(e) => return Self::each(start, target, limits, &MotionOptions::default()).and(Err(e)),
        };
        let axes = std::array::from_fn(|k| motion.in_proportion(line.ratios[k], &start[k], &target[k]));
        // All axes share the least of their jerk limits: an axis that alone would stay inside can
        // overshoot with it.
        let exceeds = |k: &usize| !keeps_what_holds(&axes[*k], &start[*k], &limits[*k]);
        match (0..N).find(exceeds) {
            Some(axis) => Err(SyncError::LineExceeds { axis }),
            None => Ok(Self { axes, duration: motion.duration(), straight: true }),
        }
    }

    /// Duration (s): when the last axis arrives.
    pub const fn duration(&self) -> f64 {
        self.duration
    }

    /// Returns true if all axes move in proportion, on a straight line.
    pub const fn is_straight(&self) -> bool {
        self.straight
    }

    /// The motion of each axis.
    pub const fn axes(&self) -> &[StateToState; N] {
        &self.axes
    }

    /// The state at time `t` (s). Before 0 it is the start; an axis that has arrived goes on with
    /// the velocity of its target, once the acceleration of the target is brought to zero with the
    /// largest jerk ([`StateToState::at_or_after`]). Allocates nothing. For samples in the order of
    /// time see [`Trajectory::sampler`].
    pub fn at(&self, t: f64) -> JointState<N> {
        let mut state = JointState::default();
        for (k, axis) in self.axes.iter().enumerate() {
            let s = axis.at_or_after(t);
            (state.q[k], state.qd[k], state.qdd[k], state.qddd[k]) = (s.p, s.v, s.a, s.j);
        }
        state
    }
}

/// The shortest motion of one axis whose duration the options allow.
pub(crate) fn with_least_duration(problem: &AxisProblem, options: &MotionOptions) -> Result<StateToState, FeedError> {
    let mut t = options.round_up(problem.shortest_duration());
    for _ in 0..ROUNDS {
        match problem.with_duration(t) {
            Err(FeedError::DurationImpossible { above, .. }) if above > t => t = options.round_up(above),
            done => return done,
        }
    }
    Err(FeedError::OutOfRange { what: "duration of the motion" })
}

/// Returns true if a motion stays within the limits from `now` on.
pub(crate) fn keeps(motion: &StateToState, now: f64, l: &AxisLimits) -> bool {
    motion.duration() >= now && keeps_all_of(motion, now, l, |s| l.contain_now(s))
}

/// Returns true if a motion keeps the limits that `start` is inside of and can stay inside of.
pub(crate) fn keeps_what_holds(motion: &StateToState, start: &AxisState, l: &AxisLimits) -> bool {
    let velocity = |v: f64| l.contain_now(&AxisState::new(0.0, v, 0.0));
    let acceleration = |a: f64| l.contain_now(&AxisState::new(0.0, 0.0, a));
    let slow = velocity(start.v) && velocity(l.velocity_after(start));
    let soft = acceleration(start.a);
    keeps_all_of(motion, 0.0, l, |s| (!slow || velocity(s.v)) && (!soft || acceleration(s.a)))
}

/// Returns true if a motion keeps its jerk limit from `now` on and `inside` holds where velocity or
/// acceleration is extremal.
fn keeps_all_of(motion: &StateToState, now: f64, l: &AxisLimits, inside: impl Fn(&AxisState) -> bool) -> bool {
    motion.phases().filter(|(phase, dt)| phase.t + dt > now).all(|(phase, dt)| {
        let from = (now - phase.t).max(0.0);
        let top = -phase.a / phase.j;
        let top = if top > from && top < dt { top } else { from };
        let jerk = phase.j >= l.j_min() * ROUND_OFF_FACTOR && phase.j <= l.j_max() * ROUND_OFF_FACTOR;
        jerk && [from, top, dt].into_iter().all(|t| {
            let s = phase.after(t);
            inside(&AxisState::new(s.p, s.v, s.a))
        })
    })
}

/// Limits are kept up to this factor of round-off.
const ROUND_OFF_FACTOR: f64 = 1.0 + 16.0 * f64::EPSILON;

/// More blocked intervals than an axis has.
const ROUNDS: usize = 8;
