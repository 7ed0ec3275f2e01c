//! Where the readers put what they find in a drawing.

use std::path::Path;

use arcfeed_geometry::GeometryError;

use super::omitted::Omitted;
use super::piece::{Entity, Piece};
use super::selection::Selection;
use crate::input::error::InputError;
use crate::text::clip;

/// The largest coordinate, m.
const FARTHEST: f64 = 1e6;
/// What coordinates have to be, and what to do.
const TOO_FAR: (&str, &str) =
    ("coordinates are finite, and 1000 km at the most", "check its numbers, and the unit of the drawing");

/// Most bytes that are read, those of copies as often as they are shown: twice those of the largest file.
const MOST_BYTES: u64 = 256 << 20;

/// What is found in a drawing.
#[derive(Debug)]
pub(super) struct Sink<'a> {
    pub file: &'a Path,
    pub layers: Selection,
    pub omitted: Omitted,
    pub warnings: Vec<String>,
    pub entities: Vec<Entity>,
    pieces: usize,
    most: usize,
    bytes: u64,
}

/// An entity in messages: its name and its line.
#[derive(Debug, Clone, Copy)]
pub(super) struct Named<'a> {
    pub name: &'a str,
    pub line: u64,
}

impl<'a> Sink<'a> {
    pub fn new(file: &'a Path, layers: Selection, most: usize) -> Self {
        let (omitted, warnings, entities) = (Omitted::default(), Vec::new(), Vec::new());
        Self { file, layers, omitted, warnings, entities, pieces: 0, most, bytes: 0 }
    }

    /// Counts bytes that are read; false where they are more than a drawing may have.
    pub fn reads(&mut self, bytes: u64) -> bool {
        self.bytes = self.bytes.saturating_add(bytes);
        self.bytes <= MOST_BYTES
    }

    /// The error of a drawing that has more bytes than it may.
    pub fn too_much(&self, at: Named) -> InputError {
        let value = format!("more than {} MB", MOST_BYTES >> 20);
        let why = ("a drawing has 256 MB at the most with its copies", "show or insert fewer copies");
        self.wrong(at, "what is read up to here", &value, why)
    }

    /// Takes an entity whose coordinates are sound.
    pub fn add(&mut self, entity: Entity) -> Result<(), InputError> {
        let named = Named { name: &entity.name, line: entity.line };
        self.pieces += entity.pieces.len();
        if self.pieces > self.most {
            let value = format!("more than the {} pieces", self.most);
            let rule = "a drawing may not have more lines, arcs and curves";
            return Err(self.wrong(named, "what the drawing holds", &value, (rule, "divide the drawing")));
        }
        let far = |piece: &&Piece| {
            let extent = piece.extent();
            extent.is_nan() || extent > FARTHEST
        };
        if let Some(piece) = entity.pieces.iter().find(far) {
            return Err(self.wrong(named, "a coordinate", &format!("{:e} m", piece.extent()), TOO_FAR));
        }
        self.entities.push(entity);
        Ok(())
    }

    /// The error of a value in an entity; `why` is the rule and the remedy.
    pub fn wrong(&self, at: Named, key: &str, value: &str, why: (&'static str, &'static str)) -> InputError {
        InputError::Value {
            file: self.file.to_owned(),
            line: usize::try_from(at.line).ok(),
            key: format!("{}: {key}", clip(at.name, 80)),
            value: clip(value, 80),
            rule: why.0,
            remedy: why.1,
        }
    }

    /// The error of a shape that is no curve.
    pub fn curve_error(&self, at: Named, source: GeometryError) -> InputError {
        if let GeometryError::PointNotFinite { value, .. } = source {
            return self.wrong(at, "a coordinate", &format!("{value:e} m"), TOO_FAR);
        }
        InputError::Curve {
            file: self.file.to_owned(),
            key: format!("line {}: {}", at.line, clip(at.name, 80)),
            source,
        }
    }
}
