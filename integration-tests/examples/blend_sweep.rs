//! The time over one corner with the shape of the library, against a search over the lengths and the shapes of its family, on the CR7:
//! `blend_sweep [all | rule]`. Without an argument one corner at one tolerance; `rule` prints the shape that is fastest on the mean over
//! tolerances, limits and directions, for each angle.
//!
//! The search starts at the shape of the library and goes to whichever of its neighbours is faster: a shorter blend, and the second and
//! third control point nearer to the corner or farther from it. Every shape of the search has the deviation that the length leaves it.

use integration_tests::blend_corner::{Corner, Failure, Shape, TOOLS, search};

fn main() -> Result<(), Failure> {
    let asked = |what: &str| std::env::args().any(|argument| argument == what);
    if asked("rule") {
        return rule();
    }
    let all = asked("all");
    let (angles, tolerances): (&[i32], &[f64]) =
        if all { (&[10, 30, 60, 90, 120, 150, 170], &[1e-5, 1e-4, 1e-3, 5e-3]) } else { (&[90], &[1e-4]) };
    println!("| angle, deg | tolerance, mm | stop, s | shipped, s | best, s | shipped / best | scale, b, c | plans |");
    println!("|---|---|---|---|---|---|---|---|");
    for &degrees in angles {
        for &tolerance in tolerances {
            let corner = Corner { angle: f64::from(degrees).to_radians(), tolerance, direction: 0.5, tool: TOOLS[0] };
            let stop = corner.time(None)?;
            let made = corner.shipped()?;
            let (best, shape, plans) = search(made, |shape| corner.time(Some(shape)))?;
            println!(
                "| {degrees} | {} | {stop:.4} | {:.4} | {best:.4} | {:.4} | {:.2}, {:.3}, {:.3} | {plans} |",
                1e3 * tolerance,
                made.0,
                made.0 / best,
                shape.scale,
                shape.b,
                shape.c
            );
        }
    }
    Ok(())
}

/// Prints the fastest shapes.
fn rule() -> Result<(), Failure> {
    println!("| angle, deg | shipped: b, c, mean time, s | best: b, c, mean time, s |");
    for degrees in [5, 10, 20, 30, 45, 60, 75, 90, 105, 120, 135, 150, 160, 170] {
        let angle = f64::from(degrees).to_radians();
        let corners: Vec<Corner> = [1e-5, 1e-4, 1e-3]
            .into_iter()
            .flat_map(|tolerance| {
                TOOLS
                    .into_iter()
                    .flat_map(move |tool| [0.5, 2.0].map(|direction| Corner { angle, tolerance, direction, tool }))
            })
            .collect();
        let mean = |shape: Shape| -> Result<f64, Failure> {
            let times: Result<Vec<f64>, Failure> = corners.iter().map(|corner| corner.time(Some(shape))).collect();
            Ok(times?.iter().sum::<f64>() / corners.len() as f64)
        };
        let (_, made) = corners[0].shipped()?;
        let made = Shape { scale: 1.0, ..made };
        let time = mean(made)?;
        let (best, shape, _) = search((time, made), mean)?;
        println!("| {degrees} | {:.3}, {:.3}, {time:.4} | {:.3}, {:.3}, {best:.4} |", made.b, made.c, shape.b, shape.c);
    }
    Ok(())
}
