//! The part of a hybrid motion in joint space: from point to point, with holds, from any state of motion.

use arcfeed_feedrate::{AxisLimits, AxisState, MotionLaw, StateToState};
use arcfeed_kinematics::{JointLimits, Joints};
use arcfeed_sync::{
    JointState, OnlineGenerator, ProjectionStatus, ProjectionSync, SyncError, Synchronisation, symmetric_limits,
};

use super::command::JointMoveBy;
use super::error::HybridError;

/// Rounding, relative to a range or a limit.
const ROUNDING: f64 = 1e-12;

/// All joints on the way to one target.
#[derive(Debug, Clone)]
pub(super) struct JointSpace<const N: usize> {
    mover: Mover<N>,
    limits: [AxisLimits; N],
    lower: Joints<N>,
    upper: Joints<N>,
    period: f64,
    target: Joints<N>,
    by: JointMoveBy,
    held: bool,
    /// A projection was broken off before a joint left its range: the arm brakes, and then goes on by least time.
    broken_off: bool,
}

/// The part that moves the joints.
#[derive(Debug, Clone)]
#[allow(clippy::large_enum_variant, reason = "one of each motion, never moved about")]
enum Mover<const N: usize> {
    Generator(OnlineGenerator<N>),
    Projection(ProjectionSync<N>),
}

impl<const N: usize> JointSpace<N> {
    /// At rest at `q`, for a control `period` (s).
    pub fn new(limits: &JointLimits<N>, period: f64, q: &Joints<N>) -> Result<Self, HybridError> {
        let all = axis_limits(limits)?;
        let generator = OnlineGenerator::new(rest(q), all, period, Synchronisation::Time)?;
        Ok(Self {
            mover: Mover::Generator(generator),
            limits: all,
            lower: *limits.lower(),
            upper: *limits.upper(),
            period,
            target: *q,
            by: JointMoveBy::LeastTime,
            held: false,
            broken_off: false,
        })
    }

    /// Sets how the targets from now on are reached.
    pub fn move_by(&mut self, by: JointMoveBy) {
        self.by = by;
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
        self.go(&start, target, self.by)
    }

    /// Goes for another target from the present motion.
    pub fn retarget(&mut self, target: &Joints<N>) -> Result<(), HybridError> {
        self.go(&self.state(), target, self.by)
    }

    fn go(&mut self, from: &[AxisState; N], target: &Joints<N>, by: JointMoveBy) -> Result<(), HybridError> {
        let mover = match by {
            JointMoveBy::LeastTime => {
                let mut generator = OnlineGenerator::new(*from, self.limits, self.period, Synchronisation::Time)?;
                generator.set_target(rest(target))?;
                self.check(&generator)?;
                Mover::Generator(generator)
            }
            JointMoveBy::Projection => {
                if let Some(error) = self.leaves(from) {
                    return Err(error);
                }
                let start = JointState {
                    q: Joints::from_fn(|k, _| from[k].p),
                    qd: Joints::from_fn(|k, _| from[k].v),
                    qdd: Joints::from_fn(|k, _| from[k].a),
                    qddd: Joints::zeros(),
                };
                Mover::Projection(ProjectionSync::new(&start, *target, &self.limits)?)
            }
        };
        (self.mover, self.target, self.held, self.broken_off) = (mover, *target, false, false);
        Ok(())
    }

    /// Brakes every joint as hard as its limits allow.
    pub fn hold(&mut self) -> Result<(), HybridError> {
        if !self.held {
            self.brake()?;
            (self.held, self.broken_off) = (true, false);
        }
        Ok(())
    }

    fn brake(&mut self) -> Result<(), HybridError> {
        let mut state = self.state();
        for (axis, limits) in state.iter_mut().zip(&self.limits) {
            // A joint that moves by rounding alone stands: nothing would be left to brake, and it never rested.
            if axis.v.abs() <= ROUNDING * limits.v_max() && axis.a.abs() <= ROUNDING * limits.a_max() {
                *axis = AxisState::rest(axis.p);
            }
        }
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
        self.mover = Mover::Generator(generator);
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

    /// True where every joint is `within` (rad) of the target, on the way there.
    pub fn is_near(&self, within: f64) -> bool {
        let state = self.state();
        !self.held && !self.broken_off && (0..N).all(|k| (state[k].p - self.target[k]).abs() <= within)
    }

    /// Moves on by one cycle: position, velocity, acceleration, jerk, and whether the target is reached or a hold stands.
    pub fn step(&mut self) -> ([Joints<N>; 4], bool) {
        if let Mover::Projection(sync) = &self.mover {
            let mut next = *sync;
            if let Ok(step) = next.step(self.period) {
                let JointState { q, qd, qdd, qddd } = step.state;
                let state = std::array::from_fn(|k| AxisState::new(q[k], qd[k], qdd[k]));
                if self.leaves(&state).is_none() {
                    self.mover = Mover::Projection(next);
                    return ([q, qd, qdd, qddd], matches!(step.status, ProjectionStatus::Reached { .. }));
                }
            }
            self.break_off();
        }
        let (state, arrived) = match &mut self.mover {
            Mover::Generator(generator) => {
                let step = generator.step();
                (step.state, step.events.reached || !generator.is_underway())
            }
            // Nothing else could be planned: it stays where it is going.
            Mover::Projection(sync) => (sync.step(self.period).map_or(sync.state(), |step| step.state), false),
        };
        if arrived && self.broken_off {
            let target = self.target;
            let again = self.go(&self.state(), &target, JointMoveBy::LeastTime);
            self.broken_off = again.is_err();
            return ([state.q, state.qd, state.qdd, state.qddd], false);
        }
        ([state.q, state.qd, state.qdd, state.qddd], arrived)
    }

    /// From a projection that would leave the range of a joint to a motion that does not.
    fn break_off(&mut self) {
        let target = self.target;
        if self.go(&self.state(), &target, JointMoveBy::LeastTime).is_err() && self.brake().is_ok() {
            self.broken_off = true;
        }
    }

    fn state(&self) -> [AxisState; N] {
        match &self.mover {
            Mover::Generator(generator) => *generator.state(),
            Mover::Projection(sync) => {
                let now = sync.state();
                std::array::from_fn(|k| AxisState::new(now.q[k], now.qd[k], now.qdd[k]))
            }
        }
    }

    /// The first joint that can no longer come to rest within its range.
    fn leaves(&self, state: &[AxisState; N]) -> Option<HybridError> {
        (0..N).find_map(|joint| {
            let rounding = self.rounding(joint);
            let (lower, upper) = (self.lower[joint] - rounding, self.upper[joint] + rounding);
            let stop = StateToState::stop(&state[joint], &self.limits[joint]).ok()?;
            let range = stop.position_range();
            (range.max > upper || range.min < lower).then(|| {
                let (value, limit) = if range.max > upper { (range.max, upper) } else { (range.min, lower) };
                HybridError::BrakesFirst { joint, value, limit }
            })
        })
    }

    /// What is outside by rounding is a point on the limit itself.
    fn rounding(&self, joint: usize) -> f64 {
        ROUNDING * (self.upper[joint] - self.lower[joint])
    }

    /// No joint leaves its range on the way.
    fn check(&self, generator: &OnlineGenerator<N>) -> Result<(), HybridError> {
        for (joint, axis) in generator.plan().axes().iter().enumerate() {
            let range = axis.position_range();
            let (lower, upper) = (self.lower[joint], self.upper[joint]);
            let rounding = self.rounding(joint);
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

#[cfg(test)]
mod tests {
    use super::*;
    use arcfeed_kinematics::JointRange;
    use arcfeed_testing::Random;

    const PERIOD: f64 = 2e-3;

    /// Next to an end of the range, moving as fast as still can be stopped, to a target anywhere within it. Returns whether the projection
    /// was broken off.
    fn plays(seed: u64) -> Result<bool, String> {
        let mut random = Random::new(seed);
        let range = JointRange::new(Joints::repeat(-1.0), Joints::repeat(1.0)).expect("a range");
        let limits = range.with_rates(Joints::repeat(2.0), Joints::repeat(8.0), Joints::repeat(80.0)).expect("limits");
        let place = |random: &mut Random| random.sign() * (1.0 - random.log(1e-3, 1.0));
        let q = Joints::<6>::from_fn(|_, _| place(&mut random));
        let qd = Joints::from_fn(|_, _| random.between(-2.0, 2.0));
        let qdd = Joints::from_fn(|_, _| random.between(-4.0, 4.0));
        let target = Joints::from_fn(|_, _| place(&mut random));
        let mut space = JointSpace::new(&limits, PERIOD, &q).expect("a motion");
        space.move_by(JointMoveBy::Projection);
        if space.start(&q, &qd, &qdd, &target).is_err() {
            return Err(String::new());
        }
        let mut broken_off = false;
        for cycle in 0..10_000 {
            let before = space.state();
            let ([q, qd, qdd, _], arrived) = space.step();
            broken_off |= matches!(space.mover, Mover::Generator(_));
            for k in 0..6 {
                let jerk = (qdd[k] - before[k].a) / PERIOD;
                let fine =
                    q[k].abs() <= 1.0 + 1e-11 && qdd[k].abs() < 8.0 * (1.0 + 1e-6) && jerk.abs() < 80.0 * (1.0 + 1e-6);
                let step = q[k] - before[k].p - 0.5 * PERIOD * (qd[k] + before[k].v);
                if !fine || step.abs() > 80.0 * PERIOD.powi(3) / 12.0 + 1e-14 {
                    return Err(format!("joint {} at {} after {cycle} cycles, jerk {jerk}", k + 1, q[k]));
                }
            }
            if arrived {
                return if q == target && qd.amax() == 0.0 { Ok(broken_off) } else { Err(format!("ends at {q}")) };
            }
        }
        Err("does not arrive".to_owned())
    }

    #[test]
    fn a_projection_that_would_leave_the_range_is_broken_off_before() {
        let (mut arrived, mut broken_off) = (0, 0);
        for seed in 0..2000 {
            match plays(seed) {
                Ok(broken) => (arrived, broken_off) = (arrived + 1, broken_off + usize::from(broken)),
                // It could not be stopped from the start.
                Err(why) if why.is_empty() => {}
                Err(why) => panic!("seed {seed}: {why}"),
            }
        }
        assert!(arrived > 100 && broken_off > 5, "{arrived} arrived, {broken_off} of them broken off");
    }
}
