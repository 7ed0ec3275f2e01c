//! The motions that are being followed, axis by axis.

use arcfeed_feedrate::{AxisLimits, AxisState, FeedError, MotionLaw, MotionState, PositionLimits, StateToState};

use super::coast::Coast;
use super::course::Course;
use crate::error::SyncError;
use crate::sampler::Window;
use crate::state_to_state::Trajectory;
use crate::way_points::WayPointTrajectory;
#[cfg(not(feature = "std"))]
use num_traits::Float;

/// Every axis on the way to its target, or going on without one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Following<const N: usize> {
    pub plan: Trajectory<N>,
    pub axes: [Axis; N],
    /// The section of the route that is under way; the one after it is what the axes do after.
    pub section: Option<usize>,
}

/// One axis: how far it is on its motion and how it goes on after that.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axis {
    /// Cycles since its motion began, and until the target; not whole where time was scaled.
    pub steps: f64,
    pub planned: f64,
    /// The motion leads to the target; otherwise it is `after`.
    pub underway: bool,
    pub after: Coast,
    window: Window,
}

/// The motion of one axis in a cycle.
pub(super) struct AxisStep {
    pub state: MotionState,
    pub arrived: bool,
    pub range_ends: bool,
}

impl Axis {
    fn new(planned: f64, underway: bool, after: Coast) -> Self {
        Self { steps: 0.0, planned, underway, after, window: Window::default() }
    }

    /// Cycles beyond the end of the motion after so many more; `None` before it.
    fn beyond(&self, cycles: f64) -> Option<f64> {
        let beyond = self.steps + cycles - self.planned;
        (self.underway && beyond >= -WHOLE).then_some(beyond)
    }
}

impl<const N: usize> Following<N> {
    /// Goes on from `start` without a target.
    pub fn coasting(
        start: &[AxisState; N],
        limits: &[AxisLimits; N],
        ranges: &[PositionLimits; N],
    ) -> Result<Self, SyncError> {
        Self::each(|k| checked(k, "present state", Coast::new(&start[k], &limits[k], &ranges[k]), &ranges[k]))
    }

    /// Every axis by itself.
    fn each(mut motion: impl FnMut(usize) -> Result<Coast, SyncError>) -> Result<Self, SyncError> {
        let mut motions = [StateToState::default(); N];
        let mut axes = [Axis::new(0.0, false, Coast::default()); N];
        for k in 0..N {
            axes[k].after = motion(k)?;
            motions[k] = axes[k].after.motion;
        }
        Ok(Self { plan: Trajectory::of(motions), axes, section: None })
    }

    /// Every axis by itself to a velocity, within its range.
    pub fn jogging(
        start: &[AxisState; N],
        velocity: &[f64; N],
        limits: &[AxisLimits; N],
        ranges: &[PositionLimits; N],
    ) -> Result<Self, SyncError> {
        Self::each(|k| {
            let after = StateToState::to_velocity(&start[k], velocity[k], 0.0, &limits[k])
                .and_then(|_| Coast::to_velocity(&start[k], velocity[k], &limits[k], &ranges[k]));
            checked(k, "present state", after, &ranges[k])
        })
    }

    /// Motions that end at rest, each in a whole number of cycles or a little earlier.
    pub fn stopping(plan: Trajectory<N>, cycle: f64) -> Self {
        let rest = |m: &StateToState| Coast::none(StateToState::standing(m.at(m.duration()).p));
        let axes = std::array::from_fn(|k| {
            let motion = &plan.axes()[k];
            Axis::new((motion.duration() / cycle).ceil(), true, rest(motion))
        });
        Self { plan, axes, section: None }
    }

    /// Along a route from its begin on.
    ///
    /// Every section is computed, so that none fails on the way, and checked against the ranges.
    pub fn along(route: &WayPointTrajectory<N>, cycle: f64, ranges: &[PositionLimits; N]) -> Result<Self, SyncError> {
        let sections = route.section_durations().len();
        let first = route.section(0)?;
        check_sections(route, (0, 0.0), ranges)?;
        let axes = [Axis::new(route.section_durations()[0] / cycle, true, Coast::default()); N];
        let mut following = Self { plan: first, axes, section: Some(0) };
        // What cannot go on after the target is refused at once.
        following.load_last(route, ranges)?;
        if sections > 1 {
            following.load_next(route, ranges)?;
        }
        Ok(following)
    }

    /// Goes on to the next section of a route where this one ends within so many cycles. Returns the
    /// number of points passed, or an error where the next section has none.
    pub fn pass(
        &mut self,
        route: &WayPointTrajectory<N>,
        cycles: f64,
        cycle: f64,
        ranges: &[PositionLimits; N],
    ) -> Result<usize, SyncError> {
        let mut ended = 0;
        while let (Some(section), Some(beyond)) = (self.section, self.axes.first().and_then(|a| a.beyond(cycles))) {
            if section + 1 >= route.section_durations().len() {
                break;
            }
            self.plan = Trajectory::of(self.axes.map(|axis| axis.after.motion)).on_line(route.is_line(section + 1));
            let planned = route.section_durations()[section + 1] / cycle;
            for axis in &mut self.axes {
                *axis = Axis::new(planned, true, axis.after);
                axis.steps = beyond.max(0.0) - cycles;
            }
            self.section = Some(section + 1);
            ended += usize::from(route.ends_in_point(section));
            // Computed when the route was set, with the same result.
            self.load_next(route, ranges)?;
        }
        Ok(ended)
    }

    /// What follows the section under way: the next one, or what follows the target.
    fn load_next(&mut self, route: &WayPointTrajectory<N>, ranges: &[PositionLimits; N]) -> Result<(), SyncError> {
        let next = self.section.map_or(0, |section| section + 1);
        if next == route.section_durations().len() {
            return self.load_last(route, ranges);
        }
        let motion = route.section(next)?;
        for (axis, motion) in self.axes.iter_mut().zip(motion.axes()) {
            axis.after = Coast::none(*motion);
        }
        Ok(())
    }

    /// What follows the target of a route.
    pub fn load_last(&mut self, route: &WayPointTrajectory<N>, ranges: &[PositionLimits; N]) -> Result<(), SyncError> {
        let (target, limits) = (route.target(), route.limits(usize::MAX));
        (0..N).try_for_each(|k| self.arrange_after(k, &target[k], &limits[k], &ranges[k]))
    }

    /// Axis `k`, which has arrived, goes on from `state`. Where that is not the state of its `plan`, as time was scaled, it goes back
    /// to the velocity it goes on with; so it does where it is on the way back already, was slower within its limits, or brakes
    /// because its range ended before. Limits below that velocity do not change what it is.
    pub fn coast(
        &mut self,
        k: usize,
        (state, plan): (&AxisState, &AxisState),
        (l, range): (&AxisLimits, &PositionLimits),
        cycle: f64,
    ) -> Result<(), SyncError> {
        let axis = &self.axes[k];
        let returns = state != plan || axis.after.deviates_at(axis.steps * cycle);
        let velocity = if returns { axis.after.velocity } else { l.velocity_after(state) };
        let permitted = velocity.clamp(l.v_min(), l.v_max());
        let after = checked(k, "present state", Coast::to_velocity(state, permitted, l, range), range)?;
        self.go_on(k, &Coast { velocity, returns, limited: velocity != permitted, ..after });
        Ok(())
    }

    /// Axis `k` follows its motion of the plan, which leads to `target` in so many cycles.
    pub fn lead(
        &mut self,
        k: usize,
        planned: f64,
        target: &AxisState,
        l: &AxisLimits,
        range: &PositionLimits,
    ) -> Result<(), SyncError> {
        range.check(&self.plan.axes()[k]).map_err(|source| leaves(k, source))?;
        self.axes[k] = Axis::new(planned, true, self.axes[k].after);
        self.arrange_after(k, target, l, range)
    }

    /// The motion of axis `k` after `target`.
    pub fn arrange_after(
        &mut self,
        k: usize,
        target: &AxisState,
        l: &AxisLimits,
        range: &PositionLimits,
    ) -> Result<(), SyncError> {
        l.check_leaving(target).map_err(|source| SyncError::State { axis: k, source })?;
        self.axes[k].after = checked(k, "target", Coast::new(target, l, range), range)?;
        Ok(())
    }

    /// Moves axis `k` on by `elapsed` seconds of its plan, `cycles` cycles.
    pub fn step(&mut self, k: usize, (elapsed, cycles): (f64, f64), cycle: f64, target: &AxisState) -> AxisStep {
        let mut arrived = self.axes[k].underway && self.axes[k].planned == 0.0;
        if arrived {
            // On a route it may have been there for a part of the cycle.
            let steps = self.axes[k].steps;
            self.arrive(k);
            self.axes[k].steps = steps;
        }
        let axis = &mut self.axes[k];
        let end = axis.beyond(cycles);
        axis.steps += cycles;
        let t = axis.steps * cycle;
        let mut state = axis.window.sample(&self.plan.axes()[k], t);
        let mut range_ends = false;
        if !axis.underway {
            range_ends = axis.after.brakes_between(t - elapsed, t);
        } else if let Some(beyond) = end {
            arrived = true;
            self.arrive(k);
            let j = self.plan.axes()[k].at(0.0).j;
            state = MotionState { p: target.p, v: target.v, a: target.a, j };
            if beyond > WHOLE {
                self.axes[k].steps = beyond;
                state = self.plan.axes()[k].at_or_after(beyond * cycle);
            }
        }
        AxisStep { state, arrived, range_ends }
    }

    /// What the axes have before them, with the limits of a route, or `limits`.
    pub fn courses<'a>(
        &'a self,
        route: Option<&'a WayPointTrajectory<N>>,
        limits: &'a [AxisLimits; N],
        cycle: f64,
    ) -> [Course<'a>; N] {
        let mut of_motions = [limits; 2];
        let mut open = false;
        if let (Some(section), Some(route)) = (self.section, route) {
            of_motions = [route.limits(section), route.limits(section + 1)];
            // Only a target at rest needs no look at what follows it.
            let (left, rests) = (route.section_durations().len() - section, |s: &AxisState| s.v == 0.0 && s.a == 0.0);
            open = left > 2 || (left == 2 && !route.target().iter().all(rests));
        }
        std::array::from_fn(|k| {
            let (axis, motion) = (&self.axes[k], &self.plan.axes()[k]);
            let until = if axis.underway { axis.planned * cycle } else { f64::INFINITY };
            let motions = [(motion, &of_motions[0][k]), (&axis.after.motion, &of_motions[1][k])];
            Course::new(motions, (axis.steps * cycle, until), open)
        })
    }

    /// Returns true if `other` has the same motions after those under way, where all axes are under way.
    pub fn goes_on_as(&self, other: &Self) -> bool {
        self.axes.iter().zip(&other.axes).all(|(x, y)| x.underway && y.underway && x.after == y.after)
    }

    fn arrive(&mut self, k: usize) {
        let after = self.axes[k].after;
        self.go_on(k, &after);
    }

    fn go_on(&mut self, k: usize, after: &Coast) {
        self.plan.replace(k, &after.motion);
        self.axes[k] = Axis::new(0.0, false, *after);
    }
}

/// Part of a cycle that counts as round-off.
const WHOLE: f64 = 1e-9;

/// Returns an error if a section of a route, from the one given on, has no motion or leaves a range;
/// that section is `since` seconds under way.
pub(super) fn check_sections<const N: usize>(
    route: &WayPointTrajectory<N>,
    (first, since): (usize, f64),
    ranges: &[PositionLimits; N],
) -> Result<(), SyncError> {
    let mut begin = -since;
    for (index, duration) in route.section_durations().iter().enumerate().skip(first) {
        let section = route.section(index)?;
        for (axis, (motion, range)) in section.axes().iter().zip(ranges).enumerate() {
            if let Err(FeedError::LeavesPositions { position, time, limit }) = range.check(motion) {
                return Err(SyncError::LeavesRange { axis, position, time: begin + time, limit });
            }
        }
        begin += duration;
    }
    Ok(())
}

/// A motion without a target, or an error if there is none or it leaves the range.
fn checked(
    axis: usize,
    what: &'static str,
    after: Result<Coast, FeedError>,
    range: &PositionLimits,
) -> Result<Coast, SyncError> {
    let after = after.map_err(|source| SyncError::State { axis, source })?;
    match range.check(&after.motion) {
        Err(FeedError::LeavesPositions { position, limit, .. }) => {
            Err(SyncError::CannotStop { axis, what, position, limit })
        }
        Err(source) => Err(SyncError::State { axis, source }),
        Ok(()) => Ok(after),
    }
}

/// An axis that leaves its range on the way to its target.
fn leaves(axis: usize, source: FeedError) -> SyncError {
    match source {
        FeedError::LeavesPositions { position, time, limit } => SyncError::LeavesRange { axis, position, time, limit },
        source => SyncError::State { axis, source },
    }
}
