//! The time over one corner between two lines on the CR7, with the blend of the library or with another of its family.

use arcfeed_geometry::{Blending, GeometryError, JoinedPathBuilder, JointOutcome, NurbsCurve};
use arcfeed_kinematics::models;
use nalgebra::Vector3;

pub use crate::on_cr7::Failure;
use crate::on_cr7::planned;

/// Length of a leg, m.
const LEG: f64 = 0.05;
/// The corner.
const CORNER: [f64; 3] = [0.42, -0.05, 0.2];
/// Steps of the search.
const STEPS: [f64; 2] = [0.12, 0.06];

/// A blend of two lines: the length taken as a part of the largest one, and the parts of it at which the second and the third control
/// point stand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shape {
    /// Part of the largest length.
    pub scale: f64,
    /// Of the second control point.
    pub b: f64,
    /// Of the third control point.
    pub c: f64,
}

/// A corner between two legs of 50 mm, with limits of the tool.
#[derive(Debug, Clone, Copy)]
pub struct Corner {
    /// rad.
    pub angle: f64,
    /// m.
    pub tolerance: f64,
    /// Of the first leg, rad.
    pub direction: f64,
    /// Feed in m/s, tangential acceleration in m/s^2 and jerk in m/s^3, normal acceleration in m/s^2.
    pub tool: [f64; 4],
}

/// The limits of a job that says nothing, at a high feed; and limits of the tool that leave the speed to the joints.
pub const TOOLS: [[f64; 4]; 2] = [[0.5, 1.0, 20.0, 1.0], [0.2, 5.0, 200.0, 5.0]];

/// The fastest shape found from one with its time, with its time and the number of plans.
///
/// # Errors
/// What `time_of` returns.
pub fn search(
    (time, shape): (f64, Shape),
    time_of: impl Fn(Shape) -> Result<f64, Failure>,
) -> Result<(f64, Shape, usize), Failure> {
    let (mut best, mut plans) = ((time, shape), 0);
    for step in STEPS {
        loop {
            let Shape { scale, b, c } = best.1;
            let mut next = best;
            for (scale, b, c) in [
                (scale - step, b, c),
                (scale, b - step, c - step),
                (scale, b + step, c + step),
                (scale, b + step, c),
                (scale, b - step, c),
                (scale, b, c + step),
                (scale, b, c - step),
            ] {
                if !(scale > 0.1 && scale <= 1.0 + 1e-9 && c > 0.0 && c < b && b < 1.0) {
                    continue;
                }
                let shape = Shape { scale, b, c };
                plans += 1;
                let time = time_of(shape)?;
                if time < next.0 * (1.0 - 1e-4) {
                    next = (time, shape);
                }
            }
            if next == best {
                break;
            }
            best = next;
        }
    }
    Ok((best.0, best.1, plans))
}

impl Corner {
    fn legs(&self) -> [Vector3<f64>; 2] {
        let along = |angle: f64| Vector3::new(angle.cos(), angle.sin(), 0.0);
        [along(self.direction), along(self.direction + self.angle)]
    }

    /// The largest length that a shape may take of both legs.
    fn largest(&self, b: f64, c: f64) -> f64 {
        // The middle of the blend is farthest, 1 / 32 (1 + 5 b + 10 c) of the sum of both legs from the corner.
        (self.tolerance / (0.5 * self.angle.sin() * (1.0 + 5.0 * b + 10.0 * c) / 16.0)).min(LEG)
    }

    /// The shape that the library makes, with its time in s.
    ///
    /// # Errors
    /// What prevents the blend or the plan.
    pub fn shipped(&self) -> Result<(f64, Shape), Failure> {
        let corner = Vector3::from(CORNER);
        let [along, on] = self.legs();
        let mut path = JoinedPathBuilder::new(corner - along * LEG, 1e-9)?;
        path.line_to(corner, 1)?.line_to(corner + on * LEG, 2)?;
        let blended = path.build()?.blended(&Blending::within(self.tolerance))?;
        let JointOutcome::Blended { taken, piece, .. } = blended.joints[0].1 else { return Err("not blended".into()) };
        let curve = blended.path.to_curve()?;
        let first = if blended.path.pieces().len() == 1 { 0 } else { 5 * piece };
        let part = |i: usize| (curve.control_points()[first + i] - corner).norm() / taken[0];
        let (b, c) = (part(1), part(2));
        let shape = Shape { scale: taken[0] / self.largest(b, c), b, c };
        Ok((self.time_along(curve)?, shape))
    }

    /// The time over the corner with a blend, or with a stop, s.
    ///
    /// # Errors
    /// What prevents the plan.
    pub fn time(&self, shape: Option<Shape>) -> Result<f64, Failure> {
        self.time_along(self.curve(shape)?)
    }

    fn curve(&self, shape: Option<Shape>) -> Result<NurbsCurve<3>, GeometryError> {
        let corner = Vector3::from(CORNER);
        let [along, on] = self.legs();
        let (start, end) = (corner - along * LEG, corner + on * LEG);
        let Some(Shape { scale, b, c }) = shape else {
            return NurbsCurve::bspline(1, vec![start, corner, end], vec![0.0, 0.0, LEG, 2.0 * LEG, 2.0 * LEG]);
        };
        let taken = scale * self.largest(b, c);
        let (from, to) = (|part: f64| corner - along * (part * taken), |part: f64| corner + on * (part * taken));
        let blend = [from(1.0), from(b), from(c), to(c), to(b), to(1.0)];
        let rest = LEG - taken;
        let mut points = blend.to_vec();
        let mut knots = vec![0.0; 6];
        if rest > 1e-6 {
            let before = (0..5).map(|i| start.lerp(&blend[0], f64::from(i) / 5.0));
            let after = (1..=5).map(|i| blend[5].lerp(&end, f64::from(i) / 5.0));
            points = before.chain(blend).chain(after).collect();
            knots.extend([[rest; 5], [rest + taken; 5]].concat());
        }
        knots.extend([2.0 * rest + taken; 6]);
        NurbsCurve::bspline(5, points, knots)
    }

    fn time_along(&self, curve: NurbsCurve<3>) -> Result<f64, Failure> {
        Ok(planned(&models::cr7(), curve, self.tool)?.duration())
    }
}
