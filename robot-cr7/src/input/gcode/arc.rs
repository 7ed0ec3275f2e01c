//! Arcs: centre and angle from I J K or from R.

use std::f64::consts::{PI, TAU};

use nalgebra::{Unit, Vector2, Vector3};

use super::fault::GcodeFault;
use super::program::MoveShape;
use crate::input::unit::LengthUnit;

/// Two points closer together than this, in metres, are one.
pub(super) const SAME_POINT: f64 = 1e-9;
/// An angle below this, in rad, is a full turn (LinuxCNC, `CIRCLE_FUZZ`).
const FULL_TURN_BELOW: f64 = 1e-6;
/// Part of the radius by which both radii of an arc may differ (LinuxCNC, "Center Format Arcs").
const RELATIVE: f64 = 1e-3;
/// Largest change of the angle, in rad, when the centre is moved so that it fits both ends.
const ANGLE_CHANGE: f64 = 0.2;

/// A plane of arcs, by the axes that run first, second and along its normal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Plane {
    /// G17.
    Xy,
    /// G18.
    Zx,
    /// G19.
    Yz,
}

impl Plane {
    /// Indices of the first and second axis and of the normal: a right-handed frame.
    pub(super) fn axes(self) -> [usize; 3] {
        match self {
            Self::Xy => [0, 1, 2],
            Self::Zx => [2, 0, 1],
            Self::Yz => [1, 2, 0],
        }
    }

    fn flat(self, point: Vector3<f64>) -> Vector2<f64> {
        let [a, b, _] = self.axes();
        Vector2::new(point[a], point[b])
    }
}

/// How an arc is given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum ArcForm {
    /// By its centre, in metres. The coordinate along the normal does not count.
    Centre(Vector3<f64>),
    /// By its radius in metres; below 0 for an arc of more than 180 degrees.
    Radius(f64),
}

/// An arc as a block gives it.
#[derive(Debug, Clone, Copy)]
pub(super) struct ArcWords {
    pub(super) plane: Plane,
    pub(super) start: Vector3<f64>,
    pub(super) to: Vector3<f64>,
    pub(super) form: ArcForm,
    /// True for G2.
    pub(super) clockwise: bool,
    /// Number of full turns beside the arc.
    pub(super) turns: f64,
    /// Unit of the program, for the tolerances.
    pub(super) unit: LengthUnit,
}

/// Tolerances of LinuxCNC in metres, for programs in inches or in millimetres.
struct Tolerances {
    /// The radii of both ends may differ by this, or by a thousandth of the radius, and never by 100 times this.
    ends: f64,
    /// Least radius, and what a radius may lack to reach the end.
    radius: f64,
}

impl Tolerances {
    /// From the G-code reference of LinuxCNC ("Center Format Arcs") and its `RADIUS_TOLERANCE_INCH`.
    fn of(unit: LengthUnit) -> Self {
        let ends = if unit == LengthUnit::Inch { LengthUnit::Inch.to_metres(5e-4) } else { 5e-6 };
        Self { ends, radius: LengthUnit::Inch.to_metres(5e-5) }
    }
}

impl ArcWords {
    /// The arc, with a centre that fits both ends.
    pub(super) fn shape(&self) -> Result<MoveShape, GcodeFault> {
        let (start, to) = (self.plane.flat(self.start), self.plane.flat(self.to));
        let (centre, sweep) = match self.form {
            ArcForm::Centre(centre) => self.by_centre(start, to, self.plane.flat(centre))?,
            ArcForm::Radius(radius) => self.by_radius(start, to, radius)?,
        };
        let [first, second, along] = self.plane.axes();
        let mut point = self.start;
        point[first] = centre.x;
        point[second] = centre.y;
        let direction = if self.clockwise { -1.0 } else { 1.0 };
        Ok(MoveShape::Arc {
            centre: point,
            normal: Unit::new_unchecked(Vector3::from_fn(|i, _| if i == along { 1.0 } else { 0.0 })),
            sweep: direction * (sweep + TAU * self.turns),
            rise: self.to[along] - self.start[along],
            to: self.to,
        })
    }

    /// Centre and angle above 0 of an arc with a given centre.
    ///
    /// The centre moves along the chord until both ends are on one circle.
    fn by_centre(
        &self,
        start: Vector2<f64>,
        to: Vector2<f64>,
        given: Vector2<f64>,
    ) -> Result<(Vector2<f64>, f64), GcodeFault> {
        let tolerances = Tolerances::of(self.unit);
        let (start_radius, end_radius) = ((start - given).norm(), (to - given).norm());
        if start_radius.min(end_radius) < tolerances.radius {
            let rule = "the radius of an arc is at least 0.00127 mm";
            let remedy =
                "correct I, J and K: they lead from the start to the centre, or to it from the origin after G90.1";
            return Err(GcodeFault::Value { value: start_radius.min(end_radius), rule, remedy });
        }
        let limit = tolerances.ends.max(RELATIVE * start_radius).min(100.0 * tolerances.ends);
        let misfit = GcodeFault::ArcRadii { start_radius, end_radius, limit };
        if (start_radius - end_radius).abs() > limit {
            return Err(misfit);
        }
        let sweep = self.angle(start - given, to - given);
        let chord = (to - start).norm();
        if chord <= SAME_POINT {
            return Ok((given, sweep));
        }
        let along = (to - start) / chord;
        let shift = (given - 0.5 * (start + to)).dot(&along);
        let centre = given - shift * along;
        let fitted = self.angle(start - centre, to - centre);
        if (fitted - sweep).abs() > ANGLE_CHANGE {
            return Err(misfit);
        }
        let limit = 10.0 * tolerances.ends;
        if sweep > PI && shift.abs() > limit {
            return Err(GcodeFault::ArcCentre { shift: shift.abs(), limit });
        }
        Ok((centre, fitted))
    }

    /// Angle from `from` to `to` in the direction of the arc, above 0.
    fn angle(&self, from: Vector2<f64>, to: Vector2<f64>) -> f64 {
        let left = from.perp(&to).atan2(from.dot(&to));
        let angle = if self.clockwise { -left } else { left };
        if angle < FULL_TURN_BELOW { angle + TAU } else { angle }
    }

    /// Centre and angle above 0 of an arc with a given radius.
    fn by_radius(&self, start: Vector2<f64>, to: Vector2<f64>, radius: f64) -> Result<(Vector2<f64>, f64), GcodeFault> {
        let tolerances = Tolerances::of(self.unit);
        let chord = (to - start).norm();
        if chord <= SAME_POINT {
            let needs = "an arc with R ends at another point of the plane than it starts";
            return Err(GcodeFault::Missing { needs, remedy: "write a full circle with I, J or K" });
        }
        let (half, size) = (0.5 * chord, radius.abs());
        if half - size > tolerances.radius || size < tolerances.radius {
            return Err(GcodeFault::ArcReach { radius: size, chord });
        }
        // Near a half circle the square root below would magnify rounding (LinuxCNC, `TINY`).
        let distance = if half > size * (1.0 - 1e-12) { 0.0 } else { ((size - half) * (size + half)).sqrt() };
        let left = Vector2::new(start.y - to.y, to.x - start.x) / chord;
        let large = radius < 0.0;
        let side = if self.clockwise != large { -distance } else { distance };
        let minor = 2.0 * half.atan2(distance);
        Ok((0.5 * (start + to) + side * left, if large { TAU - minor } else { minor }))
    }
}
