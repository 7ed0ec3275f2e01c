//! The report of a motion in joint space: what `cr7 move` and `cr7 online` have in common.

use std::fmt::{self, Display, Formatter};
use std::path::PathBuf;

use serde::Serialize;

use super::limit_table::{ending, limit_table};
use crate::run::limit_line::LimitLine;
use crate::run::online_events::Happening;
use crate::text::{WIDTH, clip, number};

/// The result of a motion in joint space. Its fields are the keys of the JSON form, SI units in their names.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JointReport {
    /// The name of the motion.
    pub name: String,
    /// Duration in s.
    pub duration_s: f64,
    /// Number of samples.
    pub samples: usize,
    /// Control period in s.
    pub period_s: f64,
    /// Facts in words, each a name and a value.
    pub facts: Vec<(String, String)>,
    /// The events on the way.
    pub events: Vec<Happening>,
    /// Every limit with its worst place.
    pub limits: Vec<LimitLine>,
    /// Warnings.
    pub warnings: Vec<String>,
    /// Files written.
    pub files: Vec<PathBuf>,
}

const MOST_EVENTS: usize = 12;

impl Display for JointReport {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", clip(&self.name, WIDTH))?;
        let samples =
            format!("{} s, {} samples at {} ms", number(self.duration_s), self.samples, number(self.period_s * 1e3));
        writeln!(f, "  {:<16}{samples}", "duration")?;
        for (name, value) in &self.facts {
            writeln!(f, "  {name:<16}{}", clip(value, WIDTH - 18))?;
        }
        for event in self.events.iter().take(MOST_EVENTS) {
            writeln!(f, "  {:>10} s  {}", format!("{:.4}", event.t_s), clip(&event.what, WIDTH - 16))?;
        }
        if self.events.len() > MOST_EVENTS {
            writeln!(f, "  and {} more events (all in the JSON report)", self.events.len() - MOST_EVENTS)?;
        }
        limit_table(f, &self.limits)?;
        ending(f, &self.warnings, &self.files, [usize::MAX; 2])
    }
}
