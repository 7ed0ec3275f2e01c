//! The one capability every curve has: position and derivatives in one call.

use nalgebra::SVector;

/// A point of a curve with its first three derivatives.
///
/// The derivatives are with respect to the parameter the curve was evaluated by: the curve's own `u`, or the arc length
/// `s` (then `d1` is the unit tangent and `d2` the curvature vector). Units: those of the curve, per power of the
/// parameter's unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jet<const D: usize> {
    /// Position.
    pub point: SVector<f64, D>,
    /// First derivative.
    pub d1: SVector<f64, D>,
    /// Second derivative.
    pub d2: SVector<f64, D>,
    /// Third derivative.
    pub d3: SVector<f64, D>,
}

impl<const D: usize> Jet<D> {
    /// Length of the first derivative, `|C'|`.
    pub fn speed(&self) -> f64 {
        self.d1.norm()
    }

    /// Unit tangent, or `None` where the derivative vanishes.
    pub fn tangent(&self) -> Option<SVector<f64, D>> {
        self.d1.try_normalize(0.0)
    }

    /// Curvature `|C' x C''| / |C'|^3`, never negative, in 1 / unit of length (Liu et al. 2023, eq. 10).
    ///
    /// Infinite where the first derivative vanishes and the second does not; 0 where both vanish.
    pub fn curvature(&self) -> f64 {
        let q = self.d1.norm_squared();
        if q == 0.0 {
            return if self.d2.norm_squared() == 0.0 { 0.0 } else { f64::INFINITY };
        }
        // Lagrange's identity |a x b|^2 = sum of the squared 2 x 2 minors: no cancellation, in any dimension.
        let mut cross2 = 0.0;
        for i in 0..D {
            for j in i + 1..D {
                let minor = self.d1[i] * self.d2[j] - self.d1[j] * self.d2[i];
                cross2 += minor * minor;
            }
        }
        cross2.sqrt() / (q * q.sqrt())
    }

    /// The same point with derivatives by arc length instead of the curve's own parameter.
    ///
    /// With `q = |C'|^2`, `b = C'.C''`, `c = C'.C''' + |C''|^2`:
    /// `u' = q^(-1/2)`, `u'' = -b q^(-2)`, `u''' = (4 b^2 - q c) q^(-7/2)`, then the chain rule.
    /// Meaningless where the first derivative vanishes.
    pub fn by_arc_length(&self) -> Jet<D> {
        let q = self.d1.norm_squared();
        let b = self.d1.dot(&self.d2);
        let c = self.d1.dot(&self.d3) + self.d2.norm_squared();
        let iq = 1.0 / q;
        // Not `iq.sqrt()`: the root need not wait for the division.
        let u1 = q.sqrt() * iq;
        let u2 = -b * iq * iq;
        let u3 = (4.0 * b * b - q * c) * (iq * iq * iq * u1);
        Jet {
            point: self.point,
            d1: self.d1 * u1,
            d2: self.d2 * (u1 * u1) + self.d1 * u2,
            d3: self.d3 * (u1 * u1 * u1) + self.d2 * (3.0 * u1 * u2) + self.d1 * u3,
        }
    }
}

impl Jet<2> {
    /// Signed curvature of a plane curve, positive where it turns left, in 1 / unit of length.
    pub fn signed_curvature(&self) -> f64 {
        let cross = self.d1.x * self.d2.y - self.d1.y * self.d2.x;
        let unsigned = self.curvature();
        if cross < 0.0 { -unsigned } else { unsigned }
    }
}

/// A parametric curve in `D` dimensions.
pub trait Curve<const D: usize> {
    /// First and last parameter.
    fn domain(&self) -> (f64, f64);

    /// Position and the first three derivatives by the curve's parameter.
    ///
    /// Parameters outside the domain are taken to its nearest end. Where derivatives jump (at knots) the value is the
    /// one from the right; at the end of the domain the one from the left.
    fn jet(&self, u: f64) -> Jet<D>;

    /// Like [`Curve::jet`], with the derivatives from the left where they jump.
    fn jet_left(&self, u: f64) -> Jet<D>;

    /// Position alone.
    fn point(&self, u: f64) -> SVector<f64, D> {
        self.jet(u).point
    }
}
