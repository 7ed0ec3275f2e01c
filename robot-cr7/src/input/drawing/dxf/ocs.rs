//! Object coordinate systems.

use nalgebra::{Matrix3, Vector3};

use super::record::Record;
use crate::input::drawing::map::Map;
use crate::input::drawing::sink::Sink;
use crate::input::error::InputError;

/// Below this in x and y, a normal is near the z axis of the drawing (DXF reference, "arbitrary axis algorithm").
const NEAR_Z: f64 = 1.0 / 64.0;

/// The axes of the object coordinates with this z axis, by the arbitrary axis algorithm of the DXF reference. `None` where it has no length.
pub(super) fn axes(normal: &Vector3<f64>) -> Option<Matrix3<f64>> {
    let largest = normal.amax();
    let z = (normal / largest).try_normalize(1e-3).filter(|z| largest > 0.0 && z.iter().all(|c| c.is_finite()))?;
    let near = z.x.abs() < NEAR_Z && z.y.abs() < NEAR_Z;
    let x = if near { Vector3::y().cross(&z) } else { Vector3::z().cross(&z) }.try_normalize(1e-6)?;
    Some(Matrix3::from_columns(&[x, z.cross(&x), z]))
}

/// The map from the object coordinates of an entity to those of the drawing.
pub(super) fn object_map(record: &Record, sink: &Sink) -> Result<Map, InputError> {
    let normal = record.extrusion(sink)?;
    match axes(&normal) {
        Some(linear) => Ok(Map { linear, shift: Vector3::zeros() }),
        None => {
            let value = format!("({}, {}, {})", normal.x, normal.y, normal.z);
            let why = ("a direction needs a length", "draw the entity again");
            Err(record.wrong(sink, "the extrusion direction (210, 220, 230)", &value, why))
        }
    }
}
