//! Random arms of six joints without a closed form on small circles and lines: `soak_six_joints
//! [CASES, else 100] [FIRST SEED, else 0]`. Each must be planned and verified, or refused for a
//! reason in the arm. A case that fails is printed with its seed, and `-- 1 SEED` plays it again.

#[path = "../tests/it/common/six_joints.rs"]
mod six_joints;

use six_joints::{Outcome, draw_case, play};

fn main() {
    let mut arguments = std::env::args().skip(1).map(|text| text.parse::<u64>());
    let count = arguments.next().and_then(Result::ok).unwrap_or(10);
    let first = arguments.next().and_then(Result::ok).unwrap_or(0);
    let (mut planned, mut out_of_reach, mut failed, mut seed) = (0_u64, 0_u64, 0_u64, first);
    while planned + out_of_reach + failed < count {
        let case = draw_case(seed);
        seed += 1;
        match case.map(|case| play(&case)) {
            None if count == 1 => break,
            None => {}
            Some(Ok(Outcome::Planned)) => planned += 1,
            Some(Ok(Outcome::OutOfReach)) => out_of_reach += 1,
            Some(Err(what)) => {
                failed += 1;
                println!("seed {}: {what}", seed - 1);
            }
        }
    }
    println!("seeds {first} to {}: {planned} planned, {out_of_reach} out of reach, {failed} failed", seed - 1);
    if failed > 0 {
        std::process::exit(1);
    }
}
