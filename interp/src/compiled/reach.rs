//! Bounds on the derivatives of a tool by time, from bounds on those of the joints and the lengths of the arm.
//!
//! A joint turns all that follows it. So the derivative of the tool point by several joint values is at most the reach of the
//! outermost of these joints: the sum of the lengths from it to the tool. See `docs/certificate.md`.

use arcfeed_kinematics::{ForwardKinematics, Joints};

use super::bernstein::Bernstein;
use super::certificate::Motion;

/// The reach of every joint of an arm during a motion.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reach<const N: usize> {
    /// Largest distance from a joint to the tool point, m; 1 for a joint that slides, which moves the tool by as much as itself.
    reach: [f64; N],
    /// True if a joint turns the tool.
    turns: [bool; N],
}

/// Bounds on velocity, acceleration, jerk and the first two derivatives of the jerk of every joint.
#[derive(Debug, Clone, Copy)]
pub(super) struct JointRateBounds<const N: usize> {
    pub velocity: [f64; N],
    pub acceleration: [f64; N],
    pub jerk: [f64; N],
    pub snap: [f64; N],
    pub crackle: [f64; N],
}

impl<const N: usize> JointRateBounds<N> {
    /// For a piece of a motion.
    pub fn of(motion: &Motion<'_, N>, piece: usize) -> Self {
        let of = |order: usize| std::array::from_fn(|joint| motion.bernstein(piece, joint, order, 0.0).bound());
        Self { velocity: of(1), acceleration: of(2), jerk: of(3), snap: of(4), crackle: of(5) }
    }
}

impl<const N: usize> Reach<N> {
    /// For the arm `arm` during a motion.
    pub fn of(arm: &dyn ForwardKinematics<N>, motion: &Motion<'_, N>) -> Self {
        let start = motion.pieces.first().map_or(Joints::zeros(), |piece| piece[0]);
        let configuration = arm.configuration(&start);
        let jacobian = configuration.jacobian();
        let turns: [bool; N] = std::array::from_fn(|j| jacobian.fixed_view::<3, 1>(3, j).norm() > 0.5);
        let (points, tool) = (configuration.points(), configuration.position());
        let mut reach = [0.0; N];
        let mut beyond = 0.0;
        for j in (0..N).rev() {
            let next = if j + 1 < N { &points[j + 1] } else { tool };
            beyond += (next - points[j]).norm();
            if !turns[j] {
                // A joint that slides makes the arm longer by at most its way from the start.
                let way = |piece| Bernstein::bound(&motion.bernstein(piece, j, 0, start[j]));
                beyond += (0..motion.pieces.len()).map(way).fold(0.0, f64::max);
            }
            reach[j] = if turns[j] { beyond } else { 1.0 };
        }
        Self { reach, turns }
    }

    /// By how much the tool point and its orientation move at most when each joint moves by 1.
    pub fn per_unit(&self) -> [f64; 2] {
        [self.reach.iter().sum(), self.turns.iter().filter(|turns| **turns).count() as f64]
    }

    /// Bounds on speed and acceleration of the tool point, and on its angular speed.
    pub fn largest_rates(&self, rates: &JointRateBounds<N>) -> [f64; 3] {
        let JointRateBounds { velocity: v, acceleration: a, .. } = rates;
        let (mut point, mut change, mut turning, mut speed) = (0.0, 0.0, 0.0, 0.0_f64);
        for i in 0..N {
            point += self.reach[i] * v[i];
            change += self.reach[i] * (a[i] + (speed + v[i]).powi(2) - speed.powi(2));
            turning += if self.turns[i] { v[i] } else { 0.0 };
            speed += v[i];
        }
        [point, change, turning]
    }

    /// Bounds on the third and the fourth derivative of the tool point by time.
    pub fn point_rates(&self, rates: &JointRateBounds<N>) -> [f64; 2] {
        let JointRateBounds { velocity: v, acceleration: a, jerk: j, snap, .. } = rates;
        let one = |x: &[f64; N]| (0..N).map(|i| self.reach[i] * x[i]).sum::<f64>();
        let (mut va, mut vj, mut aa) = (0.0, 0.0, 0.0);
        for i in 0..N {
            for k in 0..N {
                let reach = self.reach[i.max(k)];
                va += reach * v[i] * a[k];
                vj += reach * v[i] * j[k];
                aa += reach * a[i] * a[k];
            }
        }
        // Sums over all choices of several joints, by the outermost one: those up to it less those before it.
        let (mut vvv, mut vvva, mut vvvv) = (0.0, 0.0, 0.0);
        let (mut speed, mut pull) = (0.0_f64, 0.0_f64);
        for i in 0..N {
            let (speed_to, pull_to) = (speed + v[i], pull + a[i]);
            vvv += self.reach[i] * (speed_to.powi(3) - speed.powi(3));
            vvva += self.reach[i] * (speed_to.powi(2) * pull_to - speed.powi(2) * pull);
            vvvv += self.reach[i] * (speed_to.powi(4) - speed.powi(4));
            (speed, pull) = (speed_to, pull_to);
        }
        [one(j) + 3.0 * va + vvv, one(snap) + 4.0 * vj + 3.0 * aa + 6.0 * vvva + vvvv]
    }

    /// A bound on the fifth derivative of the tool point by time.
    ///
    /// All choices of joints whose outermost one is `i` are those up to `i` less those before it.
    pub fn fifth_rate(&self, rates: &JointRateBounds<N>) -> f64 {
        let orders = [&rates.velocity, &rates.acceleration, &rates.jerk, &rates.snap, &rates.crackle];
        let (mut sums, mut before, mut fifth) = ([0.0; 5], 0.0, 0.0);
        for i in 0..N {
            for (sum, rate) in sums.iter_mut().zip(orders) {
                *sum += rate[i];
            }
            let [v, a, j, s, c]: [f64; 5] = sums;
            let single = c + 5.0 * v * s + 10.0 * a * j;
            let several = 10.0 * v * v * j + 15.0 * v * a * a + 10.0 * v.powi(3) * a + v.powi(5);
            fifth += self.reach[i] * (single + several - before);
            before = single + several;
        }
        fifth
    }

    /// A bound on the second derivative of the angular velocity of the tool by time.
    pub fn turning_rate(&self, rates: &JointRateBounds<N>) -> f64 {
        let JointRateBounds { velocity: v, acceleration: a, jerk: j, .. } = rates;
        // Bounds on angular velocity and acceleration of the link before a joint.
        let (mut spin, mut spin_rate, mut sum) = (0.0, 0.0, 0.0);
        for i in (0..N).filter(|i| self.turns[*i]) {
            sum += j[i] + 2.0 * spin * a[i] + (spin_rate + spin * spin) * v[i];
            spin_rate += a[i] + spin * v[i];
            spin += v[i];
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use arcfeed_kinematics::{Chain, Joint, models};
    use nalgebra::{Complex, Isometry3, Vector3};

    fn still<const N: usize>() -> Vec<[Joints<N>; 6]> {
        vec![[Joints::zeros(); 6]]
    }

    fn reach<const N: usize>(arm: &dyn ForwardKinematics<N>) -> Reach<N> {
        Reach::of(arm, &Motion { times: &[0.0, 1.0], pieces: &still() })
    }

    fn planar(lengths: [f64; 3]) -> Chain<3> {
        let joint = |x: f64| Joint::revolute(Isometry3::translation(x, 0.0, 0.0), Vector3::z()).expect("a joint");
        let tool = Isometry3::translation(lengths[2], 0.0, 0.0);
        let chain = Chain::new([joint(0.0), joint(lengths[0]), joint(lengths[1])]).expect("an arm");
        chain.with_tool(tool).expect("a tool")
    }

    /// A planar arm that is stretched out attains the bounds, term by term: no term can be smaller.
    #[test]
    fn a_stretched_arm_attains_every_term() {
        let lengths = [0.5, 0.4, 0.3];
        let reach = reach(&planar(lengths));
        for (powers, order) in [
            ([0.0, 0.0, 0.0, 1.0], 3),
            ([-4.0, 0.0, -9.0, -9.0], 3),
            ([0.0, -9.0, -9.0, -9.0], 3),
            ([0.0, 0.0, 0.0, 9.0], 4),
            ([-4.0, -9.0, 0.0, -19.0], 4),
            ([-9.0, 0.0, -19.0, -19.0], 4),
            ([0.0, -4.0, -9.0, -19.0], 4),
            ([0.0, -9.0, -9.0, -19.0], 4),
        ] {
            let scale: [f64; 4] = powers.map(|p| if p == 0.0 { 1.0 } else { 10_f64.powf(p) });
            let scale = if order == 3 && powers[3] == 1.0 { [1e-9, 1e-9, 10.0, 1.0] } else { scale };
            let scale = if powers[3] == 9.0 { [1e-9, 1e-9, 1e-9, 1e9] } else { scale };
            let of = |order: usize| [1.0, 0.7, 1.3].map(|x| x * scale[order - 1]);
            let rates =
                JointRateBounds { velocity: of(1), acceleration: of(2), jerk: of(3), snap: of(4), crackle: [0.0; 3] };
            // Each link is a complex number l e^(i phi), its angle the sum of all joints before it.
            let mut sums = [0.0; 4];
            let (mut third, mut fourth) = (Complex::new(0.0, 0.0), Complex::new(0.0, 0.0));
            let i = Complex::i();
            for k in 0..3 {
                for (sum, rate) in sums.iter_mut().zip([of(1), of(2), of(3), of(4)]) {
                    *sum += rate[k];
                }
                let [d1, d2, d3, d4] = sums;
                third += (i * d3 - 3.0 * d1 * d2 - i * d1.powi(3)) * lengths[k];
                fourth +=
                    (i * d4 - (4.0 * d1 * d3 + 3.0 * d2 * d2) - i * (6.0 * d1 * d1 * d2) + d1.powi(4)) * lengths[k];
            }
            let bound = reach.point_rates(&rates)[order - 3];
            let attained = if order == 3 { third.norm() } else { fourth.norm() };
            assert!(attained <= bound * (1.0 + 1e-12), "{powers:?}: {attained} > {bound}");
            assert!(attained >= bound * (1.0 - 1e-3), "{powers:?}: {attained} << {bound}");
        }
    }

    /// On a planar arm the sum of the sizes of all terms is that of `l exp(phi)` over the links, `phi` the sum of the joints up to each:
    /// its derivatives come from `y' = phi' y` without a formula for them.
    #[test]
    fn the_sum_of_all_terms_is_that_of_the_exponential() {
        let lengths = [0.5, 0.4, 0.3];
        let rates = JointRateBounds {
            velocity: [1.0, 0.7, 1.3],
            acceleration: [0.4, 2.0, 0.9],
            jerk: [3.0, 0.2, 1.7],
            snap: [0.6, 5.0, 2.2],
            crackle: [4.0, 0.3, 6.0],
        };
        let mut expected = [0.0; 3];
        for link in 0..3 {
            let of = [&rates.velocity, &rates.acceleration, &rates.jerk, &rates.snap, &rates.crackle];
            let phi = of.map(|x| x[..=link].iter().sum::<f64>());
            let choose = [
                [1.0, 0.0, 0.0, 0.0, 0.0],
                [1.0, 1.0, 0.0, 0.0, 0.0],
                [1.0, 2.0, 1.0, 0.0, 0.0],
                [1.0, 3.0, 3.0, 1.0, 0.0],
                [1.0, 4.0, 6.0, 4.0, 1.0],
            ];
            let mut y = vec![1.0];
            for n in 0..5 {
                y.push((0..=n).map(|k| choose[n][k] * phi[k] * y[n - k]).sum::<f64>());
            }
            expected[0] += lengths[link] * y[3];
            expected[1] += lengths[link] * y[4];
            expected[2] += lengths[link] * y[5];
        }
        let reach = reach(&planar(lengths));
        let [third, fourth] = reach.point_rates(&rates);
        let bounds = [third, fourth, reach.fifth_rate(&rates)];
        for (bound, expected) in bounds.into_iter().zip(expected) {
            assert!((bound - expected).abs() <= 1e-12 * expected, "{bound} is not {expected}");
        }
    }

    /// Arms in space at random states: jerk of the tool by the kinematics of the arm, within the bounds.
    #[test]
    fn tools_of_arms_in_space_keep_the_bounds() {
        fn holds<const N: usize>(arm: &dyn ForwardKinematics<N>, seed: u64) -> [f64; 2] {
            let mut seed = seed;
            let mut random = || {
                seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
            };
            let (reach, mut most) = (reach(arm), [0.0, 0.0]);
            for _ in 0..20_000 {
                let mut joints = |size: f64| Joints::<N>::from_fn(|_, _| size * random());
                let [q, qd, qdd, jerk] = [joints(3.0), joints(1.0), joints(2.0), joints(3.0)];
                let size = |x: &Joints<N>| std::array::from_fn(|k| x[k].abs());
                let rates = JointRateBounds {
                    velocity: size(&qd),
                    acceleration: size(&qdd),
                    jerk: size(&jerk),
                    snap: [0.0; N],
                    crackle: [0.0; N],
                };
                let twist = arm.jacobian(&q) * jerk + arm.jerk_bias(&q, &qd, &qdd);
                let linear = twist.fixed_rows::<3>(0).norm() / reach.point_rates(&rates)[0];
                let angular = twist.fixed_rows::<3>(3).norm() / reach.turning_rate(&rates);
                assert!(linear <= 1.0 && angular <= 1.0, "{linear} {angular} at {q}");
                most = [linear.max(most[0]), angular.max(most[1])];
            }
            most
        }
        for most in [
            holds(&models::ur5e(), 1),
            holds(&models::cr7(), 2),
            holds(&models::puma560(), 3),
            holds(&models::panda(), 4),
        ] {
            // The bounds say something.
            assert!(most[0] > 0.2 && most[1] > 0.3, "{most:?}");
        }
    }

    /// The first two axes of this arm are at a right angle: one joint turns the axis of the other, and every term is attained.
    #[test]
    fn two_axes_at_a_right_angle_attain_every_term_of_turning() {
        let arm = models::puma560();
        let reach = reach(&arm);
        let two = |a: f64, b: f64| Joints::from([a, b, 0.0, 0.0, 0.0, 0.0]);
        for (qd, qdd, jerk) in [
            (two(1e-6, 0.0), two(0.0, 1.0), two(0.0, 0.0)),
            (two(0.0, 1e-6), two(1.0, 0.0), two(0.0, 0.0)),
            (two(1.0, 1e-6), two(0.0, 0.0), two(0.0, 0.0)),
            (two(0.0, 0.0), two(0.0, 0.0), two(0.0, 1.0)),
        ] {
            let size = |x: &Joints<6>| std::array::from_fn(|k| x[k].abs());
            let rates = JointRateBounds {
                velocity: size(&qd),
                acceleration: size(&qdd),
                jerk: size(&jerk),
                snap: [0.0; 6],
                crackle: [0.0; 6],
            };
            let q = Joints::repeat(0.3);
            let twist = arm.jacobian(&q) * jerk + arm.jerk_bias(&q, &qd, &qdd);
            let (attained, bound) = (twist.fixed_rows::<3>(3).norm(), reach.turning_rate(&rates));
            assert!(attained <= bound * (1.0 + 1e-9) && attained >= bound * (1.0 - 1e-3), "{attained} {bound}");
        }
    }
}
