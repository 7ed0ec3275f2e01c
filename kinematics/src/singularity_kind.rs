//! The kinds of singular poses, by name: errors tell them too.

/// Which kind of singular pose a six-joint arm is close to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SingularityKind {
    /// The last joint's axis lines up with an earlier one: it and the forearm joints turn the tool the same way.
    Wrist,
    /// The arm is stretched or folded: it cannot move along itself.
    Elbow,
    /// The wrist stands over the first joint's axis: the first joint no longer moves it sideways to the arm.
    Shoulder,
}

impl SingularityKind {
    pub(crate) fn describe(self) -> &'static str {
        match self {
            Self::Wrist => "close to a wrist singularity (two axes of the wrist line up)",
            Self::Elbow => "close to an elbow singularity (arm stretched or folded)",
            Self::Shoulder => "close to a shoulder singularity (wrist over the first axis)",
        }
    }
}

impl std::fmt::Display for SingularityKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Wrist => "wrist",
            Self::Elbow => "elbow",
            Self::Shoulder => "shoulder",
        })
    }
}
