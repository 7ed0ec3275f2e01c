//! What the families have in common: random numbers, failures, and their count.
// Shared with a test, which uses a part of it.
#![allow(dead_code)]

mod changes;
pub mod curve;
pub mod generator;
mod generator_input;
pub mod interrupts;
pub mod judge;
pub mod lines;
pub mod projection;
pub mod ranges;
pub mod states;
pub mod way_points;

use arcfeed_testing::Random;
use std::collections::BTreeMap;

/// A kind of motion that is tried at random.
pub struct Family {
    pub name: &'static str,
    /// Plays the case of a seed.
    pub case: fn(u64) -> Outcome,
}

pub const FAMILIES: [Family; 9] = [
    Family { name: "states", case: states::case },
    Family { name: "generator", case: generator::case },
    Family { name: "projection", case: projection::case },
    Family { name: "interrupts", case: interrupts::case },
    Family { name: "routes", case: interrupts::routes },
    Family { name: "changes", case: interrupts::changes },
    Family { name: "way_points", case: way_points::case },
    Family { name: "lines", case: lines::case },
    Family { name: "ranges", case: ranges::case },
];

/// What one case gave.
#[derive(Default)]
pub struct Outcome {
    /// Cases or cycles.
    pub counted: u64,
    /// What is worth counting, and how often it was.
    pub facts: BTreeMap<String, u64>,
    /// A case ends with its first failure.
    pub failure: Option<(String, Failure)>,
}

impl Outcome {
    pub fn see(&mut self, fact: &str) {
        *self.facts.entry(fact.to_owned()).or_default() += 1;
    }
}

/// The input that failed, and by how much.
pub struct Failure {
    pub size: f64,
    pub seed: u64,
    pub input: String,
}

/// The sum of many cases: of every kind of failure the number and the worst.
#[derive(Default)]
pub struct Tally {
    pub counted: u64,
    pub panicked: u64,
    pub facts: BTreeMap<String, u64>,
    pub failures: BTreeMap<String, (u64, Failure)>,
}

impl Tally {
    pub fn add(&mut self, other: Self) {
        self.counted += other.counted;
        self.panicked += other.panicked;
        for (fact, count) in other.facts {
            *self.facts.entry(fact).or_default() += count;
        }
        for (kind, (count, failure)) in other.failures {
            self.fail(kind, count, failure);
        }
    }

    fn fail(&mut self, kind: String, count: u64, failure: Failure) {
        match self.failures.get_mut(&kind) {
            None => {
                self.failures.insert(kind, (count, failure));
            }
            Some(known) => {
                known.0 += count;
                if failure.size > known.1.size {
                    known.1 = failure;
                }
            }
        }
    }
}

/// Plays cases of the seeds `first`, `first + stride`, ... until `count` is reached.
pub fn play(family: &Family, count: u64, first: u64, stride: u64) -> Tally {
    let mut tally = Tally::default();
    let mut seed = first;
    while tally.counted < count {
        let outcome = (family.case)(seed);
        tally.counted += outcome.counted.max(1);
        for (fact, count) in outcome.facts {
            *tally.facts.entry(fact).or_default() += count;
        }
        if let Some((kind, failure)) = outcome.failure {
            tally.fail(kind, 1, failure);
        }
        seed = seed.wrapping_add(stride);
    }
    tally
}

/// Neighbouring seeds give unrelated numbers.
pub fn random(seed: u64) -> Random {
    Random::new(Random::new(seed).bits())
}
