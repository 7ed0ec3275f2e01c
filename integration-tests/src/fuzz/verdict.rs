//! What became of one input.

/// What became of one input.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Verdict {
    /// Read, or planned.
    Accepted,
    /// Refused by an error.
    Refused,
    /// Neither: a defect, in words.
    Broken(String),
}

impl Verdict {
    /// Broken if one is, accepted if one is.
    pub(super) fn worst(all: impl IntoIterator<Item = Self>) -> Self {
        all.into_iter().fold(Self::Refused, |worst, one| match (worst, one) {
            (Self::Broken(what), _) | (_, Self::Broken(what)) => Self::Broken(what),
            (Self::Accepted, _) | (_, Self::Accepted) => Self::Accepted,
            _ => Self::Refused,
        })
    }
}
