//! Problems of several axes and an independent judge of their motions.
#![allow(dead_code, missing_docs, clippy::unwrap_used, clippy::neg_cmp_op_on_partial_ord)]

use arcfeed_sync::feedrate::{AxisLimits, AxisState, MotionLaw};
use arcfeed_sync::{MotionOptions, SyncError, Synchronisation, Trajectory};
use arcfeed_testing::{Phase, Random, Wanted};

#[derive(Debug, Clone, Copy)]
pub struct Problem<const N: usize> {
    pub start: [AxisState; N],
    pub target: [AxisState; N],
    pub limits: [AxisLimits; N],
}

impl<const N: usize> Problem<N> {
    pub fn solve(&self, mode: Synchronisation) -> Result<Trajectory<N>, SyncError> {
        Trajectory::new(&self.start, &self.target, &self.limits, &MotionOptions::new(mode))
    }
}

/// A random problem between states that can be left and entered within the limits; at rest with `moving = 0`.
pub fn moving_problem<const N: usize>(rng: &mut Random, moving: f64) -> Problem<N> {
    let mut p = Problem {
        start: [AxisState::rest(0.0); N],
        target: [AxisState::rest(0.0); N],
        limits: [AxisLimits::symmetric(1.0, 1.0, 1.0).unwrap(); N],
    };
    for k in 0..N {
        let pair = |rng: &mut Random, lo: f64, hi: f64| (-rng.log(lo, hi), rng.log(lo, hi));
        let (v, a, j) = (pair(rng, 0.3, 5.0), pair(rng, 0.5, 20.0), pair(rng, 2.0, 200.0));
        p.limits[k] = AxisLimits::new(v, a, j).unwrap();
        let state = |rng: &mut Random| {
            let position = rng.between(-3.0, 3.0);
            if rng.unit() >= moving {
                return AxisState::rest(position);
            }
            let x = if rng.unit() < 0.5 { 0.0 } else { rng.between(a.0, a.1) };
            // Room on both sides, for the way in and the way out.
            let room = 0.5 * x * x / j.1.min(-j.0);
            if v.0 + room > v.1 - room {
                return AxisState::new(position, 0.5 * (v.0 + v.1), 0.0);
            }
            AxisState::new(position, rng.between(v.0 + room, v.1 - room), x)
        };
        (p.start[k], p.target[k]) = (state(rng), state(rng));
    }
    p
}

/// Adds up the phases of every axis: ends, limits, common duration.
pub fn check<const N: usize>(problem: &Problem<N>, motion: &Trajectory<N>) -> Result<(), String> {
    for k in 0..N {
        let (s, e, l) = (&problem.start[k], &problem.target[k], &problem.limits[k]);
        let axis = &motion.axes()[k];
        let t = axis.duration();
        if t > motion.duration() {
            return Err(format!("axis {k} lasts {t}, longer than {}", motion.duration()));
        }
        let of = |s: &AxisState| [s.p, s.v, s.a];
        let limits = [(l.v_min(), l.v_max()), (l.a_min(), l.a_max()), (l.j_min(), l.j_max())];
        let wanted = Wanted { start: of(s), target: of(e), limits };
        let phases: Vec<Phase> = axis
            .phases()
            .map(|(phase, time)| Phase { state: [phase.s, phase.v, phase.a], jerk: phase.j, time })
            .collect();
        if let Some(fault) = wanted.fault(&phases, wanted.starts_inside(1e-13)) {
            return Err(format!("axis {k}: {fault}"));
        }
    }
    Ok(())
}
