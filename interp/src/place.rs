//! The parameter of a path, and a place on a path.

use std::fmt;

/// The quantity that the parameter of a [`MotionPath`](crate::MotionPath) measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PathParameter {
    /// Length covered by the tool point, m.
    ArcLength,
    /// Angle turned by the tool (the full angle, not half of it), rad.
    RotationAngle,
    /// Sum of the straight distances between joint way-points (Euclidean, over all joints), rad.
    JointDistance,
}

impl PathParameter {
    /// Unit of the parameter: "m" or "rad".
    pub const fn unit(self) -> &'static str {
        match self {
            Self::ArcLength => "m",
            Self::RotationAngle | Self::JointDistance => "rad",
        }
    }
}

impl From<arcfeed_geometry::PathParameter> for PathParameter {
    fn from(parameter: arcfeed_geometry::PathParameter) -> Self {
        match parameter {
            arcfeed_geometry::PathParameter::ArcLength => Self::ArcLength,
            arcfeed_geometry::PathParameter::RotationAngle => Self::RotationAngle,
        }
    }
}

impl fmt::Display for PathParameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::ArcLength => "arc length",
            Self::RotationAngle => "rotation angle",
            Self::JointDistance => "joint distance",
        })
    }
}

/// A place on a path, as messages name it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathPlace {
    /// Value of the parameter.
    pub s: f64,
    /// The quantity that the parameter measures.
    pub parameter: PathParameter,
    /// Tool point there, m, in base; `None` where the path prescribes none.
    pub tool: Option<[f64; 3]>,
}

impl fmt::Display for PathPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "s = {:.6} {}", self.s, self.parameter.unit())?;
        if self.parameter != PathParameter::ArcLength {
            write!(f, " ({})", self.parameter)?;
        }
        match self.tool {
            Some([x, y, z]) => write!(f, " (tool at x {x:.4}, y {y:.4}, z {z:.4} m)"),
            None => Ok(()),
        }
    }
}
