//! Position and orientation of the tool by arc length.

use nalgebra::{Isometry3, Translation3, Vector3, Vector6};

use crate::arc_length::{ArcLengthCurve, Corner};
use crate::orientation::OrientationPath;

/// A tool pose with three derivatives by arc length.
///
/// The derivatives have the rows of a twist: linear x y z, then angular x y z, in base axes, at the tool point. `d1` times
/// the feed rate is the tool's velocity; `d2` and `d3` are the plain derivatives of `d1` by arc length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseJet {
    /// Tool in base.
    pub pose: Isometry3<f64>,
    /// First derivative: unit tangent (linear) and angular rate in rad/m.
    pub d1: Vector6<f64>,
    /// Second derivative: curvature vector in 1/m and derivative of the angular rate in rad/m^2.
    pub d2: Vector6<f64>,
    /// Third derivative, per m^2 and rad/m^3.
    pub d3: Vector6<f64>,
}

/// A tool path: a space curve by arc length with an orientation at each place.
#[derive(Debug, Clone)]
pub struct PosePath {
    curve: ArcLengthCurve<3>,
    orientation: OrientationPath,
}

impl PosePath {
    /// Joins a curve and an orientation profile by the curve's arc length.
    pub fn new(curve: ArcLengthCurve<3>, orientation: OrientationPath) -> Self {
        Self { curve, orientation }
    }

    /// Length of the path, m.
    pub fn length(&self) -> f64 {
        self.curve.length()
    }

    /// The curve the tool point follows.
    pub fn curve(&self) -> &ArcLengthCurve<3> {
        &self.curve
    }

    /// The orientation profile.
    pub fn orientation(&self) -> &OrientationPath {
        &self.orientation
    }

    /// Pose and derivatives at the arc length `s`; where derivatives jump, those from the right.
    #[inline]
    pub fn jet(&self, s: f64) -> PoseJet {
        self.assemble(self.curve.jet(s), s)
    }

    /// Like [`PosePath::jet`], with the derivatives from the left where they jump.
    pub fn jet_left(&self, s: f64) -> PoseJet {
        // The orientation spline's third derivative is taken a hair before the place; value and lower ones do not jump.
        let before = s - 1e-12 * self.length();
        let mut jet = self.assemble(self.curve.jet_left(s), s);
        let angular = self.orientation.jet(before).dd_rate;
        jet.d3.fixed_rows_mut::<3>(3).copy_from(&angular);
        jet
    }

    /// Pose at the arc length `s`.
    pub fn pose(&self, s: f64) -> Isometry3<f64> {
        self.jet(s).pose
    }

    /// Arc lengths, increasing from 0 to the length, where higher derivatives of position or orientation may jump.
    pub fn knots(&self) -> Vec<f64> {
        let length = self.length();
        let mut all = self.curve.knots();
        all.extend(self.orientation.knots().iter().filter(|&&s| s > 0.0 && s < length));
        all.sort_by(f64::total_cmp);
        all.dedup_by(|b, a| *b - *a <= 1e-12 * length);
        // `dedup_by` keeps the first of a run; the end has to stay exactly the length.
        if let Some(last) = all.last_mut() {
            *last = length;
        }
        all
    }

    /// Places where the direction turns by more than `angle` (rad) at once: the tool has to stop there.
    pub fn corners(&self, angle: f64) -> Vec<Corner> {
        self.curve.corners(angle)
    }

    #[inline]
    fn assemble(&self, c: crate::curve::Jet<3>, s: f64) -> PoseJet {
        let o = self.orientation.jet(s);
        let join = |a: Vector3<f64>, b: Vector3<f64>| Vector6::new(a.x, a.y, a.z, b.x, b.y, b.z);
        PoseJet {
            pose: Isometry3::from_parts(Translation3::from(c.point), o.rotation),
            d1: join(c.d1, o.rate),
            d2: join(c.d2, o.d_rate),
            d3: join(c.d3, o.dd_rate),
        }
    }
}
