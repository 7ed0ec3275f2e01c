//! Smooth passages of the joints through singular poses.
//!
//! At a singular pose the joint derivatives do not follow from those of the tool. A path may still pass it with smooth joints, as one
//! does along which the wrist of an arm straightens while the fourth joint stands still. Between two places of the path on either side
//! where the derivatives are known, the joints there are the polynomial of degree 7 that has the values and three derivatives of both
//! (Hermite interpolation). It counts only where the tool stays on the path; a path that asks for a turn of a joint in between is not
//! followed by it.

use arcfeed_kinematics::{ForwardKinematics, Jacobian, Joints, KinematicsError, Twist, smallest_singular_value};
use nalgebra::Matrix6;

use super::jet::JointJet;
use super::motion_path::MotionPath;
use crate::error::PathError;

/// Smallest singular values of the Jacobian at the ends of a passage: the larger, the better the derivatives there are known; the
/// smaller, the shorter the passage. The one whose tool follows the path best is taken.
const ENDS: [f64; 5] = [2e-2, 1e-2, 5e-3, 2.5e-3, 1.25e-3];
/// Distance of the first look for an end, as a part of the path; the next are each twice as far.
const FIRST_LOOK: f64 = 1e-7;
/// Halvings in which an end is moved near to the place with its smallest singular value.
const HALVINGS: usize = 4;
/// Halvings of an interval in search of a singular pose.
const BISECTIONS: usize = 60;
/// Intervals in which the tool is compared with the path.
const INTERVALS: usize = 64;
/// Largest distance of the tool from the path, m: a tenth of the usual chord tolerance.
const OFF_PATH: f64 = 1e-7;
/// Largest angle from the orientation of the path, rad.
const TURNED: f64 = 2e-7;
/// Largest difference of the first derivative of the tool point from that of the path, per unit of the parameter, m.
const FIRST: f64 = 2e-7;
/// Largest difference of its second derivative, per unit of the parameter squared, m; relative to that of the path where it is above 1,
/// as a bend of the path bounds the speed.
const SECOND: f64 = 1e-4;

/// An interval of a path with a singular pose inside, and the joints there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Passage<const N: usize> {
    /// Start and end, by the path's parameter.
    pub from: f64,
    pub to: f64,
    /// With x = (s - from) / (to - from): coefficients of the Taylor series at x = 0, and of the powers of x - 1 in the rest, which is
    /// x^4 times a cubic.
    taylor: [Joints<N>; 4],
    rest: [Joints<N>; 4],
}

/// True for the error of a pose that is too nearly singular.
pub(super) fn is_singular(error: &PathError) -> bool {
    matches!(error, PathError::Arm { source: KinematicsError::Singular { .. }, .. })
}

/// The passage that holds `s`.
pub(super) fn passage_at<const N: usize>(passages: &[Passage<N>], s: f64) -> Option<&Passage<N>> {
    let i = passages.partition_point(|passage| passage.to < s);
    passages.get(i).filter(|passage| passage.from <= s)
}

/// True where the determinant of the Jacobian of a six-joint arm has another sign at `a` than at `b`.
pub(super) fn crosses_singular_pose<const N: usize>(
    arm: &dyn ForwardKinematics<N>,
    a: &Joints<N>,
    b: &Joints<N>,
) -> bool {
    determinant(&arm.jacobian(a)) * determinant(&arm.jacobian(b)) < 0.0
}

/// 0 for arms of other than six joints.
fn determinant<const N: usize>(jacobian: &Jacobian<N>) -> f64 {
    if N == 6 { Matrix6::from_fn(|row, column| jacobian[(row, column)]).determinant() } else { 0.0 }
}

impl<const N: usize> Passage<N> {
    /// The passage through the singular pose that is crossed between two places of `path`, if the joints are smooth there.
    pub fn between(
        path: &dyn MotionPath<N>,
        arm: &dyn ForwardKinematics<N>,
        [a, b]: [&JointJet<N>; 2],
    ) -> Option<Self> {
        let (mut a, mut b) = (*a, *b);
        for _ in 0..BISECTIONS {
            let s = 0.5 * (a.s + b.s);
            if s <= a.s || s >= b.s {
                return None;
            }
            let near = a.ahead(s - a.s);
            match path.jet(s, &near) {
                Ok(jet) if crosses_singular_pose(arm, &a.q, &jet.q) => b = jet,
                Ok(jet) => a = jet,
                Err(error) if is_singular(&error) => return Self::around(path, arm, s, &near),
                Err(_) => return None,
            }
        }
        None
    }

    /// The passage through the singular pose near `s`, where the joints are about `near`, if they are smooth there.
    pub fn around(path: &dyn MotionPath<N>, arm: &dyn ForwardKinematics<N>, s: f64, near: &Joints<N>) -> Option<Self> {
        let mut best: Option<(f64, Self)> = None;
        for sigma in ENDS {
            let good = |jet: &JointJet<N>| smallest_singular_value(&arm.jacobian(&jet.q)) >= sigma;
            let Some(from) = end(path, (s, -1.0), |_| *near, good) else { continue };
            let Some(to) = end(path, (s, 1.0), |s| from.ahead(s - from.s), good) else { continue };
            for [from, to] in [[from, to], with_third_of_quintic([from, to])] {
                let passage = Self::joining(&from, &to);
                let deviation = passage.deviation(path, arm);
                if deviation <= best.map_or(1.0, |(least, _)| least) {
                    best = Some((deviation, passage));
                }
            }
        }
        best.map(|(_, passage)| passage)
    }

    /// The polynomial with the values and derivatives of both.
    fn joining(from: &JointJet<N>, to: &JointJet<N>) -> Self {
        let w = to.s - from.s;
        let scaled = |jet: &JointJet<N>| [jet.q, jet.d1 * w, jet.d2 * (w * w / 2.0), jet.d3 * (w * w * w / 6.0)];
        let taylor = scaled(from);
        let [t0, t1, t2, t3] = taylor;
        let series = [t0 + t1 + t2 + t3, t1 + t2 * 2.0 + t3 * 3.0, t2 + t3 * 3.0, t3];
        let end = scaled(to);
        let missing: [Joints<N>; 4] = std::array::from_fn(|k| end[k] - series[k]);
        // The Taylor series of x^-4 at x = 1.
        let inverse = [1.0, -4.0, 10.0, -20.0];
        let rest = std::array::from_fn(|k| (0..=k).fold(Joints::zeros(), |sum, j| sum + missing[j] * inverse[k - j]));
        Self { from: from.s, to: to.s, taylor, rest }
    }

    /// Joint values and derivatives at `s`.
    pub fn jet(&self, s: f64) -> JointJet<N> {
        let w = self.to - self.from;
        let x = (s - self.from) / w;
        let ([t0, t1, t2, t3], [r0, r1, r2, r3], u) = (self.taylor, self.rest, x - 1.0);
        let rest = [
            r0 + (r1 + (r2 + r3 * u) * u) * u,
            r1 + (r2 * 2.0 + r3 * (3.0 * u)) * u,
            r2 * 2.0 + r3 * (6.0 * u),
            r3 * 6.0,
        ];
        let power = [x.powi(4), 4.0 * x.powi(3), 12.0 * x * x, 24.0 * x];
        let product = |binomials: &[f64]| {
            let order = binomials.len() - 1;
            (0..=order).fold(Joints::zeros(), |sum, k| sum + rest[order - k] * (binomials[k] * power[k]))
        };
        JointJet {
            s,
            q: t0 + (t1 + (t2 + t3 * x) * x) * x + product(&[1.0]),
            d1: (t1 + (t2 * 2.0 + t3 * (3.0 * x)) * x + product(&[1.0, 1.0])) / w,
            d2: (t2 * 2.0 + t3 * (6.0 * x) + product(&[1.0, 2.0, 1.0])) / (w * w),
            d3: (t3 * 6.0 + product(&[1.0, 3.0, 3.0, 1.0])) / (w * w * w),
        }
    }

    /// The largest deviation of the tool from the path, in parts of what is allowed. Between two places of the comparison the tool is
    /// off by no more than at the nearer one and by what the difference of its rate there makes of the distance.
    fn deviation(&self, path: &dyn MotionPath<N>, arm: &dyn ForwardKinematics<N>) -> f64 {
        let half = 0.5 * (self.to - self.from) / INTERVALS as f64;
        let norms = |twist: Twist| [twist.fixed_rows::<3>(0).norm(), twist.fixed_rows::<3>(3).norm()];
        let at = |i: usize| {
            let s = self.from + (self.to - self.from) * i as f64 / INTERVALS as f64;
            let Some(tool) = path.tool(s) else { return f64::INFINITY };
            let jet = self.jet(s);
            let at = arm.configuration(&jet.q);
            let (pose, jacobian) = (at.pose(), at.jacobian());
            let [linear, angular] = norms(jacobian * jet.d1 - tool.d1);
            let [second, _] = norms(jacobian * jet.d2 + at.acceleration_bias(&jet.d1) - tool.d2);
            let bend = norms(tool.d2)[0].max(1.0);
            let off = (pose.translation.vector - tool.pose.translation.vector).norm() + half * linear;
            let turned = pose.rotation.angle_to(&tool.pose.rotation) + half * angular;
            [off / OFF_PATH, turned / TURNED, linear / FIRST, second / (SECOND * bend)].into_iter().fold(0.0, larger)
        };
        (0..=INTERVALS).map(at).fold(0.0, larger)
    }
}

/// The same with the third derivatives of the polynomial of degree 5 that has the values and two derivatives of both. Those of a path
/// whose third derivative jumps at many knots, as that of a spline through measured poses, grow with the inverse of the singular value.
fn with_third_of_quintic<const N: usize>([from, to]: [JointJet<N>; 2]) -> [JointJet<N>; 2] {
    let w = to.s - from.s;
    let (step, v, a) = ((to.q - from.q) * 60.0, [from.d1 * w, to.d1 * w], [from.d2 * (w * w), to.d2 * (w * w)]);
    let first = step - v[0] * 36.0 - v[1] * 24.0 - a[0] * 9.0 + a[1] * 3.0;
    let last = step - v[0] * 24.0 - v[1] * 36.0 - a[0] * 3.0 + a[1] * 9.0;
    [JointJet { d3: first / w.powi(3), ..from }, JointJet { d3: last / w.powi(3), ..to }]
}

/// The larger number, or NaN if one is.
fn larger(a: f64, b: f64) -> f64 {
    if a >= b || a.is_nan() { a } else { b }
}

/// The place nearest to `s` in this direction (-1 or 1) where the derivatives are `good`, about; the joints are near `predicted` there.
fn end<const N: usize>(
    path: &dyn MotionPath<N>,
    (s, direction): (f64, f64),
    predicted: impl Fn(f64) -> Joints<N>,
    good: impl Fn(&JointJet<N>) -> bool,
) -> Option<JointJet<N>> {
    let inside = |s: f64| (0.0..=path.length()).contains(&s);
    let look = |away: f64| {
        let place = s + direction * away;
        path.jet(place, &predicted(place)).ok().filter(|jet| good(jet))
    };
    let mut away = FIRST_LOOK * path.length();
    let mut found = loop {
        if !inside(s + direction * away) {
            return None;
        }
        match look(away) {
            Some(jet) => break jet,
            None => away *= 2.0,
        }
    };
    let mut near = 0.5 * away;
    for _ in 0..HALVINGS {
        let middle = 0.5 * (near + away);
        match look(middle) {
            Some(jet) => (found, away) = (jet, middle),
            None => near = middle,
        }
    }
    Some(found)
}
