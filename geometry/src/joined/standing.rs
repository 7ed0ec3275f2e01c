//! Ends of spans in which a curve stands still, because control points coincide there.
//!
//! A span of degree `n` whose first `k + 1` control points coincide leaves the first one `P` as
//! `C(t) - P = t^(k+1) M(t)`. So its direction tends to `M(0)`, which leads to the first other control point. By the
//! parameter `r = t^(k+1)` the span is `P + r M(0) + r^((k+2)/(k+1)) M'(0) + ...`: the derivative does not vanish, and
//! the curvature grows as `r^(-k/(k+1))` where `M'(0)` is not along `M(0)`. No change of the parameter makes it finite.
//! A short stretch at the end is therefore replaced, unless the span is a straight line.

use nalgebra::Vector3;

use super::arcs::rounding;
use super::certificate::{Rail, deviation};
use super::shape::{between, leads_on};
use super::spans::{SpanJet, Spans, homogeneous, jet, length, standardise};
use crate::bezier::{Homogeneous, project, restrict};

/// Control points nearer to the end than this part of the size of a span, or than rounding, coincide with it.
const SAME_POINT: f64 = 1e-9;
/// Largest part of a span, by its parameter, that is replaced at an end.
const MOST_REPLACED: f64 = 0.5;
/// Tries to find a stretch whose replacement is within the tolerance.
const MOST_TRIES: usize = 40;
/// Part of the tolerance that a try aims at.
const AIM: f64 = 0.9;

/// A span that stands still at neither end.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct RegularSpan {
    pub points: Vec<Homogeneous>,
    /// Upper bound on the distance between it and the span that was given, in both directions; 0 for a part of it.
    pub deviation: f64,
}

/// The span with replacements where it stands still at an end, in order; none where all its points coincide, and
/// `None` where no replacement is certain to be within the tolerance.
///
/// A replacement is a polynomial of degree 5. It starts in the end in the direction of the span with zero curvature,
/// and takes over tangent and curvature where the span goes on. A straight span becomes a line.
pub(super) fn regular_spans(span: Vec<Homogeneous>, tolerance: f64) -> Option<Vec<RegularSpan>> {
    let points: Vec<Vector3<f64>> = span.iter().map(project).collect();
    let (first, last) = (points[0], points[points.len() - 1]);
    if extent(&points) <= rounding(&[&first, &last]) {
        return Some(Vec::new());
    }
    let [leading, trailing] = coincide(&points);
    if leading == 1 && trailing == 1 {
        return Some(vec![RegularSpan { points: span, deviation: 0.0 }]);
    }
    if is_straight(&points) {
        return Some(vec![RegularSpan { points: vec![homogeneous(&first), homogeneous(&last)], deviation: 0.0 }]);
    }
    let (mut from, mut to) = (0.0, 1.0);
    let (mut before, mut after) = (None, None);
    if leading > 1 {
        let (cut, start) = replacement(&span, leading, tolerance)?;
        (from, before) = (cut, Some(start));
    }
    if trailing > 1 {
        let back: Vec<Homogeneous> = span.iter().rev().copied().collect();
        let (cut, mut end) = replacement(&back, trailing, tolerance)?;
        end.points.reverse();
        (to, after) = (1.0 - cut, Some(end));
    }
    let middle = (from < to).then(|| RegularSpan { points: part(&span, from, to), deviation: 0.0 });
    let mut spans: Vec<RegularSpan> = before.into_iter().chain(middle).chain(after).collect();
    // The end stays where it is, to the last digit.
    if let (Some(end), Some(last)) = (spans.last_mut().and_then(|s| s.points.last_mut()), span.last()) {
        *end = *last;
    }
    Some(spans)
}

/// Largest distance of a control point from the first one.
pub(super) fn extent(points: &[Vector3<f64>]) -> f64 {
    points.iter().map(|p| (p - points[0]).norm()).fold(0.0, f64::max)
}

/// How many control points coincide with the first one, and how many with the last one, itself counted.
pub(super) fn coincide(points: &[Vector3<f64>]) -> [usize; 2] {
    let (first, last) = (points[0], points[points.len() - 1]);
    let same = (SAME_POINT * extent(points)).max(rounding(&[&first, &last]));
    let repeated = |end: Vector3<f64>| move |p: &&Vector3<f64>| (*p - end).norm() <= same;
    [points.iter().take_while(repeated(first)).count(), points.iter().rev().take_while(repeated(last)).count()]
}

/// True where the control points go along a line, to rounding, and not back. So does the span, because it crosses
/// no plane more often than they do.
fn is_straight(points: &[Vector3<f64>]) -> bool {
    let last = points.len() - 1;
    let Some(along) = (points[last] - points[0]).try_normalize(0.0) else { return false };
    let off = |p: &Vector3<f64>| {
        let from = p - points[0];
        (from - along * from.dot(&along)).norm()
    };
    let rounding = rounding(&[&points[0], &points[last]]);
    points.iter().all(|p| off(p) <= rounding) && points.windows(2).all(|w| (w[1] - w[0]).dot(&along) >= -rounding)
}

/// What replaces the start of a span whose first `repeated` control points coincide, and the parameter up to which.
///
/// It leaves towards the first other control point. Beside another place at which the span stands still, that point may be
/// as near as the loop between both, and the next one tells the direction.
fn replacement(span: &[Homogeneous], repeated: usize, tolerance: f64) -> Option<(f64, RegularSpan)> {
    (repeated..span.len()).find_map(|next| replacement_towards(span, next, tolerance))
}

/// The same towards a given control point.
fn replacement_towards(span: &[Homogeneous], next: usize, tolerance: f64) -> Option<(f64, RegularSpan)> {
    let point: Vector3<f64> = project(&span[0]);
    let towards = project(span.get(next)?) - point;
    let start = SpanJet { point, d1: towards, d2: Vector3::zeros() };
    let mut cut = MOST_REPLACED;
    for _ in 0..MOST_TRIES {
        let replaced = part(span, 0.0, cut);
        let half = 0.5 * length(&replaced, 0.0, 1.0);
        let points = between(&[start, jet(&replaced, 1.0)], [half; 2], 0.0);
        let mut factor = 0.5;
        if leads_on(&points) {
            let rounding = rounding(&[&points[0], &points[5]]);
            let points: Vec<Homogeneous> = points.iter().map(homogeneous).collect();
            // In both directions: a tip of the span may be far from a stretch that goes past it.
            let deviation =
                deviation(&points, &halves(&replaced)).max(deviation(&replaced, &halves(&points))) + rounding;
            if deviation <= tolerance {
                return Some((cut, RegularSpan { points, deviation }));
            }
            factor = (AIM * tolerance / deviation).powf(1.0 / (next + 1) as f64);
        }
        cut *= factor.max(0.1).min(0.9);
    }
    None
}

/// Both halves of a span.
fn halves(span: &[Homogeneous]) -> [Rail; 2] {
    [(0.0, 0.5), (0.5, 1.0)].map(|(from, to)| {
        let points = part(span, from, to);
        let mut spans = Spans::default();
        spans.push(&points, length(&points, 0.0, 1.0));
        Rail::new(spans)
    })
}

/// The span between two of its parameters.
pub(super) fn part(span: &[Homogeneous], from: f64, to: f64) -> Vec<Homogeneous> {
    let mut points = span.to_vec();
    if (from, to) != (0.0, 1.0) {
        restrict(&mut points, from, to);
        standardise(&mut points);
    }
    points
}
