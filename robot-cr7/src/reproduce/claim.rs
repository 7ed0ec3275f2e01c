//! One row of a reproduction, and all rows of a paper.

use std::fmt;

use serde::Serialize;

use super::printed::Printed;
use crate::text::json;

/// What a row is worth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// Recomputed from samples, by finite differences, or by another method than the one that is
    /// judged.
    Independent,
    /// Equal to a printed number within the rounding of the print.
    Print,
    /// The printed number was used to make a stand-in, so agreement shows nothing.
    Fitted,
    /// Shown, and not judged.
    Information,
}

impl Kind {
    /// The kind in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Independent => "independent check",
            Self::Print => "agrees with print",
            Self::Fitted => "fitted",
            Self::Information => "for information",
        }
    }
}

/// One number of a paper and ours.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Claim {
    /// Where in the paper: "table 1", ...
    pub place: String,
    /// What the number is.
    pub what: String,
    /// The paper's value, as printed; empty where the paper has none.
    pub paper: String,
    /// Ours.
    pub ours: String,
    /// What a reader should know about the pair.
    pub note: String,
    /// What the row is worth.
    pub kind: Kind,
    /// Whether the row holds; `None` for a row that does not count.
    pub holds: Option<bool>,
}

impl Claim {
    /// Makes of a row for information one whose printed number was used to make a stand-in.
    pub fn fitted(&mut self) -> &mut Self {
        self.kind = Kind::Fitted;
        self
    }

    /// Adds what a reader should know.
    pub fn note(&mut self, note: impl Into<String>) -> &mut Self {
        self.note = note.into();
        self
    }

    fn mark(&self) -> &'static str {
        match (self.holds, self.kind) {
            (Some(false), _) => "BROKEN",
            (_, kind) => kind.words(),
        }
    }
}

/// All rows of one paper.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reproduction {
    /// Which paper.
    pub paper: String,
    /// Its numbers and ours.
    pub claims: Vec<Claim>,
}

/// How many rows there are of each kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Tally {
    /// Independent checks.
    pub independent: usize,
    /// Rows that agree with the print.
    pub print: usize,
    /// Fitted rows, which do not count.
    pub fitted: usize,
    /// Rows for information, which do not count.
    pub information: usize,
    /// Rows that count and do not hold.
    pub broken: usize,
}

impl Tally {
    /// Counts rows.
    pub fn of<'a>(claims: impl IntoIterator<Item = &'a Claim>) -> Self {
        let mut tally = Self::default();
        for claim in claims {
            match claim.kind {
                Kind::Independent => tally.independent += 1,
                Kind::Print => tally.print += 1,
                Kind::Fitted => tally.fitted += 1,
                Kind::Information => tally.information += 1,
            }
            tally.broken += usize::from(claim.holds == Some(false));
        }
        tally
    }

    /// Number of rows that count.
    pub fn counted(&self) -> usize {
        self.independent + self.print
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} of {} checks hold ({} independent, {} agree with the print); not counted: {} fitted, {} for \
             information",
            self.counted() - self.broken,
            self.counted(),
            self.independent,
            self.print,
            self.fitted,
            self.information
        )
    }
}

impl Reproduction {
    /// No rows yet.
    pub fn new(paper: &str) -> Self {
        Self { paper: paper.to_owned(), claims: Vec::new() }
    }

    /// Rows that do not hold.
    pub fn broken(&self) -> impl Iterator<Item = &Claim> {
        self.claims.iter().filter(|c| c.holds == Some(false))
    }

    /// How many rows there are of each kind.
    pub fn tally(&self) -> Tally {
        Tally::of(&self.claims)
    }

    /// One JSON object on one line.
    pub fn to_json(&self) -> String {
        json(self)
    }

    /// Adds an independent check.
    pub fn independent(
        &mut self,
        place: &str,
        what: impl Into<String>,
        paper: impl Into<String>,
        ours: impl Into<String>,
        holds: bool,
    ) -> &mut Claim {
        self.add(place, (what.into(), paper.into(), ours.into()), Kind::Independent, Some(holds))
    }

    /// Adds a row that compares `ours` with a printed number, within the rounding of the print. A
    /// text that is no number is broken.
    pub fn print(&mut self, place: &str, what: impl Into<String>, printed: &str, ours: f64) -> &mut Claim {
        let parsed = Printed::parse(printed);
        let holds = parsed.is_some_and(|printed| printed.agrees(ours));
        let shown = parsed.map_or_else(|| ours.to_string(), |printed| printed.shown(ours));
        self.add(place, (what.into(), printed.to_owned(), shown), Kind::Print, Some(holds))
    }

    /// Like [`Reproduction::print`] for several printed numbers, each with ours.
    pub fn print_all(&mut self, place: &str, what: impl Into<String>, pairs: &[(&str, f64)]) -> &mut Claim {
        let parsed: Vec<_> = pairs.iter().map(|(text, ours)| (Printed::parse(text), *ours)).collect();
        let holds = parsed.iter().all(|(printed, ours)| printed.is_some_and(|printed| printed.agrees(*ours)));
        let shown = parsed.iter().map(|(printed, ours)| printed.map_or_else(|| ours.to_string(), |p| p.shown(*ours)));
        let ours = format!("({})", shown.collect::<Vec<_>>().join(", "));
        let paper = format!("({})", pairs.iter().map(|p| p.0).collect::<Vec<_>>().join(", "));
        self.add(place, (what.into(), paper, ours), Kind::Print, Some(holds))
    }

    /// Adds a row that is shown and not judged.
    pub fn information(
        &mut self,
        place: &str,
        what: impl Into<String>,
        paper: impl Into<String>,
        ours: impl Into<String>,
    ) -> &mut Claim {
        self.add(place, (what.into(), paper.into(), ours.into()), Kind::Information, None)
    }

    /// Adds a broken row for a part that cannot be computed.
    pub fn failed(&mut self, place: &str, error: &dyn fmt::Display) -> &mut Claim {
        self.independent(place, "can be computed", "", error.to_string(), false)
    }

    fn add(
        &mut self,
        place: &str,
        (what, paper, ours): (String, String, String),
        kind: Kind,
        holds: Option<bool>,
    ) -> &mut Claim {
        self.claims.push(Claim { place: place.to_owned(), what, paper, ours, note: String::new(), kind, holds });
        let last = self.claims.len() - 1;
        &mut self.claims[last]
    }
}

impl fmt::Display for Reproduction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.paper)?;
        let mut place = "";
        let width = self.claims.iter().map(|c| c.what.chars().count()).max().unwrap_or(0);
        for c in &self.claims {
            if c.place != place {
                place = &c.place;
                writeln!(f, "\n{place}")?;
                writeln!(f, "  {:<width$} {:>20} {:>24}  kind", "", "paper", "ours")?;
            }
            writeln!(f, "  {:<width$} {:>20} {:>24}  {}", c.what, c.paper, c.ours, c.mark())?;
            if !c.note.is_empty() {
                writeln!(f, "      {}", c.note)?;
            }
        }
        writeln!(f, "\n{}", self.tally())
    }
}
