//! Orientation through given keys: a spline on the rotation group.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::rotation::{OrientationJet, end_acceleration, right_jacobian, rotate_along, shorter_way};

/// Most rounds of the iteration that makes angular acceleration continuous. Nearly all keys need ten; of random keys two
/// radians apart one set in ten thousand needs more than thirty, and three in a hundred thousand end here.
const MAX_ROUNDS: usize = 200;

/// From key to key the orientation is `key * exp(phi(s))` with a cubic `phi` of rotation vectors. Where no cubics with a
/// continuous angular acceleration are found, `phi` is of degree five.
///
/// A spline on the rotation group in the sense of Park and Ravani, "Smooth invariant interpolation of rotations" (ACM
/// Trans. Graphics 16, 1997), with the rates at the keys solved for all at once. Each stretch has its own chart, so that
/// nothing happens at a full turn, and neither the base nor the tool frame matters.
#[derive(Debug, Clone)]
pub struct Through {
    s: Vec<f64>,
    stretches: Vec<Stretch>,
}

/// `phi(x) = first + c[0] x + c[1] x^2 + ... + c[4] x^5` about the key, with the arc length `x` since the start.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stretch {
    pub key: UnitQuaternion<f64>,
    pub first: Vector3<f64>,
    pub c: [Vector3<f64>; 5],
}

impl Stretch {
    /// `phi` and its first three derivatives at `x`.
    #[inline]
    fn phi(&self, x: f64) -> [Vector3<f64>; 4] {
        let c = &self.c;
        [
            self.first + (c[0] + (c[1] + (c[2] + (c[3] + c[4] * x) * x) * x) * x) * x,
            c[0] + (c[1] * 2.0 + (c[2] * 3.0 + (c[3] * 4.0 + c[4] * (5.0 * x)) * x) * x) * x,
            c[1] * 2.0 + (c[2] * 6.0 + (c[3] * 12.0 + c[4] * (20.0 * x)) * x) * x,
            c[2] * 6.0 + (c[3] * 24.0 + c[4] * (60.0 * x)) * x,
        ]
    }
}

/// The equations of the rates at the keys: equal angular accelerations on both sides of each key, and none at the ends.
///
/// With the steps `r`, their widths `h`, the rates `w` in axes of their keys and the right Jacobian `J` of the rotation
/// group at `r`, a stretch has the Hermite data `phi'(0) = w0`, `phi'(h) = J^-1 w1 = v`, so that its angular accelerations
/// are `6 r / h^2 - (4 w0 + 2 v) / h` and `J (2 w0 + 4 v) / h - 6 r / h^2 + c(v)`. Without the quadratic `c` the rates
/// follow from a block tridiagonal system; with it, from a few steps of Newton's method.
struct RateEquations {
    h: Vec<f64>,
    r: Vec<Vector3<f64>>,
    j: Vec<Matrix3<f64>>,
    j_inverse: Vec<Matrix3<f64>>,
}

impl RateEquations {
    fn new(keys: &[(f64, UnitQuaternion<f64>)]) -> Self {
        let h = keys.windows(2).map(|k| k[1].0 - k[0].0).collect();
        let r: Vec<Vector3<f64>> = keys.windows(2).map(|k| shorter_way(&k[0].1, &k[1].1)).collect();
        let (j, j_inverse) = r.iter().map(right_jacobian).unzip();
        Self { h, r, j, j_inverse }
    }

    /// The rates with `c` replaced by its tangent `c + slope (w - before)`, by Thomas' algorithm.
    fn solve(&self, c: &[Vector3<f64>], slope: &[Matrix3<f64>], before: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        let Self { h, r, j, j_inverse } = self;
        let n = before.len();
        let fixed = |i: usize| if i + 1 < n { r[i] * (6.0 / (h[i] * h[i])) } else { Vector3::zeros() };
        let mut w: Vec<Vector3<f64>> = Vec::with_capacity(n);
        let mut upper: Vec<Matrix3<f64>> = Vec::with_capacity(n);
        for i in 0..n {
            let mut inverse_widths = 0.0;
            let mut pivot = Matrix3::zeros();
            let mut right = fixed(i);
            if i > 0 {
                let lower = j[i - 1] * (2.0 / h[i - 1]);
                inverse_widths += 1.0 / h[i - 1];
                pivot += slope[i - 1] - lower * upper[i - 1];
                right += fixed(i - 1) - c[i - 1] + slope[i - 1] * before[i] - lower * w[i - 1];
            }
            if i + 1 < n {
                inverse_widths += 1.0 / h[i];
            }
            pivot += Matrix3::identity() * (4.0 * inverse_widths);
            // Diagonally dominant without the slopes; a singular one leaves the rate at 0, to be found next time.
            let inverse = pivot.try_inverse().unwrap_or_else(Matrix3::zeros);
            upper.push(if i + 1 < n { inverse * j_inverse[i] * (2.0 / h[i]) } else { Matrix3::zeros() });
            w.push(inverse * right);
        }
        for i in (0..n - 1).rev() {
            w[i] = w[i] - upper[i] * w[i + 1];
        }
        w
    }

    /// The rates by Newton's method, and whether it ended. Where it did not, they are those of the round with the least change.
    fn rates(&self) -> (Vec<Vector3<f64>>, bool) {
        let Self { r, j_inverse, .. } = self;
        let n = r.len() + 1;
        let mut c = vec![Vector3::zeros(); n - 1];
        let mut slope = vec![Matrix3::zeros(); n - 1];
        let mut w = self.solve(&c, &slope, &vec![Vector3::zeros(); n]);
        // The iterate that was changed least, and by how much.
        let mut best = (f64::INFINITY, w.clone());
        for _ in 0..MAX_ROUNDS {
            for i in 0..n - 1 {
                let at = |v: Vector3<f64>| end_acceleration(&[r[i], v, Vector3::zeros(), Vector3::zeros()]);
                let v = j_inverse[i] * w[i + 1];
                c[i] = at(v);
                // It is quadratic in v: c(v + e) - c(v) - c(e) is its derivative along e, exactly.
                let along = |e: Vector3<f64>| at(v + e) - c[i] - at(e);
                let size = v.norm();
                if size > 0.0 {
                    let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()].map(|e| along(e * size) / size);
                    slope[i] = Matrix3::from_columns(&[x, y, z]) * j_inverse[i];
                }
            }
            let next = self.solve(&c, &slope, &w);
            let change = next.iter().zip(&w).fold(0.0f64, |m, (a, b)| m.max((a - b).norm()));
            let size = next.iter().fold(0.0f64, |m, a| m.max(a.norm()));
            w = next;
            if change < best.0 {
                best = (change, w.clone());
            }
            // Sizes that are not numbers end it too: `max` above drops them.
            if change <= 1e-15 * size {
                break;
            }
        }
        // Newton's method ends at a few units in the last place; what does not come near wanders about.
        let found = best.0 <= 1e-12 * best.1.iter().fold(0.0f64, |m, a| m.max(a.norm()));
        (if found { w } else { best.1 }, found)
    }
}

impl Through {
    /// Stretches that join on their own, each over the arc lengths from `s[i]` to `s[i + 1]`.
    pub(crate) fn from_stretches(s: Vec<f64>, stretches: Vec<Stretch>) -> Self {
        Self { s, stretches }
    }

    /// Through these orientations, with rates by [`RateEquations`].
    pub(super) fn new(keys: &[(f64, UnitQuaternion<f64>)]) -> Self {
        let equations = RateEquations::new(keys);
        let (w, found) = equations.rates();
        let RateEquations { h, r, j_inverse, .. } = equations;
        let n = keys.len();
        let mut stretches = Vec::with_capacity(n - 1);
        for i in 0..n - 1 {
            let (mean, v) = (r[i] / h[i], j_inverse[i] * w[i + 1]);
            let [c1, c2, c3] = [w[i], (mean * 3.0 - w[i] * 2.0 - v) / h[i], (w[i] + v - mean * 2.0) / (h[i] * h[i])];
            let zero = Vector3::zeros();
            stretches.push(Stretch { key: keys[i].1, first: zero, c: [c1, c2, c3, zero, zero] });
        }
        let mut path = Self { s: keys.iter().map(|k| k.0).collect(), stretches };
        if !found {
            path.join_accelerations(&j_inverse);
        }
        path
    }

    /// Gives both sides of every key the mean of their angular accelerations, by stretches of degree five with the rates
    /// they have. `j_inverse` are the inverse right Jacobians at the ends of the stretches.
    fn join_accelerations(&mut self, j_inverse: &[Matrix3<f64>]) {
        let n = self.s.len();
        let width = |i: usize| self.s[i + 1] - self.s[i];
        // In the axes of each key.
        let mean = |i: usize| {
            let before = (i > 0).then(|| end_acceleration(&self.stretches[i - 1].phi(width(i - 1))));
            let after = (i + 1 < n).then(|| self.stretches[i].c[1] * 2.0);
            match (before, after) {
                (Some(a), Some(b)) => (a + b) * 0.5,
                (one, other) => one.or(other).unwrap_or_else(Vector3::zeros),
            }
        };
        let accelerations: Vec<Vector3<f64>> = (0..n).map(mean).collect();
        for i in 0..n - 1 {
            let h = width(i);
            let [r, v, ..] = self.stretches[i].phi(h);
            let without = end_acceleration(&[r, v, Vector3::zeros(), Vector3::zeros()]);
            let (start, end) = (accelerations[i], j_inverse[i] * (accelerations[i + 1] - without));
            // What is left to the powers three to five at the end, with the two derivatives.
            let rate = self.stretches[i].c[0];
            let d = r - rate * h - start * (0.5 * h * h);
            let e = (v - rate - start * h) * h;
            let f = (end - start) * (h * h);
            let h3 = h * h * h;
            self.stretches[i].c = [
                rate,
                start * 0.5,
                (d * 10.0 - e * 4.0 + f * 0.5) / h3,
                (e * 7.0 - d * 15.0 - f) / (h3 * h),
                (d * 6.0 - e * 3.0 + f * 0.5) / (h3 * h * h),
            ];
        }
    }

    /// Stretch that holds `s`, of two the later one.
    #[inline]
    pub(super) fn find(&self, s: f64) -> usize {
        self.s[1..self.s.len() - 1].partition_point(|&k| k <= s)
    }

    #[inline]
    pub(super) fn jet(&self, i: usize, s: f64) -> OrientationJet {
        let stretch = &self.stretches[i];
        rotate_along(&stretch.key, &stretch.phi(s - self.s[i]))
    }

    /// [`Through::jet`], of two stretches that meet at `s` by the earlier one.
    pub(super) fn jet_left(&self, s: f64) -> OrientationJet {
        let i = self.find(s);
        self.jet(if i > 0 && s <= self.s[i] { i - 1 } else { i }, s)
    }

    /// Arc lengths of the keys.
    pub(super) fn knots(&self) -> &[f64] {
        &self.s
    }

    /// Moves knots that are within `tolerance` of one of `places` (sorted) onto it, so that both count as one.
    pub(super) fn snap_knots(&mut self, places: &[f64], tolerance: f64) {
        for k in &mut self.s {
            let i = places.partition_point(|&p| p < *k - tolerance);
            if let Some(&place) = places.get(i).filter(|&&p| p <= *k + tolerance) {
                *k = place;
            }
        }
    }
}
