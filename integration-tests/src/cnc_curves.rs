//! Ten curves of the kind that interpolators of machine tools are compared on, drawn anew: closed and open, nine of them with jumps of
//! curvature, at any size, in front of any arm with six joints.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, PI, TAU};
use std::sync::Arc;

use arcfeed_feedrate::LowerBound;
use arcfeed_geometry::{ArcLengthCurve, GeometryError, NurbsCurve, OrientationPath, PosePath};
use arcfeed_interp::{
    LimitError, Limits, Method, PathArm, PathError, PlanError, Planner, ToolLimits, ToolPath, Trajectory,
};
use arcfeed_kinematics::{AnalyticInverse, JointRange, Joints, models};
use nalgebra::{UnitQuaternion, Vector3};

/// The curves.
pub const NAMES: [&str; 10] =
    ["star", "wm", "goggles", "omega", "diamond", "trident", "serpentine", "slot", "wave", "infinity"];

/// The arms that they are planned on, with where the middle of the curve lies in front of them, m.
pub const ARMS: [(&str, [f64; 3]); 4] = [
    ("cr7", [0.45, -0.15, 0.25]),
    ("ur5e", [0.45, -0.15, 0.2]),
    ("kr6_r700", [0.45, 0.0, 0.35]),
    ("puma560", [0.42, -0.15, 0.1]),
];

/// Curves from this width on (m) are out of the Puma's reach there with the tool pointing down. They lie here, m, and the tool points
/// forward.
const WIDE_ON_PUMA: (f64, [f64; 3]) = (0.4, [0.59, 0.0, 0.55]);

/// One curve of a size, at a feed, on an arm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CncJob {
    /// One of [`NAMES`].
    pub curve: &'static str,
    /// Width of the curve, m.
    pub size: f64,
    /// m/s.
    pub feed: f64,
    /// One of [`ARMS`], by name.
    pub arm: &'static str,
    /// Factors on the limits of the joints' velocity, acceleration and jerk, and of the tool's tangential acceleration, tangential jerk
    /// and normal acceleration.
    pub factors: [f64; 6],
    /// True if the duration is to be bounded from below, too.
    pub bounded: bool,
}

/// What one method gave.
#[derive(Debug, Clone, PartialEq)]
pub struct Planned {
    /// s.
    pub duration: f64,
    /// Why it is not the law of the method that was asked for.
    pub fallback: Option<String>,
    /// Rounds of planning.
    pub rounds: usize,
    /// Intervals of the grid.
    pub intervals: usize,
    /// Time to plan without verification, s.
    pub planning: f64,
    /// The lower bound of the duration, or why there is none, where it was asked for.
    pub bound: Option<Result<LowerBound, String>>,
}

impl CncJob {
    /// The job with limits as they are stated: 180 deg/s, 10 rad/s^2, 100 rad/s^3 for every joint; 1 m/s^2 along the path and across it,
    /// 20 m/s^3 along it.
    pub fn new(curve: &'static str, size: f64, feed: f64, arm: &'static str) -> Self {
        Self { curve, size, feed, arm, factors: [1.0; 6], bounded: false }
    }

    /// Plans it by a method.
    ///
    /// # Errors
    /// What the planner says, as text.
    pub fn plan(&self, method: Method) -> Result<Planned, String> {
        match self.arm {
            "cr7" => self.plan_on(&models::cr7(), method),
            "ur5e" => self.plan_on(&models::ur5e(), method),
            "kr6_r700" => self.plan_on(&models::kr6_r700(), method),
            "puma560" => self.plan_on(&models::puma560(), method),
            other => Err(format!("no arm {other}")),
        }
    }

    fn plan_on<A: PathArm<6> + AnalyticInverse<6> + HasRange>(
        &self,
        arm: &A,
        method: Method,
    ) -> Result<Planned, String> {
        let path = self.path().map_err(|e| e.to_string())?;
        let path = ToolPath::new(arm, path, arm.joint_range()).map_err(|e: PathError| e.to_string())?;
        let limits = self.limits(arm.joint_range()).map_err(|e| e.to_string())?;
        let planner = Planner::new(arm, limits).with_method(method);
        planner.plan_shared(Arc::new(path)).map(|t| planned(&t, self.bounded)).map_err(|e: PlanError| e.to_string())
    }

    fn limits(&self, range: &JointRange<6>) -> Result<Limits<'static, 6>, LimitError> {
        let [v, a, j, tangential, tangential_jerk, normal] = self.factors;
        let tool = ToolLimits::new()
            .with_feed(self.feed)?
            .with_tangential_acceleration(tangential)?
            .with_tangential_jerk(20.0 * tangential_jerk)?
            .with_normal_acceleration(normal)?;
        let rates = [PI * v, 10.0 * a, 100.0 * j].map(Joints::repeat);
        let range = range.with_rates(rates[0], rates[1], rates[2]).expect("factors above 0");
        Ok(Limits::new(range).with_tool(tool))
    }

    /// The curve before the arm, in a level plane, the tool pointing down; wide ones before the Puma have it point forward.
    ///
    /// # Errors
    /// [`GeometryError`] for an unknown name or a size that makes no curve.
    pub fn path(&self) -> Result<PosePath, GeometryError> {
        let (wide, place) = WIDE_ON_PUMA;
        let is_wide = self.arm == "puma560" && self.size > wide;
        let usual = ARMS.iter().find(|(name, _)| *name == self.arm).map_or([0.45, -0.15, 0.25], |(_, at)| *at);
        let (middle, pitch) = if is_wide { (place, -FRAC_PI_2) } else { (usual, 0.0) };
        let (degree, points, weights, knots) = shape(self.curve);
        let (mut least, mut most) = ([f64::MAX; 2], [f64::MIN; 2]);
        for p in &points {
            for i in 0..2 {
                (least[i], most[i]) = (least[i].min(p[i]), most[i].max(p[i]));
            }
        }
        let scale = self.size / (most[0] - least[0]).max(most[1] - least[1]);
        let place = |p: &[f64; 2]| {
            let [x, y] = [0, 1].map(|i| scale * (p[i] - 0.5 * (least[i] + most[i])));
            Vector3::from(middle) + Vector3::new(y, x, 0.0)
        };
        let curve = NurbsCurve::new(degree, points.iter().map(place).collect(), weights, knots)?;
        let orientation = UnitQuaternion::from_euler_angles(PI, pitch, 0.0);
        Ok(PosePath::new(ArcLengthCurve::new(curve, 1e-15)?, OrientationPath::Constant(orientation)))
    }
}

/// An arm that knows the range of its joints.
trait HasRange {
    fn joint_range(&self) -> &JointRange<6>;
}

impl HasRange for arcfeed_kinematics::ParallelAxisArm {
    fn joint_range(&self) -> &JointRange<6> {
        self.range()
    }
}

impl HasRange for arcfeed_kinematics::SphericalWristArm {
    fn joint_range(&self) -> &JointRange<6> {
        self.range()
    }
}

fn planned(trajectory: &Trajectory<'_>, bounded: bool) -> Planned {
    let info = trajectory.info();
    Planned {
        duration: trajectory.duration(),
        fallback: info.fallback.map(|why| why.to_string()),
        rounds: info.rounds,
        intervals: info.intervals,
        planning: trajectory.timings().planning().as_secs_f64(),
        bound: bounded.then(|| trajectory.lower_bound().map_err(|why| why.to_string())),
    }
}

/// Degree, control points, weights and knots.
type Shape = (usize, Vec<[f64; 2]>, Vec<f64>, Vec<f64>);

/// A curve by name.
fn shape(name: &str) -> Shape {
    match name {
        "star" => uniform(2, ring(10, [1.0, 0.4]), &[]),
        "wm" => uniform(2, WM.to_vec(), &[]),
        "goggles" => uniform(2, GOGGLES.to_vec(), &[1.0, 1.0, 2.0, 1.0, 2.0, 1.0, 0.8, 1.0, 2.0, 1.0, 2.0, 1.0, 1.0]),
        "omega" => uniform(2, OMEGA.to_vec(), &[]),
        "diamond" => uniform(2, ring(8, [1.0, 0.6]), &[4.0, 1.0, 4.0, 1.0, 4.0, 1.0, 4.0, 1.0, 4.0]),
        "trident" => uniform(2, TRIDENT.to_vec(), &[1.0, 2.0, 1.0, 1.5, 3.0, 1.5, 1.0, 2.0, 1.0]),
        "serpentine" => serpentine(),
        "slot" => slot(),
        "wave" => {
            let height = |i: i32| if i % 2 == 0 { 0.0 } else { 1.0 + 0.25 * f64::from(i) };
            uniform(2, (0..16).map(|i| [f64::from(i), height(i)]).collect(), &[])
        }
        _ => uniform(3, INFINITY.to_vec(), &[]),
    }
}

const WM: [[f64; 2]; 10] = [
    [0.0, 6.0],
    [1.0, 0.0],
    [3.0, 4.0],
    [5.0, 0.0],
    [6.0, 6.0],
    [7.0, 0.0],
    [8.0, 6.0],
    [10.0, 2.0],
    [12.0, 6.0],
    [13.0, 0.0],
];
const GOGGLES: [[f64; 2]; 13] = [
    [0.0, 0.0],
    [-2.0, 3.0],
    [-5.0, 2.5],
    [-6.0, 0.0],
    [-5.0, -2.5],
    [-2.0, -2.0],
    [0.0, 0.6],
    [2.0, -2.0],
    [5.0, -2.5],
    [6.0, 0.0],
    [5.0, 2.5],
    [2.0, 3.0],
    [0.0, 0.0],
];
const OMEGA: [[f64; 2]; 11] = [
    [-4.0, 0.0],
    [-2.0, 0.0],
    [-0.8, 0.4],
    [-3.2, 2.5],
    [-2.6, 5.8],
    [0.0, 7.0],
    [2.6, 5.8],
    [3.2, 2.5],
    [0.8, 0.4],
    [2.0, 0.0],
    [4.0, 0.0],
];
const TRIDENT: [[f64; 2]; 9] =
    [[-3.0, 5.0], [-3.2, 1.0], [-1.0, 0.0], [-0.6, 3.0], [0.0, 6.5], [0.6, 3.0], [1.0, 0.0], [3.2, 1.0], [3.0, 5.0]];
const INFINITY: [[f64; 2]; 12] = [
    [0.0, 0.0],
    [1.5, 1.5],
    [3.5, 1.8],
    [4.5, 0.0],
    [3.5, -1.8],
    [1.5, -1.5],
    [-1.5, 1.5],
    [-3.5, 1.8],
    [-4.5, 0.0],
    [-3.5, -1.8],
    [-1.5, -1.5],
    [0.0, 0.0],
];

/// A closed polygon of `n` corners whose distances from the middle are the two in turn.
fn ring(n: usize, radii: [f64; 2]) -> Vec<[f64; 2]> {
    let corner = |i: usize| {
        let (radius, angle) = (radii[i % 2], TAU * i as f64 / n as f64 + PI / 2.0);
        [radius * angle.cos(), radius * angle.sin()]
    };
    (0..=n).map(|i| corner(i % n)).collect()
}

/// With knots at equal distances; no weights stand for equal ones.
fn uniform(degree: usize, points: Vec<[f64; 2]>, weights: &[f64]) -> Shape {
    let inner = points.len() - degree - 1;
    let mut knots = vec![0.0; degree + 1];
    knots.extend((1..=inner).map(|i| i as f64));
    knots.extend(vec![(inner + 1) as f64; degree + 1]);
    let weights = if weights.is_empty() { vec![1.0; points.len()] } else { weights.to_vec() };
    (degree, points, weights, knots)
}

/// Half circles, up and down in turn.
fn serpentine() -> Shape {
    let (mut points, mut weights) = (vec![[0.0, 0.0]], vec![1.0]);
    for half in 0..5_i32 {
        let (x, y) = (2.0 * f64::from(half), if half % 2 == 0 { 1.0 } else { -1.0 });
        points.extend([[x, y], [x + 1.0, y], [x + 2.0, y], [x + 2.0, 0.0]]);
        weights.extend([FRAC_1_SQRT_2, 1.0, FRAC_1_SQRT_2, 1.0]);
    }
    (2, points.clone(), weights, double_knots(points.len()))
}

/// Two half circles and two straight lines.
fn slot() -> Shape {
    let points = [
        [0.0, -1.0],
        [1.5, -1.0],
        [3.0, -1.0],
        [4.0, -1.0],
        [4.0, 0.0],
        [4.0, 1.0],
        [3.0, 1.0],
        [0.0, 1.0],
        [-3.0, 1.0],
        [-4.0, 1.0],
        [-4.0, 0.0],
        [-4.0, -1.0],
        [-3.0, -1.0],
        [-1.5, -1.0],
        [0.0, -1.0],
    ];
    let weight = |i: usize| if [3, 5, 9, 11].contains(&i) { FRAC_1_SQRT_2 } else { 1.0 };
    (2, points.to_vec(), (0..15).map(weight).collect(), double_knots(15))
}

/// Knots of quadratic arcs that meet at every second control point.
fn double_knots(points: usize) -> Vec<f64> {
    let arcs = (points - 1) / 2;
    let mut knots = vec![0.0; 3];
    (1..arcs).for_each(|i| knots.extend([i as f64; 2]));
    knots.extend([arcs as f64; 3]);
    knots
}
