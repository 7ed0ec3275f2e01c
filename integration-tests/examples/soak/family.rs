//! A family of random cases.

/// The end of one case.
pub enum Outcome {
    /// Done and checked.
    Done,
    /// Refused with a reason, which is no failure.
    Refused,
    /// Something that must not be.
    Failed(String),
}

/// Cases by seed.
pub struct Family<'a> {
    pub name: &'static str,
    pub play: Box<dyn FnMut(u64) -> Outcome + 'a>,
}

impl<'a> Family<'a> {
    pub fn new(name: &'static str, play: impl FnMut(u64) -> Outcome + 'a) -> Self {
        Self { name, play: Box::new(play) }
    }
}
