//! The states of a run and their colours.

use plotters::prelude::RGBColor;

use super::canvas::{LIMIT, PALETTE};

/// Names of the states with their colours.
pub(super) const STATES: [(&str, RGBColor); 9] = [
    ("task path", PALETTE[0]),
    ("leaving", PALETTE[1]),
    ("joint move", PALETTE[2]),
    ("waiting", PALETTE[5]),
    ("returning", PALETTE[3]),
    ("holding", RGBColor(150, 150, 150)),
    ("stepping back", RGBColor(213, 94, 0)),
    ("stopping", LIMIT),
    ("done", PALETTE[4]),
];

/// The colour of a state.
pub(super) fn colour_of(state: &str) -> RGBColor {
    STATES.iter().find(|(name, _)| state.starts_with(name)).map_or(PALETTE[5], |s| s.1)
}
