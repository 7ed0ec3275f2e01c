//! One piece of a joint trajectory: polynomials of the time since its start.

use arcfeed_kinematics::Joints;

/// Coefficients of one piece, `q(tau) = sum c[k] tau^k` with `tau` in s since its start.
pub(super) type Coefficients<const N: usize> = [Joints<N>; 6];

/// Position, velocity and acceleration of all joints at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct State<const N: usize> {
    pub q: Joints<N>,
    pub qd: Joints<N>,
    pub qdd: Joints<N>,
}

/// The quintic with the states `a` and `b` at both ends, `h` (s) apart.
pub(super) fn quintic<const N: usize>(a: &State<N>, b: &State<N>, h: f64) -> Coefficients<N> {
    let (h2, h3) = (h * h, h * h * h);
    let dq = (b.q - a.q) - a.qd * h - a.qdd * (0.5 * h2);
    let dv = ((b.qd - a.qd) - a.qdd * h) * h;
    let da = (b.qdd - a.qdd) * h2;
    [
        a.q,
        a.qd,
        a.qdd * 0.5,
        (dq * 10.0 - dv * 4.0 + da * 0.5) / h3,
        (dq * -15.0 + dv * 7.0 - da) / (h3 * h),
        (dq * 6.0 - dv * 3.0 + da * 0.5) / (h3 * h2),
    ]
}

/// The cubic with the positions and velocities of `a` and `b` at both ends, `h` (s) apart.
pub(super) fn cubic<const N: usize>(a: &State<N>, b: &State<N>, h: f64) -> Coefficients<N> {
    let dq = (b.q - a.q) - a.qd * h;
    let dv = (b.qd - a.qd) * h;
    let zero = Joints::zeros();
    [a.q, a.qd, (dq * 3.0 - dv) / (h * h), (dv - dq * 2.0) / (h * h * h), zero, zero]
}

/// The quartic with state `a` and, `h` (s) later, the velocity and the acceleration of `b`: its jerk is the straight line that is
/// nearest to any jerk with the same ends.
pub(super) fn quartic<const N: usize>(a: &State<N>, b: &State<N>, h: f64) -> Coefficients<N> {
    let dv = (b.qd - a.qd) - a.qdd * h;
    let da = (b.qdd - a.qdd) * h;
    let (third, fourth) = ((dv * 3.0 - da) / (3.0 * h * h), (da - dv * 2.0) / (4.0 * h * h * h));
    [a.q, a.qd, a.qdd * 0.5, third, fourth, Joints::zeros()]
}

/// The piece of constant jerk from state `a` to the acceleration `qdd`, `h` (s) later.
pub(super) fn constant_jerk<const N: usize>(a: &State<N>, qdd: &Joints<N>, h: f64) -> Coefficients<N> {
    let zero = Joints::zeros();
    [a.q, a.qd, a.qdd * 0.5, (qdd - a.qdd) / (6.0 * h), zero, zero]
}

/// Position, velocity, acceleration and jerk a time `tau` (s) after the start, by Horner's scheme for a polynomial and its derivatives.
#[inline]
pub(super) fn evaluate<const N: usize>(c: &Coefficients<N>, tau: f64) -> [Joints<N>; 4] {
    let [c0, c1, c2, c3, c4, c5] = c.each_ref().map(|c| &c.data.0[0]);
    let mut out = [[0.0; N]; 4];
    for j in 0..N {
        let p4 = c4[j] + tau * c5[j];
        let p3 = c3[j] + tau * p4;
        let p2 = c2[j] + tau * p3;
        let p1 = c1[j] + tau * p2;
        let v3 = p4 + tau * c5[j];
        let v2 = p3 + tau * v3;
        let v1 = p2 + tau * v2;
        let a2 = v3 + tau * c5[j];
        let a1 = v2 + tau * a2;
        let j1 = a2 + tau * c5[j];
        out[0][j] = c0[j] + tau * p1;
        out[1][j] = p1 + tau * v1;
        out[2][j] = 2.0 * (v1 + tau * a1);
        out[3][j] = 6.0 * (a1 + tau * j1);
    }
    out.map(Joints::from)
}

/// The state a time `tau` (s) after the start.
pub(super) fn state<const N: usize>(c: &Coefficients<N>, tau: f64) -> State<N> {
    let [q, qd, qdd, _] = evaluate(c, tau);
    State { q, qd, qdd }
}

/// The piece of duration `h` (s) backwards in time.
pub(super) fn reversed<const N: usize>(c: &Coefficients<N>, h: f64) -> Coefficients<N> {
    let mut shifted = *c;
    // Taylor's shift to the end by repeated division, then the sign of odd powers.
    for first in 0..5 {
        for k in (first..5).rev() {
            let above = shifted[k + 1];
            shifted[k] += above * h;
        }
    }
    for k in [1, 3, 5] {
        shifted[k] = -shifted[k];
    }
    shifted
}
