//! URDF texts damaged at random are read to an arm or an error, never to a panic.
//!
//! `cargo run --release -p arcfeed-kinematics --features urdf --example 09_damaged_urdf -- 100000
//! 1` (count and first seed). A text that panics is the one of the seed printed last; `-- 1 SEED`
//! prints and reads it again.

#[path = "../tests/it/common/damaged_urdf.rs"]
mod damaged_urdf;

use arcfeed_kinematics::models;
use damaged_urdf::{damaged, read};
use std::cell::Cell;

thread_local! {
    static SEED: Cell<u64> = const { Cell::new(0) };
}

fn main() {
    let mut arguments = std::env::args().skip(1).map(|text| text.parse::<u64>());
    let count = arguments.next().and_then(Result::ok).unwrap_or(10_000);
    let first = arguments.next().and_then(Result::ok).unwrap_or(1);
    let built_in = models::NAMES.iter().filter_map(|name| models::description(name));
    let mut sound: Vec<String> = built_in.map(|arm| arm.to_urdf()).collect();
    sound.push(include_str!("../tests/fixtures/hand.urdf").to_owned());
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |what| {
        println!("seed {}:", SEED.get());
        usual(what);
    }));
    let mut arms = 0_u64;
    for seed in first..first + count {
        SEED.set(seed);
        let text = damaged(&sound, seed);
        if count == 1 {
            println!("{text}");
        }
        arms += u64::from(read(&text));
    }
    println!("seeds {first} to {}: {arms} arms, {} errors", first + count - 1, count - arms);
}
