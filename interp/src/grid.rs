//! Where along a path the limits are evaluated: its knots, borders within it, and more points where it bends.

use arcfeed_geometry::PosePath;
use nalgebra::Vector3;

use crate::limits::ToolLimits;

/// Neighbouring grid points differ in what the bend allows by no more than this factor (natural logarithm).
const RATIO: f64 = 0.2;
/// Part of the jerk limit that a path between two grid points may need more than its ends say; its middle is in the rows too, so that
/// what is left is far less.
const WRONG: f64 = 0.014;
/// An interval is halved at most this often for the sake of both.
const HALVINGS: u32 = 14;
/// At least so many intervals, so that the arm's own nonlinearity is seen on straight paths.
const LEAST: usize = 100;

/// Increasing arc lengths from 0 to the path's length: `knots` and `breaks` (borders of sections, chord segments), refined where
/// the path bends.
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

    let look = |s: f64| Place::at(path, s, limits);
    let mut out = vec![0.0];
    for pair in merged.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let parts = ((b - a) / length * LEAST as f64).ceil().max(1.0) as usize;
        // Inside the knots, so that one-sided derivatives belong to this interval.
        let inset = close.min(0.25 * (b - a));
        let mut left = Place { s: a, ..look(a + inset) };
        for i in 1..=parts {
            let end = if i == parts { b } else { a + (b - a) * i as f64 / parts as f64 };
            let right = Place { s: end, ..look(end - inset) };
            refine(&look, limits, &left, &right, HALVINGS, &mut out);
            left = right;
        }
    }
    out
}

/// What the path is like at one place.
#[derive(Clone, Copy)]
struct Place {
    s: f64,
    /// Speed that the bend and its change allow, capped at the feed.
    pace: f64,
    /// Third derivative of the tool point.
    third: Vector3<f64>,
}

impl Place {
    fn at(path: &PosePath, s: f64, limits: &ToolLimits) -> Self {
        // Speed at which the bend uses the normal acceleration, or the same acceleration per time constant feed /
        // acceleration by its change.
        let reach = limits.feed / limits.normal_acceleration;
        let jet = path.jet(s);
        let bend = jet.d2.fixed_rows::<3>(0).norm();
        let third = jet.d3.fixed_rows::<3>(0).into_owned();
        let by_bend = (limits.normal_acceleration / bend).sqrt();
        let by_change = (limits.normal_acceleration / reach / third.norm()).cbrt();
        // 0 bend divides to infinity, which the feed caps.
        let pace = by_bend.min(by_change).min(limits.feed).max(1e-9 * limits.feed);
        Self { s, pace, third }
    }
}

fn refine(look: &impl Fn(f64) -> Place, limits: &ToolLimits, a: &Place, b: &Place, halvings: u32, out: &mut Vec<f64>) {
    let m = look(0.5 * (a.s + b.s));
    let fastest = a.pace.max(b.pace).max(m.pace);
    let spread = (fastest / a.pace.min(b.pace).min(m.pace)).ln();
    // Between grid points the third derivative is taken as linear: the jerk by which that is wrong.
    let wrong = (m.third - (a.third + b.third) * 0.5).norm() * m.pace.powi(3);
    if (spread > RATIO || wrong > WRONG * limits.tangential_jerk) && halvings > 0 {
        refine(look, limits, a, &m, halvings - 1, out);
        refine(look, limits, &m, b, halvings - 1, out);
    } else {
        out.push(b.s);
    }
}
