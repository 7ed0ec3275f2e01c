//! The projection synchroniser, with targets and limits that change.
//!
//! Judged from the samples alone: every step is possible within the limits, and the motion comes to rest in its target, in the time it promises.

use arcfeed_sync::feedrate::{AxisLimits, AxisState};
use arcfeed_sync::nalgebra::SVector;
use arcfeed_sync::{JointState, ProjectionStatus, ProjectionSync, symmetric_limits};

use super::judge::{Precision, broken};
use arcfeed_testing::Random;

use super::{Failure, Outcome, random};

const AXES: usize = 4;
/// The part of a limit by which it may be exceeded.
const EXACT: Precision = Precision { slack: 1e-9, size: 0.0 };
type Joints = SVector<f64, AXES>;

/// Cycles in which something changes, and after which a motion is no longer followed.
const CHANGING: u64 = 2000;
const MOST: u64 = 200_000;

fn any_limits(hostile: bool, rng: &mut Random) -> [AxisLimits; AXES] {
    let mut each = |lo: f64, hi: f64| Joints::from_fn(|_, _| rng.log(lo, hi));
    let (v, a, j) = if hostile {
        // Brakes in seconds, not in hours.
        let (v, a, j) = (each(0.1, 50.0), each(0.1, 1e4), each(1.0, 1e8));
        let a = a.zip_map(&v, |a, v| a.max(0.5 * v));
        (v, a, j.zip_map(&a, f64::max))
    } else {
        (each(0.3, 4.0), each(1.0, 20.0), each(10.0, 1000.0))
    };
    symmetric_limits(v, a, j).expect("above zero")
}

/// Another target; of some joints only, or within round-off of where they are.
fn another(target: &Joints, now: &Joints, rng: &mut Random) -> Joints {
    Joints::from_fn(|k, _| match rng.below(10) {
        0..=4 => target[k],
        5 => now[k] + rng.sign() * rng.log(1e-15, 1e-3),
        6 => now[k],
        _ => rng.between(-2.0, 2.0),
    })
}

pub fn case(seed: u64) -> Outcome {
    let mut rng = random(seed);
    let mut outcome = Outcome::default();
    if let Err((kind, size, input)) = play(&mut rng, &mut outcome) {
        outcome.failure = Some((kind, Failure { size, seed, input }));
    }
    outcome
}

fn start(limits: &[AxisLimits; AXES], hostile: bool, rng: &mut Random) -> JointState<AXES> {
    let mut start = JointState::rest(Joints::from_fn(|_, _| rng.between(-2.0, 2.0)));
    if rng.chance(0.4) {
        let beyond = if hostile { 3.0 } else { 1.0 };
        for (k, limits) in limits.iter().enumerate() {
            start.qd[k] = beyond * rng.between(-1.0, 1.0) * limits.v_max();
            start.qdd[k] = beyond * rng.between(-1.0, 1.0) * limits.a_max();
        }
    }
    start
}

fn play(rng: &mut Random, outcome: &mut Outcome) -> Result<(), (String, f64, String)> {
    let hostile = rng.chance(0.5);
    let mut limits = any_limits(hostile, rng);
    let mut now = start(&limits, hostile, rng);
    let mut target = Joints::from_fn(|_, _| rng.between(-2.0, 2.0));
    let refused = |what: &str, e: &dyn std::fmt::Display, input: String| {
        (format!("{what} refused"), 1.0, format!("{e}\n{input}"))
    };
    let show = |s: &JointState<AXES>, t: &Joints, l: &[AxisLimits; AXES]| format!("from {s:?}\nto {t:?}\nwithin {l:?}");
    let mut sync =
        ProjectionSync::new(&now, target, &limits).map_err(|e| refused("start", &e, show(&now, &target, &limits)))?;
    let period = rng.one_of(&[1e-4, 1e-3, 2e-3, 8e-3]);
    let follows = rng.chance(0.3);
    let (mut begun, mut reached) = (now, false);
    // Seconds until the target is to be reached.
    let mut promised = None;
    for cycle in 0..MOST {
        if cycle >= CHANGING && reached {
            return Ok(());
        }
        outcome.counted += 1;
        if cycle < CHANGING && (follows || rng.chance(0.01)) {
            target = if follows {
                target + Joints::from_fn(|_, _| 1e-3 * rng.between(-0.5, 1.0))
            } else {
                another(&target, &now.q, rng)
            };
            sync.set_target(target).map_err(|e| refused("target", &e, show(&now, &target, &limits)))?;
            (begun, reached, promised) = (now, false, None);
        }
        if cycle < CHANGING && rng.chance(0.003) {
            limits = any_limits(hostile, rng);
            sync.set_limits(&limits).map_err(|e| refused("limits", &e, show(&now, &target, &limits)))?;
            (begun, reached, promised) = (now, false, None);
        }
        let dt = if rng.chance(0.1) { period * rng.between(0.3, 2.0) } else { period };
        let step = sync.step(dt).map_err(|e| refused("step", &e, show(&now, &target, &limits)))?;
        let axis = |s: &JointState<AXES>, k: usize| AxisState::new(s.q[k], s.qd[k], s.qdd[k]);
        for (k, l) in limits.iter().enumerate() {
            let (from, to) = (axis(&now, k), axis(&step.state, k));
            if let Some((what, size)) = broken(&from, &to, dt, l, EXACT) {
                let input = format!("axis {k} in {dt} s {from:?} -> {to:?}\n{}", show(&begun, &target, &limits));
                return Err((what.to_owned(), size, input));
            }
        }
        now = step.state;
        promised = promised.map(|left: f64| left - dt).or_else(|| sync.remaining());
        if !reached
            && promised.is_some_and(|left| left < -dt)
            && !matches!(step.status, ProjectionStatus::Reached { .. })
        {
            return Err(("later than promised".to_owned(), 1.0, show(&begun, &target, &limits)));
        }
        if matches!(step.status, ProjectionStatus::Reached { .. }) && !reached {
            reached = true;
            outcome.see("arrivals");
            if now.q != target || now.qd.amax() > 0.0 || now.qdd.amax() > 0.0 {
                let off = (now.q - target).amax();
                return Err(("arrives beside its target".to_owned(), off, show(&begun, &target, &limits)));
            }
        }
    }
    // Limits that fell by decades: braking alone takes minutes.
    outcome.see("still on the way");
    Ok(())
}
