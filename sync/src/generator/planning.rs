//! Targets and limits that are set, and the plans that follow from them.

use arcfeed_feedrate::{AxisLimits, AxisState, MotionLaw, StateToState};

use super::command::Command;
use super::following::Following;
use super::{OnlineGenerator, is_outside};
use crate::error::SyncError;
use crate::mode::Synchronisation;
use crate::state_to_state::{Trajectory, keeps};
use crate::way_points::{RouteMemory, WayPointTrajectory};
#[cfg(not(feature = "std"))]
use num_traits::Float;

impl<const N: usize, R: RouteMemory<N>> OnlineGenerator<N, R> {
    /// Sets the state to reach.
    ///
    /// Where the scale of time cannot go on ([`OnlineGenerator::set_scale`]) it starts at 1 again: after
    /// [`OnlineGenerator::hold`] the axes may become faster once more before they rest.
    ///
    /// # Errors
    /// As [`Trajectory::new`]. Nothing changes then.
    pub fn set_target(&mut self, target: [AxisState; N]) -> Result<(), SyncError> {
        self.set(target, self.limits)
    }

    /// Sets the state one axis is to reach. After a stop, or instead of a route, a jog or a stop on the path, the
    /// other axes come to rest.
    ///
    /// # Errors
    /// As [`Trajectory::new`], [`SyncError::NoSuchAxis`]. Nothing changes then.
    pub fn set_axis_target(&mut self, axis: usize, target: AxisState) -> Result<(), SyncError> {
        let mut all = self.targets_now()?;
        *all.get_mut(axis).ok_or(SyncError::NoSuchAxis { axis, count: N })? = target;
        self.set_target(all)
    }

    /// Sets the limits, of a target that is followed: a route has its own
    /// ([`SyncError::LimitsOfRoute`]). A stop or a jog goes on within them, a jog no faster than they allow; a stop
    /// on the path is finished with the limits it began with, on a route with those of its sections, and refuses others until then.
    ///
    /// Where the scale of time cannot go on ([`OnlineGenerator::set_scale`]) it starts at 1 again: after
    /// [`OnlineGenerator::hold`] the axes may become faster once more before they rest.
    ///
    /// # Errors
    /// As [`Trajectory::new`]: the target must be inside the new limits. Nothing changes then.
    pub fn set_limits(&mut self, limits: [AxisLimits; N]) -> Result<(), SyncError> {
        match self.command {
            Command::Target => self.set(self.target, limits),
            _ => self.recommand(limits),
        }
    }

    /// Sets the limits of one axis.
    ///
    /// # Errors
    /// As [`OnlineGenerator::set_limits`], [`SyncError::NoSuchAxis`]. Nothing changes then.
    pub fn set_axis_limits(&mut self, axis: usize, limits: AxisLimits) -> Result<(), SyncError> {
        let mut all = self.limits;
        *all.get_mut(axis).ok_or(SyncError::NoSuchAxis { axis, count: N })? = limits;
        self.set_limits(all)
    }

    /// Sets target and limits at once: where neither goes with the other's old value.
    ///
    /// Where the scale of time cannot go on ([`OnlineGenerator::set_scale`]) it starts at 1 again: after
    /// [`OnlineGenerator::hold`] the axes may become faster once more before they rest.
    ///
    /// # Errors
    /// As [`Trajectory::new`]; [`SyncError::State`] also for a target from which the axis cannot go
    /// on within its velocity limits; with ranges [`SyncError::OutsideRange`],
    /// [`SyncError::LeavesRange`] and [`SyncError::CannotStop`]. Nothing changes then.
    pub fn set(&mut self, target: [AxisState; N], limits: [AxisLimits; N]) -> Result<(), SyncError> {
        let from = *self.planning_state();
        let order = Order { target: &target, limits: &limits, from: &from, anew: self.command != Command::Target };
        let next = self.follow(&order)?;
        if next.0.as_ref().is_some_and(|next| !self.scale_fits(next, None, &limits)) {
            return self.plan_from_commanded(&target, &limits);
        }
        self.obey(&order, next);
        Ok(())
    }

    /// Plans to targets from the state commanded last, where the scale of time starts at 1 again.
    pub(super) fn plan_from_commanded(
        &mut self,
        target: &[AxisState; N],
        limits: &[AxisLimits; N],
    ) -> Result<(), SyncError> {
        let from = self.state;
        let order = Order { target, limits, from: &from, anew: true };
        let next = self.follow(&order)?;
        self.scale.jump(1.0);
        self.obey(&order, next);
        Ok(())
    }

    /// Follows what was planned for an order, with its limits and targets.
    fn obey(&mut self, order: &Order<'_, N>, (next, replanned): (Option<Following<N>>, bool)) {
        self.limits = *order.limits;
        self.command = Command::Target;
        self.replanned |= replanned;
        if let Some(next) = next {
            self.adopt(next);
        }
        for ((old, new), axis) in self.target.iter_mut().zip(order.target).zip(&self.following.axes) {
            // Arrival is exact for the latest target, the same one up to round-off included.
            if axis.underway {
                *old = *new;
            }
        }
    }

    /// Follows other motions from now on.
    pub(super) fn adopt(&mut self, next: Following<N>) {
        self.following = next;
        self.outside_limits = is_outside(&self.state, &self.limits);
        self.scale.retarget();
        if self.scale.steady() != Some(1.0) {
            // Plans that begin in the state commanded last.
            for (k, _) in self.following.axes.iter().enumerate().filter(|(_, axis)| axis.steps == 0.0) {
                let s = self.following.plan.axes()[k].at(0.0);
                self.planned[k] = AxisState::new(self.ranges[k].nearest(s.p), s.v, s.a);
            }
        } else {
            self.planned = self.state;
        }
    }

    /// The state from which plans begin: that of the plan where its time is scaled, and the one
    /// commanded last where it is held.
    pub(super) fn planning_state(&self) -> &[AxisState; N] {
        if self.scale.steady() == Some(0.0) { &self.state } else { &self.planned }
    }

    /// Returns true if the scale can go on as it does while other motions are followed, with the limits of
    /// a route, or `limits`.
    ///
    /// At a scale below 1 the axes may be inside limits that the state of the plan exceeds: a plan from
    /// there would take them out.
    pub(super) fn scale_fits(
        &self,
        next: &Following<N>,
        route: Option<&WayPointTrajectory<N>>,
        limits: &[AxisLimits; N],
    ) -> bool {
        self.scale.fits(|| next.courses(route, limits, self.cycle))
    }

    /// The motions for an order, where they are new, and whether a plan is.
    fn follow(&self, order: &Order<'_, N>) -> Result<(Option<Following<N>>, bool), SyncError> {
        let mut next = None;
        let mut replanned = false;
        if self.options.synchronisation() == Synchronisation::None {
            for k in 0..N {
                replanned |= self.change([k], order, &mut next)?;
            }
        } else {
            replanned = self.change(std::array::from_fn::<_, N, _>(|k| k), order, &mut next)?;
        }
        Ok((next, replanned))
    }

    /// The targets, or the places where the axes can rest soonest while they follow none.
    fn targets_now(&self) -> Result<[AxisState; N], SyncError> {
        if matches!(self.command, Command::Target | Command::Stop) {
            return Ok(self.target);
        }
        let mut all = self.target;
        for (k, target) in all.iter_mut().enumerate() {
            let stop = StateToState::stop(&self.state[k], &self.limits[k])
                .map_err(|source| SyncError::State { axis: k, source })?;
            *target = AxisState::rest(self.ranges[k].nearest(stop.at(stop.duration()).p));
        }
        Ok(all)
    }

    /// Plans the motion of a group of axes that move together for an order, and puts it into `next`
    /// where it is a new plan. Returns true if it is.
    fn change<const M: usize>(
        &self,
        group: [usize; M],
        order: &Order<'_, N>,
        next: &mut Option<Following<N>>,
    ) -> Result<bool, SyncError> {
        let (target, limits) = (order.target, order.limits);
        let same_target = group.iter().all(|&k| self.is_target(k, &target[k]));
        if same_target && !order.anew && group.iter().all(|&k| limits[k] == self.limits[k]) {
            return Ok(false);
        }
        if !same_target {
            self.check_inside("target", target)?;
        }
        let next = next.get_or_insert(self.following);
        let arrived = !group.iter().any(|&k| self.following.axes[k].underway);
        if same_target && arrived && self.command == Command::Target {
            // Nothing to plan but the way back inside, and to the velocity with which the axis goes on.
            for &k in &group {
                next.coast(k, (&order.from[k], &self.planned[k]), (&limits[k], &self.ranges[k]), self.cycle)?;
            }
            return Ok(false);
        }
        let (from, to, within) = (group.map(|k| order.from[k]), group.map(|k| target[k]), group.map(|k| limits[k]));
        let mut plan = Trajectory::<M>::new(&from, &to, &within, &self.options).map_err(|e| e.of_axis(|k| group[k]))?;
        let ranges = group.map(|k| self.ranges[k]);
        let leaves = plan.axes().iter().zip(&ranges).any(|(motion, range)| !range.contain_all_of(motion));
        if leaves && self.options.synchronisation() != Synchronisation::ForcedStraight {
            // What stays impossible is named below, by the place where the motion leaves.
            plan = Trajectory::inside(&from, &to, &within, (&ranges, &self.options)).unwrap_or(plan);
        }
        let left = group.iter().fold(0.0, |t: f64, &k| t.max(self.time_left_of(k)));
        let keeps = same_target && !order.anew && plan.duration() >= left;
        if keeps && group.iter().all(|&k| self.plan_keeps(k, &limits[k])) {
            for &k in &group {
                next.arrange_after(k, &target[k], &limits[k], &self.ranges[k])?;
            }
            return Ok(false);
        }
        next.section = None;
        next.plan.take(&group, &plan);
        for (&k, motion) in group.iter().zip(plan.axes()) {
            let planned = (motion.duration() / self.cycle).round();
            next.lead(k, planned, &target[k], &limits[k], &self.ranges[k])?;
        }
        Ok(true)
    }

    /// Returns true if `new` is the target set already, up to round-off in the caller's arithmetic.
    fn is_target(&self, k: usize, new: &AxisState) -> bool {
        let (old, s, l) = (&self.target[k], &self.planned[k], &self.limits[k]);
        let same = |x: f64, y: f64, size: f64| x == y || (x - y).abs() <= ROUND_OFF * size;
        same(old.p, new.p, old.p.abs() + s.p.abs())
            && same(old.v, new.v, l.v_max() - l.v_min())
            && same(old.a, new.a, l.a_max() - l.a_min())
    }

    /// Returns true if what is left of the plan of an axis stays within `limits`.
    fn plan_keeps(&self, k: usize, limits: &AxisLimits) -> bool {
        keeps(&self.following.plan.axes()[k], self.following.axes[k].steps * self.cycle, limits)
    }
}

/// What is set, and where plans begin.
#[derive(Clone, Copy)]
struct Order<'a, const N: usize> {
    target: &'a [AxisState; N],
    limits: &'a [AxisLimits; N],
    from: &'a [AxisState; N],
    /// No plan is kept.
    anew: bool,
}

/// Relative difference that counts as round-off in the caller's arithmetic.
const ROUND_OFF: f64 = 16.0 * f64::EPSILON;
