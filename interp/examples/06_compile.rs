//! A motion through way-points as polynomials of the time, and what is certain about it between samples.
//!
//! `cargo run -p arcfeed-interp --example 06_compile`

use arcfeed_interp::{Interpolation, JointSpline, Limits, Planner};
use arcfeed_kinematics::{Joints, models};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arm = models::ur5e();
    let limits = arm.range().with_rates(Joints::repeat(3.0), Joints::repeat(10.0), Joints::repeat(100.0))?;
    let path = JointSpline::through(&[Joints::repeat(0.0), Joints::repeat(0.5), Joints::repeat(-0.2)])?;
    let trajectory = Planner::new(&arm, Limits::new(limits)).plan(&path)?;

    println!("{:.3} s, {} knots of the speed law", trajectory.duration(), trajectory.law().knots().len());
    println!(
        "\n{:>10} {:>14} {:>14} {:>12} {:>12}",
        "tolerance", "quintic pieces", "cubic pieces", "bound", "measured"
    );
    for tolerance in [1e-4, 1e-5, 1e-6, 1e-7] {
        let [quintic, cubic] =
            [Interpolation::Quintic, Interpolation::Cubic].map(|i| trajectory.compile_with(tolerance, i));
        let (quintic, cubic) = (quintic?, cubic?);
        let Some(deviation) = quintic.deviation() else { continue };
        let (bound, measured) = (deviation.bound, deviation.measured);
        println!("{tolerance:>10.0e} {:>14} {:>14} {bound:>12.3e} {measured:>12.3e}", quintic.len(), cubic.len());
    }

    let compiled = trajectory.compile(1e-6)?;
    let certificate = compiled.certify(limits.range(), &(&limits).into());
    println!("\nOf the first joint, at any time:");
    for bound in &certificate.bounds()[..4] {
        let used = 100.0 * bound.ratio();
        println!(
            "  {:<24} {:>9.5} at t = {:.4} s, never more than {used:.5} % of its limit",
            bound.id.to_string(),
            bound.attained,
            bound.t
        );
    }
    println!("Every limit is kept: {}", certificate.holds(1e-6));

    let there_and_back = compiled.clone().then(&compiled.reversed())?;
    println!(
        "There and back: {:.3} s, ends at {:.1e} rad",
        there_and_back.duration(),
        there_and_back.at(f64::INFINITY).q[0]
    );
    Ok(())
}
