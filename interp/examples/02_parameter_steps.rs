//! Four ways to advance a curve's parameter, compared by the arc length they really run through.
//!
//! `cargo run -p arcfeed-interp --example 02_parameter_steps`

use arcfeed_feedrate::{AxisLimits, SProfile};
use arcfeed_geometry::{ArcLengthCurve, NurbsCurve};
use arcfeed_interp::parameter::{
    ArcLengthStep, CompensatedTaylor, FirstTaylor, ParameterStep, SecondTaylor, fluctuation,
};
use nalgebra::vector;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A narrow hairpin, 60 mm long: its parameter runs very unevenly.
    let points = vec![
        vector![0.0, 0.0, 0.0],
        vector![0.03, 0.0, 0.0],
        vector![0.031, 0.002, 0.0],
        vector![0.03, 0.004, 0.0],
        vector![0.0, 0.005, 0.0],
    ];
    let curve =
        NurbsCurve::new(3, points, vec![1.0, 2.0, 5.0, 2.0, 1.0], vec![0.0, 0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 1.0, 1.0])?;
    let path = ArcLengthCurve::new(curve, 1e-15)?;
    let law = SProfile::new(path.length(), 0.0, 0.0, &AxisLimits::symmetric(0.05, 1.0, 50.0)?)?;
    let mut steps: Vec<Box<dyn ParameterStep>> = vec![
        Box::new(FirstTaylor::new(path.curve())),
        Box::new(SecondTaylor::new(path.curve())),
        Box::new(CompensatedTaylor::new(path.curve(), 1e-15)?),
        Box::new(ArcLengthStep::new(&path)),
    ];
    println!("{:<20} {:>12} {:>12} {:>12} {:>16}", "50 mm/s, 1 ms", "largest", "rms", "u at end", "missing [mm]");
    for step in &mut steps {
        let f = fluctuation(&path, &law, 1e-3, step.as_mut())?;
        println!(
            "{:<20} {:>12.2e} {:>12.2e} {:>12.9} {:>16.2e}",
            step.name(),
            f.largest,
            f.rms,
            f.end,
            f.truncation * 1e3
        );
    }
    Ok(())
}
