//! The one shape of every limit along a path, and where each limit comes from.

#[cfg(not(feature = "std"))]
use num_traits::Float;
use std::fmt;

/// The quantity that is limited.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Quantity {
    /// Position of a joint: distance from the middle of its range against half the range.
    JointPosition,
    /// Speed of a joint.
    JointVelocity,
    /// Acceleration of a joint.
    JointAcceleration,
    /// Torque of a joint.
    JointTorque,
    /// Jerk of a joint.
    JointJerk,
    /// Angular speed of the tool.
    AngularSpeed,
    /// Speed of the tool point.
    Feed,
    /// Tangential acceleration of the tool.
    TangentialAcceleration,
    /// Tangential jerk of the tool.
    TangentialJerk,
    /// Normal acceleration of the tool.
    NormalAcceleration,
    /// Normal jerk of the tool.
    NormalJerk,
    /// Magnitude of the acceleration of the tool point.
    ToolAcceleration,
    /// Magnitude of the jerk of the tool point.
    ToolJerk,
    /// Distance of the path from the straight line between two setpoints.
    ChordError,
    /// Distance of the tool from its path.
    PathDeviation,
    /// Angle between the tool and the orientation of its path.
    OrientationDeviation,
    /// Misfit of position, velocity and acceleration from one sample to the next, against what the
    /// limits allow.
    Continuity,
    /// State at the start and at the end, in units of what counts as zero.
    Ends,
    /// Difference between the tool of a setpoint and the tool of its joints, in units of what
    /// counts as zero.
    SetpointAgreement,
    /// Distance of a joint from the position asked for at the start or at the end.
    EndPosition,
    /// Difference from the velocity asked for at the start or at the end.
    EndVelocity,
    /// Difference from the acceleration asked for at the start or at the end.
    EndAcceleration,
    /// A corner or a jump of curvature that a limit on acceleration or jerk cannot pass in motion.
    Corner,
    /// The speed asked for at the start.
    StartSpeed,
    /// The speed asked for at the end.
    EndSpeed,
    /// The speed that the rest of the path allows.
    ControllableSet,
    /// A row of the caller's own.
    Other,
}

impl Quantity {
    /// Name in words; those of joints begin with "joint".
    pub const fn name(self) -> &'static str {
        match self {
            Self::JointPosition => "joint position",
            Self::JointVelocity => "joint velocity",
            Self::JointAcceleration => "joint acceleration",
            Self::JointTorque => "joint torque",
            Self::JointJerk => "joint jerk",
            Self::AngularSpeed => "angular speed",
            Self::Feed => "feed",
            Self::TangentialAcceleration => "tangential acceleration",
            Self::TangentialJerk => "tangential jerk",
            Self::NormalAcceleration => "normal acceleration",
            Self::NormalJerk => "normal jerk",
            Self::ToolAcceleration => "tool acceleration",
            Self::ToolJerk => "tool jerk",
            Self::ChordError => "chord error",
            Self::PathDeviation => "deviation from the path",
            Self::OrientationDeviation => "turn away from the path",
            Self::Continuity => "continuity",
            Self::Ends => "state at both ends",
            Self::SetpointAgreement => "setpoint agreement",
            Self::EndPosition => "position at both ends",
            Self::EndVelocity => "velocity at both ends",
            Self::EndAcceleration => "acceleration at both ends",
            Self::Corner => "corner",
            Self::StartSpeed => "start speed",
            Self::EndSpeed => "end speed",
            Self::ControllableSet => "the rest of the path",
            Self::Other => "custom row",
        }
    }

    /// SI unit of its values, where the path's parameter is in metres.
    pub const fn unit(self) -> &'static str {
        match self {
            Self::JointPosition | Self::OrientationDeviation | Self::EndPosition => "rad",
            Self::JointVelocity | Self::AngularSpeed | Self::EndVelocity => "rad/s",
            Self::JointAcceleration | Self::EndAcceleration => "rad/s^2",
            Self::JointJerk => "rad/s^3",
            Self::JointTorque => "N m",
            Self::Feed | Self::Corner | Self::StartSpeed | Self::EndSpeed | Self::ControllableSet => "m/s",
            Self::TangentialAcceleration | Self::NormalAcceleration | Self::ToolAcceleration => "m/s^2",
            Self::TangentialJerk | Self::NormalJerk | Self::ToolJerk => "m/s^3",
            Self::ChordError | Self::PathDeviation => "m",
            Self::Continuity | Self::Ends | Self::SetpointAgreement | Self::Other => "1",
        }
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The limit that a row stems from: the quantity, and the joint if there is one.
///
/// Prints as a person would say it; joints are counted from 1 there, from 0 in the field.
///
/// ```
/// use arcfeed_feedrate::{Quantity, LimitId};
/// assert_eq!(LimitId::joint(Quantity::JointTorque, 2).to_string(), "torque of joint 3");
/// assert_eq!(LimitId::path(Quantity::Feed).to_string(), "feed");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct LimitId {
    /// The limited quantity.
    pub quantity: Quantity,
    /// Index of the joint, from 0.
    pub joint: Option<u16>,
}

impl LimitId {
    /// The limit of one joint, counted from 0.
    pub fn joint(quantity: Quantity, joint: usize) -> Self {
        Self { quantity, joint: Some(u16::try_from(joint).unwrap_or(u16::MAX)) }
    }

    /// A limit on the motion as a whole.
    pub const fn path(quantity: Quantity) -> Self {
        Self { quantity, joint: None }
    }
}

impl fmt::Display for LimitId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = self.quantity.name();
        match self.joint {
            Some(joint) => write!(f, "{} of joint {}", name.trim_start_matches("joint "), u32::from(joint) + 1),
            None => write!(f, "{}", self.quantity),
        }
    }
}

/// `lo <= a u + b x + c sqrt(x) + d <= hi` at one place of the path, with `x = (ds/dt)^2` and
/// `u = d2s/dt2`.
///
/// Joint acceleration has `a = q'`, `b = q''`; torque adds viscous friction as `c` and gravity with
/// Coulomb friction as `d` (Electronics 2025, 14, 3869, eqs. 5 and 8). The unit is that of the
/// limited quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// Factor of `u`.
    pub a: f64,
    /// Factor of `x`.
    pub b: f64,
    /// Factor of `sqrt(x)`.
    pub c: f64,
    /// Value at rest.
    pub d: f64,
    /// Least value allowed; may be `-inf`.
    pub lo: f64,
    /// Greatest value allowed; may be `inf`.
    pub hi: f64,
    /// The limit that the row states.
    pub source: LimitId,
}

impl Row {
    /// `|a u + b x| <= limit`.
    pub const fn symmetric(a: f64, b: f64, limit: f64, source: LimitId) -> Self {
        Self { a, b, c: 0.0, d: 0.0, lo: -limit, hi: limit, source }
    }

    /// The value at `(u, x)`.
    pub fn value(&self, u: f64, x: f64) -> f64 {
        let friction = if self.c == 0.0 { 0.0 } else { self.c * x.sqrt() };
        self.a * u + self.b * x + friction + self.d
    }

    /// Excess of the value at `(u, x)` over its bounds; 0 inside.
    pub fn excess(&self, u: f64, x: f64) -> f64 {
        let value = self.value(u, x);
        (value - self.hi).max(self.lo - value).max(0.0)
    }

    #[cfg(feature = "std")]
    pub(crate) fn is_sound(&self) -> bool {
        // Two tests without a branch between them, since this runs over every row. The difference
        // of the bounds is negative where they exclude each other and NaN where both are the same
        // infinity.
        ((self.a + self.b + self.c + self.d).abs() < f64::INFINITY) & (self.hi - self.lo >= 0.0)
    }
}

/// `|(alpha w + beta u + gamma x) sqrt(x)| + step x <= limit` with `w = du/ds`: a limit on the third
/// derivative in time.
///
/// Joint jerk has `alpha = q'`, `beta = 3 q''`, `gamma = q'''`; tangential jerk `alpha = 1` and
/// nothing else. Where `q''` jumps nearby, `step` is the jump over the time that it is spread over.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JerkRow {
    /// Factor of `w`.
    pub alpha: f64,
    /// Factor of `u`.
    pub beta: f64,
    /// Factor of `x`.
    pub gamma: f64,
    /// Jump of the second derivative nearby over the time that it is spread over, not negative.
    pub step: f64,
    /// Greatest magnitude allowed, above 0; may be `inf`.
    pub limit: f64,
    /// The limit that the row states.
    pub source: LimitId,
}

impl JerkRow {
    /// The value at `(w, u, x)`, without the step.
    pub fn value(&self, w: f64, u: f64, x: f64) -> f64 {
        (self.alpha * w + self.beta * u + self.gamma * x) * x.sqrt()
    }
}

/// One limit over a whole interval of the grid, by magnitudes that its terms do not exceed anywhere
/// on it. `v`, `u` and `j` are speed, acceleration and jerk along the path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum IntervalBound {
    /// `v <= most`.
    Speed {
        /// Greatest speed.
        most: f64,
        /// The limit that the bound states.
        source: LimitId,
    },
    /// `a |u| + b v^2 + c v + rest <= limit`.
    Acceleration {
        /// Factor of the acceleration.
        a: f64,
        /// Factor of the squared speed.
        b: f64,
        /// Factor of the speed.
        c: f64,
        /// Value at rest.
        rest: f64,
        /// Greatest value, above 0.
        limit: f64,
        /// The limit that the bound states.
        source: LimitId,
    },
    /// `alpha |j| + beta v |u| + gamma v^3 + step v^2 <= limit`.
    Jerk {
        /// Factor of the jerk.
        alpha: f64,
        /// Factor of speed times acceleration.
        beta: f64,
        /// Factor of the cubed speed.
        gamma: f64,
        /// Jump of the acceleration at an end of the interval by the squared speed, over the time
        /// it is spread over.
        step: f64,
        /// Greatest value, above 0.
        limit: f64,
        /// The limit that the bound states.
        source: LimitId,
    },
}
