//! Three axes generated cycle by cycle while a target and a limit change, printed as a table.
use arcfeed_sync::feedrate::{AxisLimits, AxisState};
use arcfeed_sync::{OnlineGenerator, Synchronisation};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let limits = [AxisLimits::symmetric(1.5, 6.0, 60.0)?; 3];
    let cycle = 1e-3;
    let mut generator = OnlineGenerator::new([AxisState::rest(0.0); 3], limits, cycle, Synchronisation::Time)?;
    generator.set_target([1.2, -0.6, 0.3].map(AxisState::rest))?;
    println!("{:>6} {:>8} {:>8} {:>8} {:>8}", "t s", "q1", "qd1", "q2", "q3");
    for n in 1_u32.. {
        // Setting the same target again is nothing new: the plan is kept.
        generator.set_target(*generator.target())?;
        if n == 300 {
            generator.set_axis_target(1, AxisState::rest(0.2))?;
        }
        if n == 500 {
            generator.set_axis_limits(0, AxisLimits::symmetric(0.6, 6.0, 60.0)?)?;
        }
        let step = generator.step();
        let (s, e) = (&step.state, step.events);
        if n % 100 == 0 || e.replanned || e.reached {
            let notes =
                [(e.replanned, " replanned"), (e.outside_limits, " outside its limits"), (e.reached, " reached")];
            let note: String = notes.iter().filter(|x| x.0).map(|x| x.1).collect();
            let t = f64::from(n) * cycle;
            println!("{t:6.3} {:8.4} {:8.4} {:8.4} {:8.4}{note}", s.q[0], s.qd[0], s.q[1], s.q[2]);
        }
        if e.reached {
            break;
        }
    }
    Ok(())
}
