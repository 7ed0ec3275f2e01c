//! The state of several axes.

use arcfeed_feedrate::AxisState;
use nalgebra::SVector;

/// Position of all axes and its first three derivatives by time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointState<const N: usize> {
    /// Position (rad).
    pub q: SVector<f64, N>,
    /// Velocity (rad/s).
    pub qd: SVector<f64, N>,
    /// Acceleration (rad/s²).
    pub qdd: SVector<f64, N>,
    /// Jerk (rad/s³).
    pub qddd: SVector<f64, N>,
}

impl<const N: usize> JointState<N> {
    /// At rest at a position (rad).
    pub fn rest(q: SVector<f64, N>) -> Self {
        let still = SVector::zeros();
        Self { q, qd: still, qdd: still, qddd: still }
    }

    /// The states of the axes, without jerk.
    pub(crate) fn of(axes: &[AxisState; N]) -> Self {
        let each = |value: fn(&AxisState) -> f64| SVector::from_fn(|k, _| value(&axes[k]));
        Self { q: each(|s| s.p), qd: each(|s| s.v), qdd: each(|s| s.a), qddd: SVector::zeros() }
    }
}

impl<const N: usize> Default for JointState<N> {
    fn default() -> Self {
        let zero = SVector::zeros();
        Self { q: zero, qd: zero, qdd: zero, qddd: zero }
    }
}
