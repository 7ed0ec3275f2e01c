//! Random problems on rows for every planner, judged with arithmetic of its own: at the grid points and at 20 places between.
//!
//! `cargo run --release -p arcfeed-feedrate --example 08_soak_rows -- SEED COUNT [FAMILY|all] [INDEX]`
//!
//! Prints a summary per planner and family, and every input that fails as Rust to paste into a test.
use std::collections::BTreeMap;

use arcfeed_feedrate::{
    ContinuousAccelerationScan, FeedPlanner, ForwardBackwardScan, InterpolatedReachability, JerkLimited, Reachability,
};

#[path = "../tests/it/common/row_families.rs"]
mod row_families;
use row_families::{Case, FAMILIES, Path, judge};

/// Excess allowed at the grid points and between them.
const ALLOWED: [f64; 2] = [1e-9, 1e-6];

#[derive(Default)]
struct Tally {
    solved: usize,
    duration: f64,
    worst: [f64; 2],
    broken: usize,
    refused: BTreeMap<String, (usize, usize)>,
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize| arguments.get(i).and_then(|text| text.parse::<u64>().ok());
    let (seed, count) = (number(0).unwrap_or(1), number(1).unwrap_or(80));
    let family = arguments.get(2).and_then(|name| FAMILIES.iter().position(|family| family == name));
    // Rows between the points, rows on jerk, whether it keeps the limits between the points.
    let planners: [(&str, &dyn FeedPlanner, bool, bool); 5] = [
        ("both ends", &ForwardBackwardScan, false, false),
        ("reachability", &Reachability, false, false),
        ("certified", &InterpolatedReachability, true, false),
        ("jerk-limited", &JerkLimited::default(), true, true),
        ("joined", &ContinuousAccelerationScan, true, true),
    ];
    let mut tallies: BTreeMap<(usize, usize), Tally> = BTreeMap::new();
    let mut failures = 0;
    for index in number(3).map_or(0..count, |index| index..index + 1) {
        let family = family.unwrap_or(index as usize % FAMILIES.len());
        let case = Case::numbered(seed, family, index);
        let path = Path::new(&case);
        for (which, (name, planner, between, jerk)) in planners.iter().enumerate() {
            let tally = tallies.entry((family, which)).or_default();
            let plan = path.problem(*between, *jerk).and_then(|problem| planner.plan(&problem));
            let plan = match plan {
                Ok(plan) => plan,
                Err(error) => {
                    if number(3).is_some() {
                        println!("{name}: {error}");
                    }
                    let kind = format!("{error:?}").split([' ', '{']).next().unwrap_or_default().to_owned();
                    tally.refused.entry(kind).or_insert((0, index as usize)).0 += 1;
                    continue;
                }
            };
            tally.solved += 1;
            tally.duration += plan.duration().ln();
            let excess = judge(&path, &plan, *jerk);
            let found = [excess.at_grid, if *between { excess.between } else { 0.0 }];
            for (worst, found) in tally.worst.iter_mut().zip(found) {
                *worst = if found.is_nan() { f64::NAN } else { worst.max(found) };
            }
            // A NaN is no plan that keeps anything.
            if found.iter().zip(ALLOWED).any(|(found, allowed)| found.is_nan() || *found > allowed) {
                tally.broken += 1;
                failures += 1;
                println!("{name}, {} {index}: {found:?} {:?}", FAMILIES[family], excess.what);
                if failures <= 10 {
                    println!("    {}", case.literal());
                }
            }
        }
    }
    println!("seed {seed}, {count} cases, {failures} failures");
    for ((family, which), tally) in &tallies {
        println!(
            "{:>16} {:>13}: {:>6} solved (mean log duration {:.9}), worst {:9.1e} at the grid {:9.1e} between, {} broken, refused (count, first) {:?}",
            FAMILIES[*family],
            planners[*which].0,
            tally.solved,
            tally.duration / tally.solved.max(1) as f64,
            tally.worst[0],
            tally.worst[1],
            tally.broken,
            tally.refused
        );
    }
    if failures > 0 {
        std::process::exit(1);
    }
}
