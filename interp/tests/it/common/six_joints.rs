//! Arms of six joints without a closed form, drawn at random, and small paths within their reach.

use arcfeed_geometry::{ArcLengthCurve, NurbsCurve, OrientationPath, PosePath};
use arcfeed_interp::{Limits, MotionPath, PlanError, Planner, ToolLimits, ToolPath, Trajectory};
use arcfeed_kinematics::{
    Arm, Chain, ForwardKinematics, InverseMethod, Joint, JointLimits, JointRange, Joints, smallest_singular_value,
};
use nalgebra::{Isometry3, Point3, Unit, UnitQuaternion, Vector3, Vector6};
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

/// A multiplicative sequence, the same on every machine.
pub struct Sequence(pub u64);

impl Sequence {
    /// From 0 to 1.
    pub fn draw(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn within(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.draw()
    }

    fn log(&mut self, from: f64, to: f64) -> f64 {
        self.within(from.ln(), to.ln()).exp()
    }

    fn vector(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.within(-1.0, 1.0))
    }
}

/// A path that an arm is to follow from `start` on.
pub struct Case {
    pub arm: Arm<6>,
    pub limits: JointLimits<6>,
    pub tool: ToolLimits,
    pub path: PosePath,
    pub start: Joints<6>,
}

/// How a case ended.
#[derive(Debug, PartialEq)]
pub enum Outcome {
    Planned,
    /// A joint leaves its range, or a singular pose is in the way.
    OutOfReach,
}

fn revolute(xyz: [f64; 3], rpy: [f64; 3]) -> Joint {
    let turn = UnitQuaternion::from_euler_angles(rpy[0], rpy[1], rpy[2]);
    Joint::revolute(Isometry3::from_parts(xyz.into(), turn), Vector3::z()).expect("a joint")
}

fn arm(joints: [Joint; 6], range: f64) -> Arm<6> {
    let range = JointRange::new(Joints::repeat(-range), Joints::repeat(range)).expect("a range");
    Arm::new(Chain::new(joints).expect("a chain"), range)
}

/// An arm whose wrist is bent by a radian and offset by 80 mm, and a line of 30 mm for it.
pub fn bent_wrist() -> Case {
    let joints = [
        revolute([0.0, 0.0, 0.2], [0.0; 3]),
        revolute([0.0; 3], [FRAC_PI_2, 0.0, 0.0]),
        revolute([0.4, 0.0, 0.0], [0.0; 3]),
        revolute([0.05, 0.0, 0.0], [FRAC_PI_2, 0.0, 0.0]),
        revolute([0.0, 0.0, 0.3], [1.0, 0.0, 0.0]),
        revolute([0.0, 0.0, 0.08], [-1.0, 0.0, 0.0]),
    ];
    let arm = arm(joints, 3.0);
    let rates = [3.0, 10.0, 100.0].map(Joints::repeat);
    let limits = arm.range().with_rates(rates[0], rates[1], rates[2]).expect("limits");
    let from = Vector3::new(0.1631, 0.1299, 0.1628);
    let [roll, pitch, yaw] = [135.0_f64, 30.6, -57.5].map(f64::to_radians);
    let turn = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
    let curve = NurbsCurve::line(from, from + Vector3::x() * 0.03).expect("a line");
    let curve = ArcLengthCurve::new(curve, 1e-15).expect("a length");
    let path = PosePath::new(curve, OrientationPath::Constant(turn));
    let start = ToolPath::new(&arm, path.clone(), limits.range()).expect("in reach").start();
    Case { arm, limits, tool: tool(0.05), path, start }
}

fn tool(feed: f64) -> ToolLimits {
    ToolLimits::new()
        .with_feed(feed)
        .and_then(|t| t.with_tangential_acceleration(1.0))
        .and_then(|t| t.with_tangential_jerk(30.0))
        .and_then(|t| t.with_normal_acceleration(1.0))
        .expect("valid limits")
}

/// One of four families: an offset and bent wrist, nearly parallel axes, a wrist that misses its
/// centre, any chain at all.
fn draw_joints(draw: &mut Sequence) -> [Joint; 6] {
    let q = FRAC_PI_2;
    let family = (draw.draw() * 4.0) as usize;
    let (a, b) = (draw.within(0.2, 0.6), draw.within(0.2, 0.5));
    let (bend, offset) = (draw.within(0.3, 1.3), draw.within(0.02, 0.12));
    let mut shape: [([f64; 3], [f64; 3]); 6] = match family {
        0 => [
            ([0.0, 0.0, 0.2], [0.0; 3]),
            ([0.0; 3], [q, 0.0, 0.0]),
            ([a, 0.0, 0.0], [0.0; 3]),
            ([0.05, 0.0, 0.0], [q, 0.0, 0.0]),
            ([0.0, 0.0, b], [bend, 0.0, 0.0]),
            ([0.0, 0.0, offset], [-bend, 0.0, 0.0]),
        ],
        1 => [
            ([0.0, 0.0, 0.2], [0.0; 3]),
            ([0.0, offset, 0.0], [q, 0.0, 0.0]),
            ([a, 0.0, 0.0], [0.0; 3]),
            ([b, 0.0, 0.0], [0.0; 3]),
            ([0.0, 0.0, 0.1], [q, 0.0, 0.0]),
            ([0.0, 0.0, 0.1], [-q, 0.0, 0.0]),
        ],
        2 => [
            ([0.0, 0.0, 0.3], [0.0; 3]),
            ([0.03, 0.0, 0.0], [q, 0.0, 0.0]),
            ([a, 0.0, 0.0], [0.0; 3]),
            ([0.03, 0.0, 0.0], [q, 0.0, 0.0]),
            ([0.0, offset, b], [-q, 0.0, 0.0]),
            ([offset, 0.0, 0.0], [q, 0.0, 0.0]),
        ],
        _ => std::array::from_fn(|_| {
            let (xyz, rpy) = (draw.vector() * 0.3, draw.vector() * 3.0);
            (xyz.into(), rpy.into())
        }),
    };
    // Axes tilted from little to much, as after a calibration or in a careless drawing.
    let tilt = draw.log(1e-3, 0.2);
    for (_, rpy) in &mut shape {
        let by = draw.vector() * tilt;
        for (angle, by) in rpy.iter_mut().zip(by.iter()) {
            *angle += by;
        }
    }
    shape.map(|(xyz, rpy)| revolute(xyz, rpy))
}

/// The case of a seed; none where the draw has a closed form or starts next to a singular pose.
pub fn draw_case(seed: u64) -> Option<Case> {
    let mut draw = Sequence(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15));
    draw.draw();
    let joints = draw_joints(&mut draw);
    let arm = arm(joints, draw.within(2.0, 6.0)).with_tool(Isometry3::translation(0.0, 0.0, 0.05)).ok()?;
    if arm.method() != InverseMethod::Numeric {
        return None;
    }
    let start =
        Joints::from_fn(|i, _| 0.6 * draw.within(arm.range().lower()[i], arm.range().upper()[i]).clamp(-3.0, 3.0));
    if smallest_singular_value(&arm.jacobian(&start)) < 0.03 {
        return None;
    }
    let rate = |draw: &mut Sequence, from, to| Joints::from_fn(|_, _| draw.log(from, to));
    let (velocity, acceleration) = (rate(&mut draw, 1.0, 4.0), rate(&mut draw, 2.0, 30.0));
    let limits = arm.range().with_rates(velocity, acceleration, rate(&mut draw, 10.0, 2000.0)).ok()?;
    let pose = arm.forward(&start);
    let normal = Unit::try_new(draw.vector(), 1e-3)?;
    let turn = UnitQuaternion::rotation_between(&Vector3::z(), &normal)?;
    let path = if draw.draw() < 0.5 {
        let radius = draw.log(0.005, 0.04);
        let centre = pose.translation.vector - turn * Vector3::x() * radius;
        let frame = Isometry3::from_parts(centre.into(), turn);
        let curve = NurbsCurve::<3>::circle(&frame, radius).ok()?;
        PosePath::new(ArcLengthCurve::new(curve, 1e-15).ok()?, OrientationPath::Constant(pose.rotation))
    } else {
        let from = pose.translation.vector;
        let curve = NurbsCurve::line(from, from + normal.into_inner() * draw.log(0.01, 0.1)).ok()?;
        let curve = ArcLengthCurve::new(curve, 1e-15).ok()?;
        let last = UnitQuaternion::from_scaled_axis(draw.vector() * 0.3) * pose.rotation;
        let turning = OrientationPath::slerp(curve.length(), pose.rotation, last).ok()?;
        PosePath::new(curve, turning)
    };
    Some(Case { arm, limits, tool: tool(draw.log(0.01, 0.3)), path, start })
}

/// Plans the case from its start on.
///
/// # Errors
/// What the planner says.
pub fn plan(case: &Case) -> Result<Trajectory<'_>, PlanError> {
    let path = ToolPath::starting_near(&case.arm, case.path.clone(), &case.start)?;
    Planner::new(&case.arm, Limits::new(case.limits).with_tool(case.tool)).plan_shared(Arc::new(path))
}

/// Plans the case. A plan must hold its verification; a refusal must have a reason in the arm.
///
/// # Errors
/// What was said although the arm can follow the path.
pub fn play(case: &Case) -> Result<Outcome, String> {
    match plan(case) {
        Ok(plan) if plan.verification().holds(1e-6) => Ok(Outcome::Planned),
        Ok(_) => Err("a plan that is not verified".to_owned()),
        Err(_) if !can_follow(case) => Ok(Outcome::OutOfReach),
        Err(error) => Err(error.to_string()),
    }
}

/// Whether Newton's method along the path, in steps of 0.1 mm, stays inside the joint range and
/// away from singular poses.
fn can_follow(case: &Case) -> bool {
    /// Farther from singular poses than the planner asks for, as places between the steps are
    /// nearer.
    const SINGULAR: f64 = 4e-3;
    let length = case.path.length();
    let steps = (length / 1e-4).ceil() as usize;
    let mut q = case.start;
    for step in 0..=steps {
        let target = case.path.jet(length * step as f64 / steps as f64).pose;
        for _ in 0..5 {
            let (at, jacobian) = case.arm.forward_jacobian(&q);
            if smallest_singular_value(&jacobian) < SINGULAR {
                return false;
            }
            let shift = target.translation.vector - at.translation.vector;
            let turn = (target.rotation * at.rotation.inverse()).scaled_axis();
            let error = Vector6::new(shift.x, shift.y, shift.z, turn.x, turn.y, turn.z);
            let Some(by) = jacobian.lu().solve(&error) else { return false };
            q += by;
        }
        let met = (case.arm.forward(&q) * Point3::origin() - target * Point3::origin()).norm() < 1e-9;
        let margin = (q - case.arm.range().lower()).min().min((case.arm.range().upper() - q).min());
        if !met || margin < 1e-3 {
            return false;
        }
    }
    true
}
