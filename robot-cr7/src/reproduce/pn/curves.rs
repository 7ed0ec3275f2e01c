//! Curves of the papers, and how they are drawn.

use arcfeed_geometry::{GeometryError, NurbsCurve};

use crate::input::sample_paths::SamplePath;
use crate::output::paper_figure::{PlaneCurve, PlanePlot};
use crate::reproduce::spline::Spline;
use crate::run::error::Cr7Error;

/// An embedded curve, m.
///
/// # Errors
/// None with the files the program was built with.
pub fn curve_of(path: SamplePath) -> Result<NurbsCurve<3>, Cr7Error> {
    // The embedded paths are curves, never points.
    Ok(path.load()?.curve_with(|_| Err(GeometryError::DegreeZero))?)
}

pub(crate) fn failed(source: GeometryError) -> Cr7Error {
    Cr7Error::Curve { file: "an embedded curve".to_owned(), source }
}

/// The pieces between `breaks` in alternating colours.
pub fn pieces(curve: &Spline, breaks: &[f64]) -> Vec<PlaneCurve> {
    let n = (6000 / breaks.len().max(1)).clamp(6, 400) as u32;
    let piece = |(i, w): (usize, &[f64])| PlaneCurve {
        name: String::new(),
        colour: i % 4,
        thin: false,
        points: curve.drawn(w[0], w[1], n),
    };
    breaks.windows(2).enumerate().map(piece).collect()
}

/// A picture of pieces and points.
pub fn plane(curves: Vec<PlaneCurve>, points: Vec<([f64; 2], String)>) -> PlanePlot {
    PlanePlot { across: "x [mm]".to_owned(), label: "y [mm]".to_owned(), curves, points }
}

/// The curve, and the chords between the breaks of each method.
pub fn chords(curve: &Spline, methods: &[(&str, &[f64])]) -> PlanePlot {
    let (a, b) = curve.domain();
    let mut curves =
        vec![PlaneCurve { name: "the curve".to_owned(), colour: 5, thin: true, points: curve.drawn(a, b, 6000) }];
    for (i, (name, breaks)) in methods.iter().enumerate() {
        let at = |u: f64| {
            let p = curve.point(u);
            [p.x * 1e3, p.y * 1e3]
        };
        // Points along each chord, so that a cut-out still shows it.
        let along = |w: &[f64]| {
            let (a, b) = (at(w[0]), at(w[1]));
            let between = move |i: i32| [0, 1].map(|k| a[k] + (b[k] - a[k]) * f64::from(i) / 100.0);
            (0..=100).map(between).collect::<Vec<_>>()
        };
        let points = breaks.windows(2).flat_map(along).collect();
        curves.push(PlaneCurve { name: (*name).to_owned(), colour: i, thin: true, points });
    }
    plane(curves, Vec::new())
}
