//! The squared speeds at both ends of an interval that keep all its rows: a convex polygon, clipped
//! row by row.
//!
//! A row divided by a small factor of `u` says nothing reliable about `u`. Here every row is judged
//! in its own unit, at the vertices of the polygon, so that what round-off leaves is of the size of
//! the round-off of its terms.

use crate::row::LimitId;

/// A row `lo <= a u + b x <= hi` over one interval: `u = (y - x) / h2` for squared speeds `x` at
/// its start and `y` at its end.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    pub a: f64,
    pub b: f64,
    pub lo: f64,
    pub hi: f64,
    pub source: LimitId,
}

/// Excess that counts as none, in units of the sum of the magnitudes of the terms.
const ROUND_OFF: f64 = 4.0 * f64::EPSILON;

/// A convex set of pairs `(x, y)` by its vertices in order; a segment or a point where it has no
/// area.
#[derive(Debug, Clone, Default)]
pub(super) struct FeasiblePairs {
    vertices: Vec<[f64; 2]>,
    clipped: Vec<[f64; 2]>,
}

impl FeasiblePairs {
    /// All pairs with `x` and `y` in the given ranges.
    pub fn reset(&mut self, [x0, x1]: [f64; 2], [y0, y1]: [f64; 2]) {
        self.vertices.clear();
        self.vertices.extend([[x0, y0], [x1, y0], [x1, y1], [x0, y1]]);
    }

    /// Leaves the pairs that keep a row; whether there are any.
    pub fn keep(&mut self, line: &Line, h2: f64) -> bool {
        let &Line { b, lo, hi, .. } = line;
        let a = line.a / h2;
        let value = |[x, y]: [f64; 2]| a * (y - x) + b * x;
        // Most rows are kept by all.
        let inside = |at: &[f64; 2]| {
            let value = value(*at);
            (lo <= value) & (value <= hi)
        };
        if self.vertices.iter().all(inside) {
            return !self.vertices.is_empty();
        }
        let round_off =
            |[x, y]: [f64; 2], bound: f64| ROUND_OFF * (a.abs() * (x.abs() + y.abs()) + (b * x).abs() + bound.abs());
        self.clip(|at| (value(at) - hi, round_off(at, hi))) && self.clip(|at| (lo - value(at), round_off(at, lo)))
    }

    /// Leaves what is on the side of a line where the excess is not positive; `excess` also tells
    /// what counts as none.
    fn clip(&mut self, excess: impl Fn([f64; 2]) -> (f64, f64)) -> bool {
        let over = |at| {
            let (excess, round_off) = excess(at);
            // A bound at infinity is kept by every pair.
            if excess <= round_off { excess.min(0.0) } else { excess }
        };
        if self.vertices.iter().all(|&at| over(at) <= 0.0) {
            return !self.vertices.is_empty();
        }
        self.clipped.clear();
        let mut last = match self.vertices.last() {
            Some(&at) => (at, over(at)),
            None => return false,
        };
        for &at in &self.vertices {
            let here = (at, over(at));
            if (here.1 <= 0.0) != (last.1 <= 0.0) {
                let (inside, outside) = if here.1 <= 0.0 { (here, last) } else { (last, here) };
                // No term and no weight is a difference of large numbers: nothing is lost where one
                // end is far away.
                let span = outside.1 - inside.1;
                let (near, far) = (outside.1 / span, -inside.1 / span);
                let between = |i: usize| {
                    let (p, q) = (inside.0[i], outside.0[i]);
                    // An edge along an axis stays one.
                    if p == q { p } else { near * p + far * q }
                };
                self.clipped.push([between(0), between(1)]);
            }
            if here.1 <= 0.0 {
                self.clipped.push(at);
            }
            last = here;
        }
        std::mem::swap(&mut self.vertices, &mut self.clipped);
        !self.vertices.is_empty()
    }

    /// The least and the greatest `x`.
    pub fn range(&self) -> [f64; 2] {
        let widen = |[least, most]: [f64; 2], at: &[f64; 2]| [least.min(at[0]), most.max(at[0])];
        self.vertices.iter().fold([f64::INFINITY, f64::NEG_INFINITY], widen)
    }

    /// The vertices, in order.
    pub fn vertices(&self) -> &[[f64; 2]] {
        &self.vertices
    }
}

/// The greatest `y` beside `x`, on the edges between the given vertices; of an `x` beside them all
/// the nearest one's.
pub(super) fn greatest_beside(vertices: &[[f64; 2]], x: f64) -> Option<f64> {
    // Vertices this close together are at the same place: at the end of an upright edge its upper
    // end counts.
    let round_off = ROUND_OFF * x.abs();
    let mut best = None;
    let mut last = vertices.last()?;
    for at in vertices {
        let [p, q] = if last[0] <= at[0] { [last, at] } else { [at, last] };
        if p[0] <= x + round_off && x <= q[0] + round_off {
            let run = q[0] - p[0];
            let y = if run > round_off {
                let from = (x - p[0]).clamp(0.0, run);
                (run - from) / run * p[1] + from / run * q[1]
            } else {
                p[1].max(q[1])
            };
            best = Some(best.map_or(y, |best: f64| best.max(y)));
        }
        last = at;
    }
    best.or_else(|| {
        let nearer = |p: &&[f64; 2], q: &&[f64; 2]| (p[0] - x).abs().total_cmp(&(q[0] - x).abs());
        vertices.iter().min_by(nearer).map(|at| at[1])
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::Quantity;

    #[test]
    fn a_factor_of_round_off_decides_nothing() {
        // -1e-17 u + x <= 1 beside |u| <= 2: x may go to 1, and u to 2 there.
        let (source, mut pairs) = (LimitId::path(Quantity::Other), FeasiblePairs::default());
        pairs.reset([0.0, 5.0], [0.0, 5.0]);
        assert!(pairs.keep(&Line { a: -1e-17, b: 1.0, lo: -1.0, hi: 1.0, source }, 0.1));
        assert!(pairs.keep(&Line { a: 1.0, b: 0.0, lo: -2.0, hi: 2.0, source }, 0.1));
        let [least, most] = pairs.range();
        assert!(least == 0.0 && (most - 1.0).abs() < 1e-15, "{least} {most}");
        let y = greatest_beside(pairs.vertices(), most).unwrap_or(f64::NAN);
        assert!((y - 1.2).abs() < 1e-14, "{y}");
    }

    #[test]
    fn an_equation_leaves_a_segment() {
        let (source, mut pairs) = (LimitId::path(Quantity::Other), FeasiblePairs::default());
        pairs.reset([0.0, 4.0], [0.0, 4.0]);
        // y = x / 2.
        assert!(pairs.keep(&Line { a: 1.0, b: 0.5, lo: 0.0, hi: 0.0, source }, 1.0));
        assert_eq!(pairs.range(), [0.0, 4.0]);
        assert!((greatest_beside(pairs.vertices(), 3.0).unwrap_or(f64::NAN) - 1.5).abs() < 1e-15);
        assert!(!pairs.keep(&Line { a: 0.0, b: 1.0, lo: 5.0, hi: 6.0, source }, 1.0));
    }
}
