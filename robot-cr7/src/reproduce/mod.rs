//! The papers' numbers beside what this library measures.
//!
//! Each part of a paper is a run with public fields: `measure` computes it, `judge` adds its rows
//! to a [`Reproduction`], and `figures` gives its figures. A row is an independent check, agrees
//! with a printed number, is fitted, or is for information ([`Kind`]); only the first two count.

mod all;
pub mod checker;
mod claim;
pub mod cr7_dh;
pub mod hs;
#[cfg(feature = "plot")]
mod index;
pub mod pn;
mod printed;
pub mod qb;
mod random;
pub mod spline;

use std::fmt;

pub use all::{Overview, PAPERS, Paper};
pub use claim::{Claim, Kind, Reproduction, Tally};
pub use hs::liu_2024;
#[cfg(feature = "plot")]
pub use index::write_figures;
pub use pn::liu_2023;
pub use printed::Printed;
pub use qb::huang_2025;
pub use random::Random;

pub use crate::output::paper_figure::{Drawing, FigureLine, PanelPlot, PaperFigure, PlaneCurve, PlanePlot};

/// The rows and the figures of one paper.
#[derive(Debug, Clone, PartialEq)]
pub struct Reproduced {
    /// Rows.
    pub reproduction: Reproduction,
    /// Figures, in the order of the paper.
    pub figures: Vec<PaperFigure>,
}

impl Reproduced {
    fn new(paper: &str) -> Self {
        Self { reproduction: Reproduction::new(paper), figures: Vec::new() }
    }

    /// Adds rows and figures of a run; a run that cannot be made is a broken row.
    fn take<T, E: fmt::Display>(
        &mut self,
        place: &str,
        run: Result<T, E>,
        judge: impl FnOnce(&T, &mut Reproduction),
        figures: impl FnOnce(&T) -> Vec<PaperFigure>,
    ) {
        match run {
            Ok(run) => {
                judge(&run, &mut self.reproduction);
                self.figures.extend(figures(&run));
            }
            Err(error) => _ = self.reproduction.failed(place, &error),
        }
    }
}
