//! Vibration against an integration in small steps, and the thermal load against a dense sum.

use crate::common::{knotted, tool_down};
use crate::qb;

use arcfeed_interp::{AccelerationPiece, JointSpline, Limits, Oscillator, Planner, ToolLimits, ToolPath, Vibration};
use arcfeed_kinematics::{ForwardKinematics, Joints};
use arcfeed_testing::Random;

/// The response by the classical Runge-Kutta method of fourth order with `steps` steps per piece, and for two periods after the end.
fn integrated<const D: usize>(oscillator: &Oscillator, pieces: &[AccelerationPiece<D>], steps: usize) -> Vibration {
    let omega = std::f64::consts::TAU * oscillator.frequency();
    let zeta = oscillator.damping();
    let (mut y, mut v) = ([0.0; D], [0.0; D]);
    let mut run = |piece: &AccelerationPiece<D>, steps: usize| {
        let h = piece.duration / steps as f64;
        let mut most = y.iter().map(|y| y * y).sum::<f64>().sqrt();
        for i in 0..steps {
            let from = i as f64 * h;
            for d in 0..D {
                let force = |t: f64, y: f64, v: f64| {
                    let [a, b, c, e] = piece.coefficients[d];
                    -(a + t * (b + t * (c + t * e))) - 2.0 * zeta * omega * v - omega * omega * y
                };
                let k1 = [v[d], force(from, y[d], v[d])];
                let k2 =
                    [v[d] + 0.5 * h * k1[1], force(from + 0.5 * h, y[d] + 0.5 * h * k1[0], v[d] + 0.5 * h * k1[1])];
                let k3 =
                    [v[d] + 0.5 * h * k2[1], force(from + 0.5 * h, y[d] + 0.5 * h * k2[0], v[d] + 0.5 * h * k2[1])];
                let k4 = [v[d] + h * k3[1], force(from + h, y[d] + h * k3[0], v[d] + h * k3[1])];
                y[d] += h / 6.0 * (k1[0] + 2.0 * k2[0] + 2.0 * k3[0] + k4[0]);
                v[d] += h / 6.0 * (k1[1] + 2.0 * k2[1] + 2.0 * k3[1] + k4[1]);
            }
            most = most.max(y.iter().map(|y| y * y).sum::<f64>().sqrt());
        }
        most
    };
    let deflection = pieces.iter().map(|piece| run(piece, steps)).fold(0.0, f64::max);
    let free = AccelerationPiece { duration: 2.0 / oscillator.frequency(), coefficients: [[0.0; 4]; D] };
    Vibration { deflection, residual: run(&free, 100_000) }
}

#[test]
fn the_series_agrees_with_an_integration_in_small_steps() {
    let seed = 41;
    let mut random = Random::new(seed);
    for case in 0..12 {
        let oscillator =
            Oscillator::new(random.log(0.5, 50.0), if case % 3 == 0 { 0.0 } else { random.between(0.0, 0.6) });
        let oscillator = oscillator.expect("valid");
        let pieces: Vec<AccelerationPiece<2>> = (0..1 + random.below(6))
            .map(|_| {
                let duration = random.log(1e-3, 0.5);
                let coefficients = [(); 2].map(|()| [0, 1, 2, 3].map(|k| random.signed() / duration.powi(k)));
                AccelerationPiece { duration, coefficients }
            })
            .collect();
        let (found, expected) = (oscillator.respond(pieces.iter().copied()), integrated(&oscillator, &pieces, 20_000));
        for (found, expected) in [(found.deflection, expected.deflection), (found.residual, expected.residual)] {
            // The integration sees the peak at its steps only.
            let close = (found - expected).abs() <= 2e-6 * expected.max(1e-9);
            assert!(close, "seed {seed}, case {case}: {found} and {expected}, {oscillator:?}");
        }
    }
}

/// From rest to rest with constant acceleration and deceleration of one period each, an undamped mass comes to rest.
#[test]
fn whole_periods_of_acceleration_leave_nothing() {
    let oscillator = Oscillator::new(8.0, 0.0).expect("valid");
    let piece =
        |a: f64, periods: f64| AccelerationPiece { duration: periods / 8.0, coefficients: [[a, 0.0, 0.0, 0.0]] };
    let still = oscillator.respond([piece(2.0, 1.0), piece(-2.0, 1.0)]);
    let omega = std::f64::consts::TAU * 8.0;
    assert!((still.deflection - 4.0 / (omega * omega)).abs() < 1e-12 && still.residual < 1e-14, "{still:?}");
    let shaken = oscillator.respond([piece(2.0, 1.5), piece(-2.0, 1.5)]);
    // 2 a / w^2 from the start, 4 from the middle, 2 from the end, in phase.
    assert!((shaken.residual - 8.0 * 2.0 / (omega * omega) / 2.0).abs() < 1e-12, "{shaken:?}");
}

#[test]
fn oscillators_out_of_range_are_refused() {
    for (frequency, damping) in
        [(0.0, 0.0), (-1.0, 0.0), (f64::NAN, 0.0), (1e5, 0.0), (5.0, 1.0), (5.0, -0.1), (5.0, f64::NAN)]
    {
        assert!(Oscillator::new(frequency, damping).is_err(), "{frequency} {damping}");
    }
}

/// Joint and tool of a trajectory against an integration of densely sampled accelerations.
#[test]
fn trajectories_shake_as_their_samples_do() {
    let arm = qb::arm();
    let rates = arm.range().with_rates(Joints::repeat(2.0), Joints::repeat(8.0), Joints::repeat(150.0)).expect("valid");
    let path = ToolPath::new(&arm, tool_down(knotted()), arm.range()).expect("in reach");
    let tool = ToolLimits::new().with_feed(0.5).expect("above 0");
    let plan = Planner::new(&arm, Limits::new(rates).with_tool(tool)).plan(&path).expect("it can be followed");
    let oscillator = Oscillator::new(9.0, 0.03).expect("valid");
    let n = 40_000;
    let dt = plan.duration() / f64::from(n);
    let mut setpoints = plan.setpoints(1e-3).expect("a period");
    let samples: Vec<_> = (0..n).map(|i| setpoints.at(dt * (f64::from(i) + 0.5)).expect("on the path")).collect();
    let joint: Vec<AccelerationPiece<1>> = samples
        .iter()
        .map(|at| AccelerationPiece { duration: dt, coefficients: [[at.qdd[1], 0.0, 0.0, 0.0]] })
        .collect();
    let tool: Vec<AccelerationPiece<3>> = samples
        .iter()
        .map(|at| {
            let configuration = arm.configuration(&at.q);
            let a = configuration.jacobian() * at.qdd + configuration.acceleration_bias(&at.qd);
            AccelerationPiece { duration: dt, coefficients: [0, 1, 2].map(|d| [a[d], 0.0, 0.0, 0.0]) }
        })
        .collect();
    let pairs = [
        (plan.joint_vibration(1, &oscillator).expect("a joint"), integrated(&oscillator, &joint, 1)),
        (plan.tool_vibration(&oscillator).expect("on the path"), integrated(&oscillator, &tool, 1)),
    ];
    for (found, expected) in pairs {
        assert!(found.deflection > 0.0 && found.residual > 0.0, "{found:?}");
        assert!((found.deflection / expected.deflection - 1.0).abs() < 1e-4, "{found:?} {expected:?}");
        assert!((found.residual - expected.residual).abs() < 1e-4 * expected.deflection, "{found:?} {expected:?}");
    }
    assert!(plan.joint_vibration(6, &oscillator).is_err());
}

#[test]
fn the_thermal_load_is_the_root_of_the_mean_square() {
    let arm = qb::arm();
    let rates = arm.range().with_rates(Joints::repeat(1.0), Joints::repeat(4.0), Joints::repeat(60.0)).expect("valid");
    let limits = Limits::new(rates);
    let centre = Joints::from([0.0, -1.1, 1.5, 0.0, 0.9, 0.0]);
    let path =
        JointSpline::through(&[centre, centre + Joints::repeat(0.3), centre - Joints::repeat(0.2)]).expect("points");
    let dynamics = arm.dynamics().expect("known");
    assert_eq!(Planner::new(&arm, limits).plan(&path).expect("fine").rms_torque().expect("fine"), None);
    let limits = limits.with_torque(dynamics, Joints::repeat(f64::INFINITY)).expect("none");
    let plan = Planner::new(&arm, limits).plan(&path).expect("it can be followed");
    let rms = plan.rms_torque().expect("on the path").expect("known");
    let n = 50_000;
    let mut setpoints = plan.setpoints(1e-3).expect("a period");
    let mut sum = Joints::<6>::zeros();
    for i in 0..n {
        let at = setpoints.at(plan.duration() * (f64::from(i) + 0.5) / f64::from(n)).expect("on the path");
        let torque = limits.torque().expect("set").torque(&at.q, &at.qd, &at.qdd);
        sum += torque.component_mul(&torque) / f64::from(n);
    }
    for j in 0..6 {
        assert!((rms[j] / sum[j].sqrt() - 1.0).abs() < 1e-4, "joint {j}: {} and {}", rms[j], sum[j].sqrt());
    }
}
