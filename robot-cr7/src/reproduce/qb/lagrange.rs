//! Joint torques from positions alone, by Lagrange's equation with finite differences: a second
//! path beside the library's recursive inverse dynamics.

use arcfeed_kinematics::{Arm, Joints};
use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};

/// Step of differences along a velocity, s, and of a joint, rad.
const STEP: f64 = 1e-5;
const TURN: f64 = 1e-4;

/// One link: the joint before it, and its body.
#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    origin: Isometry3<f64>,
    axis: Vector3<f64>,
    mass: f64,
    centre: Vector3<f64>,
    tensor: Matrix3<f64>,
    rotor: f64,
    viscous: f64,
    coulomb: f64,
}

/// The links of an arm.
#[derive(Debug, Clone, PartialEq)]
pub struct Links {
    base: Isometry3<f64>,
    tip: Isometry3<f64>,
    gravity: Vector3<f64>,
    links: Vec<Link>,
}

impl Links {
    /// Reads the links of `arm`; `None` where its dynamics are unknown.
    pub fn new(arm: &Arm<6>) -> Option<Self> {
        let (chain, dynamics) = (arm.chain(), arm.dynamics()?);
        let link = |k: usize| Link {
            origin: *chain.joints()[k].origin(),
            axis: **chain.joints()[k].axis(),
            mass: dynamics.inertials()[k].mass(),
            centre: *dynamics.inertials()[k].centre(),
            tensor: *dynamics.inertials()[k].tensor(),
            rotor: dynamics.rotor_inertia()[k],
            viscous: dynamics.friction().viscous()[k],
            coulomb: dynamics.friction().forward()[k],
        };
        Some(Self {
            base: *chain.base(),
            tip: chain.flange() * chain.tool(),
            gravity: *dynamics.gravity(),
            links: (0..6).map(link).collect(),
        })
    }

    fn frames(&self, q: &Joints<6>) -> Vec<Isometry3<f64>> {
        let mut pose = self.base;
        self.links
            .iter()
            .zip(q.iter())
            .map(|(link, q)| {
                pose = pose * link.origin * UnitQuaternion::new(link.axis * *q);
                pose
            })
            .collect()
    }

    /// The tool at `q`.
    pub fn tool(&self, q: &Joints<6>) -> Isometry3<f64> {
        self.frames(q).last().map_or(self.base, |last| last * self.tip)
    }

    /// Kinetic energy at `q` with velocities `qd`, from poses shortly before and after.
    fn kinetic(&self, q: &Joints<6>, qd: &Joints<6>) -> f64 {
        let (before, after) = (self.frames(&(q - qd * STEP)), self.frames(&(q + qd * STEP)));
        let now = self.frames(q);
        let mut energy = 0.0;
        for (k, link) in self.links.iter().enumerate() {
            let centre = |pose: &Isometry3<f64>| pose.transform_point(&link.centre.into()).coords;
            let v = (centre(&after[k]) - centre(&before[k])) / (2.0 * STEP);
            let turned = after[k].rotation * before[k].rotation.inverse();
            // The vector part of a small rotation is half its angle.
            let w = now[k].rotation.inverse() * (turned.vector() * (2.0 * turned.w.signum() / (2.0 * STEP)));
            energy += 0.5 * link.mass * v.norm_squared() + 0.5 * w.dot(&(link.tensor * w));
            energy += 0.5 * link.rotor * qd[k] * qd[k];
        }
        energy
    }

    fn potential(&self, q: &Joints<6>) -> f64 {
        let height = |(link, pose): (&Link, &Isometry3<f64>)| {
            -link.mass * self.gravity.dot(&pose.transform_point(&link.centre.into()).coords)
        };
        self.links.iter().zip(&self.frames(q)).map(height).sum()
    }

    /// Generalised momentum: energy is quadratic in the velocities, so a central difference of 1
    /// rad/s is exact.
    fn momentum(&self, q: &Joints<6>, qd: &Joints<6>) -> Joints<6> {
        Joints::from_fn(|k, _| {
            let mut unit = Joints::zeros();
            unit[k] = 1.0;
            0.5 * (self.kinetic(q, &(qd + unit)) - self.kinetic(q, &(qd - unit)))
        })
    }

    /// Torques at the middle of five positions that are `h` (s) apart.
    pub fn torque(&self, q: &[Joints<6>; 5], h: f64) -> Joints<6> {
        let velocity = |i: usize| (q[i + 1] - q[i - 1]) / (2.0 * h);
        let change = (self.momentum(&q[3], &velocity(3)) - self.momentum(&q[1], &velocity(1))) / (2.0 * h);
        let (at, qd) = (&q[2], velocity(2));
        let slope = Joints::from_fn(|k, _| {
            let mut turn = Joints::zeros();
            turn[k] = TURN;
            let of = |q: &Joints<6>| self.kinetic(q, &qd) - self.potential(q);
            (of(&(at + turn)) - of(&(at - turn))) / (2.0 * TURN)
        });
        let friction = Joints::from_fn(|k, _| {
            let link = &self.links[k];
            let sign = if qd[k].abs() < 1e-9 { 0.0 } else { qd[k].signum() };
            link.viscous * qd[k] + link.coulomb * sign
        });
        change - slope + friction
    }
}
