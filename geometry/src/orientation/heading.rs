//! Orientation that follows the tangent of a curve.

use nalgebra::{Unit, UnitQuaternion, Vector3};

use super::rotation::OrientationJet;
use crate::arc_length::ArcLengthCurve;
use crate::error::GeometryError;
use crate::spline::CubicSpline;

/// Most knots a heading is given; where they do not suffice for its tolerance, [`Heading::deviation`] tells.
const MAX_HEADING_KNOTS: usize = 100_000;
/// Orientation `rot(axis, psi(s)) * reference` with a spline `psi` of angles.
#[derive(Debug, Clone)]
pub struct Heading {
    axis: Unit<Vector3<f64>>,
    reference: UnitQuaternion<f64>,
    psi: CubicSpline<1>,
    deviation: f64,
}

impl Heading {
    /// Follows the tangent of `curve`, which has no corners; see [`OrientationPath::following_tangent`].
    ///
    /// [`OrientationPath::following_tangent`]: super::OrientationPath::following_tangent
    pub(super) fn following(
        curve: &ArcLengthCurve<3>,
        axis: Unit<Vector3<f64>>,
        reference: UnitQuaternion<f64>,
        tolerance: f64,
    ) -> Result<Self, GeometryError> {
        // Two directions across the axis, from the first tangent.
        let across = |t: Vector3<f64>| t - axis.as_ref() * axis.dot(&t);
        let e1 = across(curve.jet(0.0).d1).try_normalize(1e-6).ok_or(GeometryError::NoHeading { s: 0.0 })?;
        let e2 = axis.cross(&e1);
        let heading = |s: f64| {
            let t = across(curve.jet(s).d1);
            if t.norm() < 1e-6 { Err(GeometryError::NoHeading { s }) } else { Ok(t.dot(&e2).atan2(t.dot(&e1))) }
        };
        // Knots: those of the curve, and enough between them that the heading turns little from one to the next.
        let mut s = curve.knots();
        let mut psi = Vec::with_capacity(s.len());
        for &x in &s {
            psi.push(heading(x)?);
        }
        let step = 0.2;
        let mut i = 0;
        while i + 1 < s.len() {
            let middle = 0.5 * (s[i] + s[i + 1]);
            let h = heading(middle)?;
            let turn = |a: f64, b: f64| (b - a).sin().atan2((b - a).cos()).abs();
            if turn(psi[i], h) + turn(h, psi[i + 1]) > step && s.len() < MAX_HEADING_KNOTS {
                s.insert(i + 1, middle);
                psi.insert(i + 1, h);
            } else {
                i += 1;
            }
        }
        let (psi, deviation) = refined(heading, (s, psi), 0.8 * tolerance)?;
        Ok(Self { axis, reference, psi, deviation })
    }

    /// The orientation at the arc length `s`.
    #[inline]
    pub(super) fn jet(&self, s: f64) -> OrientationJet {
        self.jet_of(self.psi.at(s))
    }

    /// [`Heading::jet`], with the third derivative from the left where it jumps.
    pub(super) fn jet_left(&self, s: f64) -> OrientationJet {
        self.jet_of(self.psi.at_left(s))
    }

    /// Arc lengths of the knots.
    pub(super) fn knots(&self) -> &[f64] {
        self.psi.knots()
    }

    #[inline]
    fn jet_of(&self, (v, d1, d2, d3): ([f64; 1], [f64; 1], [f64; 1], [f64; 1])) -> OrientationJet {
        let axis = self.axis.into_inner();
        OrientationJet {
            rotation: UnitQuaternion::from_axis_angle(&self.axis, v[0]) * self.reference,
            rate: axis * d1[0],
            d_rate: axis * d2[0],
            dd_rate: axis * d3[0],
        }
    }

    /// Largest measured angle between the tangent and the heading, rad.
    pub fn deviation(&self) -> f64 {
        self.deviation
    }
}

/// Refine until the spline is close to the heading between its knots too. Five places in each interval find the
/// largest deviation but for a tenth or so.
fn refined(
    heading: impl Fn(f64) -> Result<f64, GeometryError>,
    (mut s, mut psi): (Vec<f64>, Vec<f64>),
    limit: f64,
) -> Result<(CubicSpline<1>, f64), GeometryError> {
    loop {
        let mut unwrapped = Vec::with_capacity(psi.len());
        let mut last = 0.0;
        for &h in &psi {
            last += (h - last).sin().atan2((h - last).cos());
            unwrapped.push([last]);
        }
        let spline = CubicSpline::natural(s.clone(), unwrapped);
        let mut deviation = 0.0f64;
        let (mut finer_s, mut finer_psi) = (vec![s[0]], vec![psi[0]]);
        for i in 0..s.len() - 1 {
            let mut worst = 0.0f64;
            let mut at_middle = 0.0;
            for f in [0.12, 0.3, 0.5, 0.7, 0.88] {
                let x = s[i] + f * (s[i + 1] - s[i]);
                let h = heading(x)?;
                if f == 0.5 {
                    at_middle = h;
                }
                let d = spline.at(x).0[0] - h;
                worst = worst.max(d.sin().atan2(d.cos()).abs());
            }
            deviation = deviation.max(worst);
            if worst > limit {
                finer_s.push(0.5 * (s[i] + s[i + 1]));
                finer_psi.push(at_middle);
            }
            finer_s.push(s[i + 1]);
            finer_psi.push(psi[i + 1]);
        }
        if deviation <= limit || finer_s.len() > MAX_HEADING_KNOTS {
            return Ok((spline, deviation));
        }
        (s, psi) = (finer_s, finer_psi);
    }
}
