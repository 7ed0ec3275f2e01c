//! An upper bound on the distance of a blend from the path that it replaces.

use std::cell::Cell;

use nalgebra::Vector3;

use super::spans::{SpanJet, Spans, jet};
use crate::bezier::{Homogeneous, restrict};

/// The bound is refined until it is at most this part above a distance that is attained.
const PRECISION: f64 = 0.02;
/// Intervals at the start.
const FIRST_INTERVALS: usize = 8;
/// Most intervals; a bound that is not sharp by then is a bound nevertheless.
const MOST_INTERVALS: usize = 160;
/// Points of a stretch at which the search for the nearest one may begin.
const SAMPLES: usize = 7;
/// Steps of Newton's method towards the nearest point of the path.
const MOST_STEPS: usize = 8;

/// The stretch of path on one side of a joint that a blend replaces.
#[derive(Debug)]
pub(super) struct Rail {
    spans: Spans,
    /// Arc length at the start of each span, and the whole.
    starts: Vec<f64>,
    /// Points at equal distances, where the search for the nearest one may begin.
    samples: [Vector3<f64>; SAMPLES],
}

impl Rail {
    pub fn new(spans: Spans) -> Self {
        let mut starts = vec![0.0];
        let mut at = 0.0;
        for length in spans.lengths() {
            at += length;
            starts.push(at);
        }
        let mut this = Self { spans, starts, samples: [Vector3::zeros(); SAMPLES] };
        this.samples = std::array::from_fn(|i| this.jet(this.sample(i)).point);
        this
    }

    /// Arc length of a sample.
    fn sample(&self, i: usize) -> f64 {
        self.length() * (i as f64 / (SAMPLES - 1) as f64)
    }

    /// Arc length of the stretch.
    pub fn length(&self) -> f64 {
        self.starts[self.spans.len()]
    }

    /// The span that holds `x`, and the parameter on it.
    fn find(&self, x: f64) -> (usize, f64) {
        let span = self.starts[1..self.spans.len()].partition_point(|&start| start <= x);
        let t = (x - self.starts[span]) / self.spans.lengths()[span];
        (span, t.max(0.0).min(1.0))
    }

    /// Derivatives by `x`, which runs through each span as its parameter does.
    fn jet(&self, x: f64) -> SpanJet {
        let (span, t) = self.find(x);
        let (at, width) = (jet(self.spans.get(span), t), self.spans.lengths()[span]);
        SpanJet { point: at.point, d1: at.d1 / width, d2: at.d2 / (width * width) }
    }

    /// A place near the point of the stretch that is nearest to `p`, its point and the distance.
    fn nearest(&self, p: &Vector3<f64>, guess: f64) -> Foot {
        let distance = |q: &Vector3<f64>| (q - p).norm_squared();
        let guess = guess.max(0.0).min(self.length());
        let (mut x, mut least) = (guess, distance(&self.jet(guess).point));
        for (i, sample) in self.samples.iter().enumerate() {
            if distance(sample) < least {
                (x, least) = (self.sample(i), distance(sample));
            }
        }
        let mut best = Foot { x, point: Vector3::zeros(), distance: f64::INFINITY };
        for _ in 0..MOST_STEPS {
            let at = self.jet(x);
            let off = at.point - p;
            if off.norm() < best.distance {
                best = Foot { x, point: at.point, distance: off.norm() };
            }
            let speed = at.d1.norm_squared();
            // Newton's method for the distance, or a projection on the tangent where that would not lead down.
            let slope = speed + off.dot(&at.d2);
            let step = off.dot(&at.d1) / if slope > 0.2 * speed { slope } else { speed };
            let next = (x - step).max(0.0).min(self.length());
            if (next - x).abs() <= 1e-9 * self.length() {
                break;
            }
            x = next;
        }
        best
    }

    /// Largest distance of the hull of the stretch between two feet from the chord between them.
    fn chord_error(&self, a: &Foot, b: &Foot) -> f64 {
        let (from, to) = if a.x <= b.x { (self.find(a.x), self.find(b.x)) } else { (self.find(b.x), self.find(a.x)) };
        let mut largest = 0.0f64;
        for span in from.0..=to.0 {
            let points = self.spans.get(span);
            if points.len() == 2 && from.0 == to.0 {
                continue;
            }
            let t0 = if span == from.0 { from.1 } else { 0.0 };
            let t1 = if span == to.0 { to.1 } else { 1.0 };
            let mut part = points.to_vec();
            restrict(&mut part, t0, t1);
            largest = largest.max(hull_distance(&part, &a.point, &b.point));
        }
        largest
    }
}

/// A point of a stretch, near another point.
#[derive(Debug, Clone, Copy)]
struct Foot {
    x: f64,
    point: Vector3<f64>,
    distance: f64,
}

/// A point of the blend with its feet on both stretches.
#[derive(Debug, Clone, Copy)]
struct Node {
    t: f64,
    feet: [Foot; 2],
}

impl Node {
    fn distance(&self) -> f64 {
        self.feet[0].distance.min(self.feet[1].distance)
    }
}

/// Largest distance of some control points, and so of the curve in their hull, from the segment between two points.
fn hull_distance(points: &[Homogeneous], a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    let ab = b - a;
    let squared = ab.norm_squared();
    let distance = |h: &Homogeneous| {
        let p = Vector3::new(h[0], h[1], h[2]) / h[3] - a;
        let part = if squared > 0.0 { (p.dot(&ab) / squared).max(0.0).min(1.0) } else { 0.0 };
        (p - ab * part).norm()
    };
    points.iter().map(distance).fold(0.0, worse)
}

/// The larger distance; one that is not a number is the worst.
fn worse(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }
}

/// An upper bound on the distance of every point of a span, the blend, from the two stretches, at most a few hundredths
/// above the largest distance where the points of the blend are near their feet.
///
/// On each interval of the parameter the control points of the blend are within some distance of the chord between
/// two points of a stretch, and with them the blend is, because the distance from a segment is convex. The stretch
/// itself passes every point of its chord within the largest distance of its hull from the chord, because it leads
/// continuously from one end to the other. The sum of both distances is a bound, and it falls with the square of
/// the interval.
pub(super) fn deviation(points: &[Homogeneous], rails: &[Rail; 2]) -> f64 {
    let whole = [rails[0].length(), rails[1].length()];
    let node = |t: f64, guess: [f64; 2]| {
        let p = jet(points, t).point;
        Node { t, feet: [rails[0].nearest(&p, guess[0]), rails[1].nearest(&p, guess[1])] }
    };
    let attained = Cell::new(0.0f64);
    // The bound of an interval, and the nodes at its ends.
    let interval = |a: Node, b: Node| {
        attained.set(attained.get().max(a.distance()).max(b.distance()));
        let mut part = points.to_vec();
        restrict(&mut part, a.t, b.t);
        let of = |side: usize| {
            let (p, q) = (&a.feet[side], &b.feet[side]);
            hull_distance(&part, &p.point, &q.point) + rails[side].chord_error(p, q)
        };
        // The other stretch is looked at only where it may be nearer.
        let nearer = usize::from(a.feet[0].distance + b.feet[0].distance > a.feet[1].distance + b.feet[1].distance);
        let bound = of(nearer);
        let good = bound <= attained.get() * (1.0 + PRECISION);
        (if good { bound } else { bound.min(of(1 - nearer)) }, a, b)
    };
    let mut intervals = Vec::with_capacity(4 * FIRST_INTERVALS);
    let mut before = node(0.0, [0.0, 0.0]);
    for i in 1..=FIRST_INTERVALS {
        let t = i as f64 / FIRST_INTERVALS as f64;
        let along = t * (whole[0] + whole[1]);
        let next = node(t, [along, along - whole[0]]);
        intervals.push(interval(before, next));
        before = next;
    }
    loop {
        let largest = (0..intervals.len()).max_by(|&i, &j| intervals[i].0.total_cmp(&intervals[j].0)).unwrap_or(0);
        let (bound, a, b) = intervals[largest];
        if bound <= attained.get() * (1.0 + PRECISION) || intervals.len() >= MOST_INTERVALS {
            return bound;
        }
        let middle = node(0.5 * (a.t + b.t), [0, 1].map(|side| 0.5 * (a.feet[side].x + b.feet[side].x)));
        intervals[largest] = interval(a, middle);
        intervals.push(interval(middle, b));
    }
}
