//! A family of random cases.

use std::panic::{AssertUnwindSafe, catch_unwind};

/// The end of one case.
pub enum Outcome {
    /// Done and checked.
    Done,
    /// The same, with the largest part of a limit that was used.
    Used(f64),
    /// Refused with a reason, which is no failure.
    Refused,
    /// Something that must not be.
    Failed(String),
}

/// Cases by seed.
pub struct Family<'a> {
    pub name: &'static str,
    play: Box<dyn FnMut(u64) -> Outcome + 'a>,
}

impl<'a> Family<'a> {
    pub fn new(name: &'static str, play: impl FnMut(u64) -> Outcome + 'a) -> Self {
        Self { name, play: Box::new(play) }
    }

    /// One case. A panic is a failure.
    pub fn play(&mut self, seed: u64) -> Outcome {
        catch_unwind(AssertUnwindSafe(|| (self.play)(seed))).unwrap_or_else(|panic| {
            let words = panic.downcast_ref::<String>().map(String::as_str);
            let words = words.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("without words");
            Outcome::Failed(format!("panics: {words}"))
        })
    }
}
