//! The certificate of joint trajectories against closed forms, spikes between samples and spoilt coefficients.

use arcfeed_interp::{
    Certificate, Interpolation, JointRates, JointTrajectory, JointTrajectoryError, LimitId, Quantity, certify,
};
use arcfeed_kinematics::{JointRange, Joints};

use arcfeed_testing::Random;

const QUANTITIES: [Quantity; 4] =
    [Quantity::JointPosition, Quantity::JointVelocity, Quantity::JointAcceleration, Quantity::JointJerk];

pub(crate) type Piece<const N: usize> = [Joints<N>; 6];

fn range<const N: usize>(half: f64) -> JointRange<N> {
    JointRange::new(Joints::repeat(-half), Joints::repeat(half)).expect("a range")
}

fn rates<const N: usize>(velocity: f64, acceleration: f64, jerk: f64) -> JointRates<N> {
    let [velocity, acceleration, jerk] = [velocity, acceleration, jerk].map(Joints::repeat);
    JointRates { velocity, acceleration, jerk }
}

fn unlimited<const N: usize>() -> JointRates<N> {
    rates(f64::INFINITY, f64::INFINITY, f64::INFINITY)
}

/// Coefficients of the derivative of a polynomial.
fn derivative(c: &[f64]) -> Vec<f64> {
    c.iter().enumerate().skip(1).map(|(k, c)| k as f64 * c).collect()
}

fn value(c: &[f64], x: f64) -> f64 {
    c.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

/// The real roots between 0 and `h`: a line in closed form, everything else between the roots of its derivative, where it is
/// monotone.
fn roots(c: &[f64], h: f64) -> Vec<f64> {
    if c.len() <= 1 {
        return Vec::new();
    }
    if c.len() == 2 {
        return vec![-c[0] / c[1]].into_iter().filter(|x| *x > 0.0 && *x < h).collect();
    }
    let mut places = vec![0.0];
    places.extend(roots(&derivative(c), h));
    places.push(h);
    let mut found = Vec::new();
    for pair in places.windows(2) {
        let (mut low, mut high) = (pair[0], pair[1]);
        let rises = value(c, low) < 0.0;
        if (value(c, high) < 0.0) == rises {
            continue;
        }
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if (value(c, middle) < 0.0) == rises { low = middle } else { high = middle }
        }
        found.push(0.5 * (low + high));
    }
    found
}

/// The largest size of a polynomial between 0 and `h`: at an end or where its derivative is zero.
fn largest(c: &[f64], h: f64) -> f64 {
    let mut places = vec![0.0, h];
    places.extend(roots(&derivative(c), h));
    places.into_iter().map(|x| value(c, x).abs()).fold(0.0, f64::max)
}

fn of(certificate: &Certificate, order: usize, joint: usize) -> (f64, f64, f64) {
    let bound = certificate.of(LimitId::joint(QUANTITIES[order], joint)).expect("certified");
    (bound.attained, bound.bound, bound.t)
}

#[test]
fn extremes_of_random_polynomials_agree_with_roots_of_their_derivatives() {
    let mut random = Random::new(1);
    for case in 0..3000 {
        let h = 10_f64.powf(random.between(-6.0, 1.0));
        let c: Vec<f64> = (0..6).map(|k| random.between(-1.0, 1.0) / h.powi(k)).collect();
        let piece: Piece<1> = std::array::from_fn(|k| Joints::from([c[k]]));
        let certificate = certify(&[0.0, h], &[piece], &range(10.0), &unlimited());
        let mut polynomial = c.clone();
        for order in 0..4 {
            let (attained, bound, t) = of(&certificate, order, 0);
            let true_largest = largest(&polynomial, h);
            let at = value(&polynomial, t);
            assert!(bound >= true_largest * (1.0 - 1e-13), "case {case}, order {order}: {bound} < {true_largest}");
            assert!(bound <= true_largest * (1.0 + 2e-9), "case {case}, order {order}: {bound} > {true_largest}");
            let scale =
                c.iter().enumerate().map(|(k, c)| c.abs() * h.powi(k as i32)).sum::<f64>() / h.powi(order as i32);
            assert!((attained - at).abs() <= 1e-12 * scale, "case {case}, order {order}: {attained} is not {at}");
            polynomial = derivative(&polynomial);
        }
    }
}

/// A motion of one joint, piece by piece, each starting where the last one ended.
pub(crate) struct Chain {
    pub times: Vec<f64>,
    pub pieces: Vec<Piece<1>>,
    /// Position, velocity and acceleration at the end.
    pub state: [f64; 3],
}

impl Chain {
    pub fn new() -> Self {
        Self { times: vec![0.0], pieces: Vec::new(), state: [0.0; 3] }
    }

    pub fn now(&self) -> f64 {
        self.times[self.times.len() - 1]
    }

    /// A quintic to another state.
    pub fn to(&mut self, end: [f64; 3], duration: f64) {
        let t = self.now() + duration;
        let h = t - self.now();
        let [q0, v0, a0] = self.state;
        let [dq, dv, da] = [end[0] - q0 - v0 * h - 0.5 * a0 * h * h, (end[1] - v0 - a0 * h) * h, (end[2] - a0) * h * h];
        let c = [
            q0,
            v0,
            0.5 * a0,
            (10.0 * dq - 4.0 * dv + 0.5 * da) / h.powi(3),
            (-15.0 * dq + 7.0 * dv - da) / h.powi(4),
            (6.0 * dq - 3.0 * dv + 0.5 * da) / h.powi(5),
        ];
        self.pieces.push(c.map(|c| Joints::from([c])));
        self.times.push(t);
        self.state = end;
    }

    /// A phase of constant jerk.
    fn jerk(&mut self, jerk: f64, duration: f64) {
        let t = self.now() + duration;
        let h = t - self.now();
        let [q, v, a] = self.state;
        self.pieces.push([q, v, 0.5 * a, jerk / 6.0, 0.0, 0.0].map(|c| Joints::from([c])));
        self.times.push(t);
        self.state = [q + h * (v + h * (0.5 * a + h * jerk / 6.0)), v + h * (a + 0.5 * h * jerk), a + h * jerk];
    }

    /// Some motion within 1 rad, 1 rad/s, 10 rad/s^2, 100 rad/s^3.
    pub fn wander(&mut self, random: &mut Random) {
        for _ in 0..3 {
            let to = [random.between(-0.5, 0.5), random.between(-0.2, 0.2), random.between(-0.5, 0.5)];
            self.to(to, random.between(2.0, 3.0));
        }
    }

    pub fn compiled(&self) -> JointTrajectory<1> {
        JointTrajectory::from_pieces(self.times.clone(), self.pieces.clone(), Interpolation::Quintic).expect("joined")
    }
}

/// A spike of the quantity of derivative `order` that lasts less than 1 us and reaches `height`.
pub(crate) fn spike(chain: &mut Chain, order: usize, height: f64, width: f64) {
    let [q, v, a] = chain.state;
    match order {
        0 => {
            chain.to([height, 0.0, 0.0], 0.5 * width);
            chain.to([q, v, a], 0.5 * width);
        }
        1 => {
            // The velocity rises to its height and falls back; the joint goes on from where that led.
            let mean = 0.5 * (v + height);
            chain.to([q + 0.5 * width * mean, height, 0.0], 0.5 * width);
            chain.to([q + width * mean, v, a], 0.5 * width);
        }
        2 => {
            let jerk = (height - a) / (0.25 * width);
            chain.jerk(jerk, 0.25 * width);
            chain.jerk(-jerk, 0.5 * width);
            chain.jerk(jerk, 0.25 * width);
        }
        _ => {
            chain.jerk(height, 0.25 * width);
            chain.jerk(-height, 0.5 * width);
            chain.jerk(height, 0.25 * width);
        }
    }
}

#[test]
fn spikes_shorter_than_a_microsecond_are_caught() {
    let limits = [1.0, 1.0, 10.0, 100.0];
    let mut random = Random::new(2);
    let mut unseen = 0;
    for case in 0..4000 {
        let order = case % 4;
        let mut chain = Chain::new();
        chain.wander(&mut random);
        let only = |limits: [f64; 4]| {
            let limit = |of: usize| if of == order { limits[of] } else { f64::INFINITY };
            (range::<1>(if order == 0 { limits[0] } else { 1e9 }), rates::<1>(limit(1), limit(2), limit(3)))
        };
        let (range, rates) = only(limits);
        let calm = chain.compiled();
        assert!(calm.certify(&range, &rates).holds(1e-6), "case {case}: without a spike");
        let (begin, width) = (chain.now(), random.between(1e-8, 1e-6));
        // By as little as a thousandth.
        let height = limits[order] * random.between(1.001, 2.0) * random.sign();
        spike(&mut chain, order, height, width);
        let end = chain.now();
        chain.wander(&mut random);
        let motion = chain.compiled();
        // Samples at an eighth of a millisecond around the spike.
        let near = (begin / 1.25e-4) as i32;
        let samples = (near - 8..near + 8).map(|i| motion.at(f64::from(i) * 1.25e-4));
        let seen = samples.map(|p| [p.q, p.qd, p.qdd, p.jerk][order][0].abs()).any(|x| x > limits[order]);
        unseen += usize::from(!seen);

        let certificate = motion.certify(&range, &rates);
        assert!(!certificate.holds(1e-6), "case {case}: a spike of {height} over {width} s");
        let worst = certificate.worst().expect("limited");
        assert_eq!(worst.id.quantity, QUANTITIES[order], "case {case}");
        assert!(worst.t >= begin - 1e-9 && worst.t <= end + 1e-9, "case {case}: at {} not {begin}", worst.t);
        assert!(worst.attained.abs() > limits[order] && worst.bound >= worst.attained.abs(), "case {case}");
    }
    assert!(unseen > 3900, "samples would have seen {} spikes", 4000 - unseen);
}

/// Rest to rest over a few way-points, for two joints.
fn two_joints() -> JointTrajectory<2> {
    let (mut a, mut b) = (Chain::new(), Chain::new());
    for (qa, qb) in [(0.4, -0.1), (0.1, 0.3), (0.6, -0.5)] {
        a.to([qa, 0.1, 0.2], 1.5);
        b.to([qb, -0.1, 0.1], 1.5);
    }
    let join = |(a, b): (&Piece<1>, &Piece<1>)| std::array::from_fn(|k| Joints::from([a[k][0], b[k][0]]));
    let pieces: Vec<Piece<2>> = a.pieces.iter().zip(&b.pieces).map(join).collect();
    JointTrajectory::from_pieces(a.times, pieces, Interpolation::Quintic).expect("joined")
}

#[test]
fn a_changed_coefficient_is_caught_as_a_jump_or_as_a_limit() {
    let motion = two_joints();
    let bounds = motion.certify(&range(1.0), &unlimited());
    // Limits that the motion just keeps.
    let least = |order: usize| bounds.bounds().iter().skip(order).step_by(4).map(|b| b.bound).fold(0.0, f64::max);
    let rates = rates(least(1), least(2), least(3));
    let certificate = motion.certify(&range(1.0), &rates);
    assert!(certificate.holds(1e-6), "{certificate:?}");
    for piece in 0..motion.len() {
        for joint in 0..2 {
            for power in 0..6 {
                if piece + 1 == motion.len() && power > 2 {
                    // Another end of the motion is another motion.
                    continue;
                }
                for factor in [1e-9, 1e-3, 1.0] {
                    let mut pieces = motion.coefficients().to_vec();
                    pieces[piece][power][joint] += factor;
                    let spoilt = certify(motion.times(), &pieces, &range(1.0), &rates);
                    let at = format!("{factor} in power {power} of joint {joint} in piece {piece}");
                    assert!(!spoilt.holds(1e-6), "{at}");
                    let jump = spoilt.worst_jump().expect("limited");
                    assert!(jump.ratio() > 1.0 && jump.id.joint == Some(joint as u16), "{at}: {jump:?}");
                    let refused = JointTrajectory::from_pieces(motion.times().to_vec(), pieces, Interpolation::Quintic);
                    assert!(matches!(refused, Err(JointTrajectoryError::Jump { .. })), "{at}: {refused:?}");
                }
            }
        }
    }
}

#[test]
fn a_jump_counts_where_its_derivative_is_limited() {
    // The acceleration jumps from 1 to -1: no jerk limit can hold, and without one the motion is sound.
    let pieces: [Piece<1>; 2] =
        [[0.0, 0.0, 0.5, 0.0, 0.0, 0.0], [0.5, 1.0, -0.5, 0.0, 0.0, 0.0]].map(|c| c.map(|c| Joints::from([c])));
    let times = [0.0, 1.0, 2.0];
    let limited = certify(&times, &pieces, &range(2.0), &rates(1.0, 1.0, 1e6));
    assert!(!limited.holds(1e-6));
    let jump = limited.worst_jump().expect("limited");
    assert_eq!((jump.id.quantity, jump.jump, jump.t), (Quantity::JointAcceleration, 2.0, 1.0));
    let unlimited_jerk = certify(&times, &pieces, &range(2.0), &rates(1.0, 1.0, f64::INFINITY));
    assert!(unlimited_jerk.holds(1e-6));
    for (certificate, of_acceleration) in [(&limited, true), (&unlimited_jerk, false)] {
        let all = certificate.jumps().iter().map(|jump| (jump.id.quantity, jump.jump, jump.limited));
        let wanted = [(QUANTITIES[0], 0.0, true), (QUANTITIES[1], 0.0, true), (QUANTITIES[2], 2.0, of_acceleration)];
        assert_eq!(all.collect::<Vec<_>>(), wanted);
    }
}

#[test]
fn nothing_and_numbers_that_are_none_do_not_hold() {
    let none: [Piece<1>; 0] = [];
    assert!(!certify(&[0.0], &none, &range(1.0), &unlimited()).holds(1.0));
    assert!(!certify(&[0.0, 0.0], &[[Joints::zeros(); 6]], &range::<1>(1.0), &unlimited()).holds(1.0));
    for bad in [f64::NAN, f64::INFINITY, 1e308] {
        for power in 0..6 {
            let mut piece: Piece<1> = [Joints::zeros(); 6];
            piece[power][0] = bad;
            let certificate = certify(&[0.0, 1e3], &[piece], &range(1.0), &rates(1.0, 1.0, 1.0));
            assert!(!certificate.holds(1.0), "{bad} in power {power}");
        }
    }
}
