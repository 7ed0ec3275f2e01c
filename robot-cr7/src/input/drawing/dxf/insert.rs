//! Blocks, and where they are inserted.

use nalgebra::{Matrix3, Vector3};

use super::ocs::object_map;
use super::record::{Record, Records};
use crate::input::drawing::map::Map;
use crate::input::drawing::sink::Sink;
use crate::input::error::InputError;

/// A block: its entities are read where it is inserted.
#[derive(Debug, Clone, Copy)]
pub(super) struct Block<'a> {
    /// Where its entities begin.
    pub records: Records<'a>,
    pub base: Vector3<f64>,
    /// Its entities are in another file.
    pub external: bool,
}

impl<'a> Block<'a> {
    /// The block of a BLOCK record, with its name; `records` are those behind it.
    pub fn new(record: &Record<'a>, records: Records<'a>, sink: &Sink) -> Result<(&'a str, Self), InputError> {
        let base = [10, 20, 30].map(|code| record.number_or(code, 0.0, sink));
        let [x, y, z] = base;
        let external = record.flags(70, sink)? & 4 != 0;
        Ok((record.text(2).unwrap_or(""), Self { records, base: Vector3::new(x?, y?, z?), external }))
    }
}

/// Places of a block: rows and columns of copies.
#[derive(Debug, Clone, Copy)]
pub(super) struct Insert {
    own: Map,
    linear: Matrix3<f64>,
    base: Vector3<f64>,
    turn: Matrix3<f64>,
    pub columns: u64,
    pub rows: u64,
    spacing: [f64; 2],
}

impl Insert {
    /// The places that an INSERT record gives to a block.
    pub fn new(record: &Record, block: &Block, sink: &Sink) -> Result<Self, InputError> {
        let number = |code: i32, default: f64| record.number_or(code, default, sink);
        let (sin, cos) = number(50, 0.0)?.to_radians().sin_cos();
        let turn = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
        let scale = Vector3::new(number(41, 1.0)?, number(42, 1.0)?, number(43, 1.0)?);
        if scale.iter().any(|s| *s == 0.0) {
            let value = format!("({}, {}, {})", scale.x, scale.y, scale.z);
            let why = ("a scale may not be 0", "correct the insertion, or remove it");
            return Err(record.wrong(sink, "the scale (41, 42, 43)", &value, why));
        }
        let object = object_map(record, sink)?;
        let own = object.after(&Map::translation(record.point(10, sink)?));
        let count = |code: i32| record.flags(code, sink).map(|n| u64::try_from(n).unwrap_or(1).max(1));
        Ok(Self {
            own,
            linear: turn * Matrix3::from_diagonal(&scale),
            base: block.base,
            turn,
            columns: count(70)?,
            rows: count(71)?,
            spacing: [number(44, 0.0)?, number(45, 0.0)?],
        })
    }

    /// The map of the copy in a column and a row, into the drawing that holds the INSERT.
    pub fn map(&self, column: u64, row: u64) -> Map {
        let offset = Vector3::new(self.spacing[0] * column as f64, self.spacing[1] * row as f64, 0.0);
        let block = Map { linear: self.linear, shift: self.turn * offset - self.linear * self.base };
        self.own.after(&block)
    }
}
