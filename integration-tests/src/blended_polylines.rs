//! Random polylines by seed, blended within a tolerance and planned on the CR7: the path stays within the tolerance, its curvature is
//! continuous, and the motion keeps every limit and is no slower than with a stop in each corner.

use std::f64::consts::{FRAC_PI_2, PI};

use arcfeed_geometry::{
    ArcLengthCurve, BlendedPath, Blending, Curve, JoinedPath, JoinedPathBuilder, JointOutcome, NurbsCurve,
    OrientationPath, PosePath,
};
use arcfeed_interp::{Limits, PathError, Planner, ToolLimits, ToolPath, Trajectory};
use arcfeed_kinematics::{Joints, models};
use arcfeed_testing::Random;
use nalgebra::{Rotation3, UnitQuaternion, Vector3};

/// By how much a limit may seem to be exceeded through rounding.
const TOLERANCE: f64 = 1e-6;
/// Largest distance of the motion from its path, m.
const CHORD: f64 = 1e-6;
/// A motion without stops may be longer by this part than with them.
const SLOWER: f64 = 1e-9;
/// Jump of the tangent, and of the curvature by the length of the shorter neighbour, over rounding.
const JUMP: f64 = 1e-9;

/// A polyline, a tolerance and limits of the tool.
#[derive(Debug, Clone)]
pub struct BlendedPolyline {
    /// m.
    pub points: Vec<Vector3<f64>>,
    /// m.
    pub tolerance: f64,
    /// m/s.
    pub feed: f64,
    tangential: [f64; 2],
    normal: f64,
}

/// What became of a polyline.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outcome {
    /// Planned and verified: the duration with blends, and with a stop in each corner, s.
    Planned([f64; 2]),
    /// The arm cannot follow the polyline.
    OutOfReach,
}

impl BlendedPolyline {
    /// The polyline that belongs to `seed`.
    pub fn random(seed: u64) -> Self {
        let r = &mut Random::new(seed ^ 0x9017_11E5);
        let flat = r.chance(0.5);
        let middle = Vector3::new(0.42, -0.05, 0.2);
        let mut at = middle + 0.05 * Vector3::new(r.signed(), r.signed(), if flat { 0.0 } else { r.signed() });
        let mut points = vec![at];
        let mut along = Rotation3::from_axis_angle(&Vector3::z_axis(), r.between(-PI, PI)) * Vector3::x();
        let (shortest, longest) = r.one_of(&[(1e-3, 1e-1), (1e-2, 1e-1), (1e-3, 1e-2), (3e-2, 3e-2)]);
        for _ in 0..2 + r.below(6) {
            let length = r.log(shortest, longest);
            // Back to the middle from where the arm could not go on.
            if (at + along * length - middle).norm() > 0.15 {
                along = (middle - at).normalize();
            }
            at += along * length;
            points.push(at);
            let turn = match r.below(5) {
                0 => FRAC_PI_2,
                1 => PI - r.log(1e-3, 0.5),
                2 => r.log(1e-5, 1e-1),
                _ => r.between(0.0, PI),
            };
            let tilted = Vector3::new(r.signed(), r.signed(), 2.0);
            let axis =
                nalgebra::Unit::new_normalize(along.cross(&if flat { Vector3::z() } else { tilted }).cross(&along));
            along = (Rotation3::from_axis_angle(&axis, turn * r.sign()) * along).normalize();
        }
        let tangential = [r.log(0.5, 5.0), r.log(10.0, 200.0)];
        Self { points, tolerance: r.log(1e-5, 5e-3), feed: r.log(0.02, 0.5), tangential, normal: r.log(0.5, 5.0) }
    }

    /// Blends and plans the polyline.
    ///
    /// # Errors
    /// What does not hold.
    pub fn play(&self) -> Result<Outcome, String> {
        let error = |e: &dyn std::fmt::Display| e.to_string();
        let mut path = JoinedPathBuilder::new(self.points[0], 1e-9).map_err(|e| error(&e))?;
        for (i, point) in self.points.iter().enumerate().skip(1) {
            path.line_to(*point, i).map_err(|e| error(&e))?;
        }
        let path = path.build().map_err(|e| error(&e))?;
        let blended = path.blended(&Blending::within(self.tolerance)).map_err(|e| error(&e))?;
        self.check_path(&blended)?;
        let Some(exact) = self.plan(&path)? else { return Ok(Outcome::OutOfReach) };
        let Some(smooth) = self.plan(&blended.path)? else { return Ok(Outcome::OutOfReach) };
        if smooth > exact * (1.0 + SLOWER) {
            return Err(format!("{smooth} s with blends, {exact} s with stops"));
        }
        Ok(Outcome::Planned([smooth, exact]))
    }

    /// Distance of a point from the polyline, m.
    fn distance(&self, p: &Vector3<f64>) -> f64 {
        let from = |w: &[Vector3<f64>]| {
            let ab = w[1] - w[0];
            let part = ((p - w[0]).dot(&ab) / ab.norm_squared()).clamp(0.0, 1.0);
            (p - w[0] - ab * part).norm()
        };
        self.points.windows(2).map(from).fold(f64::INFINITY, f64::min)
    }

    /// Deviation and continuity of the blended path.
    fn check_path(&self, blended: &BlendedPath) -> Result<(), String> {
        let curve = blended.path.to_curve().map_err(|e| e.to_string())?;
        for piece in blended.path.pieces() {
            for k in 0..=100 {
                let u = piece.start + (piece.end - piece.start) * f64::from(k) / 100.0;
                let off = self.distance(&curve.point(u));
                if off > self.tolerance {
                    return Err(format!("{off} m from the polyline at u = {u}"));
                }
            }
        }
        let kept = |(_, outcome): &&(_, JointOutcome)| matches!(outcome, JointOutcome::Kept(_));
        let stops: Vec<Vector3<f64>> =
            blended.joints.iter().filter(kept).map(|(joint, _)| self.points[joint.piece + 1]).collect();
        continuous(&curve, &stops)
    }

    /// The duration of the verified motion, s; `None` where the arm cannot follow.
    fn plan(&self, path: &JoinedPath) -> Result<Option<f64>, String> {
        let arm = models::cr7();
        let rates = [PI, 10.0, 100.0].map(Joints::repeat);
        let range = arm.range().with_rates(rates[0], rates[1], rates[2]).map_err(|e| e.to_string())?;
        let curve = ArcLengthCurve::new(path.to_curve().map_err(|e| e.to_string())?, 1e-15);
        let down = UnitQuaternion::from_euler_angles(PI, 0.0, 0.0);
        let path = PosePath::new(curve.map_err(|e| e.to_string())?, OrientationPath::Constant(down));
        let path = match ToolPath::new(&arm, path, range.range()) {
            Ok(path) => path,
            Err(PathError::Arm { .. } | PathError::BranchChange { .. } | PathError::JointRange { .. }) => {
                return Ok(None);
            }
            Err(other) => return Err(other.to_string()),
        };
        let limits = self.limits().map_err(|e| e.to_string())?;
        let planner = Planner::new(&arm, Limits::new(range).with_tool(limits));
        let planner = planner.with_chord_tolerance(CHORD).map_err(|e| e.to_string())?;
        let plan = planner.plan(&path).map_err(|e| e.to_string())?;
        let verification = planner.verify(plan.problem(), plan.law(), true).map_err(|e| e.to_string())?;
        if !verification.holds(TOLERANCE) {
            return Err(format!("breaks a limit: {:?}", verification.worst()));
        }
        self.check_motion(&plan)?;
        Ok(Some(plan.duration()))
    }

    fn limits(&self) -> Result<ToolLimits, arcfeed_interp::LimitError> {
        ToolLimits::new()
            .with_feed(self.feed)?
            .with_tangential_acceleration(self.tangential[0])?
            .with_tangential_jerk(self.tangential[1])?
            .with_normal_acceleration(self.normal)
    }

    /// The tool stays within the tolerance of the polyline.
    fn check_motion(&self, plan: &Trajectory<'_>) -> Result<(), String> {
        for setpoint in plan.setpoints(4e-3).map_err(|e| e.to_string())? {
            let setpoint = setpoint.map_err(|e| e.to_string())?;
            let off = self.distance(&setpoint.pose.translation.vector);
            if off > self.tolerance + CHORD {
                return Err(format!("the tool is {off} m from the polyline at {} s", setpoint.t));
            }
        }
        Ok(())
    }
}

/// Point, tangent and curvature from both sides of every knot, except in the points `stops`.
fn continuous(curve: &NurbsCurve<3>, stops: &[Vector3<f64>]) -> Result<(), String> {
    let size = curve.control_points().iter().fold(0.0f64, |m, p| m.max(p.amax()));
    let knots: Vec<f64> = curve.knots().runs().map(|run| run.1).collect();
    for around in knots.windows(3) {
        let u = around[1];
        let (left, right) = (curve.jet_left(u).by_arc_length(), curve.jet(u).by_arc_length());
        if stops.iter().any(|p| (p - right.point).norm() <= 1e-14 * size) {
            continue;
        }
        let shorter = (u - around[0]).min(around[2] - u);
        let bend = |k: i32| curve.jet(around[0] + (around[2] - around[0]) * f64::from(k) / 16.0).curvature();
        let most = (0..=16).map(bend).fold(0.0, f64::max);
        let gap = (left.point - right.point).norm() / size;
        let tangent = (left.d1 - right.d1).norm();
        let curvature = (left.d2 - right.d2).norm() * shorter / (1.0 + most * shorter);
        // Coordinates that are rounded turn the legs of the control polygon, of which the shortest is a twentieth of its span.
        let rounding = f64::EPSILON * size / (0.05 * shorter);
        if !(gap <= 1e-14 && tangent <= JUMP + 4.0 * rounding && curvature <= JUMP + 100.0 * rounding) {
            return Err(format!("jumps of {tangent:e} and {curvature:e} at u = {u}, rounding {rounding:e}"));
        }
    }
    Ok(())
}
