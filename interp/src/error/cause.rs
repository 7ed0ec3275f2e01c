//! Why a finished motion breaks a limit.

use std::fmt;

/// The feature of the path at the place where a finished trajectory breaks a limit.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Cause {
    /// The path has a bend there that the tool would pass within two control periods at the feed.
    Bend {
        /// Arc length of its sharpest place, m.
        s: f64,
        /// Radius there, m.
        radius: f64,
    },
    /// The arm is nearly singular there.
    NearlySingular {
        /// Smallest singular value of the Jacobian, rows in m and rad.
        sigma: f64,
    },
    /// The planner knows the limits at the points of its grid alone, and the grid is too coarse.
    CoarseGrid {
        /// Its intervals.
        intervals: usize,
    },
    /// Nothing: planner and verification contradict each other.
    Contradiction,
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Bend { s, radius } => write!(
                f,
                "the path has a bend of radius {} at s = {s:.6} m: round it to a larger radius, make it a true corner \
                 (where the tool stops), or raise that limit",
                length(radius)
            ),
            Self::NearlySingular { sigma } => write!(
                f,
                "the arm is nearly singular there (smallest singular value {sigma:.2e}): move the path, or start from \
                 another configuration"
            ),
            Self::CoarseGrid { intervals } => write!(
                f,
                "the planner keeps limits at the {intervals} intervals of its grid alone: take more intervals, or a planner that \
                 keeps them between the points"
            ),
            Self::Contradiction => f.write_str("the planner kept it by its own account: please report the job"),
        }
    }
}

/// A length in the unit that suits it.
fn length(m: f64) -> String {
    match m {
        m if m < 1e-6 => format!("{:.3} nm", m * 1e9),
        m if m < 1e-3 => format!("{:.3} um", m * 1e6),
        m => format!("{:.3} mm", m * 1e3),
    }
}
