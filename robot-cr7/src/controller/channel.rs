//! The connections to a controller.

use std::fmt::{self, Display, Formatter};

/// A connection to the controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Channel {
    /// Commands and their replies (port 29999).
    Dashboard,
    /// Motion commands of version 3 (port 30003).
    Motion,
    /// The state of the arm every 8 ms (port 30004).
    Feedback,
}

impl Display for Channel {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Dashboard => "dashboard",
            Self::Motion => "motion",
            Self::Feedback => "feedback",
        })
    }
}
