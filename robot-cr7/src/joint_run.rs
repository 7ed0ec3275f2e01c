//! The report of a motion in joint space: what `cr7 move` and `cr7 online` have in common.

use std::fmt::{self, Display, Formatter};
use std::path::PathBuf;

use serde::Serialize;

use crate::limit_line::LimitLine;
use crate::report::{clip, limit_table, number};

/// Something that happened during a motion.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Happening {
    /// When, in s.
    pub t_s: f64,
    /// What, in words.
    pub what: String,
}

/// The result of a motion in joint space. Its fields are the keys of the JSON form, SI units in their names.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JointReport {
    /// What was done.
    pub name: String,
    /// Duration in s.
    pub duration_s: f64,
    /// Number of samples.
    pub samples: usize,
    /// Control period in s.
    pub period_s: f64,
    /// Facts in words, each a name and a value.
    pub facts: Vec<(String, String)>,
    /// What happened on the way.
    pub events: Vec<Happening>,
    /// Every limit with its worst place.
    pub limits: Vec<LimitLine>,
    /// Files written.
    pub files: Vec<PathBuf>,
}

impl JointReport {
    /// The whole report as one JSON object on one line.
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).unwrap_or_else(|e| serde_json::json!({ "error": e.to_string() }).to_string())
    }

    /// The largest part of a limit that is used; not a number where a sample is none.
    pub fn worst_ratio(&self) -> f64 {
        self.limits.iter().map(|l| l.ratio).fold(0.0, |a: f64, r| if r > a || r.is_nan() { r } else { a })
    }
}

const WIDTH: usize = 100;
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
        if !self.files.is_empty() {
            writeln!(f)?;
        }
        for file in &self.files {
            writeln!(f, "  wrote {}", clip(&file.display().to_string(), WIDTH - 8))?;
        }
        Ok(())
    }
}
