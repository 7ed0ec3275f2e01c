//! What can be wrong with a word or a block of a program, with the rule and the remedy.

use arcfeed_geometry::GeometryError;
use thiserror::Error;

/// What is wrong at a place of a G-code program: the rule and the remedy.
///
/// [`InputError::Gcode`](crate::InputError::Gcode) adds file, line, column and word. Lengths are in metres.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum GcodeFault {
    /// The line is longer than any line of a program.
    #[error("the line has more than {limit} bytes; break it")]
    LineLength {
        /// Most bytes of a line.
        limit: usize,
    },
    /// The text breaks the grammar.
    #[error("{rule}; {remedy}")]
    Syntax {
        /// The rule.
        rule: &'static str,
        /// The remedy.
        remedy: &'static str,
    },
    /// A value is outside its range.
    #[error("the value is {value}, but {rule}; {remedy}")]
    Value {
        /// The value found, in the unit of the program.
        value: f64,
        /// The rule it breaks.
        rule: &'static str,
        /// The remedy.
        remedy: &'static str,
    },
    /// A word that the block needs is missing.
    #[error("{needs}; {remedy}")]
    Missing {
        /// What is needed.
        needs: &'static str,
        /// The remedy.
        remedy: &'static str,
    },
    /// A letter stands twice in a block.
    #[error("the letter stands in column {first} already; keep one of the two")]
    Repeated {
        /// Column of the first word, from 1.
        first: usize,
    },
    /// Two codes of one modal group stand in a block.
    #[error("the block holds {other} already, which sets {group} too; put the two on two lines")]
    ModalGroup {
        /// The other code.
        other: String,
        /// What both set.
        group: &'static str,
    },
    /// No code of the block uses the word.
    #[error("no code of the block uses this word; remove it or add its code")]
    Unused,
    /// Two codes of the block could use the word.
    #[error("{first} and {second} of the block could both use this word; put them on two lines")]
    Shared {
        /// The first code.
        first: String,
        /// The second code.
        second: String,
    },
    /// The code is none that is known.
    #[error("the code is not known; remove it or replace it by a known code")]
    UnknownCode,
    /// The code is known and would change the motion in a way that is not computed.
    #[error("{what} is not supported; {remedy}")]
    Unsupported {
        /// What the code does.
        what: &'static str,
        /// The remedy.
        remedy: &'static str,
    },
    /// The ends of an arc have different distances from its centre.
    #[error(
        "the arc starts {start_radius} m from its centre and ends {end_radius} m from it; the two may differ by {limit} m at most: give more digits, or R"
    )]
    ArcRadii {
        /// Distance of the start from the centre, in metres.
        start_radius: f64,
        /// Distance of the end from the centre, in metres.
        end_radius: f64,
        /// Largest difference for this radius, in metres.
        limit: f64,
    },
    /// The ends of an arc of more than 180 degrees lie too close together to fit its centre.
    #[error(
        "the centre of the circle through both ends of the arc lies {shift} m from the one given; at most {limit} m is allowed: give more digits, or end where the arc starts"
    )]
    ArcCentre {
        /// Distance of the two centres, in metres.
        shift: f64,
        /// Largest distance, in metres.
        limit: f64,
    },
    /// The radius of an arc is too small to reach its end.
    #[error(
        "the radius is {radius} m, but the ends of the arc lie {chord} m apart; give a radius of half of that or more"
    )]
    ArcReach {
        /// The radius given, in metres.
        radius: f64,
        /// Distance of start and end in the plane, in metres.
        chord: f64,
    },
    /// The words of a spline do not make a curve.
    #[error("{0}")]
    Curve(GeometryError),
    /// The program has too many moves and markers.
    #[error("the program has more than {limit} moves and markers; divide it")]
    TooMany {
        /// Most moves and markers.
        limit: usize,
    },
}

/// A fault with its place in the line.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Located {
    /// Column, from 1.
    pub(crate) column: usize,
    /// The word or text found there.
    pub(crate) word: String,
    /// What is wrong.
    pub(crate) fault: GcodeFault,
}

impl Located {
    pub(crate) fn new(column: usize, word: impl Into<String>, fault: GcodeFault) -> Self {
        Self { column, word: word.into(), fault }
    }
}
