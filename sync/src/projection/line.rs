//! The plan: the part of the motion along the line, the part that brakes across it, and both over
//! time.
//!
//! The motion from `(q0, v, a)` to rest at `g` is composed as
//!
//! ```text
//! q(t) = q0 + u x(t) + w(t),     x: 0 -> 1,  x'(0) = alpha, x''(0) = beta,
//!                                w: 0 -> D,  w'(0) = v - alpha u,  w''(0) = a - beta u,  each coordinate braking to rest,
//!                                u = g - q0 - D,
//! ```
//!
//! so that both parts end at rest in `g`, and from the moment `w` rests the error is parallel to
//! `u`: a straight line. `alpha u` and `beta u` are the projections of velocity and acceleration on
//! the error.
//!
//! **Why the limits hold.** The transverse part is planned first. Over the time that is left of it,
//! its derivatives run through known ranges; what these leave of every limit, divided by the
//! component of `u`, bounds the derivatives of `x` (the least over the coordinates: Liu et al.
//! 2024, eq. 17, corrected). `x` is time-optimal within these bounds, so the sum is inside the
//! limits whatever the phases of the two. While `w` brakes the ranges shrink and the bounds widen;
//! `x` is planned again at [`STAGES`] moments from where it is then, which is inside the wider
//! bounds too.

use arcfeed_feedrate::{AxisLimits, AxisState, MotionLaw, MotionState, StateToState};
use nalgebra::{SMatrix, SVector};

use super::feasible_set::{FLOOR, FeasibleSet, Order, SLACK, ScalarBounds};
use super::transverse_brake::{Ranges, TransverseBrake};

/// Number of times the line takes up what the transverse part has freed.
pub(super) const STAGES: usize = 4;

/// Parts of the limits that the transverse motion may take; the best is kept.
const SHARES: [f64; 2] = [0.2, 0.55];

/// Parts of the projected velocity and acceleration tried, in this order.
const TRIES: [(f64, f64); 4] = [(1.0, 1.0), (1.0, 0.8), (0.6, 0.45), (0.0, 0.0)];

/// Steps to make the line end where the transverse part lets it.
const MAX_STEPS: usize = 40;

#[derive(Debug, Clone, Copy)]
pub(super) struct LinePlan<const M: usize> {
    /// From where `w` ends to the target.
    pub u: SVector<f64, M>,
    /// Axes of `w`, as columns.
    pub frame: SMatrix<f64, M, M>,
    brakes: [TransverseBrake; M],
    /// Time at which `w` has come to rest (s).
    pub brake_end: f64,
    stages: [(f64, StateToState); STAGES + 1],
    count: usize,
    pub duration: f64,
}

/// Velocity and acceleration at the start of a plan.
#[derive(Debug, Clone, Copy)]
pub(super) struct Start<const M: usize> {
    pub v: SVector<f64, M>,
    pub a: SVector<f64, M>,
}

struct Parts<const M: usize> {
    u: SVector<f64, M>,
    frame: SMatrix<f64, M, M>,
    alpha: f64,
    beta: f64,
    brakes: [TransverseBrake; M],
}

impl<const M: usize> Parts<M> {
    /// `aim` gives the way left after a displacement `D`. `None` if the line would have to turn too
    /// much.
    fn new(
        start: &Start<M>,
        set: &impl FeasibleSet<M>,
        aim: impl Fn(&SVector<f64, M>) -> SVector<f64, M>,
        (keep_v, keep_a): (f64, f64),
        share: f64,
    ) -> Option<Self> {
        let mut u = aim(&SVector::zeros());
        for _ in 0..MAX_STEPS {
            let frame = set.frame(&u, &start.v, &start.a);
            let (line, v, a) = (frame.tr_mul(&u), frame.tr_mul(&start.v), frame.tr_mul(&start.a));
            let part = |order, y: &SVector<f64, M>, keep: f64| {
                if keep == 0.0 || line.iter().all(|&x| x == 0.0) {
                    return 0.0;
                }
                let factor = keep * set.project(order, y, &line);
                factor * set.share(order, &(line * factor), y)
            };
            let alpha = part(Order::Velocity, &v, keep_v);
            let a = set.apart(&line, alpha, &v, &a);
            let beta = part(Order::Acceleration, &a, keep_a);
            let (w_v, w_a) = (v - line * alpha, a - line * beta);
            // A remainder of round-off would take its time.
            let clean = |rest: SVector<f64, M>, whole: f64| {
                rest.map(|x| if x.abs() <= 4.0 * f64::EPSILON * whole { 0.0 } else { x })
            };
            let (w_v, w_a) = (clean(w_v, v.amax()), clean(w_a, a.amax()));
            let limits = set.brake_limits(&(line * beta), &w_v, &w_a, share);
            let mut brakes = [TransverseBrake::default(); M];
            for (k, brake) in brakes.iter_mut().enumerate() {
                *brake = TransverseBrake::new(w_v[k], w_a[k], limits[k])?;
            }
            let d = frame * SVector::<f64, M>::from_fn(|k, _| brakes[k].length());
            let next = aim(&d);
            let settled = (next - u).amax() <= 1e-14 * (u.amax() + d.amax());
            u = next;
            if settled {
                return Some(Self { u, frame, alpha, beta, brakes });
            }
        }
        None
    }

    fn ranges_after(&self, t: f64) -> [Ranges; M] {
        std::array::from_fn(|k| self.brakes[k].ranges_after(t))
    }

    /// Returns true if the start of the line is inside what the transverse part leaves, now and
    /// when its acceleration has been taken off.
    fn fit(&self, bounds: &ScalarBounds) -> bool {
        let inside = |x: f64, (lower, upper): (f64, f64)| {
            x >= lower - SLACK * (upper - lower) && x <= upper + SLACK * (upper - lower)
        };
        let release = if self.beta > 0.0 { -bounds.j.0 } else { bounds.j.1 };
        let later = self.alpha + 0.5 * self.beta * (self.beta.abs() / release);
        bounds.j.0 < 0.0
            && bounds.j.1 > 0.0
            // The transverse part alone fits.
            && inside(0.0, bounds.v)
            && inside(0.0, bounds.a)
            && inside(self.alpha, bounds.v)
            && inside(self.beta, bounds.a)
            && inside(later, bounds.v)
    }
}

impl<const M: usize> LinePlan<M> {
    /// The best of a few ways to divide the motion, or `None` if none keeps the limits from this
    /// start.
    pub fn new(
        start: &Start<M>,
        set: &impl FeasibleSet<M>,
        aim: impl Fn(&SVector<f64, M>) -> SVector<f64, M>,
    ) -> Option<Self> {
        let mut best: Option<Self> = None;
        for share in SHARES {
            for keep in TRIES {
                let Some(parts) = Parts::new(start, set, &aim, keep, share) else { continue };
                let Some(plan) = Self::along(&parts, set) else { continue };
                if best.as_ref().is_none_or(|b| plan.duration < b.duration) {
                    best = Some(plan);
                }
                break;
            }
        }
        best
    }

    fn along(parts: &Parts<M>, set: &impl FeasibleSet<M>) -> Option<Self> {
        let brake_end = parts.brakes.iter().map(TransverseBrake::duration).fold(0.0, f64::max);
        let target = AxisState::rest(1.0);
        let mut x = AxisState::new(0.0, parts.alpha, parts.beta);
        let still = StateToState::new(&target, &target, &AxisLimits::symmetric(1.0, 1.0, 1.0).ok()?).ok()?;
        let mut plan = Self {
            u: parts.u,
            frame: parts.frame,
            brakes: parts.brakes,
            brake_end,
            stages: [(0.0, still); STAGES + 1],
            count: 1,
            duration: brake_end,
        };
        if parts.u.iter().all(|&c| c == 0.0) {
            return Some(plan);
        }
        let line = parts.frame.tr_mul(&parts.u);
        let full = set.scalar_bounds(&line, &[Ranges::default(); M]);
        let mut last: Option<(f64, StateToState)> = None;
        for i in 0..=STAGES {
            let t = brake_end * i as f64 / STAGES as f64;
            if i > 0 && t == 0.0 {
                break;
            }
            if let Some((began, motion)) = &last {
                if t - began >= motion.duration() {
                    break;
                }
                let now = motion.at(t - began);
                x = AxisState::new(now.p, now.v, now.a);
            }
            let bounds = set.scalar_bounds(&line, &parts.ranges_after(t));
            if i == 0 && !parts.fit(&bounds) {
                return None;
            }
            let motion = StateToState::new(&x, &target, &scalar_limits(&bounds, &full)?).ok()?;
            match &last {
                // Round-off must not replace a plan by a detour.
                Some((began, before)) if motion.duration() >= (before.duration() - (t - began)) * (1.0 - SLACK) => {}
                _ => {
                    plan.count = if last.is_none() { 1 } else { plan.count + 1 };
                    plan.stages[plan.count - 1] = (t, motion);
                    last = Some((t, motion));
                }
            }
        }
        let (began, motion) = plan.stages[plan.count - 1];
        plan.duration = brake_end.max(began + motion.duration());
        plan.duration.is_finite().then_some(plan)
    }

    /// The scalar along the line.
    #[inline]
    pub fn x(&self, t: f64) -> MotionState {
        let i = (1..self.count).take_while(|&i| self.stages[i].0 <= t).count();
        let (began, motion) = &self.stages[i];
        motion.at(t - began)
    }

    /// The transverse part in its frame: displacement and its derivatives.
    #[inline]
    pub fn w(&self, t: f64) -> [MotionState; M] {
        std::array::from_fn(|k| self.brakes[k].at(t))
    }
}

/// Bounds of the scalar, each at least a trace of what it is without the transverse part.
fn scalar_limits(bounds: &ScalarBounds, full: &ScalarBounds) -> Option<AxisLimits> {
    let open = |r: (f64, f64), f: (f64, f64)| (r.0.min(FLOOR * f.0), r.1.max(FLOOR * f.1));
    AxisLimits::new(open(bounds.v, full.v), open(bounds.a, full.a), open(bounds.j, full.j)).ok()
}
