//! The part of a hybrid motion in joint space: from point to point, with holds, from any state of motion.

use arcfeed_feedrate::{AxisLimits, AxisState, MotionLaw, StateToState};
use arcfeed_kinematics::{JointLimits, Joints};
use arcfeed_sync::{OnlineGenerator, SyncError, Synchronisation, symmetric_limits};

use super::error::HybridError;

/// All joints on the way to one target.
#[derive(Debug, Clone)]
pub(super) struct JointSpace<const N: usize> {
    generator: OnlineGenerator<N>,
    limits: [AxisLimits; N],
    lower: Joints<N>,
    upper: Joints<N>,
    period: f64,
    target: Joints<N>,
    held: bool,
}

impl<const N: usize> JointSpace<N> {
    /// At rest at `q`, for a control `period` (s).
    pub fn new(limits: &JointLimits<N>, period: f64, q: &Joints<N>) -> Result<Self, HybridError> {
        let all = axis_limits(limits)?;
        let start = std::array::from_fn(|k| AxisState::rest(q[k]));
        let generator = OnlineGenerator::new(start, all, period, Synchronisation::Time)?;
        let (lower, upper) = (*limits.lower(), *limits.upper());
        Ok(Self { generator, limits: all, lower, upper, period, target: *q, held: false })
    }

    /// From a state of motion to rest at `target`.
    ///
    /// # Errors
    /// [`HybridError::BrakesFirst`] if the way there leaves the range of a joint.
    pub fn start(
        &mut self,
        q: &Joints<N>,
        qd: &Joints<N>,
        qdd: &Joints<N>,
        target: &Joints<N>,
    ) -> Result<(), HybridError> {
        let start = std::array::from_fn(|k| AxisState::new(q[k], qd[k], qdd[k]));
        let mut generator = OnlineGenerator::new(start, self.limits, self.period, Synchronisation::Time)?;
        generator.set_target(rest(target))?;
        self.check(&generator)?;
        (self.generator, self.target, self.held) = (generator, *target, false);
        Ok(())
    }

    /// Goes for another target from the present motion.
    pub fn retarget(&mut self, target: &Joints<N>) -> Result<(), HybridError> {
        let mut generator =
            OnlineGenerator::new(*self.generator.state(), self.limits, self.period, Synchronisation::Time)?;
        generator.set_target(rest(target))?;
        self.check(&generator)?;
        (self.generator, self.target, self.held) = (generator, *target, false);
        Ok(())
    }

    /// Brakes every joint as hard as its limits allow.
    pub fn hold(&mut self) -> Result<(), HybridError> {
        if self.held {
            return Ok(());
        }
        let state = *self.generator.state();
        let mut generator = OnlineGenerator::new(state, self.limits, self.period, Synchronisation::None)?;
        let mut places = state;
        for (axis, (place, limits)) in places.iter_mut().zip(&self.limits).enumerate() {
            // A joint cannot be outside its range for a moment to come back: it turns before.
            let range = (self.lower[axis], self.upper[axis]);
            let stop = StateToState::stop_within(place, limits, range)
                .or_else(|_| StateToState::stop(place, limits))
                .map_err(|source| SyncError::State { axis, source })?;
            *place = AxisState::rest(stop.at(stop.duration()).p);
        }
        generator.set_target(places)?;
        (self.generator, self.held) = (generator, true);
        Ok(())
    }

    /// Goes on to the target after a hold.
    pub fn resume(&mut self) -> Result<(), HybridError> {
        if !self.held {
            return Ok(());
        }
        let target = self.target;
        self.retarget(&target)
    }

    pub fn is_held(&self) -> bool {
        self.held
    }

    /// Moves on by one cycle: position, velocity, acceleration, jerk, and whether the target is reached or a hold stands.
    pub fn step(&mut self) -> ([Joints<N>; 4], bool) {
        let step = self.generator.step();
        let state = step.state;
        ([state.q, state.qd, state.qdd, state.qddd], step.events.reached || !self.generator.is_underway())
    }

    /// No joint leaves its range on the way.
    fn check(&self, generator: &OnlineGenerator<N>) -> Result<(), HybridError> {
        for (joint, axis) in generator.plan().axes().iter().enumerate() {
            let range = axis.position_range();
            let (lower, upper) = (self.lower[joint], self.upper[joint]);
            // What is outside by rounding is a point on the limit itself.
            let rounding = 1e-12 * (upper - lower);
            if range.max > upper + rounding {
                return Err(HybridError::BrakesFirst { joint, value: range.max, limit: upper });
            }
            if range.min < lower - rounding {
                return Err(HybridError::BrakesFirst { joint, value: range.min, limit: lower });
            }
        }
        Ok(())
    }
}

/// Limits of all joints as those of axes.
pub(crate) fn axis_limits<const N: usize>(limits: &JointLimits<N>) -> Result<[AxisLimits; N], HybridError> {
    Ok(symmetric_limits(*limits.velocity(), *limits.acceleration(), *limits.jerk())?)
}

fn rest<const N: usize>(q: &Joints<N>) -> [AxisState; N] {
    std::array::from_fn(|k| AxisState::rest(q[k]))
}
