//! Bounds over a whole interval from rows at three places of it.

use super::{PathConstraint, Place, RowSink, Within};
use crate::row::{IntervalBound, JerkRow, LimitId, Quantity, Row};

/// Least and greatest Bernstein coefficient of the quadratic through values at both ends and in the middle, which enclose it.
fn hull([p, m, q]: [f64; 3]) -> [f64; 2] {
    let inner = 2.0 * m - 0.5 * (p + q);
    [p.min(q).min(inner), p.max(q).max(inner)]
}

fn magnitude(values: [f64; 3]) -> f64 {
    let [least, most] = hull(values);
    most.max(-least)
}

/// Appends the bounds of a constraint on interval `k` of length `h`: of its caps the least, of the coefficients of its rows the hulls.
pub(super) fn of_rows<C: PathConstraint + ?Sized>(constraint: &C, k: usize, h: f64, out: &mut Vec<IntervalBound>) {
    let [near, middle, far] = [Place::Point(k), Place::Middle { k, h }, Place::Point(k + 1)].map(|place| {
        let mut rows = Vec::new();
        let source = LimitId::path(Quantity::Other);
        let mut sink = RowSink { rows: &mut rows, sound: true, x_max: f64::INFINITY, source };
        constraint.rows(place, &mut sink);
        // A cap of 0 is a stop, which is made anyway.
        if sink.x_max > 0.0 && sink.x_max.is_finite() {
            out.push(IntervalBound::Speed { most: sink.x_max.sqrt(), source: sink.source });
        }
        rows
    });
    constraint.axis_speeds(k, h, &mut |speeds, limit, source| {
        let most = speeds.iter().fold(0.0, |most: f64, speed| most.max(speed.abs()));
        if most > 0.0 {
            out.push(IntervalBound::Speed { most: limit / most, source });
        }
    });
    for m in &middle {
        // At a point there may be rows of both sides.
        let same = |rows: &[Row]| rows.iter().filter(|row| row.source == m.source).copied().collect::<Vec<_>>();
        for p in same(&near) {
            for q in same(&far) {
                out.push(of_three(&p, m, &q));
            }
        }
    }
    let [near, middle, far] = [Within::Start, Within::Middle, Within::End].map(|within| {
        let mut rows: Vec<JerkRow> = Vec::new();
        constraint.jerk_rows(k, h, within, &mut rows);
        rows
    });
    out.extend(middle.iter().zip(near.iter().zip(&far)).map(|(m, (p, q))| {
        let most = |of: fn(&JerkRow) -> f64| magnitude([of(p), of(m), of(q)]);
        let (alpha, beta, gamma) = (most(|row| row.alpha), most(|row| row.beta), most(|row| row.gamma));
        IntervalBound::Jerk { alpha, beta, gamma, step: 0.0, limit: m.limit, source: m.source }
    }));
}

fn of_three(p: &Row, m: &Row, q: &Row) -> IntervalBound {
    let three = |of: fn(&Row) -> f64| [of(p), of(m), of(q)];
    let [least, most] = hull(three(|row| row.d));
    // What is left above and below what remains at rest.
    let limit = (m.hi - most).min(least - m.lo);
    let [a, b, c] = [magnitude(three(|row| row.a)), magnitude(three(|row| row.b)), magnitude(three(|row| row.c))];
    IntervalBound::Acceleration { a, b, c, rest: 0.0, limit, source: m.source }
}
