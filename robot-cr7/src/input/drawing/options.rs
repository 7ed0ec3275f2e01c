//! How a drawing is read.

use std::path::Path;

use crate::input::error::InputError;
use crate::input::unit::LengthUnit;

/// The longest lift, m.
const HIGHEST: f64 = 100.0;

/// How a drawing is read.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawingOptions {
    /// Unit of length of a drawing that names none. Default: millimetre for DXF, pixels of 1/96 in for SVG, with a warning.
    pub unit: Option<LengthUnit>,
    /// The layers to read, by name; empty for all of them. Default: empty.
    pub layers: Vec<String>,
    /// How far above the highest point of the drawing the tool goes between two contours, in m, above 0. Default: 5 mm.
    pub lift: f64,
    /// Feed along the contours, in m/s, above 0. Default: 0.1 m/s.
    pub feed: f64,
    /// Most lines, arcs and curves. Default: 1 000 000, which take about 300 MB of memory.
    pub most_pieces: usize,
}

impl Default for DrawingOptions {
    fn default() -> Self {
        Self { unit: None, layers: Vec::new(), lift: 5e-3, feed: 0.1, most_pieces: 1_000_000 }
    }
}

impl DrawingOptions {
    /// Refuses lengths and speeds that no motion can have.
    pub(super) fn check(&self, file: &Path) -> Result<(), InputError> {
        let wrong = |key: &str, value: f64, rule| {
            let (key, value, remedy) = (key.to_owned(), value.to_string(), "correct it, or use the default");
            Err(InputError::Value { file: file.to_owned(), line: None, key, value, rule, remedy })
        };
        if !(self.lift > 0.0 && self.lift <= HIGHEST) {
            return wrong("the lift in m", self.lift, "it has to be above 0, and at most 100 m");
        }
        if !(self.feed > 0.0 && self.feed.is_finite()) {
            return wrong("the feed in m/s", self.feed, "it has to be a finite number above 0");
        }
        Ok(())
    }
}
