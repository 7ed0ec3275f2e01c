//! Where along a path the limits are evaluated: its knots, its chord segments, and more points where it bends.

use arcfeed_geometry::PosePath;

use crate::limits::ToolLimits;

/// Neighbouring grid points differ in what the bend allows by no more than this factor (natural logarithm).
const RATIO: f64 = 0.2;
/// An interval is halved at most this often for the sake of the ratio.
const HALVINGS: u32 = 14;
/// At least so many intervals, so that the arm's own nonlinearity is seen on straight paths.
const LEAST: usize = 100;

/// Increasing arc lengths from 0 to the path's length: `knots` and `breaks` (chord segments), refined where the path
/// bends.
///
/// The measure is the speed that curvature and its derivative allow, capped at the feed: where the feed is the limit
/// anyway no points are spent.
pub(crate) fn build(path: &PosePath, knots: &[f64], breaks: &[f64], limits: &ToolLimits) -> Vec<f64> {
    let length = path.length();
    let mut base: Vec<f64> = knots.iter().chain(breaks).copied().filter(|s| *s >= 0.0 && *s <= length).collect();
    base.sort_by(f64::total_cmp);
    // Keep knots exactly; drop breaks that stand next to one.
    let close = 1e-9 * length;
    let mut merged: Vec<f64> = Vec::with_capacity(base.len());
    for s in base {
        match merged.last_mut() {
            Some(last) if s - *last <= close => {
                if knots.binary_search_by(|k| k.total_cmp(&s)).is_ok() {
                    *last = s;
                }
            }
            _ => merged.push(s),
        }
    }

    // Speed at which the bend uses the normal acceleration, or the same acceleration per time constant feed / acceleration
    // by its change.
    let reach = limits.feed / limits.normal_acceleration;
    let pace = |s: f64| {
        let jet = path.jet(s);
        let bend = jet.d2.fixed_rows::<3>(0).norm();
        let change = jet.d3.fixed_rows::<3>(0).norm();
        let by_bend = (limits.normal_acceleration / bend).sqrt();
        let by_change = (limits.normal_acceleration / reach / change).cbrt();
        // 0 bend divides to infinity, which the feed caps.
        by_bend.min(by_change).min(limits.feed).max(1e-9 * limits.feed)
    };
    let mut out = vec![0.0];
    for pair in merged.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let parts = ((b - a) / length * LEAST as f64).ceil().max(1.0) as usize;
        let mut left = (a, pace(a + close.min(0.25 * (b - a))));
        for i in 1..=parts {
            let end = if i == parts { b } else { a + (b - a) * i as f64 / parts as f64 };
            // Inside the knots, so that one-sided derivatives belong to this interval.
            let right = (end, pace(end - close.min(0.25 * (b - a))));
            refine(&pace, left, right, HALVINGS, &mut out);
            left = right;
        }
    }
    out
}

fn refine(pace: &impl Fn(f64) -> f64, a: (f64, f64), b: (f64, f64), halvings: u32, out: &mut Vec<f64>) {
    let s = 0.5 * (a.0 + b.0);
    let m = (s, pace(s));
    let spread = (a.1.max(b.1).max(m.1) / a.1.min(b.1).min(m.1)).ln();
    if spread > RATIO && halvings > 0 {
        refine(pace, a, m, halvings - 1, out);
        refine(pace, m, b, halvings - 1, out);
    } else {
        out.push(b.0);
    }
}
