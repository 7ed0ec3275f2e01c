//! Rigid-body dynamics of a serial arm: torque of a motion, mass matrix, and what torque limits need along a path.
//!
//! ```text
//! torque = M(q) qdd + C(q, qd) qd + g(q) + rotor qdd + friction(qd)
//! ```
//!
//! M includes the rotors where this module says "mass matrix". Torques are those at the joints (N m; N for prismatic
//! joints), gravity is a vector of the working frame.

mod bounds;
mod friction;
mod inertial;
mod recursion;

pub use bounds::TorqueBounds;
pub use friction::Friction;
pub use inertial::Inertial;

use crate::{chain::Chain, error::KinematicsError, joint::Joints, normalised::Normalised};
use inertial::Moments;
use nalgebra::{Cholesky, Const, Matrix3, SMatrix, Vector3};
use recursion::{composite_bodies, newton_euler};

/// Gravity unless set otherwise, m/s^2: straight down, along -z of the working frame.
pub const GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);

/// From a motion to the torques it needs, and back.
pub trait Dynamics<const N: usize> {
    /// The joint torques of a motion: inverse dynamics, everything included.
    fn torque(&self, q: &Joints<N>, qd: &Joints<N>, qdd: &Joints<N>) -> Joints<N>;

    /// The mass matrix, rotors included: symmetric, positive definite for bodies that can exist.
    fn mass_matrix(&self, q: &Joints<N>) -> SMatrix<f64, N, N>;

    /// C(q, qd) qd + g(q): what is left of the torque without acceleration and friction.
    fn bias(&self, q: &Joints<N>, qd: &Joints<N>) -> Joints<N>;

    /// The torque that holds the arm against gravity.
    fn gravity_torque(&self, q: &Joints<N>) -> Joints<N> {
        self.bias(q, &Joints::zeros())
    }

    /// The torque that overcomes friction.
    fn friction_torque(&self, qd: &Joints<N>) -> Joints<N>;

    /// The coefficients of the torque along a path with first and second derivatives `d1` and `d2` at `q`.
    fn along_path(&self, q: &Joints<N>, d1: &Joints<N>, d2: &Joints<N>) -> PathTorque<N>;

    /// What the torques, and their second derivatives by time, do not exceed in any motion in which joint values, velocities,
    /// accelerations, jerks and derivatives of jerks are at most `sizes`, as magnitudes.
    ///
    /// `None` where nothing is known, as by default. A certificate of torques between samples needs the bounds. The torque less
    /// [`Dynamics::friction_torque`] at a speed near zero of the same sign has to be differentiable twice.
    fn torque_bounds(&self, sizes: &[Joints<N>; 5]) -> Option<TorqueBounds<N>> {
        let _ = sizes;
        None
    }

    /// The joint accelerations that `torque` causes: forward dynamics.
    ///
    /// # Errors
    /// [`KinematicsError::MassMatrix`] if the mass matrix is not positive definite (a joint moves no mass, identified
    /// parameters contradict each other, or an input is not finite).
    fn acceleration(&self, q: &Joints<N>, qd: &Joints<N>, torque: &Joints<N>) -> Result<Joints<N>, KinematicsError> {
        let rest = torque - self.bias(q, qd) - self.friction_torque(qd);
        let factors = Cholesky::<f64, Const<N>>::new(self.mass_matrix(q)).ok_or(KinematicsError::MassMatrix)?;
        Ok(factors.solve(&rest))
    }
}

/// The torque along a path as a function of speed and acceleration of its parameter s:
/// `torque = inertia u + velocity x + viscous sqrt(x) + constant` with x = (ds/dt)^2, u = d2s/dt2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathTorque<const N: usize> {
    /// M q'.
    pub inertia: Joints<N>,
    /// M q'' + C(q, q') q'.
    pub velocity: Joints<N>,
    /// Viscous friction at q'.
    pub viscous: Joints<N>,
    /// Gravity, and Coulomb friction for motion towards greater s (none in a joint that stands still).
    pub constant: Joints<N>,
}

impl<const N: usize> PathTorque<N> {
    /// The torque at parameter speed `speed` (not negative) and acceleration `acceleration`.
    pub fn at(&self, speed: f64, acceleration: f64) -> Joints<N> {
        self.inertia * acceleration + self.velocity * (speed * speed) + self.viscous * speed + self.constant
    }
}

/// The rigid-body dynamics of an arm.
///
/// ```
/// use arcfeed_kinematics::{ArmDynamics, Dynamics, Inertial, Joints, models, nalgebra::{Matrix3, Vector3}};
/// // Two slender rods that swing in a vertical plane: gravity along -y of the plane.
/// let rod = |mass: f64, length: f64| {
///     let i = mass * length * length / 12.0;
///     Inertial::new(mass, Vector3::new(length / 2.0, 0.0, 0.0), Matrix3::from_diagonal(&Vector3::new(0.0, i, i)))
/// };
/// let arm = ArmDynamics::new(&models::planar_2r(), [rod(2.0, 0.4)?, rod(1.0, 0.3)?])?
///     .with_gravity(Vector3::new(0.0, -9.81, 0.0))?;
/// let held = arm.gravity_torque(&Joints::<2>::zeros());
/// assert!((held - Joints::<2>::new(9.81 * (2.0 * 0.2 + 0.55), 9.81 * 0.15)).amax() < 1e-12);
/// # Ok::<(), arcfeed_kinematics::KinematicsError>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct ArmDynamics<const N: usize> {
    chain: Normalised<N>,
    frames: [Matrix3<f64>; N],
    bodies: [Moments; N],
    rotor: Joints<N>,
    friction: Friction<N>,
    gravity: Vector3<f64>,
    /// The links without payload, and the flange in the frame of the last one.
    inertials: [Inertial; N],
    payload: Option<Inertial>,
    flange: nalgebra::Isometry3<f64>,
    lift: Vector3<f64>,
}

impl<const N: usize> ArmDynamics<N> {
    /// The dynamics of `chain` whose links are `inertials`, each in the frame of the joint that moves it (after the
    /// joint's motion). Gravity is [`GRAVITY`]; rotors, friction and payload are none.
    ///
    /// # Errors
    /// [`KinematicsError::NotFinite`] if masses and lengths are so large that their products overflow.
    pub fn new(chain: &Chain<N>, inertials: [Inertial; N]) -> Result<Self, KinematicsError> {
        let (normalised, frames) = chain.normalised();
        let dynamics = Self {
            chain: normalised,
            frames,
            bodies: [Moments::new(&Inertial::none(), &Matrix3::identity()); N],
            rotor: Joints::zeros(),
            friction: Friction::none(),
            gravity: GRAVITY,
            inertials,
            payload: None,
            flange: *chain.flange(),
            lift: Vector3::zeros(),
        };
        dynamics.assembled()
    }

    fn assembled(mut self) -> Result<Self, KinematicsError> {
        let mut inertials = self.inertials;
        if let (Some(payload), Some(last)) = (&self.payload, inertials.last_mut()) {
            *last = last.joined(&payload.seen_from(&self.flange));
        }
        self.bodies = std::array::from_fn(|i| Moments::new(&inertials[i], &self.frames[i]));
        self.lift = -(self.chain.start.rotation.transpose() * self.gravity);
        let moments = self.bodies.iter().map(|b| b.mass + b.first.sum() + b.second.xx + b.second.yy + b.second.zz);
        if !moments.sum::<f64>().is_finite() {
            return Err(KinematicsError::NotFinite { what: "the sum of the arm's moments of inertia" });
        }
        Ok(self)
    }

    /// The same arm on another base, flange or tool, or with other joints: `chain` takes the place of the one it was
    /// made with.
    ///
    /// # Errors
    /// As [`ArmDynamics::new`].
    pub fn with_chain(&self, chain: &Chain<N>) -> Result<Self, KinematicsError> {
        let (normalised, frames) = chain.normalised();
        Self { chain: normalised, frames, flange: *chain.flange(), ..*self }.assembled()
    }

    /// The dynamics of `left`, which is `chain` with `joint` held at `value`.
    pub(crate) fn locked<const M: usize>(
        &self,
        chain: &Chain<N>,
        left: &Chain<M>,
        joint: usize,
        value: f64,
    ) -> Result<ArmDynamics<M>, KinematicsError> {
        let keep = |values: &Joints<N>| Joints::<M>::from_fn(|i, _| values[i + usize::from(i >= joint)]);
        let held = &chain.joints()[joint];
        let mut inertials = self.inertials;
        if joint > 0 {
            // The held link becomes part of the one before it; the first one, of the base.
            let body = self.inertials[joint].seen_from(&(held.origin() * held.motion(value)));
            inertials[joint - 1] = inertials[joint - 1].joined(&body);
        }
        let inertials = std::array::from_fn(|i| inertials[i + usize::from(i >= joint)]);
        let friction = Friction::new(
            keep(self.friction.viscous()),
            keep(self.friction.forward()),
            keep(self.friction.backward()),
        )?;
        let dynamics = ArmDynamics::new(left, inertials)?
            .with_gravity(self.gravity)?
            .with_rotor_inertia(keep(&self.rotor))?
            .with_friction(friction);
        match self.payload {
            Some(payload) => dynamics.with_payload(payload),
            None => Ok(dynamics),
        }
    }

    /// The same arm with gravity `gravity`, m/s^2, along the axes of the working frame.
    ///
    /// # Errors
    /// [`KinematicsError::NotFinite`].
    pub fn with_gravity(&self, gravity: Vector3<f64>) -> Result<Self, KinematicsError> {
        if !gravity.iter().all(|v| v.is_finite()) {
            return Err(KinematicsError::NotFinite { what: "gravity" });
        }
        Self { gravity, ..*self }.assembled()
    }

    /// The same arm with the inertia of its rotors as felt at the joints: rotor inertia times gear ratio squared, kg m^2
    /// (kg for prismatic joints).
    ///
    /// It adds to the diagonal of the mass matrix; the gyroscopic torque of a spinning rotor on the links is left out, as
    /// is usual for gear ratios well above 1.
    ///
    /// # Errors
    /// [`KinematicsError::InvalidLimit`] names the joint: values must be finite and not negative.
    pub fn with_rotor_inertia(&self, reflected: Joints<N>) -> Result<Self, KinematicsError> {
        for joint in 0..N {
            let value = reflected[joint];
            if !(value.is_finite() && value >= 0.0) {
                let (what, rule) = ("rotor inertia", "finite and not negative");
                return Err(KinematicsError::InvalidLimit { joint, what, value, rule });
            }
        }
        Ok(Self { rotor: reflected, ..*self })
    }

    /// The same arm with friction in its joints.
    pub fn with_friction(&self, friction: Friction<N>) -> Self {
        Self { friction, ..*self }
    }

    /// The same arm carrying `payload`, a body in the frame of the **flange** (as controllers ask for it), in place of
    /// any payload before.
    ///
    /// # Errors
    /// As [`ArmDynamics::new`].
    pub fn with_payload(&self, payload: Inertial) -> Result<Self, KinematicsError> {
        Self { payload: Some(payload), ..*self }.assembled()
    }

    /// The links, without payload.
    pub fn inertials(&self) -> &[Inertial; N] {
        &self.inertials
    }

    /// The load of the arm.
    pub fn payload(&self) -> Option<&Inertial> {
        self.payload.as_ref()
    }

    /// Gravity, m/s^2.
    pub fn gravity(&self) -> &Vector3<f64> {
        &self.gravity
    }

    /// Inertia of the rotors at the joints, kg m^2 (kg).
    pub fn rotor_inertia(&self) -> &Joints<N> {
        &self.rotor
    }

    /// Friction in the joints.
    pub fn friction(&self) -> &Friction<N> {
        &self.friction
    }

    fn rigid(
        &self,
        turns: &([f64; N], [f64; N]),
        motion: (&Joints<N>, &Joints<N>, &Joints<N>),
        lift: &Vector3<f64>,
    ) -> Joints<N> {
        newton_euler(&self.chain, &self.bodies, turns, motion, lift)
    }
}

impl<const N: usize> Dynamics<N> for ArmDynamics<N> {
    fn torque(&self, q: &Joints<N>, qd: &Joints<N>, qdd: &Joints<N>) -> Joints<N> {
        self.rigid(&self.chain.turns(q), (q, qd, qdd), &self.lift)
            + self.rotor.component_mul(qdd)
            + self.friction.torque(qd)
    }

    fn mass_matrix(&self, q: &Joints<N>) -> SMatrix<f64, N, N> {
        let mut matrix = composite_bodies(&self.chain, &self.bodies, &self.chain.turns(q), q);
        for i in 0..N {
            matrix[(i, i)] += self.rotor[i];
        }
        matrix
    }

    fn bias(&self, q: &Joints<N>, qd: &Joints<N>) -> Joints<N> {
        self.rigid(&self.chain.turns(q), (q, qd, &Joints::zeros()), &self.lift)
    }

    fn friction_torque(&self, qd: &Joints<N>) -> Joints<N> {
        self.friction.torque(qd)
    }

    /// Sums of the sizes of all terms, by the lengths between the axes; see the module `bounds`.
    fn torque_bounds(&self, sizes: &[Joints<N>; 5]) -> Option<TorqueBounds<N>> {
        let (chain, bodies, rotor, friction) = (&self.chain, &self.bodies, &self.rotor, &self.friction);
        Some(bounds::Arm { chain, bodies, rotor, friction, gravity: self.lift.norm() }.torque_bounds(sizes))
    }

    fn along_path(&self, q: &Joints<N>, d1: &Joints<N>, d2: &Joints<N>) -> PathTorque<N> {
        let turns = self.chain.turns(q);
        let (rest, weightless) = (Joints::zeros(), Vector3::zeros());
        PathTorque {
            inertia: self.rigid(&turns, (q, &rest, d1), &weightless) + self.rotor.component_mul(d1),
            velocity: self.rigid(&turns, (q, d1, d2), &weightless) + self.rotor.component_mul(d2),
            viscous: self.friction.viscous_torque(d1),
            constant: self.rigid(&turns, (q, &rest, &rest), &self.lift) + self.friction.coulomb_torque(d1),
        }
    }
}
