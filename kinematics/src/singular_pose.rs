//! Singular poses near given joint values, for arms of any geometry.
//!
//! J is singular where its smallest singular value is 0. With J = U S V^T, s the weakest singular vector on the shorter
//! side of J (joints for up to six joints, tool for more) and l_i those on the longer side that the other singular values
//! leave over, that is where all c_i = s^T J l_i vanish: |N - 6| + 1 conditions. The nearest such pose solves
//! min |x - q|^2 subject to c(x) = 0, step by step with c replaced by its tangent at the step before,
//! `x = q + G^+ (G (p - q) - c)` (Hasofer, Lind, Rackwitz, Fiessler; G the gradients of c at p).

use crate::{
    chain::Chain,
    jacobian::{Configuration, Jacobian, Twist},
    joint::{JointKind, JointRange, Joints},
    lu::solve_positive,
    singularity::{dot, orthogonalise},
    singularity_kind::SingularityKind,
    traits::ForwardKinematics,
};
use nalgebra::Vector3;
#[cfg(not(feature = "std"))]
use num_traits::Float;

/// Smallest singular value, relative to the largest, that counts as 0.
const SINGULAR: f64 = 1e-9;
/// Steps of one search.
const STEPS: usize = 60;
/// The first of these look for the nearest pose; the others only for a singular one.
const NEAREST_STEPS: usize = 50;
/// After these the steps are halved: whole ones go to and fro where the singular poses are curved more than the sphere around
/// the given ones.
const WHOLE_STEPS: usize = 15;
/// Conditions that are kept: enough for arms of up to 13 joints.
const MOST_CONDITIONS: usize = 8;
/// Largest change of a joint in a step, rad (m).
const LARGEST_STEP: f64 = 0.5;
/// Distance and number of steps each way in which searches look along each joint for a place to start from.
const LOOK: f64 = std::f64::consts::PI;
const LOOKS: i32 = 48;

/// The motion at which the tool moves least: J `joints` = `sigma` `tool`, both of unit length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WeakestMotion<const N: usize> {
    /// Smallest singular value of the Jacobian.
    pub sigma: f64,
    /// Joint rates of norm 1; of redundant joints those without self-motion.
    pub joints: Joints<N>,
    /// The direction in which the tool then moves: at a singular pose, the one it has lost.
    pub tool: Twist,
}

/// A singular pose near given joint values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SingularPose<const N: usize> {
    /// Its joint values, inside the joint range.
    pub q: Joints<N>,
    /// |q - given q|, rad (sliding joints: m): no less than the distance from the nearest singular pose of all. That one may be
    /// missed where another is less than some degrees away from it.
    pub distance: f64,
    /// The direction in which the tool cannot move there.
    pub lost: Twist,
    /// The kind, where geometry tells. Wrist: the last three axes are parallel to one plane. Of the others with six
    /// joints, those whose cancelling motions have a part of joint 1 are at the shoulder, the rest at the elbow. With more
    /// joints, shoulder: the first three axes are parallel to one plane; elbow: what is lost is the motion along the line
    /// from shoulder to wrist. None for fewer than six joints, sliding joints and what is nothing of these.
    pub kind: Option<SingularityKind>,
}

/// The weakest motion of an arm at one place: smallest singular value with its two directions.
///
/// ```
/// use arcfeed_kinematics::{ForwardKinematics, Joints, models, weakest_motion};
/// let arm = models::panda();
/// let jacobian = arm.jacobian(&Joints::<7>::from([0.1, -0.4, 0.2, -2.0, 0.1, 1.6, 0.7]));
/// let weakest = weakest_motion(&jacobian);
/// assert!((jacobian * weakest.joints - weakest.tool * weakest.sigma).norm() < 1e-14);
/// ```
pub fn weakest_motion<const N: usize>(jacobian: &Jacobian<N>) -> WeakestMotion<N> {
    let Weak { sigma, pairs, .. } = Weak::new(jacobian);
    let (tool, joints) = pairs[0];
    WeakestMotion { sigma, joints, tool }
}

/// The weakest singular vectors: of the tool and of the joints. On the shorter side of J there is one, the same in all
/// pairs, on the longer one those that the other singular values leave over, the weakest first.
struct Weak<const N: usize> {
    sigma: f64,
    largest: f64,
    pairs: [(Twist, Joints<N>); MOST_CONDITIONS],
    count: usize,
}

impl<const N: usize> Weak<N> {
    fn new(jacobian: &Jacobian<N>) -> Self {
        let mut pairs = [(Twist::zeros(), Joints::zeros()); MOST_CONDITIONS];
        if N <= 6 {
            let mut columns: [[f64; 6]; N] = std::array::from_fn(|c| std::array::from_fn(|r| jacobian[(r, c)]));
            let (sigma, largest, joints, tools, count) = split(&mut columns);
            pairs.iter_mut().zip(tools).for_each(|(pair, tool)| *pair = (tool.into(), joints.into()));
            Self { sigma, largest, pairs, count }
        } else {
            let mut rows: [[f64; N]; 6] = std::array::from_fn(|r| std::array::from_fn(|c| jacobian[(r, c)]));
            let (sigma, largest, tool, joints, count) = split(&mut rows);
            pairs.iter_mut().zip(joints).for_each(|(pair, joints)| *pair = (tool.into(), joints.into()));
            Self { sigma, largest, pairs, count: count.min(MOST_CONDITIONS) }
        }
    }
}

/// Least and largest singular value of `K` vectors of length `D`, the combination of the vectors that is least, and what
/// the other `K` - 1 combinations leave over of the space.
fn split<const D: usize, const K: usize>(vectors: &mut [[f64; D]; K]) -> (f64, f64, [f64; K], [[f64; D]; D], usize) {
    let mut basis: [[f64; K]; K] = std::array::from_fn(|i| std::array::from_fn(|k| f64::from(u8::from(i == k))));
    orthogonalise(vectors, &mut basis);
    let lengths = vectors.map(|vector| dot(&vector, &vector).sqrt());
    let weakest = (0..K).fold(0, |least, i| if lengths[i] < lengths[least] { i } else { least });
    let largest = lengths.iter().fold(0.0_f64, |most, length| most.max(*length));
    // An orthonormal basis: the others first, then the weakest unless it is noise, then what is missing.
    let mut all = [[0.0; D]; D];
    let mut known = 0;
    let mut add = |vector: &[f64; D]| {
        let mut rest = *vector;
        for _ in 0..2 {
            for one in &all[..known] {
                let along = dot(&rest, one);
                rest.iter_mut().zip(one).for_each(|(r, o)| *r -= along * o);
            }
        }
        let length = dot(&rest, &rest).sqrt();
        if length > 0.3 * dot(vector, vector).sqrt() && known < D {
            all[known] = rest.map(|v| v / length);
            known += 1;
        }
        known
    };
    let mut others = 0;
    for i in (0..K).filter(|i| *i != weakest && lengths[*i] > 1e-12 * largest) {
        others = add(&vectors[i]);
    }
    if K > 0 && lengths[weakest] > 1e-9 * largest {
        add(&vectors[weakest]);
    }
    // Of D unit vectors, one at least is at more than 1 / sqrt(D) from any subspace.
    for k in (0..D).chain(0..D) {
        add(&std::array::from_fn(|i| f64::from(u8::from(i == k))));
    }
    let mut left = [[0.0; D]; D];
    let count = (D + 1).saturating_sub(K).min(known.saturating_sub(others));
    left[..count].copy_from_slice(&all[others..others + count]);
    let (sigma, short) = if K > 0 { (lengths[weakest], basis[weakest]) } else { (0.0, [0.0; K]) };
    (sigma, largest, short, left, count)
}

/// The derivatives of `tool`^T J `joints` by the joints, the two held fixed.
fn gradient<const N: usize>(at: &Configuration<N>, tool: &Twist, joints: &Joints<N>) -> Joints<N> {
    let (force, moment) = (Vector3::new(tool[0], tool[1], tool[2]), Vector3::new(tool[3], tool[4], tool[5]));
    let arm = |i: usize| at.axes()[i].cross(&(at.position() - at.points()[i]));
    Joints::from_fn(|k, _| {
        let mut sum = 0.0;
        for j in 0..N {
            let (zk, zj) = (&at.axes()[k], &at.axes()[j]);
            sum += joints[j]
                * match (at.kinds[k], at.kinds[j]) {
                    (JointKind::Revolute, JointKind::Revolute) if k < j => {
                        force.dot(&zk.cross(&arm(j))) + moment.dot(&zk.cross(zj))
                    }
                    (JointKind::Revolute, JointKind::Revolute) => force.dot(&zj.cross(&arm(k))),
                    (JointKind::Revolute, JointKind::Prismatic) if k < j => force.dot(&zk.cross(zj)),
                    (JointKind::Prismatic, JointKind::Revolute) if k > j => force.dot(&zj.cross(zk)),
                    _ => 0.0,
                };
        }
        sum
    })
}

/// The numbers of steps at which `value` is less than beside them; where it does not change there is none.
fn least_places(value: impl Fn(f64) -> f64) -> impl Iterator<Item = f64> {
    let mut values = (value(f64::from(-LOOKS - 1)), value(f64::from(-LOOKS)));
    (-LOOKS..=LOOKS).map(f64::from).filter(move |step| {
        let next = value(step + 1.0);
        let level = values.1 * (1.0 + 1e-9);
        let least = values.1 <= values.0 && values.1 <= next && (level < values.0 || level < next);
        values = (values.1, next);
        least
    })
}

/// Where `value` is least on [a, b], by golden sections, to 1e-11 of a step.
fn least_of(value: impl Fn(f64) -> f64, mut a: f64, mut b: f64) -> f64 {
    const PART: f64 = 0.381_966_011_250_105_1;
    let (mut x, mut y) = (a + PART * (b - a), b - PART * (b - a));
    let mut values = (value(x), value(y));
    for _ in 0..54 {
        if values.0 <= values.1 {
            (b, y, values.1) = (y, x, values.0);
            x = a + PART * (b - a);
            values.0 = value(x);
        } else {
            (a, x, values.0) = (x, y, values.1);
            y = b - PART * (b - a);
            values.1 = value(y);
        }
    }
    if values.0 <= values.1 { x } else { y }
}

/// The search for singular poses of one arm.
pub(crate) struct Search<'a, const N: usize> {
    pub(crate) chain: &'a Chain<N>,
    pub(crate) range: &'a JointRange<N>,
    /// Weighs angles against lengths, m/rad.
    pub(crate) size: f64,
}

impl<const N: usize> Search<'_, N> {
    /// The nearest of the singular poses found from `q` and from the places along each joint's motion where the smallest
    /// singular value is least.
    pub(crate) fn around(&self, q: &Joints<N>) -> Option<SingularPose<N>> {
        let mut best = self.from(q, q);
        let inside = q.zip_zip_map(self.range.lower(), self.range.upper(), f64::clamp);
        for joint in 0..N {
            // Both by the number of steps from the given place, whole or not.
            let place = |steps: f64| {
                let mut place = inside;
                place[joint] += LOOK * steps / f64::from(LOOKS);
                (self.range.lower()[joint] <= place[joint] && place[joint] <= self.range.upper()[joint])
                    .then_some(place)
            };
            let weak = |steps: f64| place(steps).map(|place| self.weak(&self.chain.configuration(&place)));
            let sigma = |steps: f64| weak(steps).map_or(f64::INFINITY, |weak| weak.sigma);
            for around in least_places(&sigma) {
                let least = least_of(sigma, around - 1.0, around + 1.0);
                // This joint alone leads to a singular pose, or it is a place to start from.
                let singular = weak(least).is_some_and(|weak| weak.sigma <= SINGULAR * weak.largest);
                let start = place(least);
                let alone = start.filter(|_| singular).map(|start| self.found(&start, q));
                let nearer = start.and_then(|start| self.from(&start, q));
                for found in alone.into_iter().chain(nearer) {
                    if best.is_none_or(|best| found.distance < best.distance) {
                        best = Some(found);
                    }
                }
            }
        }
        // Where two kinds of singular poses meet, one of them may do, with a joint back at its given value.
        for joint in 0..N {
            let Some(nearest) = best else { break };
            let mut start = nearest.q;
            start[joint] = inside[joint];
            if let Some(found) = self.from(&start, q).filter(|found| found.distance < nearest.distance) {
                best = Some(found);
            }
        }
        best
    }

    fn weak(&self, at: &Configuration<N>) -> Weak<N> {
        let mut jacobian = at.jacobian();
        jacobian.fixed_rows_mut::<3>(3).scale_mut(self.size);
        Weak::new(&jacobian)
    }

    /// The singular pose near `q` that a search from `start` ends at, if it ends at one inside the joint range.
    pub(crate) fn from(&self, start: &Joints<N>, q: &Joints<N>) -> Option<SingularPose<N>> {
        if N == 0 || !start.iter().chain(q.iter()).all(|v| v.is_finite()) {
            return None;
        }
        let (lower, upper) = (self.range.lower(), self.range.upper());
        // What the distance is measured from; joints that the search drives out of their range are held at its end.
        let mut centre = q.zip_zip_map(lower, upper, f64::clamp);
        let (mut held, mut landing) = ([false; N], false);
        let mut p = start.zip_zip_map(lower, upper, f64::clamp);
        for step in 0..STEPS {
            let at = self.chain.configuration(&p);
            let weak = self.weak(&at);
            let singular = weak.sigma <= SINGULAR * weak.largest;
            // At last onto the singular pose, without a pull towards the centre.
            landing |= step >= NEAREST_STEPS;
            // Normal equations of G, and of G (p - centre) - c.
            let (mut square, mut right) = ([[0.0; N]; N], [0.0; N]);
            let from = if landing { p } else { centre };
            for (tool, joints) in &weak.pairs[..weak.count] {
                let mut weight = *tool;
                weight.fixed_rows_mut::<3>(3).scale_mut(self.size);
                let mut g = gradient(&at, &weight, joints);
                (0..N).filter(|i| held[*i]).for_each(|i| g[i] = 0.0);
                let wanted = g.dot(&(p - from)) - weight.dot(&(at.jacobian() * joints));
                for r in 0..N {
                    right[r] += g[r] * wanted;
                    (0..N).for_each(|c| square[r][c] += g[r] * g[c]);
                }
            }
            let trace: f64 = (0..N).map(|i| square[i][i]).sum();
            if trace <= 1e-20 * weak.largest * weak.largest {
                // Singular here and all around, or nowhere to go from here.
                return singular.then(|| self.found(&p, q));
            }
            (0..N).for_each(|i| square[i][i] += 1e-9 * trace);
            let mut next = from + Joints::from(solve_positive::<N>(square, right)?);
            if !landing && step >= WHOLE_STEPS {
                next = (next + p) * 0.5;
            }
            let longest = (next - p).amax();
            if longest > LARGEST_STEP {
                next = p + (next - p) * (LARGEST_STEP / longest);
            }
            for i in 0..N {
                if !(lower[i] <= next[i] && next[i] <= upper[i]) {
                    next[i] = next[i].clamp(lower[i], upper[i]);
                    (centre[i], held[i]) = (next[i], true);
                }
            }
            if singular && (next - p).amax() < 1e-7 {
                if landing {
                    return Some(self.found(&next, q));
                }
                landing = true;
            }
            p = next;
        }
        None
    }

    fn found(&self, singular: &Joints<N>, q: &Joints<N>) -> SingularPose<N> {
        let at = self.chain.configuration(singular);
        let weakest = weakest_motion(&at.jacobian());
        SingularPose { q: *singular, distance: (singular - q).norm(), lost: weakest.tool, kind: kind(&at, &weakest) }
    }
}

/// The kind of the singular pose at this place.
fn kind<const N: usize>(at: &Configuration<N>, weakest: &WeakestMotion<N>) -> Option<SingularityKind> {
    const SMALL: f64 = 1e-6;
    let (z, o) = (at.axes(), at.points());
    if N < 6 || at.kinds.contains(&JointKind::Prismatic) {
        return None;
    }
    let flat = |first: usize| z[first].dot(&z[first + 1].cross(&z[first + 2])).abs() < SMALL;
    if flat(N - 3) {
        return Some(SingularityKind::Wrist);
    }
    if N == 6 {
        // The joints whose motions cancel: does the first one take part?
        let first = weakest.joints[0].abs() > SMALL;
        return Some(if first { SingularityKind::Shoulder } else { SingularityKind::Elbow });
    }
    if flat(0) {
        return Some(SingularityKind::Shoulder);
    }
    // From the foot of axis 2 at axis 1 to that of the last but one at the one before.
    let foot = |on: usize, to: usize| {
        let across = z[on].cross(&z[to]);
        let along = (o[to] - o[on]).cross(&z[to]).dot(&across) / across.norm_squared().max(SMALL * SMALL);
        o[on] + z[on] * along
    };
    let arm = foot(N - 2, N - 3) - foot(1, 0);
    let lost = Vector3::new(weakest.tool[0], weakest.tool[1], weakest.tool[2]);
    (lost.cross(&arm).norm() < SMALL * arm.norm()).then_some(SingularityKind::Elbow)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Joint;
    use nalgebra::Isometry3;

    #[test]
    fn the_least_value_is_found_wherever_in_the_interval_it_is() {
        for i in 0..=100 {
            let least = -1.0 + 0.03 * f64::from(i);
            let found = least_of(|x| (x - least).abs() * (1.0 + 0.3 * (x - least).sin()), -1.0, 2.0);
            assert!((found - least).abs() < 1e-9, "{found} instead of {least}");
        }
    }

    #[test]
    fn gradients_are_difference_quotients() {
        let joint = |i: usize| {
            let k = i as f64;
            let origin = Isometry3::new(Vector3::new(0.2, 0.1 * k, 0.3), Vector3::new(0.4 * k, 0.3, -0.2 * k));
            let kind = if i % 3 == 1 { JointKind::Prismatic } else { JointKind::Revolute };
            Joint::new(origin, Vector3::new(0.1, 0.2 * k, 1.0), kind)
        };
        let joints = [0, 1, 2, 3, 4, 5].map(|i| joint(i).expect("an axis"));
        let arm = Chain::new(joints).expect("finite");
        let q = Joints::<6>::from([0.3, 0.1, -0.4, 0.8, -0.2, 0.5]);
        let (tool, motion) =
            (Twist::from([0.3, -0.2, 0.5, 0.7, -0.4, 0.1]), Joints::from([0.2, 0.5, -0.6, 0.3, 0.4, -0.1]));
        let slope = gradient(&arm.configuration(&q), &tool, &motion);
        for i in 0..6 {
            let at = |step: f64| {
                let mut moved = q;
                moved[i] += step;
                tool.dot(&(arm.jacobian(&moved) * motion))
            };
            let quotient = (at(1e-5) - at(-1e-5)) / 2e-5;
            assert!((slope[i] - quotient).abs() < 1e-9, "{i}: {} {quotient}", slope[i]);
        }
    }
}
