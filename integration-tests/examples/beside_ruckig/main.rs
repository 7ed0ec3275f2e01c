//! arcfeed beside the official C++ of ruckig (through its crate) in one process, on the same inputs.
//!
//! ```console
//! $ cargo run --release -p integration-tests --features ruckig --example beside_ruckig -- 20000
//! ```
//!
//! The number is that of the cases of each family; 2000 without one. The first table draws from the distributions of ruckig's
//! own test suite and from families that are hard for it; the second follows a target that moves. `docs/conformance.md` holds
//! both. The program fails if arcfeed refuses what ruckig answers, or is later.

mod case;
mod draw;
mod replanned;

use std::collections::BTreeMap;
use std::process::ExitCode;

use arcfeed_testing::Random;

use case::{Answer, Case, ours, theirs};

/// Durations that differ by less than this part are the same.
const SAME: f64 = 1e-8;

/// The answers of both to the cases of a family.
#[derive(Default)]
struct Tally {
    same: usize,
    ours_shorter: usize,
    /// Of these, the cases in which an axis starts outside its limits or is bound to leave them.
    from_outside: usize,
    theirs_shorter: usize,
    only_ours: usize,
    only_theirs: usize,
    neither: usize,
    /// What ruckig says where it finds no motion.
    failures: BTreeMap<String, usize>,
    /// The largest excess of our duration, as a part of theirs, with the case.
    worst: Option<(f64, Case)>,
}

impl Tally {
    fn add(&mut self, case: &Case) {
        match (ours(case), theirs(case)) {
            // Not an input that it takes: drawn anew by its own suite.
            (_, Answer::Invalid) => self.neither += 1,
            (Answer::Duration(ours), Answer::Duration(theirs)) => {
                let part = (ours - theirs) / theirs.max(1e-9);
                match part {
                    _ if part.abs() <= SAME => self.same += 1,
                    _ if part < 0.0 => {
                        self.ours_shorter += 1;
                        self.from_outside += usize::from(case.starts_outside());
                    }
                    _ => self.theirs_shorter += 1,
                }
                if part > self.worst.as_ref().map_or(SAME, |worst| worst.0) {
                    self.worst = Some((part, case.clone()));
                }
            }
            (Answer::Duration(_), Answer::Failed(text)) => {
                self.only_ours += 1;
                *self.failures.entry(text).or_default() += 1;
            }
            (_, Answer::Duration(_)) => self.only_theirs += 1,
            _ => self.neither += 1,
        }
    }

    /// Returns true if arcfeed answers whatever ruckig answers, and no later, but for ways that ruckig takes for none.
    fn holds(&self, name: &str) -> bool {
        self.only_theirs == 0 && (self.theirs_shorter == 0 || name.starts_with("moves of 1e-15"))
    }

    fn print(&self, name: &str) {
        let Self { same, ours_shorter, from_outside, theirs_shorter, only_ours, only_theirs, neither, .. } = self;
        let cases = same + ours_shorter + theirs_shorter + only_ours + only_theirs;
        println!(
            "| {name} | {cases} | {same} | {ours_shorter} ({from_outside}) | {theirs_shorter} | {only_ours} | {only_theirs} | {neither} |"
        );
    }
}

fn main() -> ExitCode {
    let count: usize = std::env::args().nth(1).and_then(|text| text.parse().ok()).unwrap_or(2000);
    println!(
        "| family | cases | same duration | ours shorter (start outside limits) | theirs shorter | only ours | only theirs | drawn anew |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    let mut worst = Vec::new();
    let mut holds = true;
    for (name, seed, draw) in draw::FAMILIES {
        let mut rng = Random::new(seed);
        let mut tally = Tally::default();
        for _ in 0..count {
            tally.add(&draw(&mut rng));
        }
        tally.print(name);
        holds &= tally.holds(name);
        for (text, count) in &tally.failures {
            println!("| only ours: ruckig says {text} | {count} | | | | | | |");
        }
        worst.extend(tally.worst.map(|(part, case)| (name, part, case)));
    }
    for (name, part, case) in worst {
        println!("\n{name}: ours is longer by {part:.2e} of theirs at the most: {case:?}");
    }
    println!("\n| a target that moves, set in every cycle | runs | ever within 1e-6 | with it at the end |");
    println!("|---|---|---|---|");
    replanned::print(count.div_ceil(10).min(200));
    if holds { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
