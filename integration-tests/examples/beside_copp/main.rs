//! Random splines of seven joints, planned here and by COPP on the same grid under the same limits.
//!
//!     cargo run --release -p integration-tests --features copp --example beside_copp -- COUNT [SEED]
//!
//! The recipe is that of COPP's own benchmark (github.com/TOPP-THU/copp, tests/test_random_spline.rs, MIT, written anew): 50
//! way-points in [-0.5, 0.5] on each axis, a spline of order 5 through them, 1000 intervals, limits of 1, 5 and 50 on velocity, acceleration
//! and jerk, each drawn within 10 %. Random numbers are others, and limits are equal in both directions. Durations stand beside each
//! other, and all motions are judged by differences of positions alone.

use std::env;

use arcfeed_feedrate::constraint::{JointAcceleration, JointJerk, JointVelocity, PathDerivatives};
use arcfeed_feedrate::{FeedPlanner, FeedProblem, JerkLimited, MotionLaw, Reachability};
use arcfeed_testing::Random;
use copp::InterpolationMode;
use copp::path::{Path, SplineConfig};
use copp::robot::Robot;
use copp::solver::topp2_ra::{ReachSet2OptionsBuilder, Topp2ProblemBuilder, s_to_t_topp2, topp2_ra};
use copp::solver::topp3_socp::{ClarabelOptionsBuilder, Topp3ProblemBuilder, s_to_t_topp3, t_to_s_topp3, topp3_socp};
use nalgebra::DMatrix;

const JOINTS: usize = 7;
const WAY_POINTS: usize = 50;
const INTERVALS: usize = 1000;
const NOMINAL: [f64; 3] = [1.0, 5.0, 50.0];
/// Time between two positions of a difference, s.
const STEP: f64 = 2e-3;

type Error = Box<dyn std::error::Error>;

struct Case {
    path: Path,
    grid: Vec<f64>,
    /// Of velocity, acceleration and jerk.
    limits: [[f64; JOINTS]; 3],
}

/// A motion: how long it takes, and the largest ratios of its differences to the limits.
struct Motion {
    duration: f64,
    worst: [f64; 3],
}

impl Case {
    fn draw(random: &mut Random) -> Result<Self, Error> {
        let points = DMatrix::from_fn(JOINTS, WAY_POINTS, |_, _| 0.5 * random.signed());
        let limits = NOMINAL.map(|nominal| std::array::from_fn(|_| nominal * (0.9 + 0.2 * random.unit())));
        let path = Path::from_waypoints_interpolating(&points, SplineConfig::default())?;
        let grid = (0..=INTERVALS).map(|i| i as f64 / INTERVALS as f64).collect();
        Ok(Self { path, grid, limits })
    }

    /// Durations by our planners without and with a limit on jerk; the motion with it.
    fn ours(&self) -> Result<(f64, Motion), Error> {
        let at = self.path.evaluate_up_to_3rd(&self.grid)?;
        let [first, second, third] =
            [at.dq, at.ddq, at.dddq].map(|values| values.expect("three orders are asked for").as_slice().to_vec());
        let path = PathDerivatives::new(JOINTS, &first, &second)?.with_third(&third)?;
        let velocity = JointVelocity::new(path, &self.limits[0])?;
        let acceleration = JointAcceleration::new(path, &self.limits[1])?;
        let jerk = JointJerk::new(path, &self.limits[2])?;
        let second_order = Reachability.plan(&FeedProblem::at_points(&self.grid, &[&velocity, &acceleration])?)?;
        let problem = FeedProblem::between_points(&self.grid, &[&velocity, &acceleration, &jerk])?;
        let law = JerkLimited::default().plan(&problem)?;
        let places: Vec<f64> =
            (0..(law.duration() / STEP) as usize).map(|i| law.at(i as f64 * STEP).p.clamp(0.0, 1.0)).collect();
        Ok((second_order.duration(), Motion { duration: law.duration(), worst: self.worst(&places)? }))
    }

    /// The same by COPP: TOPP2-RA, and TOPP3-SOCP after one and two programs.
    fn copp(&self) -> Result<(f64, [Motion; 2]), Error> {
        let (n, limits) = (self.grid.len(), &self.limits);
        let low = limits.map(|limits| limits.map(|limit| -limit));
        let mut robot = Robot::with_capacity(JOINTS, n);
        robot
            .with_s(&self.grid)?
            .with_q_from_path_3rd(&self.path, 0, n)?
            .with_axial_velocity((&limits[0][..], n), (&low[0][..], n), 0)?
            .with_axial_acceleration((&limits[1][..], n), (&low[1][..], n), 0)?
            .with_axial_jerk((&limits[2][..], n), (&low[2][..], n), 0)?;
        let problem = Topp2ProblemBuilder::new(&robot, (0, n - 1), (0.0, 0.0)).build()?;
        let mut near = topp2_ra(&problem, &ReachSet2OptionsBuilder::new().build()?)?;
        let second_order = s_to_t_topp2(&self.grid, &near, 0.0)?.0;
        let options = ClarabelOptionsBuilder::new()
            .allow_almost_solved(true)
            .allow_max_time(true)
            .allow_max_iterations(true)
            .allow_insufficient_progress(true)
            .build()?;
        let mut program = || -> Result<Motion, Error> {
            let problem =
                Topp3ProblemBuilder::new(&mut robot, 0, &near, (0.0, 0.0), (0.0, 0.0)).build_with_linearization()?;
            let profile = topp3_socp(&problem, &options)?;
            let (duration, times) = s_to_t_topp3(&self.grid, profile.as_parts(), 0.0)?;
            let even = InterpolationMode::UniformTimeGrid(0.0, STEP, false);
            let mut places = t_to_s_topp3(&self.grid, profile.as_parts(), &times, even)?;
            places.truncate((duration / STEP) as usize);
            near.clone_from(&profile.a);
            Ok(Motion { duration, worst: self.worst(&places)? })
        };
        Ok((second_order, [program()?, program()?]))
    }

    /// The largest ratios of first, second and third differences to the limits, at even times.
    fn worst(&self, places: &[f64]) -> Result<[f64; 3], Error> {
        let places: Vec<f64> = places.iter().map(|s| s.clamp(0.0, 1.0)).collect();
        let q = self.path.evaluate_up_to_2nd(&places)?.q;
        let mut worst = [0.0_f64; 3];
        for joint in 0..JOINTS {
            let mut values: Vec<f64> = q.row(joint).iter().copied().collect();
            for (worst, limits) in worst.iter_mut().zip(&self.limits) {
                values = values.windows(2).map(|w| (w[1] - w[0]) / STEP).collect();
                *worst = values.iter().fold(*worst, |worst, value| worst.max(value.abs() / limits[joint]));
            }
        }
        Ok(worst)
    }
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = values.fold((0.0, 0.0), |(count, sum), value| (count + 1.0, sum + value));
    sum / count
}

fn main() -> Result<(), Error> {
    let mut arguments = env::args().skip(1);
    let count: u64 = arguments.next().ok_or("COUNT [SEED]")?.parse()?;
    let seed: u64 = arguments.next().map_or(Ok(1), |seed| seed.parse())?;
    let (mut second, mut third) = (Vec::new(), Vec::new());
    for case in 0..count {
        let case = Case::draw(&mut Random::new(seed + case))?;
        let ((ours2, ours), (theirs2, [one, two])) = (case.ours()?, case.copp()?);
        second.push([ours2, theirs2]);
        third.push([ours, one, two]);
    }
    println!("{count} splines, seeds from {seed} on");
    println!(
        "| motion | mean duration, s | COPP's over ours, least to most | largest ratio: velocity | acceleration | jerk |"
    );
    println!("|---|---|---|---|---|---|");
    for (k, name) in ["arcfeed `Reachability`", "COPP TOPP2-RA"].iter().enumerate() {
        let duration = mean(second.iter().map(|pair| pair[k]));
        let ratios: Vec<f64> = second.iter().map(|pair| pair[k] / pair[0]).collect();
        println!("| {name} | {duration:.4} | {} | | | |", span(&ratios));
    }
    for (k, name) in ["arcfeed `JerkLimited`", "COPP TOPP3-SOCP, one program", "two programs"].iter().enumerate() {
        let duration = mean(third.iter().map(|motions| motions[k].duration));
        let ratios: Vec<f64> = third.iter().map(|motions| motions[k].duration / motions[0].duration).collect();
        let worst = |order: usize| third.iter().map(|motions| motions[k].worst[order]).fold(0.0, f64::max);
        let [v, a, j] = [0, 1, 2].map(worst);
        println!("| {name} | {duration:.4} | {} | {v:.4} | {a:.4} | {j:.4} |", span(&ratios));
    }
    Ok(())
}

fn span(values: &[f64]) -> String {
    let (least, most) =
        values.iter().fold((f64::INFINITY, 0.0_f64), |(least, most), value| (least.min(*value), most.max(*value)));
    format!("{least:.4} to {most:.4}")
}
