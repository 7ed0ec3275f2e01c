//! Corners of a polyline, told apart from the angles that rounded coordinates cause.

use std::collections::VecDeque;

use nalgebra::SVector;

use super::polyline::{Vertex, angle, between};

/// Finds the corners of a polyline as its vertices arrive.
///
/// The angle at a vertex is measured between chords that leave it at a distance on both sides. On a smooth curve
/// it is in proportion to the distance, and at a corner it stays. Twice the angle at half the distance less the
/// angle at the full distance is therefore the jump of the direction, whatever the curvature on both sides.
///
/// The full distance is `8 tolerance / angle`: legs of this length that meet at this angle leave the circle
/// through their ends and the vertex by the tolerance. Of the vertices nearer to each other than half the
/// distance at most one is a corner.
#[derive(Debug, Clone)]
pub(super) struct CornerFinder<const D: usize> {
    least_angle: f64,
    reach: f64,
    vertices: VecDeque<Vertex<D>>,
    /// Number of vertices that left the front of the queue.
    gone: usize,
    /// Number of vertices that are handed on.
    released: usize,
    /// Number of vertices that are judged.
    judged: usize,
    /// The corner that the vertices up to half the distance behind it may still replace, with its score.
    best: Option<(usize, f64)>,
    finished: bool,
}

impl<const D: usize> CornerFinder<D> {
    pub fn new(tolerance: f64, least_angle: f64) -> Self {
        let reach = 8.0 * tolerance / least_angle;
        let (vertices, best) = (VecDeque::new(), None);
        Self { least_angle, reach, vertices, gone: 0, released: 0, judged: 0, best, finished: false }
    }

    pub fn last(&self) -> Option<&Vertex<D>> {
        self.vertices.back()
    }

    pub fn push(&mut self, vertex: Vertex<D>) {
        self.vertices.push_back(vertex);
    }

    /// No vertex follows.
    pub fn finish(&mut self) {
        self.finished = true;
    }

    /// The next vertex, and whether it is a corner; `None` until more vertices are known.
    pub fn pop(&mut self) -> Option<(Vertex<D>, bool)> {
        let count = self.gone + self.vertices.len();
        loop {
            // Confirmed corners and vertices before them are free to go.
            let confirmed = self.best.is_some_and(|(corner, _)| {
                let ahead = if self.judged < count { self.vertex(self.judged).at } else { f64::INFINITY };
                ahead - self.vertex(corner).at > 0.5 * self.reach && (self.judged < count || self.finished)
            });
            let free = self.best.map_or(self.judged, |(corner, _)| corner);
            if self.released < free || (confirmed && self.released == free) {
                let corner = self.released == free;
                if corner {
                    self.best = None;
                }
                let vertex = *self.vertex(self.released);
                self.released += 1;
                return Some((vertex, corner));
            }
            if self.judged == count || !(self.finished || self.sees_far_enough()) {
                return None;
            }
            self.judge();
            self.drop_passed();
        }
    }

    fn vertex(&self, number: usize) -> &Vertex<D> {
        &self.vertices[number - self.gone]
    }

    fn sees_far_enough(&self) -> bool {
        self.vertices.back().is_some_and(|last| last.at - self.vertex(self.judged).at >= self.reach)
    }

    fn judge(&mut self) {
        let number = self.judged;
        self.judged += 1;
        if let Some(score) = self.score(number)
            && self.best.is_none_or(|(_, best)| score > best)
        {
            self.best = Some((number, score));
        }
    }

    /// How much of a corner the vertex is, or `None` where it is none.
    fn score(&self, number: usize) -> Option<f64> {
        let i = number - self.gone;
        if i == 0 || i + 1 == self.vertices.len() {
            return None;
        }
        let (back, ahead) = self.legs(i, 0.5 * self.reach);
        let lengths = (back.norm_squared() * ahead.norm_squared()).sqrt();
        if back.dot(&ahead) > self.least_angle.cos() * lengths {
            return None;
        }
        let turn = |(back, ahead): (SVector<f64, D>, SVector<f64, D>)| angle(&back, &ahead);
        let half = angle(&back, &ahead);
        let jump = 2.0 * half - turn(self.legs(i, self.reach));
        // The same at half the distance, where another corner has no effect; with less accuracy.
        let near = 2.0 * turn(self.legs(i, 0.25 * self.reach)) - half;
        // Near the tip of a reversal the jump is the same as at the tip, and the angle close by is not.
        let close = turn(self.legs(i, 0.125 * self.reach)) + 0.1 * turn(self.legs(i, 0.0));
        (jump > self.least_angle && near > 0.5 * self.least_angle).then_some(jump + close)
    }

    /// Chords to the vertex from `distance` before it and from the vertex to `distance` behind it, along the
    /// polyline, but no shorter than to the next vertices.
    fn legs(&self, i: usize, distance: f64) -> (SVector<f64, D>, SVector<f64, D>) {
        let v = &self.vertices;
        let (here, from, to) = (&v[i], v[i].at - distance, v[i].at + distance);
        let back = if v[i - 1].at > from {
            let j = v.partition_point(|w| w.at <= from);
            if j == 0 { v[0].point } else { between(&v[j - 1], &v[j], from) }
        } else {
            v[i - 1].point
        };
        let ahead = if v[i + 1].at < to {
            let j = v.partition_point(|w| w.at < to);
            if j == v.len() { v[j - 1].point } else { between(&v[j - 1], &v[j], to) }
        } else {
            v[i + 1].point
        };
        (here.point - back, ahead - here.point)
    }

    /// Drops vertices that are handed on and that no leg reaches any more.
    fn drop_passed(&mut self) {
        let Some(next) = self.vertices.get(self.judged - self.gone).map(|v| v.at) else { return };
        while self.gone < self.released && self.vertices.get(1).is_some_and(|v| v.at < next - self.reach) {
            self.vertices.pop_front();
            self.gone += 1;
        }
    }
}
