//! A few cases of every family of `examples/02_soak`: as many as you like with `02_soak FAMILY COUNT SEED`.
use crate::soak_cases as soak;

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
