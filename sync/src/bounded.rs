//! Several axes from state to state inside ranges of positions.

use arcfeed_feedrate::{AxisLimits, AxisState, BoundedProblem, FeedError, PositionLimits, StateToState};

use crate::error::SyncError;
use crate::mode::MotionOptions;
use crate::state_to_state::Trajectory;

/// Durations tried at most for each axis.
const ROUNDS: usize = 8;

impl<const N: usize> Trajectory<N> {
    /// The motion from `start` to `target` within `limits` and inside ranges of positions, all axes
    /// together, in the shortest duration in which each axis finds one
    /// ([`BoundedProblem::with_duration`]).
    ///
    /// # Errors
    /// [`SyncError::State`] naming the axis.
    ///
    /// ```
    /// use arcfeed_sync::feedrate::{AxisLimits, AxisState, PositionLimits};
    /// use arcfeed_sync::{MotionOptions, Trajectory};
    /// let limits = [AxisLimits::symmetric(1.0, 2.0, 20.0)?; 2];
    /// let ranges = [PositionLimits::new(-1.0, 0.2)?, PositionLimits::ALL];
    /// let start = [AxisState::new(0.0, 0.8, 0.0), AxisState::rest(0.0)];
    /// let target = [-0.5, 0.3].map(AxisState::rest);
    /// let motion = Trajectory::inside(&start, &target, &limits, (&ranges, &MotionOptions::default()))?;
    /// assert!(motion.axes()[0].position_range().max <= 0.2 + 1e-15);
    /// assert_eq!(motion.at(motion.duration()).q.as_slice(), [-0.5, 0.3]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn inside(
        start: &[AxisState; N],
        target: &[AxisState; N],
        limits: &[AxisLimits; N],
        (ranges, options): (&[PositionLimits; N], &MotionOptions),
    ) -> Result<Self, SyncError> {
        let problems: [_; N] =
            std::array::from_fn(|k| BoundedProblem::new(&start[k], &target[k], &limits[k], &ranges[k]));
        let mut shortest = 0.0_f64;
        for (axis, problem) in problems.iter().enumerate() {
            match problem {
                Ok(p) => shortest = shortest.max(p.shortest_duration()),
                Err(source) => return Err(SyncError::State { axis, source: *source }),
            }
        }
        let mut duration = options.round_up(shortest);
        let mut last = 0;
        for _ in 0..ROUNDS * (N + 1) {
            match lasting(&problems, duration) {
                Ok(axes) => return Ok(Self::of(axes)),
                Err(SyncError::State { axis, source: FeedError::DurationImpossible { above, .. } })
                    if above > duration && above.is_finite() =>
                {
                    last = axis;
                    duration = options.round_up(above);
                }
                Err(e) => return Err(e),
            }
        }
        Err(SyncError::State { axis: last, source: FeedError::OutOfRange { what: "duration of the motion" } })
    }
}

/// Every axis in the common duration.
fn lasting<const N: usize>(
    problems: &[Result<BoundedProblem, FeedError>; N],
    duration: f64,
) -> Result<[StateToState; N], SyncError> {
    let mut axes = [StateToState::default(); N];
    for (axis, (motion, problem)) in axes.iter_mut().zip(problems).enumerate() {
        if let Ok(problem) = problem {
            *motion = problem.with_duration(duration).map_err(|source| SyncError::State { axis, source })?;
        }
    }
    Ok(axes)
}
