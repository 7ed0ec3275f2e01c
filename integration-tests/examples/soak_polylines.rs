//! Random polylines with blends, planned on the CR7, as many as you like: `soak_polylines [COUNT, else 20] [FIRST SEED]`.
//!
//! One that fails is printed with its seed; `soak_polylines 1 SEED` plans it again.

use std::time::Instant;

use integration_tests::blended_polylines::{BlendedPolyline, Outcome};

fn main() {
    let mut arguments = std::env::args().skip(1).map(|text| text.parse::<u64>());
    let count = arguments.next().and_then(Result::ok).unwrap_or(20);
    let first = arguments.next().and_then(Result::ok).unwrap_or(0);
    let begin = Instant::now();
    let (mut planned, mut out_of_reach, mut failed) = (0, 0, 0);
    let (mut ratios, mut worst) = (0.0, 0.0f64);
    for seed in first..first + count {
        let polyline = BlendedPolyline::random(seed);
        match polyline.play() {
            Ok(Outcome::Planned([smooth, exact])) => {
                planned += 1;
                ratios += smooth / exact;
                worst = worst.max(smooth / exact);
            }
            Ok(Outcome::OutOfReach) => out_of_reach += 1,
            Err(what) => {
                failed += 1;
                println!("seed {seed}: {what}\n{polyline:?}");
            }
        }
    }
    println!(
        "{planned} planned, {out_of_reach} out of reach, {failed} failed; mean duration {:.4} of that with stops, at most {worst:.4}; \
         {:.0} s",
        ratios / f64::from(planned.max(1)),
        begin.elapsed().as_secs_f64()
    );
    if failed > 0 {
        std::process::exit(1);
    }
}
