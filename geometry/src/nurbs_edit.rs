//! Other forms of the same curve: knot insertion, splitting, degree elevation, Bezier pieces; and moving it as a whole.

use nalgebra::{Isometry3, SVector};

use crate::bezier::{Homogeneous, RationalBezier, lerp, project};
use crate::chord::check_positive;
use crate::curve::Curve;
use crate::error::GeometryError;
use crate::nurbs::NurbsCurve;
use crate::span::bezier_points;

impl<const D: usize> NurbsCurve<D> {
    /// The same curve with the knot `u` inserted `times` times (Boehm's algorithm; Liu et al. 2023, eqs. 4-7). A value
    /// that counts as a knot of the curve (see [`KnotVector`](crate::KnotVector)) is inserted as that knot.
    ///
    /// # Errors
    /// Fails when `u` lies outside the domain, or would stand there more than degree times.
    pub fn with_knot(&self, u: f64, times: usize) -> Result<Self, GeometryError> {
        let u = self.knots().snapped(u);
        self.check_insertion(u, times)?;
        let (mut knots, mut points) = (self.knots().as_slice().to_vec(), self.homogeneous().to_vec());
        for _ in 0..times {
            insert(&mut knots, &mut points, self.degree(), u);
        }
        self.rebuilt(self.degree(), &points, knots)
    }

    /// The same curve with several knots inserted, in any order; a value given twice is inserted twice.
    ///
    /// # Errors
    /// As [`NurbsCurve::with_knot`], for the smallest value that breaks a rule.
    pub fn refined(&self, new_knots: &[f64]) -> Result<Self, GeometryError> {
        let mut sorted: Vec<f64> = new_knots.iter().map(|&u| self.knots().snapped(u)).collect();
        sorted.sort_by(f64::total_cmp);
        for run in sorted.chunk_by(|a, b| a == b) {
            self.check_insertion(run[0], run.len())?;
        }
        let (mut knots, mut points) = (self.knots().as_slice().to_vec(), self.homogeneous().to_vec());
        for &u in &sorted {
            insert(&mut knots, &mut points, self.degree(), u);
        }
        self.rebuilt(self.degree(), &points, knots)
    }

    /// The parts before and after `u`, with the parameters they had; both are clamped at `u`.
    ///
    /// # Errors
    /// Fails when `u` does not lie strictly inside the domain.
    pub fn split(&self, u: f64) -> Result<(Self, Self), GeometryError> {
        let (start, end) = self.domain();
        let u = self.knots().snapped(u);
        if !(start < u && u < end) {
            return Err(GeometryError::OutsideDomain { value: u, start, end });
        }
        let p = self.degree();
        let (knots, points) = self.with_full_knot(u);
        let first = knots.partition_point(|&k| k < u);
        let after = knots.partition_point(|&k| k <= u);
        let mut left = knots[..first].to_vec();
        left.extend(std::iter::repeat_n(u, p + 1));
        let mut right = vec![u; p + 1];
        right.extend_from_slice(&knots[after..]);
        // With the knot p times the point at u belongs to both sides; with p + 1 times each side has its own.
        let shared = after - first == p;
        let right_points = if shared { &points[first - 1..] } else { &points[first..] };
        Ok((self.rebuilt(p, &points[..first], left)?, self.rebuilt(p, right_points, right)?))
    }

    /// The same curve with first and last knot standing degree + 1 times, so that it starts and ends in its first and
    /// last control point. A clamped curve is returned as it is.
    ///
    /// # Errors
    /// Only where rounding spoils a curve that was on the edge of what [`NurbsCurve::new`] accepts.
    pub fn clamped(&self) -> Result<Self, GeometryError> {
        if self.knots().is_clamped() {
            return Ok(self.clone());
        }
        let p = self.degree();
        let (start, end) = self.domain();
        let (mut knots, mut points) = self.with_full_knot(end);
        let first = knots.partition_point(|&k| k < end);
        knots.truncate(first);
        knots.extend(std::iter::repeat_n(end, p + 1));
        points.truncate(first);
        while knots.iter().filter(|&&k| k == start).count() < p {
            insert(&mut knots, &mut points, p, start);
        }
        let after = knots.partition_point(|&k| k <= start);
        let mut clamped = vec![start; p + 1];
        clamped.extend_from_slice(&knots[after..]);
        self.rebuilt(p, &points[after - p - 1..], clamped)
    }

    /// The same curve run through backwards, over the same domain: `C(start + end - u)`.
    ///
    /// # Errors
    /// Fails when knots that were distinct fall together in the rounding of the mirrored parameter.
    pub fn reversed(&self) -> Result<Self, GeometryError> {
        let (a, b) = self.domain();
        // Each branch maps a to b and b to a exactly and keeps the order.
        let mirror = |t: f64| {
            if t <= a {
                b + (a - t)
            } else if t >= b {
                a - (t - b)
            } else {
                (a + (b - t)).min(b)
            }
        };
        let knots = self.knots().as_slice().iter().rev().map(|&t| mirror(t)).collect();
        let points = self.control_points().iter().rev().copied().collect();
        let weights = self.weights().iter().rev().copied().collect();
        Self::new(self.degree(), points, weights, knots)
    }

    /// The same curve with its degree raised by one. An unclamped curve is clamped first.
    ///
    /// Every distinct knot gains one in multiplicity, so that the smoothness at the knots is written down as it was. A
    /// new control point is the mean of the polar form over its `p + 1` knots with one of them left out in turn; each
    /// of these values is found by knot insertion, hence by convex combinations alone.
    ///
    /// # Errors
    /// Only where rounding spoils a curve that was on the edge of what [`NurbsCurve::new`] accepts.
    pub fn elevated(&self) -> Result<Self, GeometryError> {
        let curve = self.clamped()?;
        let p = curve.degree();
        let mut knots = Vec::new();
        for (_, value, multiplicity) in curve.knots().runs() {
            knots.extend(std::iter::repeat_n(value, multiplicity + 1));
        }
        let count = knots.len() - p - 2;
        let mut points = Vec::with_capacity(count);
        let mut arguments = Vec::with_capacity(p);
        for i in 0..count {
            let window = &knots[i + 1..i + p + 2];
            let mut sum = [0.0; 4];
            for omitted in 0..=p {
                arguments.clear();
                arguments.extend_from_slice(&window[..omitted]);
                arguments.extend_from_slice(&window[omitted + 1..]);
                let value = polar(curve.knots().as_slice(), curve.homogeneous(), &arguments);
                for l in 0..4 {
                    sum[l] += value[l];
                }
            }
            points.push(sum.map(|x| x / (p + 1) as f64));
        }
        self.rebuilt(p + 1, &points, knots)
    }

    /// The rational Bezier pieces of the curve, one per non-empty knot span, in order.
    ///
    /// Each piece knows its interval `[m, n]` of the curve's parameter. The control points come from the polar form
    /// (blossom) of the span, which equals inserting every knot to full multiplicity (Boehm; Liu et al. 2023,
    /// eqs. 4-7) and works for clamped and unclamped vectors alike. The curve does not move.
    pub fn decompose(&self) -> Vec<RationalBezier<D>> {
        self.knots()
            .spans()
            .map(|k| {
                let t = self.knots().as_slice();
                let interval = (t[k], t[k + 1]);
                RationalBezier::from_homogeneous(interval, bezier_points(t, self.homogeneous(), self.degree(), k))
            })
            .collect()
    }

    /// The curve with all coordinates multiplied by `factor`; 0.001 turns millimetres into metres.
    ///
    /// # Errors
    /// Fails when the factor is not a finite number above 0 or the coordinates overflow.
    pub fn scaled(&self, factor: f64) -> Result<Self, GeometryError> {
        check_positive("scale factor", factor)?;
        self.mapped(|p| p * factor)
    }

    fn mapped(&self, f: impl Fn(&SVector<f64, D>) -> SVector<f64, D>) -> Result<Self, GeometryError> {
        let points = self.control_points().iter().map(f).collect();
        Self::new(self.degree(), points, self.weights().to_vec(), self.knots().as_slice().to_vec())
    }

    fn check_insertion(&self, u: f64, times: usize) -> Result<(), GeometryError> {
        let (start, end) = self.domain();
        if !(start <= u && u <= end) {
            return Err(GeometryError::OutsideDomain { value: u, start, end });
        }
        let present = self.knots().multiplicity(u);
        if times > self.degree().saturating_sub(present) {
            return Err(GeometryError::KnotFull { value: u, present, times, degree: self.degree() });
        }
        Ok(())
    }

    /// Knots and homogeneous points with `u` standing at least degree times.
    fn with_full_knot(&self, u: f64) -> (Vec<f64>, Vec<Homogeneous>) {
        let (mut knots, mut points) = (self.knots().as_slice().to_vec(), self.homogeneous().to_vec());
        for _ in self.knots().multiplicity(u)..self.degree() {
            insert(&mut knots, &mut points, self.degree(), u);
        }
        (knots, points)
    }

    /// A curve from homogeneous points that came out of this one's.
    fn rebuilt(&self, degree: usize, points: &[Homogeneous], knots: Vec<f64>) -> Result<Self, GeometryError> {
        // The homogeneous form is kept relative to the largest weight; what goes out has the scale that came in. Equal
        // weights stay equal to the last digit, so that a polynomial curve stays one.
        let largest = self.weights().iter().fold(0.0f64, |m, &w| m.max(w));
        let weight = |h: &Homogeneous| if self.is_rational() { h[3] * largest } else { largest };
        let weights = points.iter().map(weight).collect();
        Self::new(degree, points.iter().map(project).collect(), weights, knots)
    }
}

impl NurbsCurve<3> {
    /// The curve moved and turned as a rigid body: `placement` takes the curve's frame to the new one.
    ///
    /// # Errors
    /// Fails when the placement holds a number that is not finite or the coordinates overflow.
    pub fn transformed(&self, placement: &Isometry3<f64>) -> Result<Self, GeometryError> {
        self.mapped(|p| placement.rotation * p + placement.translation.vector)
    }
}

/// Inserts `u` once, by Boehm's algorithm. It must lie in the domain and stand fewer than `p` times so far.
fn insert(knots: &mut Vec<f64>, points: &mut Vec<Homogeneous>, p: usize, u: f64) {
    let first = knots.partition_point(|&k| k < u);
    let after = knots.partition_point(|&k| k <= u);
    // Points p - multiplicity in number change; the last span start at or before u is `after - 1`.
    let (from, to) = (after - p, first - 1);
    points.insert(to, points[to]);
    // From behind: each new point mixes two old ones, and the old ones before it are still in place.
    for i in (from..=to).rev() {
        let alpha = (u - knots[i]) / (knots[i + p] - knots[i]);
        let right = if i == to { points[i + 1] } else { points[i] };
        points[i] = lerp(&points[i - 1], &right, alpha);
    }
    knots.insert(after, u);
}

/// The polar form (blossom) of a clamped spline at `arguments`: as many as the degree, increasing, and holding every
/// knot strictly between the first and the last of them as often as the knot vector does.
fn polar(knots: &[f64], points: &[Homogeneous], arguments: &[f64]) -> Homogeneous {
    let p = arguments.len();
    // Only the neighbourhood takes part.
    let low = knots.partition_point(|&k| k < arguments[0]).saturating_sub(p + 1);
    let high = (knots.partition_point(|&k| k <= arguments[p - 1]) + p + 1).min(knots.len());
    let mut local_knots = knots[low..high].to_vec();
    let mut local_points = points[low..high - p - 1].to_vec();
    for (i, &u) in arguments.iter().enumerate() {
        let wanted = arguments[..=i].iter().filter(|&&k| k == u).count();
        let present = local_knots.iter().filter(|&&k| k == u).count();
        if wanted > present {
            insert(&mut local_knots, &mut local_points, p, u);
        }
    }
    // The control point i has the knots i + 1 to i + p for its arguments.
    let i = local_knots.partition_point(|&k| k < arguments[0]);
    let copies = arguments.iter().filter(|&&k| k == arguments[0]).count();
    let run = local_knots.partition_point(|&k| k <= arguments[0]) - i;
    if copies == p { local_points[i.saturating_sub(1)] } else { local_points[i + run - copies - 1] }
}
