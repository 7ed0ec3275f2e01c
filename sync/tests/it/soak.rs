//! A few cases of every family of `examples/02_soak`: as many as you like with `02_soak FAMILY COUNT SEED`.
use arcfeed_sync::feedrate::{AxisLimits, AxisState};
use arcfeed_sync::{MotionOptions, Trajectory};

use crate::soak_cases as soak;
use soak::curve::Curve;
use soak::{FAMILIES, play};

#[test]
fn random_motions_pass_their_judges() {
    for (family, count) in FAMILIES.iter().zip([20_000, 150_000, 60_000, 300_000, 150_000, 150_000, 300, 3_000, 5_000])
    {
        let tally = play(family, count, 1_000_003, 1);
        let failures: Vec<String> = tally
            .failures
            .iter()
            .map(|(kind, (n, f))| format!("{n} x {kind}: `02_soak {} 1 {} 1`\n{}", family.name, f.seed, f.input))
            .collect();
        assert!(failures.is_empty(), "{}", failures.join("\n"));
    }
}

/// A duration at an end of the possible ones, but for round-off, was refused as one that is not representable.
#[test]
fn durations_at_the_end_of_the_possible_ones_are_passed_over() {
    for seed in [35304, 34940] {
        let failure = (FAMILIES[1].case)(seed).failure;
        assert!(failure.is_none(), "seed {seed}: {}", failure.map_or_else(String::new, |(kind, _)| kind));
    }
}

/// What long runs found once: the position jumped in a move of 1e-9 s; starts far outside the limits were refused, and so was a
/// route of lines whose axes move very different ways; limits set at a scale of time below 1 were exceeded.
#[test]
fn what_long_runs_found_once_passes() {
    let generator = [25597, 31327, 35195, 44000, 15092].map(|seed| (1, seed));
    let changes = [78, 633, 104_595, 105_156, 105_523, 103_276, 100_794, 102_734].map(|seed| (5, seed));
    for (family, seed) in [(0, 6_083_481), (7, 114_276)].into_iter().chain(generator).chain(changes) {
        let failure = (FAMILIES[family].case)(seed).failure;
        assert!(failure.is_none(), "seed {seed}: {}", failure.map_or_else(String::new, |(kind, _)| kind));
    }
}

/// The judge of curves: axes that turn all at once, at a low scale, are where they are; those that run back, or jumped back, are found.
#[test]
fn axes_that_run_back_on_their_curve_are_found() {
    let limits = [AxisLimits::symmetric(1.0, 5.0, 50.0).expect("limits above 0"); 3];
    // Ahead, back beyond the start, and on.
    let ends = [0.4, -0.3, 0.5].map(|p| [1.0, 0.7, -0.5].map(|part| AxisState::rest(part * p)));
    let from = [[AxisState::rest(0.0); 3], ends[0], ends[1]];
    let motions = from
        .iter()
        .zip(&ends)
        .map(|(from, to)| Trajectory::new(from, to, &limits, &MotionOptions::default()).expect("from rest to rest"));
    let motions: Vec<_> = motions.collect();
    let state = |t: f64, scale: f64| {
        let (mut left, mut i) = (t, 0);
        while i + 1 < motions.len() && left >= motions[i].duration() {
            left -= motions[i].duration();
            i += 1;
        }
        let s = motions[i].at(left);
        std::array::from_fn(|k| AxisState::new(s.q[k], scale * s.qd[k], 0.0))
    };
    let whole: f64 = motions.iter().map(Trajectory::duration).sum();
    for scale in [0.03, 0.3, 1.0] {
        for turn in [0.11, 0.29, 0.45, 0.71, 2.0] {
            let (mut curve, mut t, mut found) = (Curve::of(motions.clone()), 0.0, 0);
            let mut sign = 1.0;
            for _ in 0..(whole / (scale * 1e-3)) as usize {
                sign = if t > turn * whole { -1.0 } else { sign };
                t += sign * scale * 1e-3;
                let off = curve.advance(&state(t, sign * scale), (sign * scale, 1e-3), 1e-9);
                assert!(off < 1e-9, "scale {scale}, {turn}: off by {off} at {t}");
                found += usize::from(curve.runs_back());
                assert!(sign < 0.0 || found == 0, "scale {scale}, {turn}: forward at {t} of {whole}, {curve:?}");
                if sign < 0.0 && t < turn * whole - 0.02 {
                    break;
                }
            }
            assert!((found > 0) == (turn < 1.0), "scale {scale}, {turn}");
        }
    }
}
