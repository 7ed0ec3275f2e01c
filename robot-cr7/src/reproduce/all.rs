//! All papers together.

use serde::Serialize;

use super::{Claim, Kind, Reproduced, Reproduction, Tally, huang_2025, liu_2023, liu_2024};
use crate::run::error::Cr7Error;
use crate::text::json;

/// A paper: its short name, and what reproduces it.
pub type Paper = (&'static str, fn() -> Result<Reproduced, Cr7Error>);

/// The papers that are reproduced.
pub const PAPERS: &[Paper] = &[("pn", liu_2023), ("hs", || Ok(liu_2024())), ("qb", || Ok(huang_2025()))];

/// What stands before the tables in Markdown.
const INTRODUCTION: &str = "# The numbers of the papers beside ours

`cr7 reproduce all --markdown` wrote this page. Each row has a kind:

* **independent**: recomputed from samples, by finite differences, or by another method than the one that is judged.
* **print**: equal to a printed number within the rounding of the print.
* **fitted**: the printed number was used to make a stand-in, so agreement shows nothing.
* **information**: shown, and not judged.

Only the first two count. `robot-cr7/tests/it/sabotage.rs` spoils the results on purpose and names the row that each
mutation breaks. [papers.md](papers.md) lists every part of the papers.

";

/// The rows of several papers.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Overview {
    /// One for each paper.
    pub papers: Vec<Reproduction>,
    /// How many rows there are of each kind.
    pub tally: Tally,
    /// Number of rows that count and do not hold.
    pub broken: usize,
}

impl Overview {
    /// Of papers that were reproduced.
    pub fn of(papers: Vec<Reproduction>) -> Self {
        let tally = Tally::of(papers.iter().flat_map(|p| &p.claims));
        Self { papers, broken: tally.broken, tally }
    }

    /// Reproduces every paper of [`PAPERS`].
    ///
    /// # Errors
    /// What a paper's function returns.
    pub fn new() -> Result<Self, Cr7Error> {
        let papers = PAPERS.iter().map(|(_, run)| Ok(run()?.reproduction)).collect::<Result<_, Cr7Error>>()?;
        Ok(Self::of(papers))
    }

    /// Exit code of a command that shows these rows: 1 where a row that counts does not hold, else
    /// 0.
    pub fn exit_code(&self) -> u8 {
        u8::from(self.broken > 0)
    }

    /// One JSON object on one line.
    pub fn to_json(&self) -> String {
        json(self)
    }

    /// Every row, as tables in Markdown, paper by paper.
    pub fn to_markdown(&self) -> String {
        let mut text = INTRODUCTION.to_owned();
        for paper in &self.papers {
            text += &format!("## {}\n\n{}.\n", paper.paper, paper.tally());
            let mut place = "";
            for c in &paper.claims {
                if c.place != place {
                    place = &c.place;
                    text += &format!(
                        "\n### {place}\n\n| what | paper | ours | kind | note \
                     |\n|---|---|---|---|---|\n"
                    );
                }
                let cells = [&c.what, &c.paper, &c.ours, kind(c), &c.note].map(|cell| cell.replace('|', "\\|"));
                text += &format!("| {} |\n", cells.join(" | "));
            }
            text.push('\n');
        }
        text += &format!("All papers: {}.\n", self.tally);
        text
    }
}

/// The kind of a row in a table; a broken row stands out.
fn kind(claim: &Claim) -> &'static str {
    match (claim.holds, claim.kind) {
        (Some(false), _) => "**BROKEN**",
        (_, Kind::Independent) => "independent",
        (_, Kind::Print) => "print",
        (_, Kind::Fitted) => "fitted",
        (_, Kind::Information) => "information",
    }
}
