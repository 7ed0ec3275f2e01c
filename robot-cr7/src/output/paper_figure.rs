//! What is drawn of a figure of a paper, as plain numbers in the units of the labels.

use super::schedule_figure::{JointFigure, SpeedFigure};

/// A figure of a paper, drawn anew.
#[derive(Debug, Clone, PartialEq)]
pub struct PaperFigure {
    /// Name of its file.
    pub file: String,
    /// Number and title, as "Figure 10a: the butterfly".
    pub title: String,
    /// Conditions and results in words, below the title.
    pub facts: String,
    /// What the paper shows, and what differs here.
    pub caption: String,
    /// The drawing.
    pub drawing: Drawing,
}

/// How a figure is drawn.
#[derive(Debug, Clone, PartialEq)]
pub enum Drawing {
    /// Panels below each other.
    Panels(Vec<PanelPlot>),
    /// Curves in a plane, both axes in one scale.
    Plane(PlanePlot),
    /// Speed under its limits.
    Speed(SpeedFigure),
    /// One quantity of every joint.
    Joints(JointFigure),
}

/// Lines over one axis.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PanelPlot {
    /// Quantity and unit of the horizontal axis.
    pub across: String,
    /// Quantity and unit of the vertical axis.
    pub label: String,
    /// The lines.
    pub lines: Vec<FigureLine>,
    /// Limits, drawn in red.
    pub limits: Vec<FigureLine>,
    /// Places on the horizontal axis with their names.
    pub marks: Vec<(f64, String)>,
}

/// A named line: place on the horizontal axis, and value.
#[derive(Debug, Clone, PartialEq)]
pub struct FigureLine {
    /// Name in the legend; empty for none.
    pub name: String,
    /// Points.
    pub points: Vec<(f64, f64)>,
}

impl FigureLine {
    /// A line.
    pub fn new(name: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Self { name: name.into(), points }
    }

    /// A level from one end to the other.
    pub fn level((from, to): (f64, f64), value: f64) -> Self {
        Self::new("", vec![(from, value), (to, value)])
    }
}

/// Curves and points in a plane.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlanePlot {
    /// Quantity and unit of the horizontal axis.
    pub across: String,
    /// Quantity and unit of the vertical axis.
    pub label: String,
    /// Curves with the index of their colour and their name in the legend; empty for none.
    pub curves: Vec<PlaneCurve>,
    /// Points with their names; a name may be empty.
    pub points: Vec<([f64; 2], String)>,
}

/// A curve in a plane.
#[derive(Debug, Clone, PartialEq)]
pub struct PlaneCurve {
    /// Name in the legend; empty for none.
    pub name: String,
    /// Index of the colour.
    pub colour: usize,
    /// Whether the line is thin.
    pub thin: bool,
    /// Its points.
    pub points: Vec<[f64; 2]>,
}
