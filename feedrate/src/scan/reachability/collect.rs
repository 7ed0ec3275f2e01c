//! The rows of one interval as lines in `u` and `x`, friction made straight.

use super::Solver;
use crate::constraint::Within;
use crate::lp2::Band;
use crate::problem::{InnerRow, inner_row};
use crate::row::{LimitId, Quantity, Row};
use crate::scan::feasible_pairs::Line;

impl Solver<'_> {
    /// The rows of interval `k`, the set of its end included.
    pub(super) fn collect(&mut self, k: usize) {
        let problem = self.problem;
        let h2 = 2.0 * problem.h(k);
        self.lines.clear();
        let lines = &mut self.lines;
        let w = self.slopes.get(k).copied().unwrap_or(0.0);
        let half = 0.25 * h2 * w;
        for row in problem.rows(k) {
            straight(row, problem.x_max(k), self.near.get(k), |a, b, lo, hi| {
                let shift = a * half;
                lines.push(Line { a, b, lo: lo + shift, hi: hi + shift, source: row.source });
            });
        }
        for row in problem.rows(k + 1) {
            straight(row, problem.x_max(k + 1), self.near.get(k + 1), |a, b, lo, hi| {
                let shift = a * half;
                lines.push(Line { a: a + h2 * b, b, lo: lo - shift, hi: hi - shift, source: row.source });
            });
        }
        if self.between {
            self.collect_between(k, w);
        }
        let [lo, hi] = self.sets[k + 1];
        self.lines.push(Line { a: h2, b: 1.0, lo, hi, source: LimitId::path(Quantity::ControllableSet) });
    }

    /// The conditions between the ends of interval `k`, where `u` is `u_mean + w (s - s_mid)`.
    fn collect_between(&mut self, k: usize, w: f64) {
        let problem = self.problem;
        let h = problem.h(k);
        let half = 0.5 * h * w;
        let lines = &mut self.lines;
        let mut push = |row: InnerRow, within: Within| {
            let at_end = within == Within::End;
            let shift = (row.alpha + if at_end { 0.5 } else { -0.5 } * h * row.beta) * w;
            let a = row.beta + if at_end { 2.0 * h * row.gamma } else { 0.0 };
            lines.push(Line { a, b: row.gamma, lo: row.lo - shift, hi: row.hi - shift, source: row.source });
        };
        for within in [Within::Start, Within::End] {
            problem.inner_rows(k, within).for_each(|row| push(row, within));
        }
        // One straight line for the whole interval, so that what is left is a cubic; its ends are
        // bounded here too.
        let around = self.near.get(k).zip(self.near.get(k + 1)).map(|(p, q)| 0.5 * (p + q));
        let x_max = problem.middle_x_max(k).max(problem.x_max(k)).max(problem.x_max(k + 1));
        for rows in problem.friction_rows(k) {
            straight_through(rows, x_max, around.as_ref(), |rows| {
                for (within, row) in [(Within::Start, rows[0]), (Within::End, rows[2])] {
                    push(inner_row([&rows[0], &rows[1], &rows[2]], h, within), within);
                    let Row { a, b, d, lo, hi, source, .. } = row;
                    push(InnerRow { alpha: 0.0, beta: a, gamma: b, lo: lo - d, hi: hi - d, source }, within);
                }
            });
        }
        let source = problem.speed_bound(k).source;
        for [of_start, of_middle, of_end] in problem.speed_rows(k) {
            // x_k, x_k + h (u_mean - h w / 2) and x_k + 2 h u_mean.
            let (a, b) = (h * (of_middle + 2.0 * of_end), of_start + of_middle + of_end);
            if b > 0.0 {
                lines.push(Line { a, b, lo: f64::NEG_INFINITY, hi: 1.0 + of_middle * h * half, source });
            }
        }
        if w != 0.0 {
            // x stays positive inside.
            let source = LimitId::path(Quantity::ControllableSet);
            lines.push(Line { a: h, b: 1.0, lo: h * half, hi: f64::INFINITY, source });
        }
    }

    /// The lines divided by their factor of `u`; those without one bound `x` alone.
    pub(super) fn divide(&mut self, x_max: f64, h2: f64) -> (f64, f64) {
        let (mut least, mut most) = (0.0_f64, x_max);
        self.bands.clear();
        for (id, line) in self.lines.iter().enumerate() {
            let inverse = 1.0 / line.a;
            let (p, lo, hi) = (-line.b * inverse, line.lo * inverse, line.hi * inverse);
            // As u is of the size of x / h2, a factor of u this small is lost beside that of x.
            if p.abs() * h2 < 1e14 && inverse.is_finite() {
                let (lo, hi) = if inverse > 0.0 { (lo, hi) } else { (hi, lo) };
                self.bands.push(Band { p, lo, hi, id });
            } else if line.b > 0.0 {
                (least, most) = (least.max(line.lo / line.b), most.min(line.hi / line.b));
            } else if line.b < 0.0 {
                (least, most) = (least.max(line.hi / line.b), most.min(line.lo / line.b));
            } else if !(line.lo <= 0.0 && 0.0 <= line.hi) {
                most = f64::NEG_INFINITY;
            }
        }
        (least, most)
    }
}

/// Straight lines above and below `sqrt(x)` up to `x_max`: slope and value at 0 of a tangent near a
/// place, slope of a chord.
fn around_root(x_max: f64, near: Option<&f64>) -> ([f64; 2], f64) {
    // Any place to touch is safe; without a cap there is no scale to choose one by.
    let default = if x_max < f64::INFINITY { 0.25 * x_max } else { 1.0 };
    let touches = near.copied().filter(|x| x.is_finite()).unwrap_or(default).max(1e-9 * default);
    ([0.5 / touches.sqrt(), 0.5 * touches.sqrt()], 1.0 / x_max.sqrt())
}

/// Passes a row on as `lo <= a u + b x <= hi`. Friction `c sqrt(x)` is bounded by a tangent from
/// above and, up to `x_max`, by a chord from below, so each side becomes a row of its own that is
/// inside the true one.
fn straight(row: &Row, x_max: f64, near: Option<&f64>, mut push: impl FnMut(f64, f64, f64, f64)) {
    let Row { a, b, c, d, lo, hi, .. } = *row;
    let (lo, hi) = (lo - d, hi - d);
    if c == 0.0 || x_max == 0.0 {
        return push(a, b, lo, hi);
    }
    let ([slope, base], chord) = around_root(x_max, near);
    // Upper side: c sqrt(x) from above; lower side: from below.
    let (above, below) = ((slope, base), (chord, 0.0));
    let ((up_b, up_d), (down_b, down_d)) = if c > 0.0 { (above, below) } else { (below, above) };
    push(a, b + c * up_b, f64::NEG_INFINITY, hi - c * up_d);
    push(a, b + c * down_b, lo - c * down_d, f64::INFINITY);
}

/// Passes on the rows at the start, in the middle and at the end of an interval with straight lines
/// in place of friction, the same at all three: once for the upper and once for the lower side.
fn straight_through(rows: [&Row; 3], x_max: f64, near: Option<&f64>, mut push: impl FnMut([Row; 3])) {
    let ([slope, base], chord) = around_root(x_max, near);
    let c = rows.map(|row| row.c);
    // Bernstein coefficients, which bound the factor of friction all over the interval.
    let hull = [c[0], 2.0 * c[1] - 0.5 * (c[0] + c[2]), c[2]];
    let (least, most) = hull.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(p, q), &c| (c.min(p), c.max(q)));
    let changes = least < 0.0 && most > 0.0;
    for (upper, bound) in [(true, most), (false, least)] {
        let above = changes || (most > 0.0) == upper;
        push(std::array::from_fn(|i| {
            // Where the factor changes its sign it is small: its hull will do.
            let c = if changes { bound } else { c[i] };
            let (b, d) = if x_max == 0.0 {
                (0.0, 0.0)
            } else if above {
                (c * slope, c * base)
            } else {
                (c * chord, 0.0)
            };
            let (lo, hi) = if upper { (f64::NEG_INFINITY, rows[i].hi) } else { (rows[i].lo, f64::INFINITY) };
            Row { b: rows[i].b + b, c: 0.0, d: rows[i].d + d, lo, hi, ..*rows[i] }
        }));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::quadratic;

    /// Between the ends of an interval too the lines are on the safe side of friction, whatever sign its factor has where.
    #[test]
    fn straight_friction_is_on_the_safe_side_all_over_an_interval() {
        const X_MAX: f64 = 4.0;
        for factors in [
            [0.2, -0.3, 0.1],
            [-0.2, 0.3, 0.1],
            [0.3, -0.05, 0.3],
            [0.5, 0.4, 0.7],
            [-0.5, -0.4, -0.7],
            [0.0, 0.4, 0.0],
        ] {
            let source = LimitId::joint(Quantity::JointTorque, 0);
            let rows = factors.map(|c| Row { c, ..Row::symmetric(1.0, 0.5, 2.0, source) });
            let mut sides = [0, 0];
            straight_through([&rows[0], &rows[1], &rows[2]], X_MAX, None, |lines| {
                let upper = lines[0].hi.is_finite();
                sides[usize::from(upper)] += 1;
                for (fraction, n) in (0..=20).flat_map(|i| (0..=40).map(move |n| (f64::from(i) / 20.0, n))) {
                    let x = X_MAX * f64::from(n) / 40.0;
                    let mix = quadratic(fraction);
                    let of = |value: fn(&Row) -> f64| mix(value(&lines[0]), value(&lines[1]), value(&lines[2]));
                    let line = of(|row| row.b) * x + of(|row| row.d);
                    let with_friction = 0.5 * x + mix(factors[0], factors[1], factors[2]) * x.sqrt();
                    let beyond = if upper { with_friction - line } else { line - with_friction };
                    assert!(beyond < 1e-12, "{factors:?} at {fraction}, x = {x}: {line} for {with_friction}");
                }
            });
            assert_eq!(sides, [1, 1]);
        }
    }
}
