//! The search for runs of vertices that lie on a line or on an arc.

use super::polyline::{Vertex, between};
use super::primitive::Shape;

/// Chords of the shortest run, of the longest one with which a search begins, and of the longest one.
const FEW_CHORDS: usize = 8;
const LARGE_START: usize = 32;
const MANY_CHORDS: usize = 1 << 14;
/// Length of the shortest run, in its tolerances.
const SHORTEST: f64 = 64.0;
/// The polyline has left a primitive where it is farther from it than this many times the tolerance of the run.
const LEFT: f64 = 4.0;
/// A run is a line or an arc where the polyline leaves it within this part of its length, at both ends together. Where a
/// line or an arc only touches another curve, that takes more than half of the run.
const CLEAR: f64 = 0.25;
/// The place in a chord where a shape is left is found to this power of 1/2.
const HALVINGS: usize = 16;

/// A line or an arc that stands for a run of vertices.
#[derive(Debug, Clone, Copy)]
pub(super) struct Primitive<const D: usize> {
    pub shape: Shape<D>,
    /// First and last vertex of the run, by their places in the list of vertices.
    pub run: (usize, usize),
    /// Length along the polyline at both.
    pub span: (f64, f64),
    /// No point of the polyline is farther from the shape, at the same length.
    pub deviation: f64,
    /// Length beside both ends over which the polyline leaves the shape; 0 at an end of the polyline.
    pub leaves: [f64; 2],
}

impl<const D: usize> Primitive<D> {
    pub fn length(&self) -> f64 {
        self.span.1 - self.span.0
    }
}

/// A search that goes along the vertices as they arrive.
#[derive(Debug, Clone)]
pub(super) struct Recognition<const D: usize> {
    /// Distance that is allowed between a run and its shape; 0 finds nothing.
    tolerance: f64,
    /// First vertex of the run at hand.
    from: usize,
    /// Chords to look at next.
    chords: usize,
    /// The shape of the run so far, and its last vertex.
    best: Option<(Shape<D>, usize)>,
    /// Number of chords that were read.
    pub visits: u64,
}

/// How a search goes on.
pub(super) enum Next<const D: usize> {
    /// More vertices are needed.
    Wait,
    /// No run starts in some of the vertices, which are left behind.
    Passed,
    /// A run.
    Found(Primitive<D>),
}

impl<const D: usize> Recognition<D> {
    pub fn new(tolerance: f64) -> Self {
        Self { tolerance, from: 0, chords: FEW_CHORDS, best: None, visits: 0 }
    }

    /// First vertex that may belong to a run that is not found yet.
    pub fn from(&self) -> usize {
        self.from
    }

    /// The last vertex of the run at hand, as far as it is known.
    pub fn reaches(&self) -> usize {
        self.best.map_or(0, |(_, last)| last)
    }

    /// Goes on at a vertex.
    pub fn restart(&mut self, from: usize) {
        (self.from, self.chords, self.best) = (from, FEW_CHORDS, None);
    }

    /// The first vertices are gone.
    pub fn drop_front(&mut self, count: usize) {
        self.from = self.from.saturating_sub(count);
        if let Some((_, last)) = &mut self.best {
            *last = last.saturating_sub(count);
        }
    }

    /// Goes on among the vertices up to `end`. A run begins in no vertex before `floor`. `whole` says that no vertex
    /// follows in a run.
    pub fn advance(&mut self, vertices: &[Vertex<D>], end: usize, floor: usize, whole: bool) -> Next<D> {
        if self.tolerance <= 0.0 {
            self.from = end;
            return Next::Wait;
        }
        loop {
            let left = end.saturating_sub(self.from);
            if left < FEW_CHORDS && self.best.is_none() || (left < self.chords && !whole) {
                if whole && self.from < end {
                    self.restart(end);
                    return Next::Passed;
                }
                return Next::Wait;
            }
            let last = self.from + self.chords.min(left);
            let again = self.best.is_none_or(|(_, before)| last > before);
            let fitted = if again { self.fit(&vertices[self.from..=last]) } else { None };
            match fitted {
                Some(shape) if last - self.from < MANY_CHORDS => {
                    self.best = Some((shape, last));
                    self.chords *= 2;
                }
                Some(shape) => {
                    self.best = Some((shape, last));
                    return self.conclude(vertices, end, floor);
                }
                None if self.best.is_some() => return self.conclude(vertices, end, floor),
                None if self.chords > LARGE_START => self.chords = (self.chords / 2).max(LARGE_START),
                // A short part of an arc is too flat to be told from a line, and too bent to be one.
                None if self.chords < LARGE_START && last == self.from + self.chords => self.chords *= 2,
                None => {
                    self.restart((self.from + LARGE_START / 2).min(end));
                    return Next::Passed;
                }
            }
        }
    }

    /// A line, or else an arc, through a run within the tolerance.
    fn fit(&mut self, run: &[Vertex<D>]) -> Option<Shape<D>> {
        // A line that leaves the middle is none.
        let (a, b, middle) = (&run[0], &run[run.len() - 1], &run[run.len() / 2]);
        let off = (middle.point - between(a, b, middle.at)).norm();
        if off <= 4.0 * self.tolerance {
            self.visits += 2 * run.len() as u64;
            let line = Shape::line(run, None);
            if line.within(run, self.tolerance).is_some() {
                return Some(line);
            }
        }
        self.visits += 4 * run.len() as u64;
        Shape::arc(run, self.tolerance).filter(|arc| arc.within(run, self.tolerance).is_some())
    }

    /// The run at hand cannot be longer: takes it, or goes on behind most of it.
    fn conclude(&mut self, vertices: &[Vertex<D>], end: usize, floor: usize) -> Next<D> {
        let Some((shape, mut last)) = self.best else { return Next::Wait };
        let mut first = self.from;
        let near = |shape: &Shape<D>, i: usize, bound: f64| {
            shape.deviation(&vertices[i], &vertices[i + 1]) <= bound * self.tolerance
        };
        while last < end && near(&shape, last, 1.0) {
            last += 1;
        }
        while first > floor && near(&shape, first - 1, 1.0) {
            first -= 1;
        }
        // How far the polyline goes on beside the shape.
        let leaves = [self.leaves_before(&shape, vertices, first), self.leaves_behind(&shape, vertices, last)];
        let at = |i: usize| vertices[i].at;
        let span = (at(first), at(last));
        let length = span.1 - span.0;
        if !(length >= SHORTEST * self.tolerance && leaves[0] + leaves[1] <= CLEAR * length && last > first) {
            // The next run is about as long.
            let chords = last - self.from;
            self.restart(last.max(self.from + 1));
            self.chords = (chords / 2).max(FEW_CHORDS);
            return Next::Passed;
        }
        self.visits += 5 * (last - first) as u64;
        let run = &vertices[first..=last];
        let refit = match shape {
            Shape::Line { .. } => Some(Shape::line(run, None)),
            Shape::Arc { .. } => Shape::arc(run, self.tolerance),
        };
        let refit = refit.and_then(|shape| Some((shape, shape.within(run, self.tolerance)?)));
        let kept = || shape.within(run, LEFT * self.tolerance).map(|deviation| (shape, deviation));
        let found = refit.or_else(kept);
        self.restart(last);
        match found {
            Some((shape, deviation)) => Next::Found(Primitive { shape, run: (first, last), span, deviation, leaves }),
            None => Next::Passed,
        }
    }

    /// How far the polyline goes on beside a shape behind a vertex; 0 at its end.
    fn leaves_behind(&self, shape: &Shape<D>, vertices: &[Vertex<D>], last: usize) -> f64 {
        let mut passed = 0.0;
        for pair in vertices[last..].windows(2) {
            let beside = self.beside(shape, &pair[0], &pair[1]);
            passed += beside;
            if beside < pair[1].at - pair[0].at {
                break;
            }
        }
        passed
    }

    /// The same before a vertex.
    fn leaves_before(&self, shape: &Shape<D>, vertices: &[Vertex<D>], first: usize) -> f64 {
        let mut passed = 0.0;
        for pair in vertices[..=first].windows(2).rev() {
            let beside = self.beside(shape, &pair[1], &pair[0]);
            passed += beside;
            if beside < pair[1].at - pair[0].at {
                break;
            }
        }
        passed
    }

    /// The length from vertex `a` on that a chord goes on beside a shape.
    fn beside(&self, shape: &Shape<D>, a: &Vertex<D>, b: &Vertex<D>) -> f64 {
        let near = |share: f64| {
            let off = shape.point(a.at + (b.at - a.at) * share) - (a.point + (b.point - a.point) * share);
            off.norm() <= LEFT * self.tolerance
        };
        if near(1.0) {
            return (b.at - a.at).abs();
        }
        let (mut inside, mut outside) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (inside + outside);
            if near(middle) { inside = middle } else { outside = middle }
        }
        (b.at - a.at).abs() * outside
    }
}
