//! What a person should know of the feeds and tolerances of a program.

use crate::input::job::Job;
use crate::text::number;

/// Values of a program that were replaced by those of the job.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct FeedNotes {
    /// The first line whose F is above the feed of the job, and the highest F, m/s.
    held: Option<(usize, f64)>,
    /// The first line that asks for blends (G64) and states no tolerance, where the job does not either.
    unstated: Option<usize>,
}

impl FeedNotes {
    /// The F (m/s) of `line` is held to the feed of the job.
    pub fn held_to_feed(&mut self, line: usize, speed: f64) {
        let (first, highest) = self.held.unwrap_or((line, speed));
        self.held = Some((first, highest.max(speed)));
    }

    /// The tolerance of the blend after `line` is stated nowhere.
    pub fn unstated_tolerance(&mut self, line: usize) {
        self.unstated.get_or_insert(line);
    }

    /// Adds those of a later part of the program.
    pub fn and(&mut self, later: &Self) {
        if let Some((line, speed)) = later.held {
            self.held_to_feed(line, speed);
        }
        if let Some(line) = later.unstated {
            self.unstated_tolerance(line);
        }
    }

    /// As warnings.
    pub fn words(&self, job: &Job) -> Vec<String> {
        let held = self.held.map(|(first, highest)| {
            let [highest, most] = [highest, job.feed.feed].map(|v| number(v * 1e3));
            format!("F of up to {highest} mm/s, first at line {first}, is held to feed.feed_mm_s = {most} of the job")
        });
        let unstated = self.unstated.map(|line| {
            format!("G64 without P at line {line}: corners are blended within 0.1 mm; give path.blend_mm in the job")
        });
        held.into_iter().chain(unstated).collect()
    }
}
