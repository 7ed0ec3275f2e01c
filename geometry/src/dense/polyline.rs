//! The polyline of the points, by its length.

use nalgebra::SVector;

/// A vertex of the polyline.
#[derive(Debug, Clone, Copy)]
pub(super) struct Vertex<const D: usize> {
    pub point: SVector<f64, D>,
    /// Length of the polyline up to here.
    pub at: f64,
    /// Index of the point in the input.
    pub index: usize,
}

/// A chord, or a part of one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Part<const D: usize> {
    pub start: f64,
    pub end: f64,
    pub from: SVector<f64, D>,
    pub to: SVector<f64, D>,
}

/// A walk along a polyline, from one place to the next.
#[derive(Debug)]
pub(super) struct Walk<'a, const D: usize> {
    vertices: &'a [Vertex<D>],
    /// The first vertex ahead.
    next: usize,
    at: f64,
    point: SVector<f64, D>,
}

impl<'a, const D: usize> Walk<'a, D> {
    /// Starts at `at`. There are at least two vertices, and `at` lies between the first and the last.
    pub fn new(vertices: &'a [Vertex<D>], at: f64) -> Self {
        let next = vertices.partition_point(|v| v.at <= at).max(1).min(vertices.len() - 1);
        Self { vertices, next, at, point: between(&vertices[next - 1], &vertices[next], at) }
    }

    /// Point of the polyline at the present place.
    pub fn point(&self) -> SVector<f64, D> {
        self.point
    }

    /// The parts of chords up to `end`.
    pub fn parts(&mut self, end: f64) -> impl Iterator<Item = Part<D>> + use<'_, 'a, D> {
        std::iter::from_fn(move || {
            if self.at >= end {
                return None;
            }
            let vertex = &self.vertices[self.next];
            let (start, from) = (self.at, self.point);
            if vertex.at <= end {
                (self.at, self.point) = (vertex.at, vertex.point);
                // An end behind the last vertex is the last vertex, rounded.
                if self.next + 1 == self.vertices.len() {
                    self.at = end;
                } else {
                    self.next += 1;
                }
            } else {
                self.at = end;
                self.point = between(&self.vertices[self.next - 1], vertex, end);
            }
            Some(Part { start, end: self.at, from, to: self.point })
        })
    }
}

/// Point of the chord from `a` to `b` at the length `at`.
pub(super) fn between<const D: usize>(a: &Vertex<D>, b: &Vertex<D>, at: f64) -> SVector<f64, D> {
    let share = (at - a.at) / (b.at - a.at);
    a.point + (b.point - a.point) * share.max(0.0).min(1.0)
}

/// Angle between two directions, 0 to pi; 0 where one of them has no length (Kahan).
pub(super) fn angle<const D: usize>(a: &SVector<f64, D>, b: &SVector<f64, D>) -> f64 {
    let (Some(a), Some(b)) = (a.try_normalize(0.0), b.try_normalize(0.0)) else { return 0.0 };
    2.0 * (a - b).norm().atan2((a + b).norm())
}
