//! A few cases of every family of `examples/02_soak`: as many as you like with `02_soak FAMILY COUNT SEED`.
use crate::soak_cases as soak;

use soak::{FAMILIES, play};

#[test]
fn random_motions_pass_their_judges() {
    for (family, count) in FAMILIES.iter().zip([20_000, 150_000, 60_000, 300_000, 300]) {
        let tally = play(family, count, 1_000_003, 1);
        let failures: Vec<String> = tally
            .failures
            .iter()
            .map(|(kind, (n, f))| format!("{n} x {kind}: `02_soak {} 1 {} 1`\n{}", family.name, f.seed, f.input))
            .collect();
        assert!(failures.is_empty(), "{}", failures.join("\n"));
    }
}
