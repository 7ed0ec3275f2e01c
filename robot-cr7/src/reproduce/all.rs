//! All papers together.

use serde::Serialize;

use super::{Reproduction, huang_2025, liu_2023, liu_2024};
use crate::run::error::Cr7Error;

/// A paper: its short name, and what reproduces it.
pub type Paper = (&'static str, fn() -> Result<Reproduction, Cr7Error>);

/// The papers that are reproduced.
pub const PAPERS: &[Paper] = &[("pn", liu_2023), ("hs", || Ok(liu_2024().0)), ("qb", || Ok(huang_2025().0))];

/// What is claimed in all papers, beside ours.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Overview {
    /// One for each paper.
    pub papers: Vec<Reproduction>,
    /// Number of guarantees that were checked.
    pub guarantees: usize,
    /// Number of those that do not hold.
    pub broken: usize,
}

impl Overview {
    /// Reproduces every paper of [`PAPERS`].
    ///
    /// # Errors
    /// What a paper's function returns.
    pub fn new() -> Result<Self, Cr7Error> {
        let papers: Vec<Reproduction> = PAPERS.iter().map(|(_, run)| run()).collect::<Result<_, _>>()?;
        let guarantees = papers.iter().flat_map(|p| &p.claims).filter(|c| c.holds.is_some()).count();
        let broken = papers.iter().map(|p| p.broken().count()).sum();
        Ok(Self { papers, guarantees, broken })
    }

    /// One JSON object on one line.
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).unwrap_or_else(|e| serde_json::json!({ "error": e.to_string() }).to_string())
    }

    /// The numbers that the papers print, as tables in Markdown, and how many guarantees hold.
    pub fn to_markdown(&self) -> String {
        let mut text = String::new();
        for paper in &self.papers {
            text +=
                &format!("**{}**\n\n| where | what | paper | ours | guarantee |\n|---|---|---|---|---|\n", paper.paper);
            for c in paper.claims.iter().filter(|c| !c.paper.is_empty()) {
                let holds = match c.holds {
                    Some(true) => "holds",
                    Some(false) => "**BROKEN**",
                    None => "",
                };
                let place = c.place.split(':').next().unwrap_or_default();
                let cells = [place, &c.what, &c.paper, &c.ours, holds].map(|cell| cell.replace('|', "\\|"));
                text += &format!("| {} |\n", cells.join(" | "));
            }
            let guarantees = paper.claims.iter().filter(|c| c.holds.is_some()).count();
            let broken = paper.broken().count();
            text += &format!("\n{} of {guarantees} guarantees hold.\n\n", guarantees - broken);
        }
        text
    }
}
