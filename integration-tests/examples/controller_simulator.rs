//! A simulated controller of a Dobot CR on ports of this machine, in real time.
//!
//! ```sh
//! cargo run --release -p integration-tests --features controller --example controller_simulator -- v4 0 0 0 60
//! ```
//!
//! Arguments: version (v3, v4), ports of dashboard, motion and feedback (0: a free one), seconds, joints at the start in degrees,
//! drives on or off. It prints the ports, and at the end what came.

use integration_tests::controller_simulator::{
    ArmLimits, Disturbance, SimulatedArm, SimulatedController, Version, serve,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize, default: f64| arguments.get(i).map_or(Ok(default), |text| text.parse::<f64>());
    let version = if arguments.first().is_some_and(|text| text == "v3") { Version::Three } else { Version::Four };
    let ports = [number(1, 0.0)? as u16, number(2, 0.0)? as u16, number(3, 0.0)? as u16];
    let seconds = number(4, 0.2)?;
    let mut q = [0.0; 6];
    for (k, q) in q.iter_mut().enumerate() {
        *q = number(5 + k, 0.0)?;
    }
    let on = arguments.get(11).is_none_or(|text| text != "off");
    let limits = ArmLimits {
        lower: [-360.0, -360.0, -160.0, -360.0, -360.0, -360.0],
        upper: [360.0, 360.0, 160.0, 360.0, 360.0, 360.0],
        velocity: [180.0; 6],
        acceleration: [573.0; 6],
    };
    let controller = SimulatedController::new(version, SimulatedArm::new(q, limits, 0.02), on, (Disturbance::None, 0));
    let served = serve(controller, ports)?;
    println!("ports {} {} {}", served.ports[0], served.ports[1], served.ports[2]);
    std::thread::sleep(std::time::Duration::from_secs_f64(seconds));
    let controller = served.controller();
    let record = controller.record();
    println!(
        "{} setpoints, {} stops, {} motions after a stop, excess {:?}, at rest {}",
        record.setpoints.len(),
        record.stops,
        record.motions_after_stop,
        controller.arm().excess(),
        controller.arm().rests()
    );
    Ok(())
}
