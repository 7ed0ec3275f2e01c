//! A printed table of Bezier control points, beside the library's decomposition and the polar form.

use arcfeed_geometry::NurbsCurve;

use crate::output::paper_figure::{PlaneCurve, PlanePlot};
use crate::reproduce::Reproduction;
use crate::reproduce::spline::Spline;

/// Four control points as printed, x and y.
pub type PrintedBezier = [(&'static str, &'static str); 4];

/// Misprints of the two tables, as the first and second point of a piece are printed with their
/// place.
const MISPRINTS: [(&str, &str); 2] = [("8.5", "12"), ("5.3333", "6.3333")];

/// The Bezier pieces of a curve.
#[derive(Debug, Clone, PartialEq)]
pub struct BezierTable {
    /// Control points by the library's decomposition, mm.
    pub points: Vec<Vec<[f64; 2]>>,
    /// The same by the polar form, mm.
    pub polar: Vec<Vec<[f64; 2]>>,
    /// Control points of the curve itself, mm.
    pub control: Vec<[f64; 2]>,
    /// The curve.
    pub curve: Spline,
}

/// A point of a cubic by de Casteljau's scheme.
fn casteljau(points: &[[f64; 2]], t: f64) -> [f64; 2] {
    let mut d = points.to_vec();
    while d.len() > 1 {
        d = d.windows(2).map(|w| [0, 1].map(|k| w[0][k] * (1.0 - t) + w[1][k] * t)).collect();
    }
    d[0]
}

impl BezierTable {
    /// Decomposes `curve`.
    pub fn measure(curve: &NurbsCurve<3>) -> Self {
        let spline = Spline::new(curve);
        let spans = spline.breaks();
        let mm = |x: f64, y: f64| [x * 1e3, y * 1e3];
        let points: Vec<Vec<[f64; 2]>> =
            curve.decompose().iter().map(|b| b.control_points().map(|p| mm(p.x, p.y)).collect()).collect();
        let polar: Vec<Vec<[f64; 2]>> = spans
            .windows(2)
            .map(|w| spline.bezier(w[0], w[1]).iter().map(|p| mm(p.x / p.w, p.y / p.w)).collect())
            .collect();
        let control = curve.control_points().iter().map(|p| mm(p.x, p.y)).collect();
        Self { points, polar, control, curve: spline }
    }

    /// Largest distance of the pieces from the curve, by de Casteljau and de Boor, m.
    fn off(&self) -> f64 {
        let spans = self.curve.breaks();
        let mut off = 0.0f64;
        for (piece, w) in self.points.iter().zip(spans.windows(2)) {
            for i in 0..1000 {
                let t = f64::from(i) / 1000.0;
                let (got, asked) = (casteljau(piece, t), self.curve.point(w[0] + (w[1] - w[0]) * t));
                off = off.max((got[0] * 1e-3 - asked.x).hypot(got[1] * 1e-3 - asked.y));
            }
        }
        off
    }

    /// Adds the rows.
    pub fn judge(&self, r: &mut Reproduction, place: &str, printed: &[PrintedBezier]) {
        for (b, (piece, print)) in self.points.iter().zip(printed).enumerate() {
            for (i, (p, paper)) in piece.iter().zip(print).enumerate() {
                let what = format!("Bezier {}, point {}", b + 1, i + 1);
                // The second piece of HS prints the same pair rightly, as its own second point.
                let misprint = MISPRINTS.contains(paper) && (b, i) != (1, 1);
                if misprint {
                    let ours = format!("({:.4}, {:.4})", p[0], p[1]);
                    r.information(place, what, format!("({}, {})", paper.0, paper.1), ours)
                        .note("the print is wrong: knot insertion on the printed NURBS points gives ours");
                } else {
                    r.print_all(place, what, &[(paper.0, p[0]), (paper.1, p[1])]);
                }
            }
        }
        let pairs = self.points.iter().flatten().zip(self.polar.iter().flatten());
        let worst = pairs.fold(0.0f64, |w, (a, b)| w.max((a[0] - b[0]).hypot(a[1] - b[1])));
        let off = self.off();
        let complete = self.points.len() == self.polar.len() && self.points.len() == printed.len();
        r.independent(
            place,
            "control points beside the polar form, mm",
            "0",
            format!("{worst:.1e}"),
            complete && worst < 1e-12,
        );
        r.independent(
            place,
            "pieces by de Casteljau off the curve by de Boor, mm",
            "0",
            format!("{:.1e}", off * 1e3),
            off < 1e-16,
        );
    }

    /// Control points of the curve with their numbers.
    pub fn polygon(&self) -> Vec<([f64; 2], String)> {
        self.control.iter().enumerate().map(|(i, p)| (*p, format!("P{}", i + 1))).collect()
    }

    /// Where pieces join.
    pub fn ends(&self) -> Vec<([f64; 2], String)> {
        self.points.iter().enumerate().map(|(i, p)| (p[0], format!("Bezier {}", i + 1))).collect()
    }

    /// Piece `index` in the frame whose x axis is its chord.
    pub fn local_frame(&self, index: usize) -> PlanePlot {
        let piece = &self.points[index];
        let (a, b) = (piece[0], piece[3]);
        let length = (b[0] - a[0]).hypot(b[1] - a[1]);
        let (c, s) = ((b[0] - a[0]) / length, (b[1] - a[1]) / length);
        let turned = |p: [f64; 2]| {
            let (x, y) = (p[0] - a[0], p[1] - a[1]);
            [c * x + s * y, c * y - s * x]
        };
        let curve = (0..=200).map(|i| turned(casteljau(piece, f64::from(i) / 200.0))).collect();
        let chord = vec![turned(a), turned(b)];
        let line = |name: &str, colour, points| PlaneCurve { name: name.to_owned(), colour, thin: false, points };
        PlanePlot {
            across: "along the chord [mm]".to_owned(),
            label: "off the chord [mm]".to_owned(),
            curves: vec![line("the curve", 0, curve), line("its chord", 5, chord)],
            points: piece.iter().enumerate().map(|(i, p)| (turned(*p), format!("C.P. {}", i + 1))).collect(),
        }
    }
}
