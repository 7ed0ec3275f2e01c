//! Blends of many random polylines and mixed paths, with the checks of the tests.
//!
//! `cargo run --release -p arcfeed-geometry --example soak_blends -- FIRST_SEED COUNT`
#![allow(clippy::unwrap_used)]

#[path = "../tests/it/common/mixed.rs"]
mod mixed;
#[path = "../tests/it/common/polylines.rs"]
mod polylines;

fn main() {
    let numbers: Vec<u64> = std::env::args().skip(1).filter_map(|a| a.parse().ok()).collect();
    let (first, count) = match numbers[..] {
        [first, count] => (first, count),
        _ => (1, 200),
    };
    let mut failures = 0;
    type Check = fn(u64, &mut polylines::Seen) -> Result<(), String>;
    for (what, check) in [("polylines", polylines::check as Check), ("mixed paths", mixed::check)] {
        let mut seen = polylines::Seen::default();
        for seed in first..first + count {
            if let Err(message) = check(seed, &mut seen) {
                failures += 1;
                println!("{what}, seed {seed}: {message}");
            }
        }
        println!("{count} {what}: {seen:?}");
    }
    if failures > 0 {
        println!("{failures} failures");
        std::process::exit(1);
    }
}
