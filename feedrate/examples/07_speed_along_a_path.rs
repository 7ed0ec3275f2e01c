//! Three joints on one path: how fast may `s` grow? Speed profiles under the limit curve, with and without a limit on jerk.
use arcfeed_feedrate::constraint::{JointAcceleration, JointJerk, JointVelocity, PathDerivatives};
use arcfeed_feedrate::{
    FeedPlanner, FeedProblem, ForwardBackwardScan, InterpolatedReachability, JerkLimited, MotionLaw, MotionState,
    SpeedLaw,
};

mod common;
use common::{Curve, Panel};

const V_MAX: [f64; 3] = [1.0, 1.2, 1.5];
const A_MAX: [f64; 3] = [3.0, 4.0, 5.0];
const J_MAX: [f64; 3] = [40.0, 50.0, 60.0];

/// Derivatives 1 to 3 by `s` of `q = (sin 5 s, 0.7 cos 9 s, 0.8 sin(13 s + 1))`.
fn jet(s: f64) -> [[f64; 3]; 3] {
    let wave = |a: f64, f: f64, p: f64| {
        let x = f * s + p;
        [a * f * x.cos(), -a * f * f * x.sin(), -a * f * f * f * x.cos()]
    };
    [wave(1.0, 5.0, 0.0), wave(0.7, 9.0, std::f64::consts::FRAC_PI_2), wave(0.8, 13.0, 1.0)]
}

/// The joint that is closest to its limit: acceleration and jerk in units of theirs.
fn strain(state: &MotionState) -> (f64, f64) {
    let MotionState { p, v, a, j } = *state;
    jet(p).iter().enumerate().fold((0.0, 0.0), |(acceleration, jerk), (i, [q1, q2, q3])| {
        let second: f64 = q1 * a + q2 * v * v;
        let third: f64 = q1 * j + 3.0 * q2 * v * a + q3 * v * v * v;
        (f64::max(acceleration, second.abs() / A_MAX[i]), f64::max(jerk, third.abs() / J_MAX[i]))
    })
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let n = 800;
    let grid: Vec<f64> = (0..=n).map(|i| f64::from(i) / f64::from(n)).collect();
    let [first, second, third]: [Vec<f64>; 3] =
        [0, 1, 2].map(|order| grid.iter().flat_map(|&s| jet(s).map(|q| q[order])).collect());
    let path = PathDerivatives::new(3, &first, &second)?.with_third(&third)?;
    let (velocity, acceleration) = (JointVelocity::new(path, &V_MAX)?, JointAcceleration::new(path, &A_MAX)?);
    let jerk = JointJerk::new(path, &J_MAX)?;
    let problem = FeedProblem::between_points(&grid, &[&velocity, &acceleration, &jerk])?;

    let scan = ForwardBackwardScan.plan(&problem)?;
    let certified = InterpolatedReachability.plan(&problem)?;
    let smooth = JerkLimited::default().plan(&problem)?;
    for (name, plan) in [("both-ends scan", &scan), ("certified", &certified), ("jerk-limited", &smooth)] {
        let states = (0..=20_000).map(|i| plan.at(plan.duration() * f64::from(i) / 20_000.0));
        let (a, j) =
            states.map(|state| strain(&state)).fold((0.0, 0.0), |m, x| (f64::max(m.0, x.0), f64::max(m.1, x.1)));
        print!("{name:15} {:.4} s, acceleration at most {a:.4} of its limit", plan.duration());
        // The others step from one acceleration to the next, which no jerk can do.
        println!("{}", if name == "jerk-limited" { format!(", jerk {j:.4}") } else { String::new() });
    }

    // At constant speed: where velocity or curvature stops the motion from being faster.
    let limit = (0..=n as usize).map(|i| {
        let rows = problem.rows(i).iter().map(|row| row.hi / row.b.abs());
        (grid[i], rows.fold(problem.cap(i).0, f64::min).sqrt())
    });
    let curve = |name, colour, plan: &SpeedLaw, f: &dyn Fn(&MotionState) -> f64| {
        let states = (0..=6000).map(|i| plan.at(plan.duration() * f64::from(i) / 6000.0));
        Curve { name, colour, points: states.map(|state| (state.p, f(&state))).collect() }
    };
    let (fast, slow) = ("#d49a2a", "#1f6fb2");
    common::write(
        "feedrate_07_speed_along_a_path.svg",
        "Speed along a path of three joints",
        "path parameter s",
        &[
            Panel {
                label: "ds/dt 1/s",
                curves: vec![
                    Curve { name: "limit at constant speed", colour: "#c0392b", points: limit.collect() },
                    curve("velocity and acceleration", fast, &certified, &|x| x.v),
                    curve("and jerk", slow, &smooth, &|x| x.v),
                ],
                limits: vec![],
            },
            Panel {
                label: "acceleration",
                curves: vec![
                    curve("velocity and acceleration", fast, &certified, &|x| strain(x).0),
                    curve("and jerk", slow, &smooth, &|x| strain(x).0),
                ],
                limits: vec![1.0],
            },
            Panel {
                label: "jerk",
                curves: vec![curve("most strained joint", slow, &smooth, &|x| strain(x).1)],
                limits: vec![1.0],
            },
        ],
    )?;
    Ok(())
}
