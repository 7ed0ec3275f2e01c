//! Mass, centre of mass and inertia tensor of one link.

use crate::error::KinematicsError;
use nalgebra::{Isometry3, Matrix3, SymmetricEigen, Vector3};

/// Largest excess of the largest principal moment over the sum of the other two, relative to it: rounding of published
/// digits, not physics.
const TRIANGLE_ROUNDING: f64 = 1e-6;
/// Asymmetry of a tensor that is taken as rounding, relative to its largest entry.
const ASYMMETRY: f64 = 1e-9;

/// Mass (kg), centre of mass (m) and inertia tensor about the centre of mass (kg m^2) of one rigid body, along the axes
/// of the frame it is given in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inertial {
    mass: f64,
    centre: Vector3<f64>,
    tensor: Matrix3<f64>,
}

impl Inertial {
    /// A body that can exist: mass not negative, tensor symmetric, and its principal moments not negative and each at
    /// most the sum of the other two (the triangle inequality).
    ///
    /// ```
    /// use arcfeed_kinematics::{Inertial, nalgebra::{Matrix3, Vector3}};
    /// let rod = Matrix3::from_diagonal(&Vector3::new(0.02, 0.02, 0.001));
    /// assert!(Inertial::new(2.0, Vector3::new(0.0, 0.0, 0.15), rod).is_ok());
    /// let impossible = Matrix3::from_diagonal(&Vector3::new(0.02, 0.005, 0.001));
    /// assert!(Inertial::new(2.0, Vector3::zeros(), impossible).unwrap_err().to_string().contains("0.006"));
    /// ```
    ///
    /// # Errors
    /// [`KinematicsError::InvalidInertial`] tells the rule, the value and its bound.
    pub fn new(mass: f64, centre: Vector3<f64>, tensor: Matrix3<f64>) -> Result<Self, KinematicsError> {
        let body = Self::identified(mass, centre, tensor)?;
        let moments = body.principal_moments();
        let [a, b, c] = moments;
        let fail = |what, value, rule, bound| Err(KinematicsError::InvalidInertial { what, value, rule, bound });
        if a < -TRIANGLE_ROUNDING * c.abs() {
            return fail("least principal moment", a, "not negative", 0.0);
        }
        if c > (a + b) * (1.0 + TRIANGLE_ROUNDING) {
            return fail("largest principal moment", c, "at most the sum of the other two", a + b);
        }
        Ok(body)
    }

    /// A body from parameters that were identified by measuring torques: only finite numbers, a mass that is not
    /// negative and a symmetric tensor are asked for.
    ///
    /// Such sets describe the arm's torques well while single links may break the triangle inequality (the Puma 560's
    /// do), because only combinations of the parameters can be measured.
    ///
    /// # Errors
    /// [`KinematicsError::InvalidInertial`].
    pub fn identified(mass: f64, centre: Vector3<f64>, tensor: Matrix3<f64>) -> Result<Self, KinematicsError> {
        let fail = |what, value, rule, bound| Err(KinematicsError::InvalidInertial { what, value, rule, bound });
        if !(mass.is_finite() && mass >= 0.0) {
            return fail("mass", mass, "finite and not negative", 0.0);
        }
        if let Some(value) = centre.iter().find(|v| !v.is_finite()) {
            return fail("centre of mass", *value, "finite", f64::INFINITY);
        }
        if let Some(value) = tensor.iter().find(|v| !v.is_finite()) {
            return fail("inertia tensor", *value, "finite", f64::INFINITY);
        }
        let skew = (tensor - tensor.transpose()).amax();
        let bound = ASYMMETRY * tensor.amax();
        if skew > bound {
            return fail("asymmetry of the inertia tensor", skew, "nothing but rounding, at most", bound);
        }
        Ok(Self { mass, centre, tensor: (tensor + tensor.transpose()) * 0.5 })
    }

    /// A body without mass.
    pub fn none() -> Self {
        Self { mass: 0.0, centre: Vector3::zeros(), tensor: Matrix3::zeros() }
    }

    /// Mass, kg.
    pub fn mass(&self) -> f64 {
        self.mass
    }

    /// Centre of mass, m.
    pub fn centre(&self) -> &Vector3<f64> {
        &self.centre
    }

    /// Inertia tensor about the centre of mass, kg m^2.
    pub fn tensor(&self) -> &Matrix3<f64> {
        &self.tensor
    }

    /// The principal moments about the centre of mass, least first, kg m^2.
    pub fn principal_moments(&self) -> [f64; 3] {
        let mut moments: [f64; 3] = SymmetricEigen::new(self.tensor).eigenvalues.into();
        moments.sort_unstable_by(f64::total_cmp);
        moments
    }

    /// True if [`Inertial::new`] would accept it.
    pub fn is_physical(&self) -> bool {
        Self::new(self.mass, self.centre, self.tensor).is_ok()
    }

    /// The same body described in another frame, in which its present frame stands at `pose`.
    pub fn seen_from(&self, pose: &Isometry3<f64>) -> Self {
        let turn = pose.rotation.to_rotation_matrix();
        let centre = turn * self.centre + pose.translation.vector;
        Self { mass: self.mass, centre, tensor: turn.matrix() * self.tensor * turn.matrix().transpose() }
    }

    /// This body and `other`, rigidly joined; both in one frame.
    pub fn joined(&self, other: &Self) -> Self {
        let mass = self.mass + other.mass;
        if mass == 0.0 {
            return Self { mass, centre: self.centre, tensor: self.tensor + other.tensor };
        }
        let centre = (self.centre * self.mass + other.centre * other.mass) / mass;
        let moved = |body: &Self| {
            let r = body.centre - centre;
            body.tensor + (Matrix3::identity() * r.norm_squared() - r * r.transpose()) * body.mass
        };
        Self { mass, centre, tensor: moved(self) + moved(other) }
    }
}

/// A body as the recursions need it: mass, first and second moments about the origin of its link's frame.
///
/// The second moment is the integral of r r^T dm, not the inertia tensor: with the matrix A of a motion (acceleration
/// A r at r), force and moment are m a + A h and the skew part of A J.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Moments {
    pub(crate) mass: f64,
    pub(crate) first: Vector3<f64>,
    pub(crate) second: Second,
}

/// A symmetric 3 x 3 matrix.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Second {
    pub(crate) xx: f64,
    pub(crate) xy: f64,
    pub(crate) xz: f64,
    pub(crate) yy: f64,
    pub(crate) yz: f64,
    pub(crate) zz: f64,
}

impl Moments {
    /// The moments of `body`, in a frame with the same origin whose axes are the columns of `frame`.
    pub(crate) fn new(body: &Inertial, frame: &Matrix3<f64>) -> Self {
        let to_frame = frame.transpose();
        let centre = to_frame * body.centre;
        let tensor = to_frame * body.tensor * frame;
        let about_centre = Matrix3::identity() * (0.5 * tensor.trace()) - tensor;
        let s = about_centre + centre * centre.transpose() * body.mass;
        let second =
            Second { xx: s[(0, 0)], xy: s[(0, 1)], xz: s[(0, 2)], yy: s[(1, 1)], yz: s[(1, 2)], zz: s[(2, 2)] };
        Self { mass: body.mass, first: centre * body.mass, second }
    }

    pub(crate) fn plus(&self, other: &Self) -> Self {
        let (a, b) = (&self.second, &other.second);
        let second = Second {
            xx: a.xx + b.xx,
            xy: a.xy + b.xy,
            xz: a.xz + b.xz,
            yy: a.yy + b.yy,
            yz: a.yz + b.yz,
            zz: a.zz + b.zz,
        };
        Self { mass: self.mass + other.mass, first: self.first + other.first, second }
    }
}
