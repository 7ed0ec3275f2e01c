//! Places where the curvature of the joint path jumps while it is in motion.

use arcfeed_kinematics::Joints;

use crate::path::JointPath;

/// A step of acceleration counts for so much, because the speed changes within the control period that it is spread over.
pub(crate) const SPREAD: f64 = 1.005;

/// A jump of the second joint derivatives at a grid point.
///
/// There the acceleration of the joints steps by `|jump of q''| v^2` (the path is only tangent-continuous). No jerk limit allows that in
/// zero time, so it is spread over one control period: within that time of the jump the step takes its part of the jerk.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Jump<const N: usize> {
    /// Grid point.
    pub at: usize,
    /// Magnitudes.
    pub of: Joints<N>,
    /// The way within a control period at the greatest speed at which the step keeps the jerk, units of the parameter.
    pub reach: f64,
}

/// The jumps at grid points other than `stops`, where the motion is at rest. A step of the acceleration is at most `step`, and the
/// speed at most `fastest`.
pub(crate) fn jumps<const N: usize>(
    joints: &JointPath<N>,
    stops: &[usize],
    step: &Joints<N>,
    (fastest, period): (f64, f64),
) -> Vec<Jump<N>> {
    let one = |i: usize| {
        let (left, right) = joints.sides(i);
        let size = left.d2.abs().zip_map(&right.d2.abs(), f64::max);
        // Below this it is rounding.
        let of =
            (right.d2 - left.d2).abs().zip_map(&size, |jump, size| if jump > 1e-7 * (size + 1.0) { jump } else { 0.0 });
        let square = step.component_div(&of).min();
        (square < f64::INFINITY).then(|| Jump { at: i, of, reach: period * square.sqrt().min(fastest) })
    };
    (1..joints.intervals()).filter(|i| stops.binary_search(i).is_err()).filter_map(one).collect()
}

/// For every interval the sum of the jumps that it is near to.
pub(crate) fn near_jumps<const N: usize>(joints: &JointPath<N>, jumps: &[Jump<N>]) -> Vec<Joints<N>> {
    let mut near = vec![Joints::zeros(); joints.intervals()];
    for jump in jumps {
        intervals_near(joints, jump).for_each(|k| near[k] += jump.of);
    }
    near
}

/// The intervals that are near to a jump.
pub(crate) fn intervals_near<'a, const N: usize>(
    joints: &'a JointPath<N>,
    jump: &Jump<N>,
) -> impl Iterator<Item = usize> + use<'a, N> {
    let (nodes, at) = (joints.nodes(), jump.at);
    let (s, reach) = (nodes[at].s, jump.reach * (1.0 - 1e-6));
    let before = (0..at).rev().take_while(move |&k| k + 1 == at || nodes[k + 1].s > s - reach);
    before.chain((at..joints.intervals()).take_while(move |&k| k == at || nodes[k].s < s + reach))
}
