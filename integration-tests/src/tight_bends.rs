//! Random paths with places that are nearly a corner, by seed: knots that nearly coincide, near-cusps, polylines with nearly
//! equal points, corners rounded with tiny radii. Each is planned and verified, or refused for a reason that names the place.

use arcfeed_geometry::{ArcLengthCurve, GeometryError, NurbsCurve, OrientationPath, PosePath};
use arcfeed_interp::{
    Cause, Limits, Method, MotionPath, PathError, PlanError, Planner, SpeedError, ToolLimits, ToolPath,
};
use arcfeed_kinematics::{Joints, models};
use nalgebra::{UnitQuaternion, Vector3};

use arcfeed_testing::Random;

use crate::hybrid_scenario::vector;

/// By how much a limit may seem to be exceeded through rounding.
const TOLERANCE: f64 = 1e-6;

/// What became of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outcome {
    /// Planned and verified: the duration, by that which the feed asks for.
    Planned(f64),
    /// Refused with the place and the reason.
    Refused,
    /// The arm cannot follow the path, however slowly.
    OutOfReach,
}

/// A path and limits.
#[derive(Debug, Clone)]
pub struct TightBend {
    degree: usize,
    points: Vec<Vector3<f64>>,
    knots: Vec<f64>,
    feed: f64,
    tangential: [f64; 2],
    normal: f64,
    joints: [f64; 3],
    chord: f64,
    period: f64,
    method: Method,
    tilt: Vector3<f64>,
}

impl TightBend {
    /// The path that belongs to `seed`.
    pub fn random(seed: u64) -> Self {
        let r = &mut Random::new(seed ^ 0x7137_BE4D);
        let centre = Vector3::new(r.between(0.35, 0.45), r.between(-0.15, 0.15), r.between(0.2, 0.35));
        let size = r.log(0.01, 0.1);
        let (degree, mut points, knots) = match r.below(4) {
            0 => close_knots(r),
            1 => near_cusps(r),
            2 => near_duplicates(r),
            _ => rounded_corners(r),
        };
        for point in &mut points {
            *point = centre + *point * size;
        }
        Self {
            degree,
            points,
            knots,
            feed: r.log(0.02, 0.5),
            tangential: [r.log(0.5, 5.0), r.log(10.0, 200.0)],
            normal: r.log(0.5, 50.0),
            joints: [r.log(1.0, 6.0), r.log(3.0, 30.0), r.log(30.0, 20_000.0)],
            chord: r.log(1e-6, 1e-4),
            period: [1e-3, 2e-3, 4e-3, 8e-3][r.below(4)],
            method: if r.below(3) == 0 { Method::ContinuousAcceleration } else { Method::JerkLimited },
            tilt: vector(r, 0.3),
        }
    }

    fn limits(&self) -> Result<ToolLimits, String> {
        ToolLimits::new()
            .with_feed(self.feed)
            .and_then(|t| t.with_tangential_acceleration(self.tangential[0]))
            .and_then(|t| t.with_tangential_jerk(self.tangential[1]))
            .and_then(|t| t.with_normal_acceleration(self.normal))
            .map_err(|e| e.to_string())
    }

    /// Plans the path and says what became of it.
    ///
    /// # Errors
    /// What is wrong: a plan that breaks a limit, or a refusal without a reason.
    pub fn play(&self) -> Result<Outcome, String> {
        let curve = match NurbsCurve::bspline(self.degree, self.points.clone(), self.knots.clone()) {
            Ok(curve) => curve,
            Err(GeometryError::KnotsTooClose { .. }) => return Ok(Outcome::Refused),
            Err(other) => return Err(format!("curve: {other}")),
        };
        let curve = match ArcLengthCurve::new(curve, 1e-15) {
            Ok(curve) => curve,
            Err(GeometryError::StandsStill { .. } | GeometryError::ZeroLength { .. }) => return Ok(Outcome::Refused),
            Err(other) => return Err(format!("arc length: {other}")),
        };
        let down = UnitQuaternion::from_euler_angles(std::f64::consts::PI, 0.0, 0.0);
        let tool = UnitQuaternion::from_scaled_axis(self.tilt) * down;
        let path = PosePath::new(curve, OrientationPath::Constant(tool));
        let arm = models::ur5e();
        let [v, a, j] = self.joints.map(Joints::repeat);
        let limits = arm.range().with_rates(v, a, j).map_err(|e| e.to_string())?;
        let Ok(path) = ToolPath::new(&arm, path, limits.range()) else { return Ok(Outcome::OutOfReach) };
        let planner = Planner::new(&arm, Limits::new(limits).with_tool(self.limits()?))
            .with_chord_tolerance(self.chord)
            .and_then(|p| p.with_period(self.period))
            .map_err(|e| e.to_string())?
            .with_method(self.method);
        match planner.plan(&path) {
            Ok(plan) => {
                let verification = planner.verify(plan.problem(), plan.law(), true).map_err(|e| e.to_string())?;
                // The slowest of these paths needs some ten seconds; a place that is nearly a corner costs a stop.
                let least = path.length() / self.feed;
                if !verification.holds(TOLERANCE) {
                    Err(format!("breaks a limit: {:?}", verification.worst()))
                } else if plan.duration() > 30.0 + 5.0 * least {
                    Err(format!("takes {} s, of which the feed asks for {least}", plan.duration()))
                } else {
                    Ok(Outcome::Planned(plan.duration() / least))
                }
            }
            Err(PlanError::Path(
                PathError::Arm { .. } | PathError::BranchChange { .. } | PathError::JointRange { .. },
            )) => Ok(Outcome::OutOfReach),
            Err(
                PlanError::Path(PathError::Geometry(GeometryError::ParameterTooCoarse { .. }))
                | PlanError::Speed(SpeedError::Infeasible { .. }),
            ) => Ok(Outcome::Refused),
            Err(PlanError::Unverified { cause: Cause::Bend { .. } | Cause::NearlySingular { .. }, .. }) => {
                Ok(Outcome::Refused)
            }
            Err(other) => Err(format!("refused: {other}")),
        }
    }

    /// The path as a path file.
    pub fn path_file(&self) -> String {
        let points: Vec<[f64; 3]> = self.points.iter().map(|&p| p.into()).collect();
        format!(
            "{{\"units\": \"m\", \"degree\": {}, \"control_points\": {points:?}, \"knots\": {:?}}}",
            self.degree, self.knots
        )
    }
}

type Shape = (usize, Vec<Vector3<f64>>, Vec<f64>);

fn clamped(degree: usize, inner: Vec<f64>, end: f64) -> Vec<f64> {
    [vec![0.0; degree + 1], inner, vec![end; degree + 1]].concat()
}

/// Pairs and groups of knots one ulp to 1e-6 of the domain apart.
fn close_knots(r: &mut Random) -> Shape {
    let degree = 2 + r.below(4);
    let (mut inner, mut u) = (Vec::new(), 0.0);
    for _ in 0..1 + r.below(4) {
        u += r.between(0.2, 1.0);
        let mut knot: f64 = u;
        for _ in 0..1 + r.below(degree) {
            inner.push(knot);
            knot = if r.below(4) == 0 { knot.next_up() } else { knot + r.log(1e-16, 1e-6) };
        }
    }
    let knots = clamped(degree, inner, u + r.between(0.2, 1.0));
    let points = (0..knots.len() - degree - 1).map(|_| vector(r, 1.0)).collect();
    (degree, points, knots)
}

/// Cubic pieces that nearly turn back on themselves: the middle control points nearly cross.
fn near_cusps(r: &mut Random) -> Shape {
    let pieces = 1 + r.below(4);
    let mut points = vec![vector(r, 1.0)];
    for _ in 0..pieces {
        let from = points[points.len() - 1];
        let to = vector(r, 1.0);
        // x(t) of 0, 1, 0, 1 / 3 ... turns back where the middle points have changed places.
        let (along, across) = (to - from, vector(r, 1.0) * r.log(1e-4, 0.3));
        let cross = r.between(0.0, 1.5);
        points.extend([from + along * (0.5 + cross) + across, to - along * (0.5 + cross) + across, to]);
    }
    let inner = (1..pieces).flat_map(|i| [i as f64; 3]).collect();
    (3, points, clamped(3, inner, pieces as f64))
}

/// Polylines some of whose points nearly coincide.
fn near_duplicates(r: &mut Random) -> Shape {
    let mut points = Vec::new();
    for _ in 0..3 + r.below(5) {
        let point = vector(r, 1.0);
        points.push(point);
        if r.below(2) == 0 {
            points.push(point + vector(r, 1.0) * r.log(1e-13, 1e-3));
        }
    }
    let n = points.len();
    (1, points, clamped(1, (1..n - 1).map(|i| i as f64).collect(), (n - 1) as f64))
}

/// A polyline whose corners are rounded by parabolas with radii from a nanometre on.
fn rounded_corners(r: &mut Random) -> Shape {
    let count = 3 + r.below(3);
    let corners: Vec<Vector3<f64>> = (0..count).map(|_| vector(r, 1.0)).collect();
    let mut points = vec![corners[0]];
    for i in 1..count - 1 {
        let cut = r.log(1e-8, 0.3);
        let (before, after) = (corners[i - 1] - corners[i], corners[i + 1] - corners[i]);
        let start = corners[i] + before * cut;
        points.extend([(points[points.len() - 1] + start) * 0.5, start, corners[i], corners[i] + after * cut]);
    }
    points.push((points[points.len() - 1] + corners[count - 1]) * 0.5);
    points.push(corners[count - 1]);
    let pieces = (points.len() - 1) / 2;
    let inner = (1..pieces).flat_map(|i| [i as f64; 2]).collect();
    (2, points, clamped(2, inner, pieces as f64))
}
