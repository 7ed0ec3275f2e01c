//! Random curves with knots that nearly coincide, and what must hold for them: by seed, for the tests and for
//! `examples/soak_close_knots.rs`.
#![allow(dead_code, clippy::needless_range_loop)]

use arcfeed_geometry::nalgebra::SVector;
use arcfeed_geometry::{ArcLengthCurve, Curve, GeometryError, NurbsCurve};
use arcfeed_testing::Random;

/// A number of twice the precision, as the sum of two (Dekker 1971).
#[derive(Clone, Copy)]
struct Double(f64, f64);

impl Double {
    fn sum(a: f64, b: f64) -> Self {
        let s = a + b;
        let t = s - a;
        Self(s, (a - (s - t)) + (b - t))
    }

    fn add(self, o: Self) -> Self {
        let s = Self::sum(self.0, o.0);
        let s = Self::sum(s.0, s.1 + (self.1 + o.1));
        Self(s.0, s.1)
    }

    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }

    fn mul(self, o: Self) -> Self {
        let p = self.0 * o.0;
        let e = self.0.mul_add(o.0, -p) + (self.0 * o.1 + self.1 * o.0);
        Self::sum(p, e)
    }

    fn div(self, o: Self) -> Self {
        let q = self.0 / o.0;
        let r = self.add(o.mul(Self(q, 0.0)).neg());
        let q2 = r.0 / o.0;
        let r = r.add(o.mul(Self(q2, 0.0)).neg());
        Self::sum(q, q2).add(Self(r.0 / o.0, 0.0))
    }
}

/// Derivatives of orders 0 to 3 of one homogeneous coordinate: de Boor's algorithm on Taylor polynomials in the
/// parameter, in twice the precision.
fn taylor(t: &[f64], points: &[Double], p: usize, k: usize, u: f64) -> [Double; 4] {
    let zero = Double(0.0, 0.0);
    let mut d: Vec<[Double; 4]> = points[k - p..=k].iter().map(|&x| [x, zero, zero, zero]).collect();
    for r in 1..=p {
        for i in (r..=p).rev() {
            let (left, right) = (t[k - p + i], t[k + 1 + i - r]);
            let width = Double::sum(right, -left);
            let (alpha, slope) = (Double::sum(u, -left).div(width), Double(1.0, 0.0).div(width));
            let (a, b) = (d[i - 1], d[i]);
            let step: [Double; 4] = std::array::from_fn(|l| b[l].add(a[l].neg()));
            for l in 0..4 {
                d[i][l] = a[l].add(alpha.mul(step[l]));
                if l > 0 {
                    d[i][l] = d[i][l].add(slope.mul(step[l - 1]));
                }
            }
        }
    }
    let factorial = [1.0, 1.0, 2.0, 6.0];
    std::array::from_fn(|l| d[p][l].mul(Double(factorial[l], 0.0)))
}

/// Point and three derivatives with twice the precision, rounded; for every order the size of what is added up.
pub struct Reference<const D: usize> {
    pub values: [SVector<f64, D>; 4],
    pub sizes: [f64; 4],
}

/// The curve on the knots `t` in the span `k` at `u`.
pub fn reference<const D: usize>(curve: &NurbsCurve<D>, t: &[f64], k: usize, u: f64) -> Reference<D> {
    let (p, points, weights) = (curve.degree(), curve.control_points(), curve.weights());
    let one = |x: f64, w: f64| Double(x, 0.0).mul(Double(w, 0.0));
    let w: Vec<Double> = weights.iter().map(|&w| Double(w, 0.0)).collect();
    let w = taylor(t, &w, p, k, u);
    let mut values = [SVector::<f64, D>::zeros(); 4];
    for axis in 0..D {
        let x: Vec<Double> = points.iter().zip(weights).map(|(q, &w)| one(q[axis], w)).collect();
        let x = taylor(t, &x, p, k, u);
        let mut c = [Double(0.0, 0.0); 4];
        let binomial = [[1.0, 0.0, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0], [1.0, 2.0, 1.0, 0.0], [1.0, 3.0, 3.0, 1.0]];
        for n in 0..4 {
            let mut sum = x[n];
            for j in 1..=n {
                sum = sum.add(Double(binomial[n][j], 0.0).mul(w[j]).mul(c[n - j]).neg());
            }
            c[n] = sum.div(w[0]);
            values[n][axis] = c[n].0;
        }
    }
    Reference { values, sizes: sizes(curve, t, k, w[0].0) }
}

/// How large the terms are that make up the derivatives, from the control points of the span.
fn sizes<const D: usize>(curve: &NurbsCurve<D>, t: &[f64], k: usize, w: f64) -> [f64; 4] {
    let p = curve.degree();
    let local = k - p..=k;
    let weights = &curve.weights()[local.clone()];
    let mut of_w = weights.to_vec();
    let mut of_x: Vec<f64> = curve.control_points()[local].iter().zip(weights).map(|(q, w)| q.norm() * w).collect();
    // A span about as wide as its neighbours is known by its Bezier points, whose differences span it alone.
    let own = t[k + 1] - t[k];
    let wide = own >= 0.02 * (t[k + p] - t[k + 1 - p]);
    let largest = |list: &[f64]| list.iter().fold(0.0f64, |m, &x| m.max(x));
    let (mut x, mut of_weights) = ([0.0; 4], [0.0; 4]);
    for order in 0..4.min(p + 1) {
        let q = p - order;
        if order > 0 {
            for i in 0..=q {
                let factor = (q + 1) as f64 / if wide { own } else { t[k + 1 + i] - t[k - q + i] };
                of_w[i] = factor * (of_w[i] + of_w[i + 1]);
                of_x[i] = factor * (of_x[i] + of_x[i + 1]);
            }
            of_w.truncate(q + 1);
            of_x.truncate(q + 1);
        }
        (x[order], of_weights[order]) = (largest(&of_x) / w, largest(&of_w) / w);
    }
    if !curve.is_rational() {
        return x;
    }
    // Quotient rule with all terms of one sign.
    let mut c = [x[0], 0.0, 0.0, 0.0];
    c[1] = x[1] + of_weights[1] * c[0];
    c[2] = x[2] + 2.0 * of_weights[1] * c[1] + of_weights[2] * c[0];
    c[3] = x[3] + 3.0 * of_weights[1] * c[2] + 3.0 * of_weights[2] * c[1] + of_weights[3] * c[0];
    c
}

/// Degree 1 to 9, pairs and groups of knots 1 ulp to 1e-6 of the domain apart, inside and at the ends, weights over
/// decades, domains of many sizes.
pub struct Case<const D: usize> {
    pub degree: usize,
    pub points: Vec<SVector<f64, D>>,
    pub weights: Vec<f64>,
    pub knots: Vec<f64>,
}

impl<const D: usize> Case<D> {
    pub fn random(seed: u64) -> Self {
        let r = &mut Random::new(seed);
        let degree = 1 + r.below(9);
        let start = if r.below(2) == 0 { 0.0 } else { r.between(-3.0, 3.0) };
        let scale = if r.below(2) == 0 { 1.0 } else { r.log(1e-3, 1e3) };
        let mut inner: Vec<f64> = Vec::new();
        let mut u = 0.0;
        for _ in 0..1 + r.below(5) {
            u += r.between(0.1, 1.0);
            let mut knot = u;
            for _ in 0..1 + r.below(degree.min(4)) {
                inner.push(knot);
                knot = match r.below(4) {
                    0 => knot,
                    1 => knot.next_up(),
                    _ => knot + r.log(1e-16, 1e-6),
                };
            }
        }
        let end = u + r.between(0.1, 1.0);
        // Close to the ends too.
        if degree > 1 && r.below(4) == 0 {
            inner.insert(0, r.log(1e-16, 1e-6));
        }
        if degree > 1 && r.below(4) == 0 {
            inner.push(end - r.log(1e-16, 1e-6));
        }
        let mut knots = vec![0.0; degree + 1];
        knots.extend(inner);
        knots.extend(vec![end; degree + 1]);
        if r.below(5) == 0 {
            // Nearly clamped.
            let n = knots.len();
            knots[0] -= r.log(1e-16, 1e-6);
            knots[n - 1] += r.log(1e-16, 1e-6);
        }
        for knot in &mut knots {
            *knot = start + scale * *knot;
        }
        let count = knots.len() - degree - 1;
        let size = r.log(0.01, 100.0);
        let points = (0..count).map(|_| SVector::from_fn(|_, _| r.between(-size, size))).collect();
        let rational = r.below(2) == 0;
        let weights = (0..count).map(|_| if rational { r.log(1e-2, 1e2) } else { 1.0 }).collect();
        Self { degree, points, weights, knots }
    }

    /// What is wrong with the curve of this case; `Ok(false)` where it is refused for a reason.
    pub fn check(&self, seed: u64) -> Result<bool, String> {
        let curve = match NurbsCurve::new(self.degree, self.points.clone(), self.weights.clone(), self.knots.clone()) {
            Ok(curve) => curve,
            Err(GeometryError::KnotsTooClose { index, width, .. }) => {
                let real = self.knots[index + 1] - self.knots[index];
                return if (real - width).abs() <= 1e-8 * width.abs() + 1e-300 {
                    Ok(false)
                } else {
                    Err(format!("width {width}, is {real}"))
                };
            }
            // Knots at an end that rounding made equal.
            Err(GeometryError::Multiplicity { index, multiplicity, .. })
                if self.knots[index..index + multiplicity].iter().all(|&k| k == self.knots[index]) =>
            {
                return Ok(false);
            }
            Err(other) => return Err(format!("refused: {other}")),
        };
        let r = &mut Random::new(seed ^ 0xC0FFEE);
        self.compare(&curve, r)?;
        for (end, index) in [(curve.domain().0, 0), (curve.domain().1, self.points.len() - 1)] {
            let clamped = if index == 0 {
                curve.knots().as_slice()[0] == end
            } else {
                curve.knots().as_slice().last() == Some(&end)
            };
            if clamped && (curve.point(end) != self.points[index] || curve.jet(end).point != self.points[index]) {
                return Err(format!("the end at {end} is not the control point"));
            }
        }
        by_length(curve)
    }

    /// Values of all orders against twice the precision, on every span.
    fn compare(&self, curve: &NurbsCurve<D>, r: &mut Random) -> Result<(), String> {
        let merged = curve.knots();
        let t = merged.as_slice();
        let (start, end) = merged.domain();
        for k in merged.spans() {
            let u = t[k] + r.between(0.0, 1.0) * (t[k + 1] - t[k]);
            if !(t[k] <= u && u < t[k + 1]) {
                continue;
            }
            let jet = curve.jet(u);
            let found = [jet.point, jet.d1, jet.d2, jet.d3];
            let exact = reference(curve, t, k, u);
            // The local parameter is rounded: each order moves by the next.
            let blur = 4.0 * f64::EPSILON * u.abs().max(start.abs());
            for n in 0..4 {
                let next = if n < 3 { exact.sizes[n + 1] } else { exact.sizes[3] / (t[k + 1] - t[k]) };
                let allowed = 2e-13 * exact.sizes[n] + blur * next;
                let error = (found[n] - exact.values[n]).norm();
                if error > allowed || error.is_nan() {
                    return Err(format!("order {n} at {u} in span {k}: off by {error:e}, allowed {allowed:e}"));
                }
            }
            // On the knots as they were given, away from the merged ones, the curve is the same to 1e-9 of its size.
            let given = self.knots.iter().filter(|&&knot| knot <= u).count() - 1;
            let wide = 1e-3 * (end - start);
            if given == k && t[k + 1] - t[k] > wide && self.knots[k + 1] - self.knots[k] > wide {
                let before = reference(curve, &self.knots, k, u);
                let moved = (before.values[0] - exact.values[0]).norm();
                let allowed = 2e-9 * (end - start) * (exact.sizes[1] + before.sizes[1]) * self.degree as f64;
                if moved > allowed || moved.is_nan() {
                    return Err(format!("merging knots moves the point at {u} by {moved:e}, allowed {allowed:e}"));
                }
            }
        }
        Ok(())
    }
}

/// Length of a polygon with many corners on every span, which is never above that of the curve.
fn chords<const D: usize>(curve: &NurbsCurve<D>, parts: usize) -> f64 {
    let t = curve.knots().as_slice();
    let mut sum = 0.0;
    for k in curve.knots().spans() {
        let mut last = curve.point(t[k]);
        for i in 1..=parts {
            let next = curve.point(t[k] + (t[k + 1] - t[k]) * (i as f64 / parts as f64));
            sum += (next - last).norm();
            last = next;
        }
    }
    sum
}

/// The arc length: a unit tangent everywhere, the length of the quadrature, corners at knots of full multiplicity alone.
fn by_length<const D: usize>(curve: NurbsCurve<D>) -> Result<bool, String> {
    let size = curve.control_points().iter().fold(0.0f64, |m, p| m.max(p.norm()));
    let path = match ArcLengthCurve::new(curve.clone(), 1e-12 * size) {
        Ok(path) => path,
        Err(GeometryError::StandsStill { u, mean, .. }) => {
            // The curve nearly stops against its speed within the span, or the next.
            let (here, left) = (curve.jet(u).speed(), curve.jet_left(u).speed());
            let k = curve.knots().span(u);
            let t = curve.knots().as_slice();
            let around = [t[k] - 1e-5 * (t[k + 1] - t[k]), t[k], 0.5 * (t[k] + t[k + 1]), t[k + 1]];
            let fastest = around.map(|v| curve.jet(v).speed().max(curve.jet_left(v).speed()));
            let fastest = fastest.into_iter().fold(mean, f64::max);
            let message = format!("stands still at {u} with {here} of {fastest}");
            return if here.min(left) < 1e-4 * fastest { Ok(false) } else { Err(message) };
        }
        Err(other) => return Err(format!("by arc length: {other}")),
    };
    let tolerance = 1e-10 * size;
    let length = curve.arc_length(tolerance).map_err(|e| e.to_string())?;
    let wrong = (path.length() - length).abs() > 1e-8 * length + tolerance;
    if wrong {
        // Of the two the quadrature may be the one that missed something: polygons, extrapolated, decide.
        let (coarse, fine) = (chords(&curve, 20_000), chords(&curve, 40_000));
        let extrapolated = fine + (fine - coarse) / 3.0;
        if fine > path.length() * (1.0 + 1e-12) || (path.length() - extrapolated).abs() > 1e-6 * extrapolated {
            return Err(format!("length {}, by quadrature {length}, by chords {extrapolated}", path.length()));
        }
    }
    for i in 0..=40 {
        let jet = path.jet(path.length() * i as f64 / 40.0);
        let finite = jet.d2.iter().chain(jet.d3.iter()).all(|x| x.is_finite());
        if !(finite && (jet.d1.norm() - 1.0).abs() < 1e-9) {
            return Err(format!("no unit tangent at place {i} of 40: {jet:?}"));
        }
    }
    let (start, end) = curve.domain();
    for corner in path.corners(1e-6) {
        let u = path.parameter(corner.s);
        let near = |k: f64| (k - u).abs() <= 1e-7 * (end - start) + 1e-12 * u.abs();
        let run = curve.knots().runs().find(|&(_, value, times)| near(value) && times >= curve.degree());
        // A bend within 1e-7 of the domain, which the arc length resolves no further, may count as a corner.
        let around = [u - 1e-7 * (end - start), u + 1e-7 * (end - start)].map(|v| curve.jet(v).tangent());
        let turns = match around {
            [Some(before), Some(after)] => (after - before).norm() > 0.5 * corner.angle,
            _ => false,
        };
        if run.is_none() && !turns {
            return Err(format!("a false corner of {} rad at u = {u}", corner.angle));
        }
    }
    Ok(true)
}
