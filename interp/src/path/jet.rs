//! Joint values and derivatives at one place of a path.

use arcfeed_feedrate::MotionState;
use arcfeed_kinematics::Joints;
use nalgebra::Isometry3;

use crate::setpoint::Setpoint;

/// Joint values and three derivatives by the path's parameter at one place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointJet<const N: usize = 6> {
    /// Value of the parameter, m or rad.
    pub s: f64,
    /// Joint values, rad.
    pub q: Joints<N>,
    /// dq/ds, rad per unit of the parameter.
    pub d1: Joints<N>,
    /// d2q/ds2.
    pub d2: Joints<N>,
    /// d3q/ds3.
    pub d3: Joints<N>,
}

impl<const N: usize> JointJet<N> {
    /// Joint values a distance `h` further on, by the Taylor series to third order.
    #[inline]
    pub fn ahead(&self, h: f64) -> Joints<N> {
        self.q + (self.d1 + (self.d2 / 2.0 + self.d3 * (h / 6.0)) * h) * h
    }

    /// Values and derivatives a distance `h` further on, by the same series.
    #[inline]
    pub fn shifted(&self, h: f64) -> Self {
        let d1 = self.d1 + (self.d2 + self.d3 * (0.5 * h)) * h;
        Self { s: self.s + h, q: self.ahead(h), d1, d2: self.d2 + self.d3 * h, d3: self.d3 }
    }

    /// The setpoint at time `t` (s) in the state `state` of the motion along the path, with the tool at `pose`.
    ///
    /// ```text
    /// velocity      q' v
    /// acceleration  q' a + q'' v^2
    /// jerk          q' j + 3 q'' v a + q''' v^3
    /// ```
    #[inline]
    pub fn setpoint(&self, t: f64, state: &MotionState, pose: Isometry3<f64>) -> Setpoint<N> {
        let (v, a, j) = (state.v, state.a, state.j);
        Setpoint {
            t,
            s: state.p,
            feed: v,
            acceleration: a,
            q: self.q,
            qd: self.d1 * v,
            qdd: self.d1 * a + self.d2 * (v * v),
            jerk: self.d1 * j + self.d2 * (3.0 * v * a) + self.d3 * (v * v * v),
            pose,
        }
    }
}
