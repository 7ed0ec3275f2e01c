//! One search from one place: damped steps until the target is met or nothing is gained any more.

use super::arm::{NullSpace, NumericArm};
use crate::{
    jacobian::{Configuration, Jacobian, Target, Twist},
    joint::Joints,
    lu::solve_positive,
    traits::ForwardKinematics,
};
#[cfg(not(feature = "std"))]
use num_traits::Float;

/// Steps without gain after which an attempt is given up.
const PATIENCE: usize = 8;
/// Steps from the tolerances to rounding, at most: each halves the miss or is the last.
const POLISH: usize = 20;

/// One attempt's end.
#[derive(Clone, Copy)]
pub(super) struct Attempt<const N: usize> {
    pub(super) q: Joints<N>,
    pub(super) position: f64,
    pub(super) orientation: f64,
    pub(super) converged: bool,
    pub(super) steps: usize,
}

/// The distance of the tool from its target.
struct Miss {
    position: f64,
    orientation: f64,
    /// The twist that leads there.
    error: Twist,
}

impl<const N: usize> NumericArm<N> {
    /// `q` inside the joint range.
    fn inside(&self, q: &Joints<N>) -> Joints<N> {
        q.zip_zip_map(self.range.lower(), self.range.upper(), f64::clamp)
    }

    /// `seed` after a step that also moves redundant joints towards the preferred posture, if there
    /// is one: it is made where the tool stands at its target, too.
    pub(super) fn moved_to_posture(&self, target: &Target, seed: &Joints<N>) -> Option<Joints<N>> {
        let NullSpace::Towards { posture, gain } = self.settings.null_space else { return None };
        if N <= 6 {
            return None;
        }
        let q = self.inside(seed);
        let at = self.chain.configuration(&q);
        let wish = (self.inside(&posture) - q) * gain;
        let dq = self.step(&q, at.jacobian(), Miss::new(target, &at).error, Some(&wish))?;
        Some(self.inside(&(q + dq)))
    }

    /// The distance of `q` from the preferred posture, if there is one.
    pub(super) fn posture_distance(&self, q: &Joints<N>) -> f64 {
        match self.settings.null_space {
            NullSpace::LeastMotion => 0.0,
            NullSpace::Towards { posture, .. } => (self.inside(&posture) - q).norm(),
        }
    }

    /// Steps from `start` until the target is met to rounding or nothing is gained any more.
    pub(super) fn attempt(&self, target: &Target, start: &Joints<N>) -> Attempt<N> {
        let mut q = self.inside(start);
        let mut best = Attempt { q, position: f64::NAN, orientation: f64::NAN, converged: false, steps: 0 };
        let (mut least, mut stalled) = (f64::INFINITY, 0);
        for step in 0..=self.settings.steps.saturating_add(POLISH) {
            let at = self.chain.configuration(&q);
            let Miss { position, orientation, error } = Miss::new(target, &at);
            let miss = position + self.size * orientation;
            let reached = position <= self.settings.position && orientation <= self.settings.orientation;
            // Once it is reached, only what halves the miss is worth a step.
            let gains = miss < if best.converged { 0.5 } else { 0.95 } * least;
            let ends = best.converged && !gains;
            if miss < least && (reached || !best.converged) {
                best = Attempt { q, position, orientation, converged: reached, ..best };
            }
            best.steps = step;
            stalled = if gains { 0 } else { stalled + 1 };
            least = least.min(miss);
            let done = reached && self.chain.residual(&q).covers(position, orientation);
            if ends || done || stalled > PATIENCE || (step >= self.settings.steps && !best.converged) {
                return best;
            }
            let Some(dq) = self.step(&q, at.jacobian(), error, None) else { return best };
            q = self.inside(&(q + dq));
        }
        best
    }

    /// One damped step for the pose error, and as much of `wish` as does not move the tool.
    fn step(
        &self,
        q: &Joints<N>,
        mut scaled: Jacobian<N>,
        mut error: Twist,
        wish: Option<&Joints<N>>,
    ) -> Option<Joints<N>> {
        scaled.fixed_rows_mut::<3>(3).scale_mut(self.size);
        error.fixed_rows_mut::<3>(3).scale_mut(self.size);
        // No more than what makes a step of half the wanted length, or targets far away would be
        // approached too slowly.
        let square = self.size * self.size;
        let damping = (0.5 * error.norm_squared()).min(square) + 1e-15 * square;
        for _ in 0..=N {
            // J wish is asked for on top of the error, and `wish` given back: what is left moves
            // the tool by the error.
            let dq = match wish {
                None => damped(&scaled, &error, damping)?,
                Some(wish) => damped(&scaled, &(error - scaled * wish), damping)? + wish,
            };
            let outwards = |i: usize| {
                let at_limit =
                    (q[i] <= self.range.lower()[i] && dq[i] < 0.0) || (q[i] >= self.range.upper()[i] && dq[i] > 0.0);
                at_limit && scaled.column(i).amax() > 0.0
            };
            let mut pushed = false;
            let blocked: [bool; N] = std::array::from_fn(outwards);
            for (i, blocked) in blocked.into_iter().enumerate() {
                if blocked {
                    scaled.column_mut(i).fill(0.0);
                    pushed = true;
                }
            }
            if !pushed {
                return Some(dq);
            }
        }
        None
    }
}

/// The damped least-squares solution of `j x = e`.
fn damped<const N: usize>(j: &Jacobian<N>, e: &Twist, damping: f64) -> Option<Joints<N>> {
    if N < 6 {
        let normal = j.transpose() * j;
        let matrix =
            std::array::from_fn(|r| std::array::from_fn(|c| normal[(r, c)] + if r == c { damping } else { 0.0 }));
        let right = j.transpose() * e;
        Some(Joints::from(solve_positive::<N>(matrix, std::array::from_fn(|i| right[i]))?))
    } else {
        let mut matrix = [[0.0; 6]; 6];
        for r in 0..6 {
            for c in 0..=r {
                matrix[r][c] = (0..N).map(|k| j[(r, k)] * j[(c, k)]).sum();
            }
            matrix[r][r] += damping;
        }
        let dual = Twist::from(solve_positive::<6>(matrix, (*e).into())?);
        Some(j.transpose() * dual)
    }
}

impl Miss {
    fn new<const N: usize>(target: &Target, at: &Configuration<N>) -> Self {
        let mut error = target.error(at);
        let position = error.fixed_rows::<3>(0).norm();
        // The error holds the sine of the angle, which falls off beyond a right angle: stretch it
        // to the angle.
        let sine = error.fixed_rows::<3>(3).norm();
        let cosine = target.cosine(at);
        // Next to the target the series of the arc sine is exact and cheap.
        let near = sine < 1e-3 && cosine > 0.0;
        let orientation = if near { sine * (1.0 + sine * sine / 6.0) } else { sine.atan2(cosine) };
        if orientation > 0.1 && sine > 1e-9 {
            error.fixed_rows_mut::<3>(3).scale_mut(orientation / sine);
        }
        Self { position, orientation, error }
    }
}
