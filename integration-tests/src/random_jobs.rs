//! Random jobs by seed: smooth and C1 curves of the tool and paths through way-points, on four arms, under random limits.

use std::f64::consts::PI;
use std::sync::Arc;

use arcfeed_geometry::{ArcLengthCurve, NurbsCurve, OrientationPath, PosePath};
use arcfeed_interp::{
    CompileError, JointRates, JointSpline, Limits, PathArm, PlanError, Planner, ToolLimits, ToolPath, Trajectory,
};
use arcfeed_kinematics::{AnalyticInverse, JointRange, Joints, models};
use nalgebra::{UnitQuaternion, Vector3};

use arcfeed_testing::Random;

/// Motion of the joints from their polynomials' distance to the plan, rad.
const TOLERANCE: f64 = 1e-6;
/// A limit may be exceeded by this part through rounding.
const ROUNDING: f64 = 1e-6;

/// The result of one job.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// The arm cannot follow the path, or the curve cannot be used.
    NoPath(String),
    /// Planned, compiled and certified.
    Done(Done),
    /// Something that must not be.
    Failed(String),
}

/// A job that was planned.
#[derive(Debug, Clone, PartialEq)]
pub struct Done {
    /// Duration, s.
    pub duration: f64,
    /// Why the law is not that of the jerk-limited planner, where it is not.
    pub fallback: Option<String>,
    /// The part of the duration by which it may be longer than the shortest motion, where that was asked for.
    pub gap: Option<f64>,
    /// Largest certified ratio to a limit of the joints.
    pub ratio: f64,
}

/// The job that belongs to `seed`; with a lower bound of its duration where `bound` says so.
pub fn random_job(seed: u64, bound: bool) -> Outcome {
    let random = &mut Random::new(seed ^ 0x10B5_C0DE);
    match random.below(3) {
        0 => job(random, &models::cr7(), models::cr7().range(), bound),
        1 => job(random, &models::ur5e(), models::ur5e().range(), bound),
        _ => {
            let arm = if random.chance(0.5) { models::kr6_r700() } else { models::puma560() };
            job(random, &arm, arm.range(), bound)
        }
    }
}

fn job<A: PathArm<6> + AnalyticInverse<6>>(
    random: &mut Random,
    arm: &A,
    range: &JointRange<6>,
    bound: bool,
) -> Outcome {
    let each = |random: &mut Random, from: f64, to: f64| Joints::from_fn(|_, _| random.log(from, to));
    let rates = [each(random, 1.0, 4.0), each(random, 3.0, 30.0), each(random, 30.0, 1000.0)];
    let Ok(limits) = range.with_rates(rates[0], rates[1], rates[2]) else {
        return Outcome::Failed("the limits are refused".to_owned());
    };
    let limits = Limits::new(limits);
    let planned = if random.chance(0.3) {
        let inside =
            |random: &mut Random| Joints::from_fn(|k, _| random.between(-0.9, 0.9) * range.upper()[k].min(1.5));
        let points: Vec<Joints<6>> = (0..2 + random.below(8)).map(|_| inside(random)).collect();
        let Ok(spline) = JointSpline::through(&points) else {
            return Outcome::NoPath("way-points of no spline".to_owned());
        };
        Planner::new(arm, limits).plan_shared(Arc::new(spline))
    } else {
        let Some(curve) = random_curve(random) else { return Outcome::NoPath("no curve".to_owned()) };
        let down = UnitQuaternion::from_euler_angles(PI, 0.0, 0.0);
        let path = match ToolPath::new(arm, PosePath::new(curve, OrientationPath::Constant(down)), range) {
            Ok(path) => path,
            Err(error) => return Outcome::NoPath(error.to_string()),
        };
        let tolerance = random.log(1e-6, 1e-4);
        tool_limits(random)
            .map_err(PlanError::from)
            .and_then(|tool| Ok(Planner::new(arm, limits.with_tool(tool)).with_chord_tolerance(tolerance)?))
            .and_then(|planner| planner.plan_shared(Arc::new(path)))
    };
    match planned {
        Ok(trajectory) => checked(&trajectory, bound),
        Err(PlanError::Path(error)) => Outcome::NoPath(error.to_string()),
        Err(error) => Outcome::Failed(error.to_string()),
    }
}

fn tool_limits(random: &mut Random) -> Result<ToolLimits, arcfeed_interp::LimitError> {
    ToolLimits::new()
        .with_feed(random.log(0.005, 1.0))?
        .with_tangential_acceleration(random.log(0.3, 5.0))?
        .with_tangential_jerk(random.log(3.0, 200.0))?
        .with_normal_acceleration(random.log(0.3, 5.0))
}

/// A B-spline of some mm to 0.3 m in front of the arm; one of three has curvature jumps at its knots.
pub fn random_curve(random: &mut Random) -> Option<ArcLengthCurve<3>> {
    let (degree, spans, rough) = (2 + random.below(4), 1 + random.below(8), random.below(3) == 0);
    let repeated = if rough && degree > 2 { degree - 1 } else { 1 };
    let size = random.log(0.002, 0.15);
    let centre = Vector3::new(random.between(0.35, 0.5), random.between(-0.2, 0.2), random.between(0.1, 0.35));
    let mut points: Vec<Vector3<f64>> = (0..degree + 1 + repeated * (spans - 1))
        .map(|_| centre + Vector3::from_fn(|_, _| random.between(-size, size)))
        .collect();
    let mut knots = vec![0.0; degree + 1];
    (1..spans).for_each(|i| knots.extend(std::iter::repeat_n(i as f64, repeated)));
    knots.extend(std::iter::repeat_n(spans as f64, degree + 1));
    if repeated > 1 {
        // The tangent is continuous where the point at a knot is between its neighbours.
        for i in (repeated..points.len() - repeated).step_by(repeated) {
            points[i] = 0.5 * (points[i - 1] + points[i + 1]);
        }
    }
    ArcLengthCurve::new(NurbsCurve::bspline(degree, points, knots).ok()?, 1e-15).ok()
}

/// Compiles the motion and holds it by its certificate.
fn checked(trajectory: &Trajectory<'_>, bound: bool) -> Outcome {
    let limits = trajectory.limits().joints();
    let compiled = match trajectory.compile(TOLERANCE) {
        Ok(compiled) => compiled,
        Err(CompileError::Plan(error)) => return Outcome::Failed(error.to_string()),
        Err(error) => return Outcome::Failed(format!("not compiled: {error}")),
    };
    let certificate = compiled.certify(limits.range(), &JointRates::from(limits));
    if !certificate.holds(ROUNDING) {
        return Outcome::Failed(format!("the certificate does not hold: {certificate}"));
    }
    let gap = match bound.then(|| trajectory.lower_bound()).transpose() {
        Ok(bound) => bound.map(|bound| trajectory.duration() / bound.duration - 1.0),
        Err(error) => return Outcome::Failed(format!("no bound: {error}")),
    };
    let ratio = certificate.worst().map_or(0.0, |worst| worst.ratio());
    let fallback = trajectory.info().fallback.as_ref().map(ToString::to_string);
    Outcome::Done(Done { duration: trajectory.duration(), fallback, gap, ratio })
}
