//! What a program says, as plain data in SI units.

use std::path::PathBuf;

use arcfeed_geometry::{Curve, NurbsCurve};
use nalgebra::{Unit, Vector3};

use crate::input::unit::LengthUnit;

/// A G-code program as data: moves and markers in their order, in metres, seconds and radians, in the workpiece frame.
///
/// ```
/// use std::path::Path;
///
/// use robot_cr7::{GcodeOptions, GcodeProgram, MoveShape};
///
/// let text = b"G21 G90\nG0 X10 Y0 Z0\nG3 X-10 I-10 F600 (half a circle)\nM2\n";
/// let program = GcodeProgram::from_bytes(text, Path::new("half.ngc"), &GcodeOptions::default())?;
/// assert_eq!(program.moves.len(), 2);
/// let MoveShape::Arc { centre, sweep, .. } = &program.moves[1].shape else { panic!("not an arc") };
/// assert!(centre.norm() < 1e-15);
/// assert!((sweep - std::f64::consts::PI).abs() < 1e-15);
/// # Ok::<(), robot_cr7::InputError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct GcodeProgram {
    /// The file it was read from (for messages).
    pub file: PathBuf,
    /// Where the first move starts, in metres ([`GcodeOptions::start`]).
    pub start: Vector3<f64>,
    /// The moves. Each starts where the one before it ends.
    pub moves: Vec<GcodeMove>,
    /// Codes that switch, wait or inform, in the order of the program.
    pub markers: Vec<GcodeMarker>,
    /// Assumptions that the reader made, each with its line.
    pub warnings: Vec<String>,
    /// Number of lines read, up to the end of the program.
    pub lines: u64,
}

impl GcodeProgram {
    /// The moves, each with the point where it starts, in metres.
    pub fn moves_with_starts(&self) -> impl Iterator<Item = (Vector3<f64>, &GcodeMove)> {
        let ends = self.moves.iter().map(GcodeMove::end);
        std::iter::once(self.start).chain(ends).zip(&self.moves)
    }
}

/// How a program is read.
#[derive(Debug, Clone, PartialEq)]
pub struct GcodeOptions {
    /// Unit of length before the first G20 or G21. Default: millimetre, with a warning.
    pub unit: LengthUnit,
    /// Position of the tool before the first move, in metres. Default: the origin.
    pub start: Vector3<f64>,
    /// Skips lines that start with `/`. Default: true.
    pub block_delete: bool,
    /// Most moves and markers together. Default: 5 000 000, which take about 1 GB of memory.
    pub most_moves: usize,
}

impl Default for GcodeOptions {
    fn default() -> Self {
        Self { unit: LengthUnit::Millimetre, start: Vector3::zeros(), block_delete: true, most_moves: 5_000_000 }
    }
}

/// One move of the tool.
#[derive(Debug, Clone, PartialEq)]
pub struct GcodeMove {
    /// Line of the file, from 1. For a NURBS block: its first line.
    pub line: u64,
    /// Number of the N word of that line.
    pub number: Option<u32>,
    /// Rapid or feed.
    pub kind: MoveKind,
    /// The path of the tool.
    pub shape: MoveShape,
    /// How exactly the end of the move is passed; `None` where the program has not said so.
    pub control: Option<PathControl>,
    /// Positions of the rotary axes A, B and C at the end of the move, in rad. `None` before the first A, B or C word.
    ///
    /// They change in proportion to the travel along the move.
    pub rotary: Option<Vector3<f64>>,
}

impl GcodeMove {
    /// Where the move ends, in metres.
    pub fn end(&self) -> Vector3<f64> {
        match &self.shape {
            MoveShape::Line { to } | MoveShape::Arc { to, .. } => *to,
            MoveShape::Curve(curve) => curve.point(curve.domain().1),
        }
    }
}

/// How fast a move is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MoveKind {
    /// As fast as the machine allows (G0).
    Rapid,
    /// At a speed of the tool point, in m/s (G94, or G95 with the speed of the spindle).
    Feed {
        /// Speed along the path in m/s, above 0.
        speed: f64,
    },
    /// The tool point rests and rotary axes turn at this speed, in rad/s.
    RotaryFeed {
        /// Norm of the rates of A, B and C in rad/s, above 0.
        speed: f64,
    },
    /// In a given time, in seconds (G93).
    InverseTime {
        /// Duration of the move in seconds, above 0.
        seconds: f64,
    },
}

/// The path of the tool in a move.
#[derive(Debug, Clone, PartialEq)]
pub enum MoveShape {
    /// A straight line.
    Line {
        /// End, in metres. It equals the start where only rotary axes move.
        to: Vector3<f64>,
    },
    /// An arc of a circle or a helix.
    Arc {
        /// Centre, in the plane of the start, in metres.
        centre: Vector3<f64>,
        /// Axis: +Z (G17), +Y (G18) or +X (G19).
        normal: Unit<Vector3<f64>>,
        /// Angle in rad, counter-clockwise about `normal` above 0 (G3), below 0 clockwise (G2). With turns it exceeds
        /// 2 pi.
        sweep: f64,
        /// Travel along `normal` in metres, in proportion to the angle.
        rise: f64,
        /// End, in metres.
        to: Vector3<f64>,
    },
    /// A spline (G5, G5.1, G5.2, G6.2), in metres.
    Curve(Box<NurbsCurve<3>>),
}

/// How exactly the end of a move is passed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PathControl {
    /// Through the programmed point, slower or at rest where the path has a corner (G61).
    ExactPath,
    /// At rest at the programmed point (G61.1).
    ExactStop,
    /// Past the programmed point (G64).
    Blend {
        /// Largest distance from the programmed path in metres (P); `None` where the program gives none.
        tolerance: Option<f64>,
        /// Lines that are collinear within this distance in metres may be merged (Q); 0 for no merging.
        naive: f64,
    },
}

/// A code without motion, at its place among the moves.
#[derive(Debug, Clone, PartialEq)]
pub struct GcodeMarker {
    /// Line of the file, from 1.
    pub line: u64,
    /// Number of moves before it.
    pub after: usize,
    /// What it says.
    pub kind: MarkerKind,
}

/// What a marker says.
#[derive(Debug, Clone, PartialEq)]
pub enum MarkerKind {
    /// An M code with its words, such as `M3` or `M62 P1`.
    Code(String),
    /// Spindle speed (S), in rev/min, or as a surface speed under G96.
    SpindleSpeed(f64),
    /// Number of the selected tool (T).
    Tool(u32),
    /// Text of a comment `(MSG, ...)`.
    Message(String),
    /// Rest (G4).
    Dwell {
        /// Its duration in seconds.
        seconds: f64,
    },
}
