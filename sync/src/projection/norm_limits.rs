//! Limits of a tool: a ball for the linear and one for the angular part of every derivative.
//!
//! Both parts of the motion are planned in a frame whose first axis is the error (by Gram-Schmidt,
//! as in Liu et al. 2024, section 4.2; the second follows the velocity). Within a ball of radius
//! `B` the line has along the first axis what the transverse part leaves: from
//! `-sqrt(B² - m²) - low` to `sqrt(B² - m²) - high`, where `m` bounds it across the line and `low`,
//! `high` along it.
//!
//! **Rotations** are composed, `R(t) = exp(u x(t)) exp(w(t)) R0`, so that the line is a turn about
//! one axis throughout. Then, with `E = exp(u x)` and `omega_w` the angular velocity of `exp(w)`,
//!
//! ```text
//! omega   = u x'   + E omega_w
//! omega'  = u x''  + E omega_w'  + u x' × E omega_w
//! omega'' = u x''' + E omega_w'' + u x'' × E omega_w + 2 u x' × E omega_w' + u x' × (u x' × E omega_w)
//! ```
//!
//! `E` turns about the first axis and so leaves `m`, `low` and `high` as they are, and every
//! product is across the line: it adds to `m`. A part of what is left is set aside for the products
//! ([`RESERVED_SHARE`]), and `x'` and `x''` are bounded so that it suffices. Where `w` keeps to one
//! axis, its derivatives are those of `omega_w`; otherwise they differ by no more than what
//! [`turning`] says.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use super::feasible_set::{FeasibleSet, NONE, Order, SLACK, ScalarBounds, WIDEST};
use super::transverse_brake::{BrakeLimits, Ranges};
use crate::error::SyncError;
#[cfg(not(feature = "std"))]
use num_traits::Float;

/// Bounds of the norm of velocity, acceleration and jerk of a tool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseLimits {
    /// Linear and angular, by order of the derivative.
    linear: [f64; 3],
    angular: [f64; 3],
}

impl PoseLimits {
    /// Velocity, acceleration and jerk: linear (m/s, m/s², m/s³) and angular (rad/s, ...).
    ///
    /// # Errors
    /// [`SyncError::Tool`] naming the bound that is not finite or not above 0.
    pub fn new(linear: [f64; 3], angular: [f64; 3]) -> Result<Self, SyncError> {
        const NAMES: [[&str; 3]; 2] = [
            ["linear velocity limit", "linear acceleration limit", "linear jerk limit"],
            ["angular velocity limit", "angular acceleration limit", "angular jerk limit"],
        ];
        for (names, bounds) in NAMES.into_iter().zip([linear, angular]) {
            for (what, value) in names.into_iter().zip(bounds) {
                if !(value.is_finite() && value > 0.0) {
                    return Err(SyncError::Tool { what, value, rule: "finite and greater than 0" });
                }
            }
        }
        Ok(Self { linear, angular })
    }

    /// Bounds of linear velocity (m/s), acceleration (m/s²) and jerk (m/s³).
    pub const fn linear(&self) -> &[f64; 3] {
        &self.linear
    }

    /// Bounds of angular velocity (rad/s), acceleration (rad/s²) and jerk (rad/s³).
    pub const fn angular(&self) -> &[f64; 3] {
        &self.angular
    }

    fn bounds(&self, order: Order) -> [f64; 2] {
        let i = usize::from(order == Order::Acceleration);
        [self.linear[i], self.angular[i]]
    }
}

/// First row of a block.
const BLOCKS: [usize; 2] = [0, 3];

/// The rows of a block.
fn block(x: &Vector6<f64>, first: usize) -> Vector3<f64> {
    x.fixed_rows::<3>(first).into_owned()
}

/// Gram-Schmidt over the given directions and the base axes; what is nearly dependent is left out.
/// Right-handed, as products of angular rates are formed in these axes.
fn axes(directions: [Vector3<f64>; 3]) -> Matrix3<f64> {
    let mut frame = Matrix3::zeros();
    let mut count = 0;
    for direction in directions.into_iter().chain([Vector3::x(), Vector3::y(), Vector3::z()]) {
        let size = direction.norm();
        if count == 2 || size == 0.0 || !size.is_finite() {
            continue;
        }
        let mut rest = direction / size;
        // Twice is enough to be orthogonal to machine precision.
        for _ in 0..2 {
            for i in 0..count {
                let axis = frame.column(i).into_owned();
                rest -= axis * axis.dot(&rest);
            }
        }
        let left = rest.norm();
        if left > 1e-6 {
            frame.set_column(count, &(rest / left));
            count += 1;
        }
    }
    let third = frame.column(0).cross(&frame.column(1));
    frame.set_column(2, &third);
    frame
}

/// Part of what the transverse motion leaves that is set aside for each product of angular rates.
const RESERVED_SHARE: f64 = 0.2;

/// Velocity, acceleration, jerk of the transverse part of a block: range along the line and bound
/// across it.
struct Transverse {
    along: [(f64, f64); 3],
    across: [f64; 3],
}

impl Transverse {
    fn new(ranges: &[Ranges]) -> Self {
        let size = |r: (f64, f64)| r.1.max(-r.0);
        let along = [ranges[0].v, ranges[0].a, ranges[0].j];
        let across = [
            size(ranges[1].v).hypot(size(ranges[2].v)),
            size(ranges[1].a).hypot(size(ranges[2].a)),
            size(ranges[1].j).hypot(size(ranges[2].j)),
        ];
        Self { along, across }
    }

    /// As angular rates.
    fn angular(ranges: &[Ranges]) -> Self {
        let mut transverse = Self::new(ranges);
        for (i, more) in turning(ranges).into_iter().enumerate() {
            transverse.across[i] += more;
            transverse.along[i].0 -= more;
            transverse.along[i].1 += more;
        }
        transverse
    }

    /// The range that it leaves along the line inside a ball.
    fn left(&self, i: usize, bound: f64, aside: f64) -> (f64, f64) {
        let across = self.across[i] + aside;
        let (low, high) = self.along[i];
        let most = high.max(-low).hypot(across);
        if most > bound * (1.0 + SLACK) || most.is_nan() {
            return NONE;
        }
        // Alone it fits, so that nought is left at least: the root is sensitive to round-off where
        // it vanishes.
        let half = ((bound - across) * (bound + across)).max(0.0).sqrt();
        ((-half - low).min(0.0), (half - high).max(0.0))
    }
}

/// Bounds of the difference between the angular rates of `exp(w)` and the derivatives of `w`.
///
/// `omega_w` is the integral of `exp(s w) w'` over `s` in `[0, 1]`, and `exp(s w)` itself turns at
/// most at `s |w'|`. With bounds `p, v, a, j` of `w` and its derivatives that gives `p v/2`;
/// `p a/2 + v²/2 min(1, p)`; `p j/2 + 3/2 v a + v³/2`.
fn turning(ranges: &[Ranges]) -> [f64; 3] {
    let active = ranges.iter().filter(|r| r.p > 0.0).count();
    let norm = |f: fn(&Ranges) -> f64| ranges.iter().map(|r| f(r) * f(r)).sum::<f64>().sqrt();
    let p = norm(|r| r.p);
    if active < 2 {
        return [0.0; 3];
    }
    let v = norm(|r| r.v.1.max(-r.v.0));
    let a = norm(|r| r.a.1.max(-r.a.0));
    let j = norm(|r| r.j.1.max(-r.j.0));
    [0.5 * p * v, 0.5 * (p * a + v * v * p.min(1.0)), 0.5 * (p * j + v * (3.0 * a + v * v))]
}

impl FeasibleSet<6> for PoseLimits {
    fn frame(&self, u: &Vector6<f64>, v: &Vector6<f64>, a: &Vector6<f64>) -> Matrix6<f64> {
        let mut frame = Matrix6::zeros();
        for i in BLOCKS {
            frame.fixed_view_mut::<3, 3>(i, i).copy_from(&axes([block(u, i), block(v, i), block(a, i)]));
        }
        frame
    }

    fn apart(&self, u: &Vector6<f64>, alpha: f64, v: &Vector6<f64>, a: &Vector6<f64>) -> Vector6<f64> {
        let product = (block(u, 3) * alpha).cross(&block(v, 3));
        let mut apart = *a;
        for k in 0..3 {
            apart[3 + k] -= product[k];
        }
        apart
    }

    fn project(&self, order: Order, y: &Vector6<f64>, u: &Vector6<f64>) -> f64 {
        let (mut dot, mut square) = (0.0, 0.0);
        for (i, bound) in BLOCKS.into_iter().zip(self.bounds(order)) {
            let (y, u) = (block(y, i) / bound, block(u, i) / bound);
            dot += y.dot(&u);
            square += u.dot(&u);
        }
        dot / square
    }

    fn share(&self, order: Order, part: &Vector6<f64>, whole: &Vector6<f64>) -> f64 {
        let mut share = 1.0f64;
        for (i, bound) in BLOCKS.into_iter().zip(self.bounds(order)) {
            // The line has its first axis alone.
            let across = whole[i + 1].hypot(whole[i + 2]);
            let b = ((bound - across) * (bound + across)).max(0.0).sqrt();
            share = share.min(order.share([part[i], whole[i]], b));
        }
        share
    }

    fn brake_limits(&self, line: &Vector6<f64>, v: &Vector6<f64>, own: &Vector6<f64>, share: f64) -> [BrakeLimits; 6] {
        let mut limits = [BrakeLimits::default(); 6];
        let square = |x: f64| x * x;
        for (i, bounds) in BLOCKS.into_iter().zip([self.linear, self.angular]) {
            let (a, j) = (bounds[1], bounds[2]);
            let (line, own) = (line[i].abs(), block(own, i));
            if own == Vector3::zeros() {
                // The direction of the velocity stays.
                let direction = block(v, i).normalize();
                let most = (share * a).min(a - line);
                for k in 0..3 {
                    let part = direction[k].abs();
                    limits[i + k] = BrakeLimits { a: part * most, j: part * share * j, in_proportion: true };
                }
                continue;
            }
            // Across the line: each at least its own acceleration, both together inside the ball
            // with the line.
            let free = square(a) - square(line + own[0].abs()) - square(own[1]) - square(own[2]);
            // All three at once make little more than the share.
            let jerk = 0.6 * share * j;
            let across = (share * a).min((0.4 * free.max(0.0)).sqrt());
            for k in 1..3 {
                limits[i + k] = BrakeLimits { a: own[k].abs().hypot(across), j: jerk, in_proportion: false };
            }
            let taken = square(limits[i + 1].a) + square(limits[i + 2].a);
            let left = (square(a) - taken).max(0.0).sqrt() - line;
            limits[i] = BrakeLimits { a: own[0].abs().max((share * a).min(left)), j: jerk, in_proportion: false };
        }
        limits
    }

    fn scalar_bounds(&self, u: &Vector6<f64>, ranges: &[Ranges; 6]) -> ScalarBounds {
        let mut bounds = ScalarBounds { v: (-WIDEST, WIDEST), a: (-WIDEST, WIDEST), j: (-WIDEST, WIDEST) };
        let mut narrow = |size: f64, v: (f64, f64), a: (f64, f64), j: (f64, f64)| {
            for (range, (lower, upper)) in [(&mut bounds.v, v), (&mut bounds.a, a), (&mut bounds.j, j)] {
                if lower > upper {
                    *range = NONE;
                } else if size > 0.0 {
                    *range = (range.0.max(lower / size), range.1.min(upper / size));
                }
            }
        };
        let linear = Transverse::new(&ranges[..3]);
        let [v, a, j] = self.linear;
        narrow(u[0].abs(), linear.left(0, v, 0.0), linear.left(1, a, 0.0), linear.left(2, j, 0.0));

        let angular = Transverse::angular(&ranges[3..]);
        let [v, a, j] = self.angular;
        let size = u[3].abs();
        let [slow, second, third] = angular.across;
        let (left_a, left_j) = ((a - second).max(0.0), (j - third).max(0.0));
        // Products: at most what full velocity and acceleration would make of them.
        let one = (2.0 * RESERVED_SHARE * left_a).min(v * slow);
        let two = (RESERVED_SHARE * left_j).min(a * slow);
        let three = (RESERVED_SHARE * left_j).min(2.0 * v * second);
        let four = (RESERVED_SHARE * left_j).min(v * v * slow);
        let ratio = |x: f64, y: f64| if y > 0.0 { x / y } else { f64::INFINITY };
        let most_v = v.min(ratio(one, slow)).min(ratio(three, 2.0 * second)).min(ratio(four, slow).sqrt());
        let most_a = a.min(ratio(two, slow));
        let cap = |range: (f64, f64), most: f64| (range.0.max(-most), range.1.min(most));
        let (line_v, line_a) = (cap(angular.left(0, v, 0.0), most_v), cap(angular.left(1, a, one), most_a));
        narrow(size, line_v, line_a, angular.left(2, j, two + three + four));
        bounds
    }
}
