//! Conditions inside an interval, by Bernstein coefficients and by interpolation of the rows at its
//! ends and in its middle.

use super::bound_table::BoundTable;
use super::feed_problem::FeedProblem;
use crate::constraint::Within;
use crate::row::{JerkRow, LimitId, Row};

/// `lo <= alpha w + beta u + gamma x <= hi` at one end of an interval on which `w = du/ds` is
/// constant.
#[derive(Debug, Clone, Copy)]
pub(crate) struct InnerRow {
    pub alpha: f64,
    pub beta: f64,
    pub gamma: f64,
    pub lo: f64,
    pub hi: f64,
    pub source: LimitId,
}

impl InnerRow {
    /// Returns true if it holds whatever the motion.
    pub fn is_nothing(&self) -> bool {
        self.alpha == 0.0 && self.beta == 0.0 && self.gamma == 0.0 && self.lo <= 0.0 && 0.0 <= self.hi
    }
}

/// Conditions inside an interval, by its Bernstein coefficients.
impl FeedProblem {
    /// Next to one end of interval `k` the inner Bernstein coefficient of every row that is a cubic
    /// there: its value at that end and a third of its slope. Coefficients of rows are interpolated
    /// through both ends and the middle, exactly so on a piecewise cubic path. Rows with friction
    /// are left out.
    pub(crate) fn inner_rows(&self, k: usize, within: Within) -> impl Iterator<Item = InnerRow> + '_ {
        let h = self.h(k);
        let straight = self.through(k).filter(|[p, _, q]| p.c == 0.0 && q.c == 0.0);
        straight.map(move |rows| inner_row(rows, h, within))
    }

    /// The rows with friction at the start, in the middle and at the end of interval `k`.
    pub(crate) fn friction_rows(&self, k: usize) -> impl Iterator<Item = [&Row; 3]> {
        self.through(k).filter(|rows| rows.iter().any(|row| row.c != 0.0))
    }

    /// Every row at the start, in the middle and at the end of interval `k`.
    pub(crate) fn through(&self, k: usize) -> impl Iterator<Item = [&Row; 3]> {
        let (near, middle, far) = (self.rows(k), self.middle_rows(k), self.rows(k + 1));
        middle.iter().enumerate().filter_map(move |(j, m)| {
            let p = matching(near, middle, j, false).map(|j| &near[j])?;
            let q = matching(far, middle, j, true).map(|j| &far[j])?;
            Some([p, m, q])
        })
    }

    /// Weights of the three Bernstein coefficients of `x(s)` on interval `k` whose sums must not
    /// exceed 1: the inner coefficients of its product, of degree six, with the bound on squared
    /// axis speeds.
    pub(crate) fn speed_rows(&self, k: usize) -> [[f64; 3]; 5] {
        let p = &self.speed_bounds[k].coefficients;
        // C(4, i - j) C(2, j) / C(6, i)
        [
            [4.0 * p[1] / 6.0, 2.0 * p[0] / 6.0, 0.0],
            [6.0 * p[2] / 15.0, 8.0 * p[1] / 15.0, p[0] / 15.0],
            [4.0 * p[3] / 20.0, 12.0 * p[2] / 20.0, 4.0 * p[1] / 20.0],
            [p[4] / 15.0, 8.0 * p[3] / 15.0, 6.0 * p[2] / 15.0],
            [0.0, 2.0 * p[4] / 6.0, 4.0 * p[3] / 6.0],
        ]
    }
}

/// The inner Bernstein coefficient next to one end of a row without friction that is a cubic on an
/// interval of length `h`.
pub(crate) fn inner_row([p, m, q]: [&Row; 3], h: f64, within: Within) -> InnerRow {
    // At the end everything runs backwards.
    let (row, other, third) = if within == Within::End { (q, p, -h / 3.0) } else { (p, q, h / 3.0) };
    let slope = |this: f64, middle: f64, other: f64| (4.0 * middle - 3.0 * this - other) / 3.0;
    let d = row.d + slope(row.d, m.d, other.d);
    InnerRow {
        alpha: third * row.a,
        beta: row.a + slope(row.a, m.a, other.a) + 2.0 * third * row.b,
        gamma: row.b + slope(row.b, m.b, other.b),
        lo: row.lo - d,
        hi: row.hi - d,
        source: row.source,
    }
}

impl FeedProblem {
    /// Returns true if a cap of another origin than axis speeds, and known at places alone, is the
    /// least in the middle of interval `k`.
    pub(crate) fn is_capped_within(&self, k: usize) -> bool {
        let largest = self.speed_bounds[k].coefficients.iter().copied().fold(0.0, f64::max);
        self.middle_x_max(k) * largest < 0.999
    }
}

/// Rows by quadratic interpolation through an interval.
impl FeedProblem {
    /// A problem without grid points and with the end speeds of this one, with capacity for `places` points.
    pub(super) fn emptied(&self, places: usize) -> Self {
        Self {
            s: Vec::with_capacity(places),
            points: self.points.emptied(places),
            middles: self.middles.emptied(places),
            speed_bounds: Vec::with_capacity(places),
            jerk_rows: Vec::with_capacity(3 * places * self.jerk_rows_per_place),
            bounds: BoundTable::default(),
            ..*self
        }
    }

    /// The problem with some intervals split at fractions (increasing, inside 0..1) of their
    /// length.
    pub(crate) fn split(&self, cuts: &[(usize, Vec<f64>)]) -> Self {
        let n = self.intervals();
        let places = n + 1 + cuts.iter().map(|(_, fractions)| fractions.len()).sum::<usize>();
        let mut new = self.emptied(places);
        let mut cuts = cuts.iter().peekable();
        for k in 0..n {
            new.s.push(self.s[k]);
            new.points.push(self.rows(k), self.x_max(k), self.points.source(k));
            let Some((_, fractions)) = cuts.next_if(|(at, _)| *at == k) else {
                new.middles.push(self.middle_rows(k), self.middle_x_max(k), self.middles.source(k));
                new.speed_bounds.push(self.speed_bounds[k]);
                let rows = 3 * self.jerk_rows_per_place;
                new.jerk_rows.extend_from_slice(&self.jerk_rows[k * rows..(k + 1) * rows]);
                continue;
            };
            // The least of three caps and the greatest of the coefficients hold in every part.
            let x_max = self.middle_x_max(k).min(if k > 0 { self.x_max(k) } else { f64::INFINITY });
            let x_max = x_max.min(if k + 1 < n { self.x_max(k + 1) } else { f64::INFINITY });
            let x_max = if x_max > 0.0 { x_max } else { self.middle_x_max(k) };
            let mut bound = self.speed_bounds[k];
            bound.coefficients = [bound.coefficients.iter().copied().fold(0.0, f64::max); 5];
            let ends = |i: usize| if i == 0 { 0.0 } else { fractions[i - 1] };
            for i in 0..=fractions.len() {
                let (from, to) = (ends(i), fractions.get(i).copied().unwrap_or(1.0));
                if i > 0 {
                    new.s.push(self.s[k] + from * self.h(k));
                    new.points.push(&self.rows_within(k, from), x_max, self.middles.source(k));
                }
                new.middles.push(&self.rows_within(k, 0.5 * (from + to)), x_max, self.middles.source(k));
                new.speed_bounds.push(bound);
                for fraction in [from, 0.5 * (from + to), to] {
                    self.jerk_rows_within(k, fraction, &mut new.jerk_rows);
                }
            }
        }
        new.s.push(self.s[n]);
        new.points.push(self.rows(n), self.x_max(n), self.points.source(n));
        new
    }

    fn rows_within(&self, k: usize, fraction: f64) -> Vec<Row> {
        let mix = quadratic(fraction);
        let (near, middle, far) = (self.rows(k), self.middle_rows(k), self.rows(k + 1));
        let between = |(j, m): (usize, &Row)| {
            let ends = matching(near, middle, j, false).zip(matching(far, middle, j, true));
            let (p, q) = ends.map_or((m, m), |(p, q)| (&near[p], &far[q]));
            Row { a: mix(p.a, m.a, q.a), b: mix(p.b, m.b, q.b), c: mix(p.c, m.c, q.c), d: mix(p.d, m.d, q.d), ..*m }
        };
        middle.iter().enumerate().map(between).collect()
    }

    fn jerk_rows_within(&self, k: usize, fraction: f64, out: &mut Vec<JerkRow>) {
        let mix = quadratic(fraction);
        let [near, middle, far] = [Within::Start, Within::Middle, Within::End].map(|within| self.jerk_rows(k, within));
        out.extend(middle.iter().zip(near.iter().zip(far)).map(|(m, (p, q))| JerkRow {
            alpha: mix(p.alpha, m.alpha, q.alpha),
            beta: mix(p.beta, m.beta, q.beta),
            gamma: mix(p.gamma, m.gamma, q.gamma),
            ..*m
        }));
    }
}

/// The quadratic through values at 0, 1/2 and 1, at `fraction`.
pub(crate) fn quadratic(fraction: f64) -> impl Fn(f64, f64, f64) -> f64 {
    let f = fraction;
    let weights = [(1.0 - f) * (1.0 - 2.0 * f), 4.0 * f * (1.0 - f), f * (2.0 * f - 1.0)];
    move |p, m, q| weights[0] * p + weights[1] * m + weights[2] * q
}

/// The index of the row at an end of an interval that belongs to row `j` of its middle: the same
/// index, or, where a jump doubles the rows of a point (those after it come first), the one that
/// comes at the same place among the rows of its source.
pub(crate) fn matching(rows: &[Row], middle: &[Row], j: usize, last: bool) -> Option<usize> {
    if rows.len() == middle.len() {
        return Some(j);
    }
    let source = middle[j].source;
    let same = |row: &&Row| row.source == source;
    let of_source = |(_, row): &(usize, &Row)| row.source == source;
    if last {
        let later = middle[j + 1..].iter().filter(same).count();
        rows.iter().enumerate().rev().filter(of_source).nth(later).map(|(i, _)| i)
    } else {
        let earlier = middle[..j].iter().filter(same).count();
        rows.iter().enumerate().filter(of_source).nth(earlier).map(|(i, _)| i)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test fails by panic")]
mod tests {
    use super::*;
    use crate::constraint::SpeedCap;
    use crate::row::Quantity;

    /// The parts of a split interval have the least of the caps in its middle, which is the mean of both ends, and at the ends
    /// that are no ends of the path. The other intervals keep theirs.
    #[test]
    fn parts_of_an_interval_have_the_least_cap_of_it() {
        let cap = SpeedCap::new(&[4.0, 6.0, 3.0, 8.0, 7.0], Quantity::NormalAcceleration).unwrap();
        let whole = FeedProblem::between_points(&[0.0, 1.0, 2.0, 3.0, 4.0], &[&cap]).unwrap();
        let means = [26.0, 22.5, 36.5, 56.5];
        for (k, least) in [26.0, 9.0, 9.0, 56.5].into_iter().enumerate() {
            let split = whole.split(&[(k, vec![0.5])]);
            assert_eq!(split.grid()[k + 1], k as f64 + 0.5);
            let caps = [split.x_max(k + 1), split.middle_x_max(k), split.middle_x_max(k + 1)];
            assert_eq!(caps, [least; 3], "interval {k}");
            for other in (0..4).filter(|other| *other != k) {
                let at = other + usize::from(other > k);
                assert_eq!(split.middle_x_max(at), means[other], "interval {other} beside {k}");
            }
        }
    }

    /// Two rows of one source and one of another: doubled at a jump, each finds its own.
    #[test]
    fn rows_of_one_source_keep_their_order_where_a_jump_doubles_them() {
        let [one, other] = [0, 1].map(|joint| LimitId::joint(Quantity::JointAcceleration, joint));
        let row = |a: f64, source| Row::symmetric(a, 0.0, 1.0, source);
        let middle = [row(1.0, one), row(2.0, one), row(3.0, other)];
        let after = [row(10.0, one), row(20.0, one), row(30.0, other)];
        let before = [row(11.0, one), row(21.0, one), row(31.0, other)];
        let point: Vec<Row> = after.iter().chain(&before).copied().collect();
        let found = |last: bool| [0, 1, 2].map(|j| matching(&point, &middle, j, last).map(|i| point[i].a));
        assert_eq!(found(false), [Some(10.0), Some(20.0), Some(30.0)]);
        assert_eq!(found(true), [Some(11.0), Some(21.0), Some(31.0)]);
    }
}
