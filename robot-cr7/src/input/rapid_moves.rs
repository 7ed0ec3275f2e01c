//! How the rapid moves of a program (G0) are made.

/// What a rapid move is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum RapidKind {
    /// A straight line of the tool: the tool is where the program says.
    #[default]
    Line,
    /// A motion of the joints to the end of the line: faster, and beside the line on the way.
    Joints,
}

/// How the rapid moves of a program (G0) are made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RapidMoves {
    /// Lines of the tool or motions of the joints.
    pub kind: RapidKind,
    /// Highest speed of rapid moves that are lines, in m/s; `None` for the feed of the job.
    pub speed: Option<f64>,
    /// Within this distance, in m, the tool passes the end of a rapid move of the joints without a stop, where another one follows.
    pub blend: f64,
}

impl Default for RapidMoves {
    fn default() -> Self {
        Self { kind: RapidKind::Line, speed: None, blend: 1e-3 }
    }
}
