//! Lines and arcs in a fitted curve, and the spans that join them to what is beside them.

use nalgebra::SVector;

use super::element::{Element, ElementShape};
use super::piece::Piece;
use super::polyline::angle;
use super::primitive::Shape;
use super::recognition::{Next, Primitive};
use super::stretch::{Checkpoint, Output, StretchFit};
use super::window::{End, Start, Window};
use crate::error::GeometryError;

/// A chord is a line where its length times the larger angle at its ends exceeds so many tolerances: an arc over
/// it would leave it by an eighth of the product.
const STRAIGHT: f64 = 12.0;
/// A chord is a line, too, where it is longer than both its neighbours by this factor,
const FAR_LONGER: f64 = 16.0;
/// and than the tolerance by this one.
const LONG: f64 = 64.0;
/// A primitive ends before the place where the polyline leaves it, by so many times the length over which that happens,
const MARGIN: f64 = 4.0;
/// but by no more than this part of its length.
const MOST_MARGIN: f64 = 0.25;
/// Two primitives meet where the polyline between them is no longer than this many times that length.
const GAP: f64 = 4.0;
/// Spans between two primitives.
const SPANS: usize = 3;
/// Parts of the primitives before and after a joint that the spans between them may take.
const OF_BEFORE: f64 = 0.8;
const OF_AFTER: f64 = 0.4;
/// Half the length of the spans between two primitives that is tried first: by the jump of the curvature `k` this many times
/// the root of `tolerance / k`, and by the angle `a` this many times `tolerance / a`.
const BY_JUMP: f64 = 16.0;
const BY_ANGLE: f64 = 24.0;
/// What it is multiplied with until the spans keep the tolerance, and how often.
const SHORTER: f64 = 0.85;
const TRIES: usize = 24;
/// Places at which two primitives are compared.
const PLACES: usize = 64;

impl<const D: usize> StretchFit<D> {
    /// Searches for lines and arcs up to vertex `end`, and fits up to each that is found. `whole` says that no run goes on
    /// behind that vertex.
    pub(super) fn recognise(&mut self, end: usize, whole: bool, out: &mut Output<D>) -> Result<(), GeometryError> {
        loop {
            let reached = self.pending.as_ref().map_or(self.at, |p| p.span.1);
            let floor = self.vertices.partition_point(|v| v.at < reached);
            match self.recognition.advance(&self.vertices, end, floor, whole) {
                Next::Wait => return Ok(()),
                Next::Found(primitive) => self.take(primitive, out)?,
                Next::Passed => {
                    let from = self.vertices[self.recognition.from()].at;
                    if self.pending.as_ref().is_some_and(|p| from - p.span.1 > GAP * p.leaves[1]) {
                        self.end_pending(out)?;
                    }
                }
            }
        }
    }

    /// Takes the chord from vertex `i` on, if it is a line.
    pub(super) fn take_line(&mut self, i: usize, out: &mut Output<D>) -> Result<(), GeometryError> {
        let Some(chord) = self.line(i) else { return Ok(()) };
        let (passed, best) = (self.pending.as_ref().map_or(0.0, |p| p.span.1), self.recognition.reaches());
        if chord.span.0 < passed.max(self.at) || best > i {
            // A part of a longer line.
            return Ok(());
        }
        self.recognise(i, true, out)?;
        self.take(chord, out)?;
        self.recognition.restart(i + 1);
        Ok(())
    }

    /// The chord from vertex `i` on, if it is a line.
    ///
    /// The line of a run. At a corner it ends in the corner. At a smooth joint it ends earlier, by the length of a curve that turns by
    /// the angle at the joint, or whose curvature rises from 0 to that of the neighbour.
    fn line(&self, i: usize) -> Option<Primitive<D>> {
        let v = &self.vertices;
        let (a, b) = (&v[i], &v[i + 1]);
        let (chord, length) = (b.point - a.point, b.at - a.at);
        let before = i.checked_sub(1).map(|h| a.point - v[h].point);
        let after = v.get(i + 2).map(|c| c.point - b.point);
        let turn = |other: &Option<SVector<f64, D>>| other.map_or(0.0, |other| angle(&chord, &other));
        let size = |other: &Option<SVector<f64, D>>| other.map_or(0.0, |other| other.norm());
        let product = length * turn(&before).max(turn(&after));
        let longer = length > FAR_LONGER * size(&before).max(size(&after)) && length > LONG * self.tolerance;
        if product <= STRAIGHT * self.tolerance && !longer {
            return None;
        }
        let margin = |other: &Option<SVector<f64, D>>| {
            if other.is_none() {
                return 0.0;
            }
            let angle = turn(other);
            let for_angle = 8.0 * self.tolerance / angle;
            let for_curvature = (12.0 * self.tolerance * size(other) / angle).sqrt();
            for_angle.min(for_curvature).min(0.25 * length)
        };
        let shape = Shape::Line { at: a.at, point: a.point, direction: chord / length };
        let leaves = [&before, &after].map(|other| margin(other) / MARGIN);
        Some(Primitive { shape, run: (i, i + 1), span: (a.at, b.at), deviation: 0.0, leaves })
    }

    /// Fits up to a primitive.
    fn take(&mut self, mut next: Primitive<D>, out: &mut Output<D>) -> Result<(), GeometryError> {
        let (first, last) = (next.leaves[0] == 0.0, next.leaves[1] == 0.0);
        if let Shape::Line { .. } = next.shape
            && (first || last)
            && next.run.1 > next.run.0 + 1
        {
            // It passes the corner, or both.
            let run = &self.vertices[next.run.0..=next.run.1];
            let (a, b) = (&run[0], &run[run.len() - 1]);
            let shape = match (first, last) {
                (true, true) => Shape::line(&[*a, *b], Some(a)),
                (true, false) => Shape::line(run, Some(a)),
                _ => Shape::line(run, Some(b)),
            };
            match shape.within(run, self.tolerance - self.rounding) {
                Some(deviation) => (next.shape, next.deviation) = (shape, deviation),
                None => return Ok(()),
            }
        }
        if let Some(before) = self.pending
            && next.span.0 - before.span.1 <= GAP * (before.leaves[1] + next.leaves[0])
            && self.join(&before, &next, out)?
        {
            self.pending = Some(next);
            return Ok(());
        }
        self.end_pending(out)?;
        let from = next.span.0 + self.margin(&next, 0);
        if from < self.at || (from == self.at && !(first && self.fresh)) {
            return Ok(());
        }
        self.checkpoint.get_or_insert_with(|| Checkpoint {
            at: self.at,
            start: self.start,
            fresh: self.fresh,
            elements: self.elements.len(),
            cubics: self.cubics,
            march: self.march.clone(),
        });
        self.lead_to(from, End::Jet(next.shape.jet(from)), out)?;
        (self.pending, self.recognised) = (Some(next), true);
        Ok(())
    }

    /// How far a primitive ends before an end of its run.
    fn margin(&self, primitive: &Primitive<D>, end: usize) -> f64 {
        let leaves = primitive.leaves[end];
        let least = match primitive.shape {
            _ if leaves > 0.0 => 0.0,
            Shape::Line { .. } => return 0.0,
            // The curve starts in the corner and not in the arc: a cubic that follows the arc from there.
            Shape::Arc { radius, .. } => (MARGIN * self.tolerance * radius.powi(3)).sqrt().sqrt(),
        };
        (MARGIN * leaves).max(least).min(MOST_MARGIN * primitive.length())
    }

    /// Ends the primitive that the fit has reached.
    pub(super) fn end_pending(&mut self, out: &mut Output<D>) -> Result<(), GeometryError> {
        let Some(primitive) = self.pending.take() else { return Ok(()) };
        self.add_primitive(&primitive, primitive.span.1 - self.margin(&primitive, 1), out)?;
        let limit = self.vertices[self.vertices.len() - 2].at;
        if limit > self.at { self.settle(limit, End::Open, out) } else { Ok(()) }
    }

    /// The same at the end of the polyline, and fits up to there.
    pub(super) fn finish_pending(&mut self, out: &mut Output<D>) -> Result<(), GeometryError> {
        if let Some(primitive) = self.pending.take() {
            self.add_primitive(&primitive, primitive.span.1 - self.margin(&primitive, 1), out)?;
            let last = self.vertices[self.vertices.len() - 1];
            self.lead_to(last.at, End::Point(last.point), out)?;
            self.settle(last.at, End::Point(last.point), out)?;
        }
        Ok(())
    }

    /// Fits cubics alone in place of the primitives since the checkpoint and what joins them, and takes those where they are
    /// fewer. They may use the polyline up to `limit`, where the condition `end` holds.
    fn settle(&mut self, limit: f64, end: End<D>, out: &mut Output<D>) -> Result<(), GeometryError> {
        let Some(Checkpoint { at, start, fresh, elements, cubics, mut march }) = self.checkpoint.take() else {
            return Ok(());
        };
        let visits = march.visits;
        let used: usize = self.elements[elements..].iter().map(Element::pieces).sum();
        let reached = self.at;
        let (mut place, mut condition) = (at, start);
        let mut pieces: Vec<Piece<D>> = Vec::new();
        while place < reached {
            let window = Window { vertices: &self.vertices, at: place, start: condition, limit, end };
            let Some(more) = march.advance(&window) else { break };
            pieces.extend(more);
            let Some(last) = pieces.last() else { break };
            (place, condition) = (last.end, Start::Jet(last.taylor_at_end()));
            // Those that reach beyond the place do not count.
            if pieces.iter().filter(|p| p.end <= reached).count() >= used {
                break;
            }
        }
        self.march.visits += march.visits - visits;
        if place < reached || pieces.iter().filter(|p| p.end <= reached).count() >= used {
            return Ok(());
        }
        self.elements.truncate(elements);
        (self.at, self.start, self.fresh, self.cubics) = (at, start, fresh, cubics);
        march.visits = self.march.visits;
        self.march = march;
        pieces.into_iter().try_for_each(|piece| self.add(piece, out))
    }

    /// Joins the primitive that the fit has reached with the next one, by spans that take over point, direction and
    /// curvature of both. False where none keep the tolerance.
    fn join(&mut self, before: &Primitive<D>, next: &Primitive<D>, out: &mut Output<D>) -> Result<bool, GeometryError> {
        let joint = nearest(before, next);
        let (a, b) = (before.shape.jet(joint), next.shape.jet(joint));
        let jump = 2.0 * (b[2] - a[2]).norm();
        let turn = angle(&a[1], &b[1]);
        let most = (OF_BEFORE * (joint - self.at)).min(OF_AFTER * (next.span.1 - joint));
        let (by_jump, by_angle) = (BY_JUMP * (self.tolerance / jump).sqrt(), BY_ANGLE * self.tolerance / turn);
        let mut half = most.min(by_jump).min(by_angle);
        for _ in 0..TRIES {
            // Inside both runs: their deviations are known there.
            let (from, to) = ((joint - half).min(before.span.1), (joint + half).max(next.span.0));
            if from.is_nan() || from <= self.at || to - from < SPANS as f64 * self.march.narrowest() {
                return Ok(false);
            }
            let (start, end) = (Start::Jet(before.shape.jet(from)), End::Jet(next.shape.jet(to)));
            if let Some(pieces) = self.spans((from, start), (to, end), SPANS) {
                self.add_primitive(before, from, out)?;
                pieces.into_iter().try_for_each(|piece| self.add(piece, out))?;
                return Ok(true);
            }
            half *= SHORTER;
        }
        Ok(false)
    }

    /// Fits up to `limit`, where the condition `end` holds: with very few spans if they keep the tolerance.
    fn lead_to(&mut self, limit: f64, end: End<D>, out: &mut Output<D>) -> Result<(), GeometryError> {
        let least = match (&self.start, &end) {
            (Start::Jet(_), End::Jet(_)) => SPANS,
            _ => 1,
        };
        let few = (least..=SPANS).find_map(|count| self.spans((self.at, self.start), (limit, end), count));
        match few {
            Some(pieces) => pieces.into_iter().try_for_each(|piece| self.add(piece, out)),
            None => self.run(limit, end, out),
        }
    }

    /// Spans of equal width from one place to another, if they keep the tolerance.
    fn spans(
        &mut self,
        (from, start): (f64, Start<D>),
        (to, end): (f64, End<D>),
        count: usize,
    ) -> Option<Vec<Piece<D>>> {
        let window = Window { vertices: &self.vertices, at: from, start, limit: to, end };
        let mut breaks: Vec<f64> = (0..=count).map(|i| from + (to - from) * (i as f64 / count as f64)).collect();
        breaks[count] = to;
        let pieces = window.fit(&breaks, &end, &mut self.march.visits)?;
        let most = self.tolerance - self.rounding;
        pieces.iter().all(|piece| piece.deviation <= most).then_some(pieces)
    }

    /// Appends a primitive from where the fit is to `to`.
    fn add_primitive(&mut self, primitive: &Primitive<D>, to: f64, out: &mut Output<D>) -> Result<(), GeometryError> {
        if to.is_nan() || to <= self.at {
            return Ok(());
        }
        let [point, direction, ..] = primitive.shape.jet(self.at);
        match primitive.shape {
            Shape::Line { .. } => {
                let piece = Piece::line((self.at, to), &point, &direction, primitive.deviation);
                self.add(piece, out)?;
            }
            Shape::Arc { .. } => self.add_arc(primitive, to),
        }
        Ok(())
    }

    fn add_arc(&mut self, primitive: &Primitive<D>, to: f64) {
        let span = (self.at, to);
        let shape = ElementShape::Arc { shape: primitive.shape, span, deviation: primitive.deviation };
        self.elements.push(Element { shape, indices: (self.index_up_to(self.at), self.index_from(to)) });
        (self.at, self.start, self.fresh) = (to, Start::Jet(primitive.shape.jet(to)), false);
        self.cubics = (to, f64::INFINITY);
    }
}

/// The length along the polyline at which two primitives are nearest to each other, about where one ends and the other
/// begins.
fn nearest<const D: usize>(before: &Primitive<D>, next: &Primitive<D>) -> f64 {
    let reach = GAP * (before.leaves[1] + next.leaves[0]);
    let from = (before.span.1 - reach).max(0.5 * (before.span.0 + before.span.1));
    let to = (next.span.0 + reach).min(0.5 * (next.span.0 + next.span.1));
    let mut best = (f64::INFINITY, 0.5 * (from + to));
    for i in 0..=PLACES {
        let t = from + (to - from) * (i as f64 / PLACES as f64);
        let apart = (before.shape.point(t) - next.shape.point(t)).norm();
        if apart < best.0 {
            best = (apart, t);
        }
    }
    best.1
}
