//! Random curves with knots that nearly coincide, as many as you like: `soak_close_knots [CASES, else 1000] [FIRST SEED]`.
//!
//! A case that fails is printed with its seed and its curve; `soak_close_knots 1 SEED` runs it again.

#[path = "../tests/it/common/close_knots.rs"]
mod close_knots;

use close_knots::Case;

fn play<const D: usize>(seed: u64) -> Result<bool, String> {
    let case = Case::<D>::random(seed);
    case.check(seed).map_err(|what| {
        let points: Vec<&[f64]> = case.points.iter().map(|p| p.as_slice()).collect();
        format!(
            "{what}\n{{\"units\": \"m\", \"degree\": {}, \"control_points\": {points:?}, \"weights\": {:?}, \"knots\": {:?}}}",
            case.degree, case.weights, case.knots
        )
    })
}

fn main() {
    let mut arguments = std::env::args().skip(1).map(|text| text.parse::<u64>());
    let count = arguments.next().and_then(Result::ok).unwrap_or(200);
    let first = arguments.next().and_then(Result::ok).unwrap_or(0);
    let (mut good, mut refused, mut failed) = (0, 0, 0);
    for seed in first..first + count {
        match if seed % 2 == 0 { play::<2>(seed) } else { play::<3>(seed) } {
            Ok(true) => good += 1,
            Ok(false) => refused += 1,
            Err(what) => {
                failed += 1;
                println!("seed {seed}: {what}");
            }
        }
    }
    println!("{good} good, {refused} refused for a reason, {failed} failed");
    if failed > 0 {
        std::process::exit(1);
    }
}
