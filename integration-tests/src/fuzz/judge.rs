//! What a motion has to keep, whatever it was planned by.

use arcfeed_sync::Trajectory;
use arcfeed_sync::feedrate::{AxisLimits, AxisState, MotionLaw};
use arcfeed_testing::{Phase, Wanted};

/// Adds up the phases of every axis: ends, limits, common duration.
pub(super) fn fault_of<const N: usize>(
    start: &[AxisState; N],
    target: &[AxisState; N],
    limits: &[AxisLimits; N],
    motion: &Trajectory<N>,
) -> Option<String> {
    for k in 0..N {
        let axis = &motion.axes()[k];
        if axis.duration() > motion.duration() {
            return Some(format!("axis {k} lasts {}, longer than {}", axis.duration(), motion.duration()));
        }
        let of = |s: &AxisState| [s.p, s.v, s.a];
        let l = &limits[k];
        let limits = [(l.v_min(), l.v_max()), (l.a_min(), l.a_max()), (l.j_min(), l.j_max())];
        let wanted = Wanted { start: of(&start[k]), target: of(&target[k]), limits };
        let phases: Vec<Phase> = axis
            .phases()
            .map(|(phase, time)| Phase { state: [phase.s, phase.v, phase.a], jerk: phase.j, time })
            .collect();
        if let Some(fault) = wanted.fault(&phases, wanted.starts_inside(1e-13)) {
            return Some(format!("axis {k}: {fault}"));
        }
    }
    None
}

/// A motion cycle by cycle that must not jump: the way of a cycle is that of the mean of both velocities, but for what the greatest
/// acceleration of all can make of it.
#[derive(Debug, Clone)]
pub(super) struct NoJump<const N: usize> {
    before: [AxisState; N],
    cycle: f64,
    /// Greatest acceleration of each axis that was ever permitted or there.
    hardest: [f64; N],
}

impl<const N: usize> NoJump<N> {
    pub(super) fn new(start: [AxisState; N], limits: &[AxisLimits; N], cycle: f64) -> Self {
        let mut judge = Self { before: start, cycle, hardest: start.map(|s| s.a.abs()) };
        judge.permit(limits);
        judge
    }

    /// From now on these limits are permitted, too.
    pub(super) fn permit(&mut self, limits: &[AxisLimits; N]) {
        for (hardest, l) in self.hardest.iter_mut().zip(limits) {
            *hardest = hardest.max(l.a_max()).max(-l.a_min());
        }
    }

    /// What is wrong with the next state.
    pub(super) fn see(&mut self, state: &[AxisState; N]) -> Option<String> {
        let h = self.cycle;
        for (k, (a, b)) in self.before.iter().zip(state).enumerate() {
            if ![b.p, b.v, b.a].iter().all(|value| value.is_finite()) {
                return Some(format!("axis {k} is at {b:?}"));
            }
            let off = (b.p - a.p) - 0.5 * h * (a.v + b.v);
            let rounding = 1e-12 * (1.0 + a.p.abs() + b.p.abs() + h * (a.v.abs() + b.v.abs()));
            if off.abs() > 0.5 * self.hardest[k] * h * h * (1.0 + 1e-6) + rounding {
                return Some(format!("axis {k} jumps by {off:e} from {a:?} to {b:?}"));
            }
            let change = (b.v - a.v).abs();
            if change > self.hardest[k] * h * (1.0 + 1e-6) + 1e-9 * (1.0 + a.v.abs() + b.v.abs()) {
                return Some(format!("the velocity of axis {k} jumps by {change:e} from {a:?} to {b:?}"));
            }
        }
        self.before = *state;
        None
    }
}
