//! Maps from the coordinates of a drawing to metres.

use nalgebra::{Matrix3, Vector3};

/// An affine map of space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Map {
    pub linear: Matrix3<f64>,
    pub shift: Vector3<f64>,
}

impl Map {
    /// The same scale along all axes.
    pub fn scale(factor: f64) -> Self {
        Self { linear: Matrix3::from_diagonal_element(factor), shift: Vector3::zeros() }
    }

    pub fn translation(shift: Vector3<f64>) -> Self {
        Self { linear: Matrix3::identity(), shift }
    }

    /// The map of a plane `x' = a x + c y + e`, `y' = b x + d y + f`, as SVG writes it.
    pub fn plane([a, b, c, d, e, f]: [f64; 6]) -> Self {
        let linear = Matrix3::new(a, c, 0.0, b, d, 0.0, 0.0, 0.0, 1.0);
        Self { linear, shift: Vector3::new(e, f, 0.0) }
    }

    /// First `inner`, then this one.
    pub fn after(&self, inner: &Self) -> Self {
        Self { linear: self.linear * inner.linear, shift: self.point(&inner.shift) }
    }

    pub fn point(&self, p: &Vector3<f64>) -> Vector3<f64> {
        self.linear * p + self.shift
    }

    pub fn vector(&self, v: &Vector3<f64>) -> Vector3<f64> {
        self.linear * v
    }
}
