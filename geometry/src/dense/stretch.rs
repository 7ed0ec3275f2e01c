//! The fit of the polyline between two corners.

use std::collections::VecDeque;

use nalgebra::SVector;

use super::element::{Element, ElementShape, curves};
use super::fitted::{FittedStretch, StretchShape, line};
use super::march::March;
use super::piece::Piece;
use super::polyline::{Vertex, between};
use super::recognition::{Primitive, Recognition};
use super::window::{End, Start, Window};
use crate::error::GeometryError;

/// Chords that are known ahead before a window is fitted, at least, and at most: between these numbers as many
/// as wide spans need.
const FEW_CHORDS: usize = 128;
const MANY_CHORDS: usize = 8192;
/// Chords that are known before the first window of a stretch is fitted: it may be a line, or begin with wide spans.
const FIRST_CHORDS: usize = 2048;
/// Length that is known ahead before a window is fitted, in tolerances.
const LENGTH: f64 = 32.0;
/// Part of the tolerance for the rounding of the curve, which is some 1e-13 of the coordinates. The tolerance is
/// at least 1e-9 of them.
const ROUNDING: f64 = 1e-3;
/// Most pieces of one curve.
const MOST_PIECES: usize = 1 << 13;
/// Longest curve, as a multiple of its narrowest span. Spans narrower than 1e-9 of a curve are no spans of it.
const LONGEST: f64 = 1e7;
/// Part of the tolerance that a line or an arc may be off the polyline; the rest is left to the curves between them.
const OF_PRIMITIVES: f64 = 0.6;

/// Finished stretches.
pub(super) type Output<const D: usize> = VecDeque<FittedStretch<D>>;

/// A fit from one corner to the next.
#[derive(Debug, Clone)]
pub(super) struct StretchFit<const D: usize> {
    pub(super) tolerance: f64,
    /// The part of the tolerance that is left to the rounding of the curve.
    pub(super) rounding: f64,
    pub(super) march: March,
    pub(super) vertices: Vec<Vertex<D>>,
    /// Parameter up to which the fit is done, and the condition there.
    pub(super) at: f64,
    pub(super) start: Start<D>,
    pub(super) recognition: Recognition<D>,
    /// A line or an arc that the fit has reached and whose end is not known.
    pub(super) pending: Option<Primitive<D>>,
    /// True where a line or an arc was found, and where the first chord is gone or a curve was handed out.
    pub(super) recognised: bool,
    partial: bool,
    /// True where nothing of the polyline was left behind.
    pub(super) fresh: bool,
    /// The curve so far: its elements, the point and the index where it starts, and whether it continues another.
    pub(super) elements: Vec<Element<D>>,
    from: SVector<f64, D>,
    first: usize,
    continues: bool,
    /// Start and narrowest span of the cubics since the last arc.
    pub(super) cubics: (f64, f64),
    /// Where the primitives began that may give way to cubics alone.
    pub(super) checkpoint: Option<Checkpoint<D>>,
}

/// A state of a fit to which it can go back.
#[derive(Debug, Clone)]
pub(super) struct Checkpoint<const D: usize> {
    pub at: f64,
    pub start: Start<D>,
    pub fresh: bool,
    pub elements: usize,
    pub cubics: (f64, f64),
    pub march: March,
}

impl<const D: usize> StretchFit<D> {
    /// A fit that starts in the corner `point`.
    pub fn new(tolerance: f64, primitives: bool, point: SVector<f64, D>, index: usize) -> Self {
        let rounding = ROUNDING * tolerance;
        Self {
            tolerance,
            rounding,
            march: March::new(tolerance - rounding),
            vertices: vec![Vertex { point, at: 0.0, index }],
            at: 0.0,
            start: Start::Point(point),
            recognition: Recognition::new(if primitives { OF_PRIMITIVES * tolerance } else { 0.0 }),
            pending: None,
            recognised: false,
            partial: false,
            fresh: true,
            elements: Vec::new(),
            from: point,
            first: index,
            continues: false,
            cubics: (0.0, f64::INFINITY),
            checkpoint: None,
        }
    }

    /// True where no chord has arrived.
    pub fn is_a_point(&self) -> bool {
        self.vertices.len() < 2
    }

    /// Number of parts of chords that were read.
    pub fn visits(&self) -> u64 {
        self.march.visits + self.recognition.visits
    }

    /// Takes the next point, which differs from the one before.
    pub fn push(&mut self, point: SVector<f64, D>, index: usize, out: &mut Output<D>) -> Result<(), GeometryError> {
        let last = self.vertices[self.vertices.len() - 1];
        self.vertices.push(Vertex { point, at: last.at + (point - last.point).norm(), index });
        let n = self.vertices.len();
        if n < 3 {
            return Ok(());
        }
        // The last chord is not known to be no line.
        self.take_line(n - 3, out)?;
        self.recognise(self.vertices.len() - 1, false, out)?;
        self.drop_passed();
        if self.pending.is_some() {
            return Ok(());
        }
        let limit = self.vertices[self.recognition.from().min(self.vertices.len() - 2)].at;
        while self.sees_far_enough(limit) {
            self.step(limit, End::Open, out)?;
            self.drop_passed();
        }
        Ok(())
    }

    /// Ends the stretch in its last point.
    pub fn finish(&mut self, out: &mut Output<D>) -> Result<(), GeometryError> {
        let (partial, mut curves) = (self.partial, Output::new());
        self.end(&mut curves)?;
        if self.recognised && !partial {
            // The whole polyline is at hand: where cubics alone are fewer, they are taken.
            let mut plain = Self::new(self.tolerance, false, self.vertices[0].point, self.vertices[0].index);
            let mut cubics = Output::new();
            for vertex in &self.vertices[1..] {
                plain.push(vertex.point, vertex.index, &mut cubics)?;
            }
            plain.end(&mut cubics)?;
            self.march.visits += plain.visits();
            let pieces = |curves: &Output<D>| curves.iter().map(FittedStretch::pieces).sum::<usize>();
            if pieces(&cubics) < pieces(&curves) {
                curves = cubics;
            }
        }
        out.append(&mut curves);
        Ok(())
    }

    fn end(&mut self, out: &mut Output<D>) -> Result<(), GeometryError> {
        let n = self.vertices.len();
        if n < 2 {
            return Ok(());
        }
        let last = self.vertices[n - 1];
        if self.fresh
            && let Some(deviation) = self.deviation_from_line()
        {
            let curve = line((self.vertices[0].point, last.point), last.at)?;
            out.push_back(FittedStretch::straight(StretchShape::Line, curve, (self.first, last.index), deviation));
            return Ok(());
        }
        self.take_line(n - 2, out)?;
        self.recognise(self.vertices.len() - 1, true, out)?;
        self.finish_pending(out)?;
        self.run(last.at, End::Point(last.point), out)?;
        self.emit(last.point, last.index, out)
    }

    /// True where enough of the polyline is known up to `limit` for another window.
    fn sees_far_enough(&self, limit: f64) -> bool {
        let rest = limit - self.at;
        if self.vertices.len() < FEW_CHORDS || rest <= LENGTH * self.tolerance {
            return false;
        }
        let chords = self.vertices.len() - self.vertices.partition_point(|v| v.at <= self.at);
        let enough = if self.fresh { FIRST_CHORDS } else { FEW_CHORDS };
        chords > MANY_CHORDS || (chords > enough && rest > self.march.wanted())
    }

    /// Drops chords that are passed, except for one before the present.
    fn drop_passed(&mut self) {
        let at = self.checkpoint.as_ref().map_or(self.at, |checkpoint| checkpoint.at);
        let passed = self.vertices.partition_point(|v| v.at <= at).saturating_sub(2);
        if passed > MANY_CHORDS / 2 {
            self.vertices.drain(..passed);
            self.partial = true;
            self.recognition.drop_front(passed);
        }
        if self.vertices.len() > 4 * MANY_CHORDS {
            // The primitives since the checkpoint stay.
            self.checkpoint = None;
        }
    }

    /// Bound of the deviation from the straight line, where that is less than half the tolerance.
    fn deviation_from_line(&self) -> Option<f64> {
        let (first, last) = (self.vertices[0], self.vertices[self.vertices.len() - 1]);
        let distance = |v: &Vertex<D>| (v.point - between(&first, &last, v.at)).norm();
        // Between the vertices both are linear.
        let largest = self.vertices.iter().map(distance).fold(0.0f64, f64::max);
        let deviation = largest + self.rounding;
        (deviation <= 0.5 * self.tolerance || self.vertices.len() == 2).then_some(deviation)
    }

    /// Fits up to `limit`, where the condition `end` holds.
    pub(super) fn run(&mut self, limit: f64, end: End<D>, out: &mut Output<D>) -> Result<(), GeometryError> {
        while self.at < limit {
            self.step(limit, end, out)?;
        }
        Ok(())
    }

    /// Fits some way on.
    fn step(&mut self, limit: f64, end: End<D>, out: &mut Output<D>) -> Result<(), GeometryError> {
        let window = Window { vertices: &self.vertices, at: self.at, start: self.start, limit, end };
        match self.march.advance(&window) {
            Some(pieces) => pieces.into_iter().try_for_each(|piece| self.add(piece, out)),
            None => self.keep_polyline(limit, end, out),
        }
    }

    pub(super) fn add(&mut self, piece: Piece<D>, out: &mut Output<D>) -> Result<(), GeometryError> {
        self.fresh = false;
        self.cubics.1 = self.cubics.1.min(piece.width());
        if !self.elements.is_empty()
            && (self.elements.len() >= MOST_PIECES || piece.end - self.cubics.0 > LONGEST * self.cubics.1)
        {
            let smooth = matches!(self.start, Start::Jet(_));
            self.emit(self.start.point(), self.index_from(self.at), out)?;
            (self.continues, self.cubics.1) = (smooth, piece.width());
        }
        self.at = piece.end;
        self.start = Start::Jet(piece.taylor_at_end());
        let indices = (self.index_up_to(piece.start), self.index_from(piece.end));
        self.elements.push(Element { shape: ElementShape::Cubic(piece), indices });
        Ok(())
    }

    /// Goes straight to the next vertex.
    fn keep_polyline(&mut self, limit: f64, end: End<D>, out: &mut Output<D>) -> Result<(), GeometryError> {
        self.fresh = false;
        let from = self.start.point();
        self.emit(from, self.index_from(self.at), out)?;
        let next = self.vertices.partition_point(|v| v.at <= self.at);
        let vertex = self.vertices[next.min(self.vertices.len() - 1)];
        let (to, at) = match end {
            End::Jet([point, ..]) if vertex.at > limit => (point, limit),
            _ => (vertex.point, vertex.at),
        };
        if from != to {
            let start = between(&self.vertices[next - 1], &vertex, self.at);
            let deviation = (from - start).norm() + self.rounding;
            let range = (self.first, vertex.index);
            let curve = line((from, to), at - self.at)?;
            out.push_back(FittedStretch::straight(StretchShape::Polyline, curve, range, deviation));
        }
        (self.at, self.start, self.from, self.continues) = (at, Start::Point(to), to, false);
        (self.first, self.cubics.0) = (self.index_up_to(at), at);
        self.march.restart();
        Ok(())
    }

    /// Hands out the curve so far, which ends in `to`. The next one starts there.
    fn emit(&mut self, to: SVector<f64, D>, last: usize, out: &mut Output<D>) -> Result<(), GeometryError> {
        let elements = std::mem::take(&mut self.elements);
        self.partial = true;
        out.extend(curves(&elements, (self.from, to), (self.first, last), self.continues, self.rounding)?);
        (self.from, self.first, self.continues) = (to, self.index_up_to(self.at), false);
        (self.cubics, self.checkpoint) = ((self.at, f64::INFINITY), None);
        Ok(())
    }

    /// Index of the last vertex that is not behind `at`.
    pub(super) fn index_up_to(&self, at: f64) -> usize {
        self.vertices[self.vertices.partition_point(|v| v.at <= at).saturating_sub(1)].index
    }

    /// Index of the first vertex that is not before `at`.
    pub(super) fn index_from(&self, at: f64) -> usize {
        self.vertices[self.vertices.partition_point(|v| v.at < at).min(self.vertices.len() - 1)].index
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::Curve;
    use nalgebra::vector;

    /// No window can be fitted any more from the middle on: the curve ends there, lines lead from vertex to
    /// vertex, and a line that ends within a chord is continued.
    #[test]
    fn the_polyline_is_kept_where_no_window_is_fitted() {
        let circle = |i: usize| vector![20.0 * (i as f64 * 0.04).cos(), 20.0 * (i as f64 * 0.04).sin()];
        let mut points: Vec<_> = (0..2500).map(circle).collect();
        points.push(points[2499] + vector![300.0, 0.0]);
        points.push(points[2500] + vector![0.1, 0.01]);
        let mut out = Output::new();
        let mut fit = StretchFit::new(0.005, false, points[0], 0);
        for (index, &point) in points.iter().enumerate().skip(1) {
            if index == 2400 {
                fit.march = March::new(1e-18);
            }
            fit.push(point, index, &mut out).unwrap();
        }
        fit.finish(&mut out).unwrap();
        let kept: Vec<_> = out.iter().filter(|s| s.shape == StretchShape::Polyline).collect();
        assert!(out[0].shape == StretchShape::Curve && out[0].pieces() > 20);
        assert!(kept.len() > 100 && kept.len() < 1000);
        assert_eq!((out[0].first, out[out.len() - 1].last), (0, 2501));
        for (before, after) in out.iter().zip(out.iter().skip(1)) {
            let (end, start) = (before.curve.jet_left(f64::MAX).point, after.curve.jet(f64::MIN).point);
            assert_eq!(end, start);
            assert!(!after.continues && after.max_deviation <= 0.005);
            assert!(after.first <= before.last && before.last <= after.first + 1);
        }
        // From the start of the second kept line on they start and end in the points themselves.
        for line in kept.iter().skip(1).filter(|s| s.last < 2499) {
            assert_eq!(line.curve.control_points(), [points[line.first], points[line.last]]);
        }
        let long = &out[out.len() - 1];
        let line = long.lines.last().map_or(0.0, |(from, to)| to - from);
        assert!(long.shape == StretchShape::Curve && long.last == 2501 && line > 299.0);
    }
}
