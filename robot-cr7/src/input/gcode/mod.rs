//! G-code programs (RS-274/NGC), read line by line into moves and markers.
//!
//! [`GcodeProgram::read`] takes the dialect of LinuxCNC, as its G-code reference states it, and the NURBS block of Fanuc.
//!
//! | understood | codes |
//! |---|---|
//! | moves | G0, G1; G2, G3 with I J K or R, as helix, with P turns |
//! | splines | G5, G5.1, G5.2 with G5.3, G6.2 |
//! | planes, units, coordinates | G17 G18 G19, G20 G21, G90 G91, G90.1 G91.1 |
//! | feed | G93, G94, G95 with S |
//! | path control | G61, G61.1, G64 P Q |
//! | markers | M codes, S, T, G4 P, `(MSG, ...)` |
//! | without effect | G8, G40, G43 H0, G49, G80, G92.1, G92.2, G96, G97, G98, G99, the first of G54 to G59.3, `O1234` alone in a line |
//! | values | numbers, `[expressions]`, `#1`, `#<name>`, functions |
//! | ends | M2, M30, `%`, the end of the file |
//!
//! Every other code is refused with its line. In this dialect:
//!
//! * Blanks and case have no meaning outside of comments. A line that starts with `/` is skipped
//!   ([`GcodeOptions::block_delete`]). Comments stand in `( )` or behind `;`.
//! * The tool starts at [`GcodeOptions::start`]. A coordinate that a program does not give stays as it was there.
//! * The unit holds for the whole block of G20 or G21, F included. F keeps its speed when the unit changes, and is
//!   cleared when G93, G94 or G95 changes the feed mode.
//! * Until G61, G61.1 or G64 a move has no [`PathControl`] of its own.
//! * An assignment takes effect behind its block. A parameter without a value is refused; LinuxCNC reads 0.
//! * The ends of an arc may differ in their distance from the centre as LinuxCNC allows: by 0.005 mm (0.0005 in) or a
//!   thousandth of the radius, and never by more than 0.5 mm (0.05 in). The centre is then moved along the chord, until
//!   both ends lie on one circle; for an arc of more than 180 degrees by 0.05 mm (0.005 in) at most.
//! * Moves shorter than 1e-9 m that turn no rotary axis are left out, with a warning.
//! * Markers stand before the move of their block, except M0, M1, M2, M30 and M60, which stand behind it.
//!
//! # Why the grammar is our own
//!
//! The crate `gcode` 0.7 has neither expressions and parameters nor block delete, and parses a text that is in memory as a
//! whole. `async-gcode` 0.3 has expressions without ranks of operators and without named parameters, and needs an
//! asynchronous stream of bytes. This reader needs these, an error with line and column, and one line in memory at a time.

mod arc;
mod block;
mod codes;
mod expression;
pub(crate) mod fault;
mod interpreter;
mod joined;
mod modal;
mod motion;
mod nurbs;
mod program;
mod reader;
mod shape_words;
mod text;

pub use fault::GcodeFault;
pub use program::{GcodeMarker, GcodeMove, GcodeOptions, GcodeProgram, MarkerKind, MoveKind, MoveShape, PathControl};
