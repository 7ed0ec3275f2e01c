//! Building a path piece by piece.

use nalgebra::Vector3;

use super::arcs::{ArcTo, Turning, rounding};
use super::cusps::cusps;
use super::path::{JoinedPath, PathPiece, PieceKind, SAME_DIRECTION, angle_between};
use super::spans::{Spans, homogeneous, jet, length, standardise};
use super::standing::{RegularSpan, coincide, extent, part, regular_spans};
use crate::bezier::{Homogeneous, project, restrict};
use crate::chord::check_positive;
use crate::error::GeometryError;
use crate::nurbs::{NurbsCurve, check_points};

/// No piece is shorter, in the unit of the path: squares of lengths stay inside the range of f64.
const SHORTEST: f64 = 1e-100;
/// A span of a curve is halved until one quadrature rule agrees with itself on both halves to this part of the
/// length.
const TAME: f64 = 1e-10;
/// A span of a curve is halved at most this often.
const MOST_HALVINGS: u32 = 10;
/// A curve stands still where its speed is below this part of the mean over its span.
const STANDING: f64 = 1e-9;
/// A part of a span between cusps whose control points are within this part of the tolerance is left out.
const SPECK: f64 = 1e-3;
/// Curvatures on both sides of a knot of a curve that differ by this part are a jump.
const SAME_CURVATURE: f64 = 1e-6;

/// Builds a [`JoinedPath`] from its start, piece by piece. A piece that is refused leaves the builder as it was.
///
/// ```
/// use arcfeed_geometry::nalgebra::{Vector3, vector};
/// use arcfeed_geometry::{ArcTo, JoinedPathBuilder};
///
/// let mut builder = JoinedPathBuilder::new(vector![0.0, 0.0, 0.0], 1e-6)?;
/// builder.line_to(vector![1.0, 0.0, 0.0], 1)?;
/// let centre = vector![1.0, 1.0, 0.0];
/// builder.arc(&ArcTo { centre, normal: Vector3::z_axis(), end: vector![1.0, 2.0, 0.0], turns: 0 }, 2)?;
/// let path = builder.build()?;
/// assert!((path.length() - 1.0 - std::f64::consts::PI).abs() < 1e-14);
/// # Ok::<(), arcfeed_geometry::GeometryError>(())
/// ```
#[derive(Debug, Clone)]
pub struct JoinedPathBuilder {
    position: Vector3<f64>,
    tolerance: f64,
    spans: Spans,
    pieces: Vec<PathPiece>,
    calls: Vec<f64>,
}

impl JoinedPathBuilder {
    /// A path that starts at `start`. `tolerance` is how far the end of an arc may be off its circle, and the start
    /// of a curve off the present end of the path, in the unit of the path. It is the tolerance of
    /// [`JoinedPathBuilder::curve`], too.
    ///
    /// # Errors
    /// Fails when a coordinate is not finite or the tolerance is not above 0.
    pub fn new(start: Vector3<f64>, tolerance: f64) -> Result<Self, GeometryError> {
        check_points("start", &[start])?;
        check_positive("tolerance", tolerance)?;
        Ok(Self { position: start, tolerance, spans: Spans::default(), pieces: Vec::new(), calls: vec![0.0] })
    }

    /// The present end of the path.
    pub fn position(&self) -> Vector3<f64> {
        self.position
    }

    /// Appends a straight line to `end`. `source` is the line of the input it comes from.
    ///
    /// # Errors
    /// Fails when a coordinate is not finite or the line has no length: its ends differ by rounding at most.
    pub fn line_to(&mut self, end: Vector3<f64>, source: usize) -> Result<&mut Self, GeometryError> {
        check_source("end of the line from input line", source, &end)?;
        let length = (end - self.position).norm();
        self.check_length(length, &end, source)?;
        let mut spans = Spans::default();
        spans.push(&[homogeneous(&self.position), homogeneous(&end)], length);
        self.append(PieceKind::Line, &spans, source, 0.0);
        Ok(self.finish_call(end))
    }

    /// Appends a circular arc of any sweep. It ends exactly in `to.end`: within the tolerance its centre is moved
    /// so that both radii are equal, and its plane is tilted.
    ///
    /// # Errors
    /// Fails when a number is not finite, the radius is 0, the end is off the circle by more than the tolerance, or
    /// there are more than 10 000 turns.
    pub fn arc(&mut self, to: &ArcTo, source: usize) -> Result<&mut Self, GeometryError> {
        check_arc(to, source)?;
        let arc = Turning::arc(&self.position, to, self.tolerance, source)?;
        self.check_length(arc.length(), &to.end, source)?;
        self.append(PieceKind::Arc, &arc.arc_spans(&self.position), source, 0.0);
        Ok(self.finish_call(to.end))
    }

    /// Appends a helix: as [`JoinedPathBuilder::arc`], and it rises along the axis to the height of its end. The
    /// path stays within `tolerance` of the helix. One that does not rise becomes an exact arc.
    ///
    /// # Errors
    /// As [`JoinedPathBuilder::arc`], and when the tolerance is lost in the rounding of the coordinates.
    pub fn helix(&mut self, to: &ArcTo, tolerance: f64, source: usize) -> Result<&mut Self, GeometryError> {
        check_arc(to, source)?;
        check_positive("tolerance of the helix", tolerance)?;
        let rise = (to.end - self.position).dot(&to.normal).abs();
        if rise <= rounding(&[&self.position, &to.end]) {
            return self.arc(to, source);
        }
        let helix = Turning::about(&self.position, to, self.tolerance, source)?;
        self.check_length(helix.length(), &to.end, source)?;
        let spans = helix.helix_spans(&self.position, tolerance)?;
        self.append(PieceKind::Helix, &spans, source, tolerance);
        Ok(self.finish_call(to.end))
    }

    /// Appends a NURBS curve: [`JoinedPathBuilder::curve_within`] with the tolerance of the builder.
    ///
    /// # Errors
    /// As [`JoinedPathBuilder::curve_within`].
    pub fn curve(&mut self, curve: &NurbsCurve<3>, source: usize) -> Result<&mut Self, GeometryError> {
        self.curve_within(curve, self.tolerance, source)
    }

    /// Appends a NURBS curve. It is moved as a whole onto the end of the path where it starts beside it within the
    /// tolerance of the builder. Where its tangent or its curvature jumps inside, it becomes several pieces.
    ///
    /// A curve whose control points coincide at an end or at a knot stands still there, or one with a cusp, and its
    /// curvature has no bound. A short stretch beside such a place is replaced by a polynomial of degree 5. No point of it is
    /// farther than `tolerance` from the curve, in the unit of the path, and no point of the curve farther from it.
    /// [`PathPiece::deviation`] states the bound.
    ///
    /// ```
    /// use arcfeed_geometry::{JoinedPathBuilder, NurbsCurve, nalgebra::vector};
    ///
    /// // A cubic whose first two control points coincide.
    /// let points = [[0.0, 0.0], [0.0, 0.0], [10.0, 0.0], [20.0, 10.0]].map(|[x, y]| vector![x, y, 0.0]);
    /// let curve = NurbsCurve::bspline(3, points.to_vec(), [[0.0; 4], [1.0; 4]].concat())?;
    /// let mut builder = JoinedPathBuilder::new(vector![0.0, 0.0, 0.0], 1e-6)?;
    /// builder.curve_within(&curve, 0.01, 1)?;
    /// let path = builder.build()?;
    /// let deviation = path.pieces()[0].deviation;
    /// assert!(deviation > 0.005 && deviation <= 0.01);
    /// # Ok::<(), arcfeed_geometry::GeometryError>(())
    /// ```
    ///
    /// # Errors
    /// Fails when the curve starts farther away, has no length, stands still at a knot and no replacement is within
    /// the tolerance, or the tolerance is not above 0.
    pub fn curve_within(
        &mut self,
        curve: &NurbsCurve<3>,
        tolerance: f64,
        source: usize,
    ) -> Result<&mut Self, GeometryError> {
        check_positive("tolerance of the curve", tolerance)?;
        let curve = curve.clamped()?;
        let points = curve.control_points();
        let gap = self.position - points[0];
        let distance = gap.norm();
        if distance.is_nan() || distance > self.tolerance {
            return Err(GeometryError::CurveStart { line: source, gap: distance, tolerance: self.tolerance });
        }
        let end = points[points.len() - 1] + gap;
        check_source("end of the curve from input line", source, &end)?;
        let mut parts = vec![(Spans::default(), 0.0)];
        for bezier in curve.decompose() {
            let moved = |h: &Homogeneous| [h[0] + gap.x * h[3], h[1] + gap.y * h[3], h[2] + gap.z * h[3], h[3]];
            let mut span: Vec<Homogeneous> = bezier.homogeneous().iter().map(moved).collect();
            standardise(&mut span);
            append_span(&mut parts, span, bezier.interval(), tolerance)?;
        }
        let whole: f64 = parts.iter().flat_map(|(spans, _)| spans.lengths()).sum();
        self.check_length(whole, &end, source)?;
        parts[0].0.set_end(false, &self.position);
        for (part, deviation) in &parts {
            self.append(PieceKind::Curve, part, source, *deviation);
        }
        Ok(self.finish_call(end))
    }

    /// The path.
    ///
    /// # Errors
    /// Fails when it has no pieces.
    pub fn build(self) -> Result<JoinedPath, GeometryError> {
        if self.pieces.is_empty() {
            return Err(GeometryError::EmptyPath);
        }
        Ok(JoinedPath::from_parts(self.spans, self.pieces, self.calls))
    }

    fn check_length(&self, length: f64, end: &Vector3<f64>, line: usize) -> Result<(), GeometryError> {
        let least = rounding(&[&self.position, end]).max(SHORTEST);
        if length > least { Ok(()) } else { Err(GeometryError::PieceTooShort { line, length, least }) }
    }

    fn append(&mut self, kind: PieceKind, spans: &Spans, source: usize, deviation: f64) {
        let first = self.spans.len();
        self.spans.append(spans);
        let before = self.pieces.last().map_or(0.0, |p| p.programmed[2]);
        let after = before + spans.lengths().iter().sum::<f64>();
        self.pieces.push(PathPiece {
            kind,
            sources: [source; 2],
            start: 0.0,
            end: 0.0,
            length: 0.0,
            deviation,
            spans: first..self.spans.len(),
            programmed: [before, 0.5 * (before + after), after],
        });
    }

    fn finish_call(&mut self, end: Vector3<f64>) -> &mut Self {
        self.position = end;
        self.calls.push(self.pieces.last().map_or(0.0, |p| p.programmed[2]));
        self
    }
}

/// Checks a point; an error names the line of the input.
fn check_source(what: &'static str, source: usize, point: &Vector3<f64>) -> Result<(), GeometryError> {
    check_points(what, &[*point]).map_err(|error| match error {
        GeometryError::PointNotFinite { what, axis, value, .. } => {
            GeometryError::PointNotFinite { what, index: source, axis, value }
        }
        other => other,
    })
}

fn check_arc(to: &ArcTo, source: usize) -> Result<(), GeometryError> {
    check_source("end of the arc from input line", source, &to.end)?;
    check_source("centre of the arc from input line", source, &to.centre)?;
    let norm = to.normal.norm();
    if (norm - 1.0).abs() <= 1e-9 { Ok(()) } else { Err(GeometryError::ArcNormal { line: source, norm }) }
}

/// Appends a span of a curve to parts without jumps, in several where it stands still inside. It covers the parameters
/// `interval` of the curve.
fn append_span(
    parts: &mut Vec<(Spans, f64)>,
    span: Vec<Homogeneous>,
    interval: (f64, f64),
    tolerance: f64,
) -> Result<(), GeometryError> {
    for (points, [from, to], moved) in between_cusps(span, tolerance) {
        let at = |t: f64| interval.0 + t * (interval.1 - interval.0);
        append_regular(parts, points, (at(from), at(to)), tolerance - moved)?;
        if let Some((_, deviation)) = parts.last_mut().filter(|_| moved > 0.0) {
            *deviation += moved;
        }
    }
    Ok(())
}

/// The parts of a span between its cusps, each with its parameters and the distance by which it was moved.
///
/// A speck, whose control points are all next to its ends, is left out, and the end of the part beside it that stands
/// still there is moved onto its other end. A speck alone stays.
fn between_cusps(span: Vec<Homogeneous>, tolerance: f64) -> Vec<(Vec<Homogeneous>, [f64; 2], f64)> {
    let cusps = cusps(&span, STANDING * length(&span, 0.0, 1.0));
    if cusps.is_empty() {
        return vec![(span, [0.0, 1.0], 0.0)];
    }
    let ends: Vec<f64> = [0.0].into_iter().chain(cusps).chain([1.0]).collect();
    let (first, last) = (span[0], span[span.len() - 1]);
    let parts = ends.windows(2).map(|w| {
        let (mut points, mut moved) = (part(&span, w[0], w[1]), 0.0);
        for cut in [w[0] > 0.0, w[1] < 1.0] {
            moved += if cut { stand_still(&mut points) } else { 0.0 };
            points.reverse();
        }
        (points, [w[0], w[1]], moved)
    });
    let speck = |points: &[Homogeneous]| {
        let points: Vec<Vector3<f64>> = points.iter().map(project).collect();
        extent(&points) <= SPECK * tolerance
    };
    let mut kept: Vec<(Vec<Homogeneous>, [f64; 2], f64)> = parts.filter(|(points, ..)| !speck(points)).collect();
    let mut at: Vector3<f64> = project(&first);
    for (points, _, moved) in &mut kept {
        *moved += move_end(points, &at);
        at = project(&points[points.len() - 1]);
    }
    match kept.last_mut() {
        Some((points, _, moved)) => {
            points.reverse();
            *moved += move_end(points, &project(&last));
            points.reverse();
        }
        None => kept.push((span, [0.0, 1.0], 0.0)),
    }
    kept
}

/// Moves the second control point of a span that stands still at its start onto the first one, where rounding left it beside. Returns
/// the distance.
fn stand_still(points: &mut [Homogeneous]) -> f64 {
    let (first, second): (Vector3<f64>, Vector3<f64>) = (project(&points[0]), project(&points[1]));
    let weights = points[1][3] / points[0][3];
    points[1] = points[0].map(|x| x * weights);
    (second - first).norm()
}

/// Moves the start of a span, with the control points that coincide with it, onto `to`. Returns the distance.
fn move_end(points: &mut [Homogeneous], to: &Vector3<f64>) -> f64 {
    let places: Vec<Vector3<f64>> = points.iter().map(project).collect();
    let by = to - places[0];
    for h in points.iter_mut().take(coincide(&places)[0]) {
        *h = [h[0] + by.x * h[3], h[1] + by.y * h[3], h[2] + by.z * h[3], h[3]];
    }
    by.norm()
}

/// Appends a span that stands still at its ends alone to parts without jumps, each with its largest deviation.
fn append_regular(
    parts: &mut Vec<(Spans, f64)>,
    span: Vec<Homogeneous>,
    interval: (f64, f64),
    tolerance: f64,
) -> Result<(), GeometryError> {
    let mean = length(&span, 0.0, 1.0);
    let standing =
        |t: f64, speed: f64| GeometryError::StandsStill { u: interval.0 + t * (interval.1 - interval.0), speed, mean };
    let [first, last] = [0.0, 1.0].map(|t| jet(&span, t).d1.norm());
    let still = if last < first { standing(1.0, last) } else { standing(0.0, first) };
    let spans = regular_spans(span, tolerance).ok_or(still)?;
    for RegularSpan { points, deviation } in spans {
        let whole = length(&points, 0.0, 1.0);
        for t in [0.0, 1.0] {
            let speed = jet(&points, t).d1.norm();
            if speed.is_nan() || speed <= STANDING * whole {
                return Err(standing(t, speed));
            }
        }
        let jump = parts.last().is_some_and(|(last, _)| last.len() > 0 && jumps(last, &points));
        if jump {
            parts.push((Spans::default(), 0.0));
        }
        if let Some((part, largest)) = parts.last_mut() {
            push_tame(part, &points, whole, MOST_HALVINGS);
            *largest = deviation.max(*largest);
        }
    }
    Ok(())
}

/// True where the tangent or the curvature jumps from the last of some spans to the next one.
fn jumps(spans: &Spans, next: &[Homogeneous]) -> bool {
    let last = spans.len() - 1;
    let (a, b) = (jet(spans.get(last), 1.0), jet(next, 0.0));
    let (before, after) = (a.curvature(), b.curvature());
    let step = (after - before).norm();
    let shorter = spans.lengths()[last].min(length(next, 0.0, 1.0));
    angle_between(&a.tangent(), &b.tangent()) > SAME_DIRECTION
        || (step > SAME_CURVATURE * before.norm().max(after.norm()) && step * shorter > SAME_DIRECTION)
}

/// Appends a span, in halves where its length is not resolved.
fn push_tame(out: &mut Spans, span: &[Homogeneous], whole: f64, halvings: u32) {
    let halves = [length(span, 0.0, 0.5), length(span, 0.5, 1.0)];
    if halvings == 0 || (halves[0] + halves[1] - whole).abs() <= TAME * whole {
        return out.push(span, halves[0] + halves[1]);
    }
    for (half, length) in [(0.0, 0.5), (0.5, 1.0)].into_iter().zip(halves) {
        let mut part = span.to_vec();
        restrict(&mut part, half.0, half.1);
        standardise(&mut part);
        push_tame(out, &part, length, halvings - 1);
    }
}
