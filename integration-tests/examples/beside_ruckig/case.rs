//! One problem, and the answers of both.

use arcfeed_feedrate::{AxisLimits, AxisState, FeedError, MotionLaw, StateToState};
use arcfeed_sync::{MotionOptions, Synchronisation, Trajectory};
use ruckig::{ControlInterface, InputParameter, Ruckig, Synchronization};

/// Axes of every case.
pub const AXES: usize = 3;

/// What is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interface {
    /// Positions, together in time.
    Position,
    /// Positions, on a line where it can be.
    Straight,
    /// Velocities.
    Velocity,
}

/// A problem.
#[derive(Debug, Clone)]
pub struct Case {
    /// What is asked for.
    pub interface: Interface,
    /// Start of each axis.
    pub start: [AxisState; AXES],
    /// Target of each axis.
    pub target: [AxisState; AXES],
    /// Velocity, acceleration and jerk limit of each axis.
    pub limits: [[f64; 3]; AXES],
}

impl Case {
    /// Returns true if an axis starts outside its limits, or leaves them however it is driven.
    pub fn starts_outside(&self) -> bool {
        self.start
            .iter()
            .zip(self.limits)
            .any(|(s, [v, a, j])| s.v.abs() > v || s.a.abs() > a || (s.v + 0.5 * s.a * s.a.abs() / j).abs() > v)
    }
}

/// An answer.
#[derive(Debug, Clone, PartialEq)]
pub enum Answer {
    /// A motion of this duration (s).
    Duration(f64),
    /// The input is refused.
    Invalid,
    /// The input is valid, but no motion was found.
    Failed(String),
}

/// The answer of arcfeed.
pub fn ours(case: &Case) -> Answer {
    match duration(case) {
        Ok(duration) => Answer::Duration(duration),
        Err(text) => Answer::Failed(text),
    }
}

fn duration(case: &Case) -> Result<f64, String> {
    let mut limits = [AxisLimits::symmetric(1.0, 1.0, 1.0).map_err(|error| error.to_string())?; AXES];
    for (limits, [v, a, j]) in limits.iter_mut().zip(case.limits) {
        *limits = AxisLimits::symmetric(v, a, j).map_err(|error| error.to_string())?;
    }
    let mode = match case.interface {
        Interface::Velocity => return to_velocities(case, &limits).map_err(|error| error.to_string()),
        Interface::Position => Synchronisation::Time,
        Interface::Straight => Synchronisation::StraightLine,
    };
    let motion = Trajectory::new(&case.start, &case.target, &limits, &MotionOptions::new(mode));
    motion.map(|motion| motion.duration()).map_err(|error| error.to_string())
}

fn to_velocities(case: &Case, limits: &[AxisLimits; AXES]) -> Result<f64, FeedError> {
    let mut duration = 0.0_f64;
    for (k, limits) in limits.iter().enumerate() {
        let motion = StateToState::to_velocity(&case.start[k], case.target[k].v, case.target[k].a, limits)?;
        duration = duration.max(motion.duration());
    }
    Ok(duration)
}

/// The answer of ruckig.
pub fn theirs(case: &Case) -> Answer {
    let mut input = InputParameter::new(AXES);
    input.control_interface = match case.interface {
        Interface::Velocity => ControlInterface::Velocity,
        _ => ControlInterface::Position,
    };
    input.synchronization = match case.interface {
        Interface::Straight => Synchronization::Phase,
        // Each axis is as fast as it can: the duration is that of the slowest.
        Interface::Velocity => Synchronization::None,
        Interface::Position => Synchronization::Time,
    };
    fill(&mut input, case);
    let mut otg = Ruckig::new_direct_and_offline(AXES);
    let mut motion = ruckig::Trajectory::new_direct(AXES);
    match otg.calculate(&mut input, &mut motion) {
        ruckig::Result::Working | ruckig::Result::Finished => Answer::Duration(motion.get_duration()),
        ruckig::Result::ErrorInvalidInput => Answer::Invalid,
        other => Answer::Failed(format!("{other:?}")),
    }
}

/// Sets states and limits.
pub fn fill(input: &mut InputParameter, case: &Case) {
    for k in 0..AXES {
        let (start, target, [v, a, j]) = (&case.start[k], &case.target[k], case.limits[k]);
        input.current_position[k] = start.p;
        input.current_velocity[k] = start.v;
        input.current_acceleration[k] = start.a;
        input.target_position[k] = target.p;
        input.target_velocity[k] = target.v;
        input.target_acceleration[k] = target.a;
        (input.max_velocity[k], input.max_acceleration[k], input.max_jerk[k]) = (v, a, j);
    }
}
