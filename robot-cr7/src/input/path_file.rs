//! Path files: NURBS curves in JSON and points in CSV, with their unit.
//!
//! A **JSON** file holds one curve; unknown keys are refused:
//!
//! ```json
//! {
//!   "name": "arch", "source": "where the numbers come from (optional)", "units": "mm", "degree": 2,
//!   "control_points": [[0, 0], [40, 60], [80, 0]],
//!   "weights": [1, 2, 1],
//!   "knots": [0, 0, 0, 1, 1, 1]
//! }
//! ```
//!
//! `control_points` have two or three coordinates each and are not multiplied by their weights; `weights` may be left
//! out (all 1); `units` must be given.
//!
//! A **CSV** file holds one point a row, `x,y` or `x,y,z`. Its header names columns and unit (`x_mm,y_mm`); without a
//! unit there, the caller has to give one. Further columns hold the tool: `i,j,k`, its axis from the tip to the holder, or
//! `qx,qy,qz,qw`, its orientation. Blank lines and lines that start with `#` are skipped.
//!
//! A **G-code** file holds a program; see [`GcodeProgram`].
//!
//! A **drawing** in DXF or SVG becomes a program; see [`read_drawing`](crate::read_drawing).

use std::path::{Path, PathBuf};

use arcfeed_geometry::{GeometryError, NurbsCurve};
use nalgebra::{Unit, UnitQuaternion, Vector2, Vector3};
use serde::Deserialize;

use super::drawing::DrawingOptions;
use super::drawing::reader::{DrawingKind, read_bytes, read_drawing_file};
use super::error::{InputError, read_text, text_of};
use super::gcode::{GcodeOptions, GcodeProgram};
use super::job::Job;
use super::unit::LengthUnit;

/// Control points of one path: with more, planning takes longer than ten seconds.
pub(crate) const MOST_CONTROL_POINTS: usize = 25_000;

const EXPECTED_JSON: &str = "one JSON object with the keys units, degree, control_points, weights and knots";
const EXPECTED_CSV: &str = "one point a line, x,y or x,y,z, under a header with the unit such as x_mm,y_mm";

/// The geometry of a path file, in metres, in the workpiece frame.
#[derive(Debug, Clone, PartialEq)]
pub enum PathGeometry {
    /// A NURBS curve (JSON files).
    Curve(NurbsCurve<3>),
    /// Points to lay a curve through (CSV files), each with its line in the file.
    Points {
        /// The points in metres.
        points: Vec<Vector3<f64>>,
        /// Line of each point in the file, from 1.
        lines: Vec<u64>,
        /// The tool at each point, where the file has columns for it.
        tools: Option<PointTools>,
    },
    /// A G-code program, or a drawing.
    Program(Box<GcodeProgram>),
}

/// The tool at each point of a file, in the workpiece frame.
#[derive(Debug, Clone, PartialEq)]
pub enum PointTools {
    /// Its axis (columns i, j, k), from the tip of the tool to its holder, as in files of CAM programs: the z axis of the tool frame is
    /// opposite. How the tool is turned about it is free.
    Axes(Vec<Unit<Vector3<f64>>>),
    /// Its orientation (columns qx, qy, qz, qw).
    Rotations(Vec<UnitQuaternion<f64>>),
}

/// A path as read from a file.
#[derive(Debug, Clone, PartialEq)]
pub struct PathFile {
    /// Name of the path: the key `name`, else the name of the file without its extension.
    pub name: String,
    /// The source of the numbers, if the file says it.
    pub source: Option<String>,
    /// The file it was read from (for messages).
    pub file: PathBuf,
    /// Curve or points, in metres; plane paths lie at z = 0.
    pub geometry: PathGeometry,
    /// True when the file gives two coordinates a point.
    pub planar: bool,
    /// Things that are allowed but look like a slip, such as a path a hundred metres wide.
    pub warnings: Vec<String>,
}

/// The JSON file as it is written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawCurve {
    name: Option<String>,
    source: Option<String>,
    units: Option<String>,
    degree: usize,
    control_points: Vec<Vec<f64>>,
    weights: Option<Vec<f64>>,
    knots: Vec<f64>,
}

impl PathFile {
    /// Reads a path file; the extension (`.json`, `.csv`, `.dxf`, `.svg`, or one of G-code: `.ngc`, `.nc`, `.gcode`, `.cnc`, `.tap`; in any
    /// case) tells its kind.
    ///
    /// `csv_unit` is the unit of CSV files whose header names none, of programs before G20 or G21, and of drawings that name none; it is not
    /// used for JSON files, which always name their own. Drawings are read with the other [`DrawingOptions`] at their defaults.
    ///
    /// # Errors
    /// Fails when the file cannot be read, or breaks a rule of its format; the message names the place and the remedy.
    pub fn read(file: &Path, csv_unit: Option<LengthUnit>) -> Result<Self, InputError> {
        Self::read_with(file, csv_unit, &drawing_options(csv_unit))
    }

    /// Reads a path file for a job: its feed, lift and layers are those of a drawing. `unit` is used before the unit of the job.
    ///
    /// # Errors
    /// As [`PathFile::read`]; a drawing for a job with feeds for sections of the path.
    pub fn read_for_job(file: &Path, unit: Option<LengthUnit>, job: &Job) -> Result<Self, InputError> {
        let unit = unit.or(job.csv_unit);
        if matches!(Kind::of(file)?, Kind::Drawing(_)) && !job.sections.is_empty() {
            return Err(InputError::Value {
                file: file.to_owned(),
                line: None,
                key: "[[sections]] of the job".to_owned(),
                value: "given".to_owned(),
                rule: "the contours of a drawing have one feed, feed.feed_mm_s",
                remedy: "remove the sections",
            });
        }
        let (layers, lift, feed) = (job.layers.clone(), job.lift, job.feed.feed);
        Self::read_with(file, unit, &DrawingOptions { layers, lift, feed, ..drawing_options(unit) })
    }

    fn read_with(file: &Path, csv_unit: Option<LengthUnit>, drawing: &DrawingOptions) -> Result<Self, InputError> {
        match Kind::of(file)? {
            Kind::Drawing(kind) => Ok(Self::of_program(read_drawing_file(file, kind, drawing)?)),
            Kind::Json => Self::parse_json(&read_text(file, EXPECTED_JSON)?, file),
            Kind::Csv => Self::parse_csv(&read_text(file, EXPECTED_CSV)?, file, csv_unit),
            Kind::Gcode => Ok(Self::of_program(GcodeProgram::read(file, &options(csv_unit))?)),
        }
    }

    /// Like [`PathFile::read`], from bytes that are in memory already; `file` is the name used in messages.
    ///
    /// # Errors
    /// As [`PathFile::read`].
    pub fn from_bytes(bytes: &[u8], file: &Path, csv_unit: Option<LengthUnit>) -> Result<Self, InputError> {
        match Kind::of(file)? {
            Kind::Drawing(kind) => Ok(Self::of_program(read_bytes(bytes, file, kind, &drawing_options(csv_unit))?)),
            Kind::Json => Self::parse_json(&text_of(bytes, file, EXPECTED_JSON)?, file),
            Kind::Csv => Self::parse_csv(&text_of(bytes, file, EXPECTED_CSV)?, file, csv_unit),
            Kind::Gcode => Ok(Self::of_program(GcodeProgram::from_bytes(bytes, file, &options(csv_unit))?)),
        }
    }

    /// The curve: the file's own, the programmed one with its corners, or what `fit` makes of its points (in metres).
    ///
    /// # Errors
    /// The error of `fit`, with the file and the line added; what [`GcodeProgram::joined`] refuses.
    pub fn curve_with<F>(&self, fit: F) -> Result<NurbsCurve<3>, InputError>
    where
        F: FnOnce(&[Vector3<f64>]) -> Result<NurbsCurve<3>, GeometryError>,
    {
        match &self.geometry {
            PathGeometry::Curve(curve) => Ok(curve.clone()),
            PathGeometry::Program(program) => program.joined()?.to_curve().map_err(|source| InputError::Curve {
                file: self.file.clone(),
                key: "the program".to_owned(),
                source,
            }),
            PathGeometry::Points { points, lines, .. } => fit(points).map_err(|source| {
                let line = match source {
                    GeometryError::PointNotFinite { index, .. } | GeometryError::DuplicatePoints { index, .. } => {
                        lines.get(index)
                    }
                    _ => None,
                };
                let key = line.map_or_else(|| "fitting the points".to_owned(), |l| format!("line {l}"));
                InputError::Curve { file: self.file.clone(), key, source }
            }),
        }
    }

    /// The curve as a plane one in x and y, when the file is a plane curve.
    pub fn plane_curve(&self) -> Option<NurbsCurve<2>> {
        match &self.geometry {
            PathGeometry::Curve(c) if self.planar => {
                let points = c.control_points().iter().map(|p| Vector2::new(p.x, p.y)).collect();
                NurbsCurve::new(c.degree(), points, c.weights().to_vec(), c.knots().as_slice().to_vec()).ok()
            }
            _ => None,
        }
    }

    fn of_program(program: GcodeProgram) -> Self {
        Self {
            name: stem(&program.file),
            source: None,
            file: program.file.clone(),
            planar: false,
            warnings: program.warnings.clone(),
            geometry: PathGeometry::Program(Box::new(program)),
        }
    }

    fn parse_json(text: &str, file: &Path) -> Result<Self, InputError> {
        let raw: RawCurve = serde_json::from_str(text).map_err(|e| {
            let mut message = e.to_string();
            // serde_json repeats the place at the end of its message.
            if let Some(end) = message.rfind(" at line ") {
                message.truncate(end);
            }
            let hint = json_hint(text, &e, &message).to_owned();
            InputError::Syntax { file: file.to_owned(), line: e.line(), column: e.column(), message, hint }
        })?;
        let unit = json_unit(raw.units.as_deref(), file)?;
        let value_error = |key: String, value: String, rule, remedy| {
            Err(InputError::Value { file: file.to_owned(), line: None, key, value, rule, remedy })
        };

        let dimension = raw.control_points.first().map_or(2, Vec::len);
        for (i, p) in raw.control_points.iter().enumerate() {
            if !(2..=3).contains(&p.len()) {
                return value_error(
                    format!("control_points[{i}]"),
                    format!("{p:?}"),
                    "a control point has two or three coordinates",
                    "write it as [x, y] or [x, y, z]",
                );
            }
            if p.len() != dimension {
                return value_error(
                    format!("control_points[{i}]"),
                    format!("{p:?}"),
                    "it has another number of coordinates than control_points[0]",
                    "give all control points two coordinates, or all three",
                );
            }
        }
        if raw.control_points.len() > MOST_CONTROL_POINTS {
            return value_error(
                "control_points".to_owned(),
                format!("a list of {}", raw.control_points.len()),
                "a path has at most 25000 control points",
                "split the path, or give its points as CSV to have a curve with fewer control points laid through them",
            );
        }
        if raw.degree >= raw.control_points.len() {
            // Checked here because a degree near the largest integer has no "degree + 1".
            return value_error(
                "control_points".to_owned(),
                format!("{} points for degree {}", raw.control_points.len(), raw.degree),
                "a curve needs at least degree + 1 control points",
                "add control points, or lower the degree",
            );
        }
        let points: Vec<_> = raw
            .control_points
            .iter()
            .map(|p| Vector3::from_fn(|axis, _| p.get(axis).map_or(0.0, |&v| unit.to_metres(v))))
            .collect();
        let warnings = size_warnings(&points, unit);
        let weights = raw.weights.unwrap_or_else(|| vec![1.0; points.len()]);
        let curve = NurbsCurve::new(raw.degree, points, weights, raw.knots).map_err(|source| InputError::Curve {
            file: file.to_owned(),
            key: key_of(&source),
            source,
        })?;
        Ok(Self {
            name: raw.name.unwrap_or_else(|| stem(file)),
            source: raw.source,
            file: file.to_owned(),
            geometry: PathGeometry::Curve(curve),
            planar: dimension == 2,
            warnings,
        })
    }
}

/// How a program is read where a unit was asked for.
fn options(unit: Option<LengthUnit>) -> GcodeOptions {
    GcodeOptions { unit: unit.unwrap_or(LengthUnit::Millimetre), ..GcodeOptions::default() }
}

/// How a drawing is read where a unit was asked for.
fn drawing_options(unit: Option<LengthUnit>) -> DrawingOptions {
    DrawingOptions { unit, ..DrawingOptions::default() }
}

/// Kind of a path file, told by its extension.
enum Kind {
    Json,
    Csv,
    Gcode,
    Drawing(DrawingKind),
}

impl Kind {
    fn of(file: &Path) -> Result<Self, InputError> {
        let extension = file.extension().map(|e| e.to_string_lossy().into_owned()).unwrap_or_default();
        let lower = extension.to_ascii_lowercase();
        if let Some(kind) = DrawingKind::of_extension(&lower) {
            return Ok(Self::Drawing(kind));
        }
        match lower.as_str() {
            "json" => Ok(Self::Json),
            "csv" => Ok(Self::Csv),
            "ngc" | "nc" | "gcode" | "cnc" | "tap" => Ok(Self::Gcode),
            _ => Err(InputError::Extension { file: file.to_owned(), extension }),
        }
    }
}

fn json_unit(symbol: Option<&str>, file: &Path) -> Result<LengthUnit, InputError> {
    let Some(symbol) = symbol else {
        let remedy = "add \"units\": \"mm\" (or \"cm\", \"m\", \"in\")";
        return Err(InputError::MissingUnit { file: file.to_owned(), place: "the key \"units\"".to_owned(), remedy });
    };
    LengthUnit::from_symbol(symbol).ok_or_else(|| InputError::UnknownUnit {
        file: file.to_owned(),
        place: "units".to_owned(),
        unit: symbol.to_owned(),
    })
}

/// The remedy for an error of the JSON parser.
fn json_hint(text: &str, error: &serde_json::Error, message: &str) -> &'static str {
    let rest = text.lines().nth(error.line().saturating_sub(1)).unwrap_or_default();
    let at: String = rest.chars().skip(error.column().saturating_sub(2)).take(9).collect();
    if ["nan", "inf"].iter().any(|w| at.to_ascii_lowercase().contains(w)) {
        "; NaN and Infinity are not numbers in JSON: a coordinate, weight or knot must be finite, find out where it was lost"
    } else if message.starts_with("unknown field") {
        "; remove the key, or correct its spelling"
    } else if message.starts_with("missing field") {
        "; add the key: a curve has units, degree, control_points, weights and knots"
    } else if message.contains("out of range") {
        "; coordinates, weights and knots must be finite numbers"
    } else if error.is_data() {
        "; a curve has units (text), degree (a whole number), control_points (a list of [x, y] or [x, y, z]), weights and knots (lists of numbers)"
    } else {
        "; the file must hold one JSON object: correct it at this place"
    }
}

/// The key of a path file that a geometry error speaks of.
fn key_of(error: &GeometryError) -> String {
    match error {
        GeometryError::DegreeZero => "degree".to_owned(),
        GeometryError::WeightCount { .. } | GeometryError::WeightRange { .. } => "weights".to_owned(),
        GeometryError::Weight { index, .. } => format!("weights[{index}]"),
        GeometryError::KnotNotFinite { index, .. }
        | GeometryError::KnotsDecrease { index, .. }
        | GeometryError::KnotsTooClose { index, .. }
        | GeometryError::Multiplicity { index, .. } => format!("knots[{index}]"),
        GeometryError::KnotCount { .. } | GeometryError::EmptyDomain { .. } | GeometryError::Jump { .. } => {
            "knots".to_owned()
        }
        GeometryError::PointNotFinite { index, axis, .. } => format!("control_points[{index}][{axis}]"),
        _ => "control_points".to_owned(),
    }
}

/// Sizes that an arm of this class cannot mean: a likely slip of the unit.
pub(super) fn size_warnings(points: &[Vector3<f64>], unit: LengthUnit) -> Vec<String> {
    let low = points.iter().fold(Vector3::repeat(f64::INFINITY), |a, p| a.inf(p));
    let high = points.iter().fold(Vector3::repeat(f64::NEG_INFINITY), |a, p| a.sup(p));
    let size = (high - low).norm();
    let symbol = unit.symbol();
    if size > 5.0 {
        let other = if unit == LengthUnit::Metre { "mm" } else { "a smaller unit" };
        vec![format!("the path is {size:.3} m wide when its numbers are read in {symbol}: did you mean {other}?")]
    } else if size > 0.0 && size < 1e-4 {
        let other = if unit == LengthUnit::Millimetre { "m" } else { "a larger unit" };
        vec![format!(
            "the path is only {:.3} um wide when its numbers are read in {symbol}: did you mean {other}?",
            size * 1e6
        )]
    } else {
        Vec::new()
    }
}

pub(super) fn stem(file: &Path) -> String {
    file.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default()
}
