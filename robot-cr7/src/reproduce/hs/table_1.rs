//! Liu et al. 2024, section 2: Table 1, Table 2, Figures 1 and 2.

use arcfeed_geometry::SegmentationMethod;

use crate::input::sample_paths::SamplePath;
use crate::output::paper_figure::{Drawing, PaperFigure};
use crate::reproduce::Reproduction;
use crate::reproduce::pn::bezier_table::{BezierTable, PrintedBezier};
use crate::reproduce::pn::counts::CountRun;
use crate::reproduce::pn::curves::{chords, curve_of, pieces, plane};
use crate::reproduce::pn::open_loop::{curvature_maxima, radius_extremes, simpson_intervals};
use crate::reproduce::spline::Spline;
use crate::run::error::Cr7Error;

const PLACE: &str = "Table 1: Bezier control points of the seven-point curve, mm";
const PLACE_2: &str = "Table 2, figure 2: seven points at 0.1 mm";
const TOLERANCE: f64 = 1e-4;
/// The truncation error that the paper prints for W.L., m.
const LENGTH: f64 = 1e-6;
/// Name, chord error as printed (mm), and where the method cuts.
const OTHERS: [(&str, &str, &str); 3] = [
    ("M.L.", "1.5", "at maxima of curvature"),
    ("X.D.", "1.5", "at extremes of the radius of curvature"),
    ("W.L.", "1.2", "where Simpson's rule needs it for a length within 0.001 mm"),
];

/// Table 1 as printed, x and y.
const PRINTED: [PrintedBezier; 4] = [
    [("1", "6"), ("2", "3"), ("3.5", "5.5"), ("4.4167", "5.9167")],
    [("4.4167", "5.9167"), ("5.3333", "6.3333"), ("5.6667", "4.6667"), ("6", "5")],
    [("6", "5"), ("5.3333", "6.3333"), ("6.6667", "7.6667"), ("7.3333", "7.3333")],
    [("7.3333", "7.3333"), ("8", "7"), ("9", "4"), ("12", "3")],
];

/// Section 2 on the seven-point curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Section2Run {
    /// Table 1.
    pub table: BezierTable,
    /// The curve.
    pub curve: Spline,
    /// Breaks by the convex hull and halving, the method of the paper.
    pub hull: CountRun,
    /// Breaks of M.L., X.D. and W.L., which know no chord tolerance.
    pub others: [Vec<f64>; 3],
}

impl Section2Run {
    /// Cuts the seven-point curve.
    ///
    /// # Errors
    /// [`Cr7Error`] when the embedded path cannot be cut.
    pub fn measure() -> Result<Self, Cr7Error> {
        let nurbs = curve_of(SamplePath::SevenPoint)?;
        let curve = Spline::new(&nurbs);
        Ok(Self {
            table: BezierTable::measure(&nurbs),
            hull: CountRun::measure(
                "seven points, 0.1 mm",
                SamplePath::SevenPoint,
                SegmentationMethod::Hull,
                TOLERANCE,
            )?,
            others: [curvature_maxima(&curve), radius_extremes(&curve), simpson_intervals(&curve, LENGTH)],
            curve,
        })
    }

    /// Adds the rows.
    pub fn judge(&self, r: &mut Reproduction) {
        self.table.judge(r, PLACE, &PRINTED);
        self.hull.judge(r, PLACE_2, "47");
        let closed = self.curve.largest_deviation(&self.hull.breaks, 400);
        for ((name, printed, cut), breaks) in OTHERS.into_iter().zip(&self.others) {
            let open = self.curve.largest_deviation(breaks, 400);
            let shown = format!("{:.3}", open * 1e3);
            r.information(PLACE_2, format!("{name}: largest chord error, mm"), printed, shown)
                .note(format!("{} segments, cut {cut}; the paper does not print the method", breaks.len() - 1));
            r.independent(
                PLACE_2,
                format!("ours is below {name} in chord error, mm"),
                "yes",
                format!("{:.4} of {:.4}", closed * 1e3, open * 1e3),
                closed < open && closed <= TOLERANCE,
            );
        }
    }

    /// Figures 1 and 2.
    pub fn figures(&self) -> Vec<PaperFigure> {
        let spans = self.curve.breaks();
        let figure = |file: &str, title: &str, facts: String, caption: &str, drawing: Drawing| PaperFigure {
            file: format!("hs_figure_{file}.svg"),
            title: title.to_owned(),
            facts,
            caption: caption.to_owned(),
            drawing,
        };
        let first: Vec<f64> = self.hull.breaks.iter().copied().filter(|u| *u <= spans[1] + 1e-12).collect();
        let count = self.hull.breaks.len() - 1;
        vec![
            figure(
                "01a",
                "Figure 1a: a NURBS curve",
                "seven control points".to_owned(),
                "The paper shows the curve and its control polygon. No difference.",
                Drawing::Plane(plane(pieces(&self.curve, &[spans[0], spans[spans.len() - 1]]), self.table.polygon())),
            ),
            figure(
                "01b",
                "Figure 1b: four Bezier curves",
                "by knot insertion".to_owned(),
                "The paper shows four Bezier curves in four colours. No difference.",
                Drawing::Plane(plane(pieces(&self.curve, &spans), self.table.ends())),
            ),
            figure(
                "01c",
                "Figure 1c: control points in the local frame of Bezier 1",
                "distance from the chord".to_owned(),
                "The paper shows the distances of the control points from the chord, which is its x axis.",
                Drawing::Plane(self.table.local_frame(0)),
            ),
            figure(
                "01d",
                "Figure 1d: Bezier 1 at 0.1 mm",
                format!("{} pieces; the paper has 15", first.len() - 1),
                "The paper has 15 pieces. Halving by control points needs fewer at this tolerance.",
                Drawing::Plane(plane(pieces(&self.curve, &first), Vec::new())),
            ),
            figure(
                "02a",
                "Figure 2a: the curve at 0.1 mm",
                format!("{count} pieces; the paper has 47"),
                "The paper has 47 pieces. No reading of its method gives this count.",
                Drawing::Plane(plane(pieces(&self.curve, &self.hull.breaks), Vec::new())),
            ),
            figure(
                "02b",
                "Figure 2b: methods compared",
                "chords of the other methods, and ours".to_owned(),
                "The paper compares with three methods that do not look at the chord error, and does not print \
                 them. Each is read as its row says.",
                Drawing::Plane(chords(
                    &self.curve,
                    &[
                        ("M.L.", &self.others[0]),
                        ("X.D.", &self.others[1]),
                        ("W.L.", &self.others[2]),
                        ("ours", &self.hull.breaks),
                    ],
                )),
            ),
        ]
    }
}
