//! A flower of many short lines with a blend at each corner, on the CR7: `short_lines [COUNT, else 200] [TOLERANCE in um, else 50]`.
//!
//! The blends of a program that does not let its lines be merged (`G64 P0.05 Q0`) make tens of intervals of each line.

use std::f64::consts::TAU;
use std::time::Instant;

use arcfeed_geometry::{Blending, JoinedPathBuilder};
use arcfeed_kinematics::models;
use integration_tests::on_cr7::{Failure, TOOL, planned};
use nalgebra::Vector3;

fn main() -> Result<(), Failure> {
    let mut arguments = std::env::args().skip(1);
    let count: u32 = arguments.next().map_or(Ok(200), |text| text.parse())?;
    let tolerance: f64 = arguments.next().map_or(Ok(50.0), |text| text.parse())?;
    let point = |i: u32| {
        let a = TAU * f64::from(i) / f64::from(count);
        let r = 0.04 + 0.01 * (5.0 * a).cos();
        let rounded = |x: f64| (x * 1e6).round() / 1e6;
        Vector3::new(0.42 + rounded(r * a.cos()), rounded(r * a.sin()), 0.15)
    };
    let mut path = JoinedPathBuilder::new(point(0), 1e-9)?;
    for i in 1..=count {
        path.line_to(point(i), i as usize)?;
    }
    let curve = path.build()?.blended(&Blending::within(1e-6 * tolerance))?.path.to_curve()?;
    let arm = models::cr7();
    let begin = Instant::now();
    let plan = planned(&arm, curve, TOOL)?;
    println!(
        "{count} lines: {:.4} s of motion, {} intervals, {} rounds, planned and verified in {:.2} s",
        plan.duration(),
        plan.info().intervals,
        plan.info().rounds,
        begin.elapsed().as_secs_f64()
    );
    Ok(())
}
