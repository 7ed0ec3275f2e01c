//! Points of a path in CSV.

use std::path::Path;

use nalgebra::{Quaternion, Unit, UnitQuaternion, Vector3};

use super::error::InputError;
use super::path_file::{PathFile, PathGeometry, PointTools, size_warnings, stem};
use super::unit::LengthUnit;

/// Two consecutive points of a CSV file have to be this far apart, in metres.
const LEAST_DISTANCE: f64 = 1e-9;
/// Points of a CSV file: laying a curve through more takes longer than ten seconds.
const MOST_POINTS: usize = 500_000;

impl PathFile {
    pub(super) fn parse_csv(text: &str, file: &Path, asked: Option<LengthUnit>) -> Result<Self, InputError> {
        let mut rows = csv_rows(text).peekable();
        let header = match rows.peek() {
            Some((line, cells)) if cells.iter().all(|c| c.parse::<f64>().is_err()) => {
                Some((*line, Header::parse(cells, *line, file)?))
            }
            _ => None,
        };
        if header.is_some() {
            rows.next();
        }
        let unit = Header::unit(header.as_ref(), asked, file)?;
        let mut columns = header.map(|(line, h)| (line, h.columns));
        let (mut points, mut lines): (Vec<Vector3<f64>>, Vec<u64>) = (Vec::new(), Vec::new());
        let (mut tool_axes, mut rotations) = (Vec::new(), Vec::new());
        for (line, cells) in rows {
            let (first_line, axes) = match &columns {
                Some((first, axes)) => (*first, axes),
                None => {
                    let n = cells.len();
                    if !(2..=3).contains(&n) {
                        return Err(count_error(file, line, n, line, 2));
                    }
                    let (_, axes) = columns.insert((line, (0..n).collect()));
                    (line, &*axes)
                }
            };
            if cells.len() != axes.len() {
                return Err(count_error(file, line, cells.len(), first_line, axes.len()));
            }
            let row = Row::of(&cells, axes, (file, line))?;
            let point = row.point(unit);
            if axes.contains(&TOOL_AXIS) {
                tool_axes.push(row.tool_axis((file, line))?);
            } else if axes.contains(&QUATERNION) {
                rotations.push(row.rotation((file, line))?);
            }
            if let (Some(last), Some(&first_line)) = (points.last(), lines.last()) {
                let distance_m = (point - last).norm();
                if distance_m < LEAST_DISTANCE {
                    let file = file.to_owned();
                    return Err(InputError::DuplicatePoints { file, first_line, second_line: line, distance_m });
                }
            }
            if points.len() == MOST_POINTS {
                return Err(InputError::Value {
                    file: file.to_owned(),
                    line: usize::try_from(line).ok(),
                    key: "the number of points".to_owned(),
                    value: format!("more than {MOST_POINTS}"),
                    rule: "a path file has at most 500000 points",
                    remedy: "leave points out, or split the path",
                });
            }
            points.push(point);
            lines.push(line);
        }
        if points.len() < 2 {
            return Err(InputError::TooFewPoints { file: file.to_owned(), found: points.len(), needed: 2 });
        }
        Ok(Self {
            name: stem(file),
            source: None,
            file: file.to_owned(),
            planar: columns.is_some_and(|(_, axes)| !axes.contains(&2)),
            warnings: size_warnings(&points, unit),
            geometry: PathGeometry::Points {
                points,
                lines,
                tools: match (tool_axes.is_empty(), rotations.is_empty()) {
                    (false, _) => Some(PointTools::Axes(tool_axes)),
                    (_, false) => Some(PointTools::Rotations(rotations)),
                    _ => None,
                },
            },
        })
    }
}

/// Names of the columns that a file may have; the numbers of columns are indices of these.
const COLUMNS: [&str; 10] = ["x", "y", "z", "i", "j", "k", "qx", "qy", "qz", "qw"];
/// The first column of the axis of the tool, and of its orientation.
const TOOL_AXIS: usize = 3;
const QUATERNION: usize = 6;
/// By how much the length of an axis or a quaternion may be off 1: what three decimals leave.
const OFF_UNIT: f64 = 0.01;

/// The largest number of a cell.
const LARGEST: f64 = 1e100;

/// The numbers of a row, by column.
struct Row([f64; 10]);

impl Row {
    /// The numbers of a line, whose cells belong to these columns.
    fn of(cells: &[String], columns: &[usize], (file, line): (&Path, u64)) -> Result<Self, InputError> {
        let mut row = [0.0; 10];
        for (i, (cell, &column)) in cells.iter().zip(columns).enumerate() {
            // Larger ones are no places, and overflow in another unit.
            let number = cell.parse::<f64>().ok().filter(|v| v.abs() <= LARGEST);
            row[column] = number.ok_or_else(|| InputError::Cell {
                file: file.to_owned(),
                line,
                column: i + 1,
                cell: cell.clone(),
                remedy: "write plain numbers of at most 1e100 with a decimal point, separated by commas, as in 12.5,-3e-2",
            })?;
        }
        Ok(Self(row))
    }

    fn point(&self, unit: LengthUnit) -> Vector3<f64> {
        Vector3::from_fn(|axis, _| unit.to_metres(self.0[axis]))
    }

    fn tool_axis(&self, place: (&Path, u64)) -> Result<Unit<Vector3<f64>>, InputError> {
        let axis = Vector3::from_column_slice(&self.0[TOOL_AXIS..TOOL_AXIS + 3]);
        let rule = "the axis of the tool has length 1";
        not_unit(axis.norm(), ("i, j, k", rule), place).map_or_else(|| Ok(Unit::new_normalize(axis)), Err)
    }

    fn rotation(&self, place: (&Path, u64)) -> Result<UnitQuaternion<f64>, InputError> {
        let [x, y, z, w] = [0, 1, 2, 3].map(|k| self.0[QUATERNION + k]);
        let quaternion = Quaternion::new(w, x, y, z);
        let rule = "a quaternion of an orientation has length 1";
        not_unit(quaternion.norm(), ("qx, qy, qz, qw", rule), place)
            .map_or_else(|| Ok(UnitQuaternion::from_quaternion(quaternion)), Err)
    }
}

/// The error of a vector that is no unit vector.
fn not_unit(length: f64, (key, rule): (&str, &'static str), (file, line): (&Path, u64)) -> Option<InputError> {
    let error = || InputError::Value {
        file: file.to_owned(),
        line: usize::try_from(line).ok(),
        key: key.to_owned(),
        value: format!("a vector of length {length}"),
        rule,
        remedy: "divide the numbers by that, or correct them",
    };
    ((length - 1.0).abs() > OFF_UNIT || length.is_nan()).then(error)
}

/// The header of a CSV file.
struct Header {
    /// What each column holds, as an index of [`COLUMNS`].
    columns: Vec<usize>,
    unit: Option<LengthUnit>,
}

impl Header {
    /// The unit of a file: that of its header, or else the one asked for.
    fn unit(header: Option<&(u64, Self)>, asked: Option<LengthUnit>, file: &Path) -> Result<LengthUnit, InputError> {
        let place = header.map_or_else(|| "the file (no header)".to_owned(), |(line, _)| format!("line {line}"));
        match (header.and_then(|(_, header)| header.unit), asked) {
            (Some(found), Some(asked)) if found != asked => {
                let (found, asked) = (found.symbol(), asked.symbol());
                Err(InputError::UnitConflict { file: file.to_owned(), place, found, asked })
            }
            (Some(unit), _) | (None, Some(unit)) => Ok(unit),
            (None, None) => {
                let remedy =
                    "name it in the header, as in x_mm,y_mm (mm, cm, m, in), or give the CSV unit with the job";
                Err(InputError::MissingUnit { file: file.to_owned(), place, remedy })
            }
        }
    }

    fn parse(cells: &[String], line: u64, file: &Path) -> Result<Self, InputError> {
        let mut columns = Vec::new();
        let mut unit = None;
        for (i, cell) in cells.iter().enumerate() {
            let wrong =
                |rule| InputError::Column { file: file.to_owned(), line, column: i + 1, name: cell.clone(), rule };
            let name = cell.to_ascii_lowercase();
            if let Some(column) = COLUMNS.iter().skip(TOOL_AXIS).position(|tool| *tool == name) {
                if columns.contains(&(TOOL_AXIS + column)) {
                    return Err(wrong("this part of the tool stands twice: remove one of the columns"));
                }
                columns.push(TOOL_AXIS + column);
                continue;
            }
            let (axis, rest) = match name.chars().next() {
                Some(c @ 'x'..='z') => (c as usize - 'x' as usize, &name[1..]),
                _ => {
                    return Err(wrong(
                        "a path has the columns x, y and optionally z, and i,j,k or qx,qy,qz,qw for the tool: rename or remove this one",
                    ));
                }
            };
            if columns.contains(&axis) {
                return Err(wrong("this coordinate stands twice: remove one of the columns"));
            }
            columns.push(axis);
            let symbol = rest.trim_matches([' ', '_', '[', ']', '(', ')']);
            let here = match symbol {
                "" => None,
                _ => Some(LengthUnit::from_symbol(symbol).ok_or_else(|| InputError::UnknownUnit {
                    file: file.to_owned(),
                    place: format!("the unit of column {} (line {line}, \"{cell}\")", i + 1),
                    unit: symbol.to_owned(),
                })?),
            };
            if columns.iter().filter(|column| **column < TOOL_AXIS).count() > 1 && here != unit {
                return Err(wrong("its unit differs from the one of the first column: use one unit for all columns"));
            }
            unit = here;
        }
        if !(columns.contains(&0) && columns.contains(&1)) {
            return Err(count_error(file, line, columns.len(), line, 2));
        }
        let given = |from: usize, to: usize| columns.iter().filter(|column| (from..to).contains(column)).count();
        let (axis, quaternion) = (given(TOOL_AXIS, QUATERNION), given(QUATERNION, COLUMNS.len()));
        if !matches!((axis, quaternion), (0 | 3, 0) | (0, 4)) {
            return Err(InputError::Value {
                file: file.to_owned(),
                line: usize::try_from(line).ok(),
                key: "the columns of the tool".to_owned(),
                value: cells.join(","),
                rule: "the tool is given by all of i,j,k, or by all of qx,qy,qz,qw",
                remedy: "add the missing columns, or remove the others",
            });
        }
        Ok(Self { columns, unit })
    }
}

/// Rows of a CSV text with their line, from 1: cells trimmed, blank lines and lines that start with `#` left out.
fn csv_rows(text: &str) -> impl Iterator<Item = (u64, Vec<String>)> {
    text.lines().zip(1u64..).filter_map(|(row, line)| {
        let row = row.trim();
        if row.is_empty() || row.starts_with('#') {
            return None;
        }
        Some((line, cells_of(row)))
    })
}

/// The cells of a row, trimmed.
pub(super) fn cells_of(row: &str) -> Vec<String> {
    if !row.contains('"') {
        return row.split(',').map(|cell| cell.trim().to_owned()).collect();
    }
    // One reader a line: the crate's own line count is off after blank lines, and a stray quote stays in its line.
    let mut reader = csv::ReaderBuilder::new().has_headers(false).trim(csv::Trim::All).from_reader(row.as_bytes());
    match reader.records().next() {
        Some(Ok(record)) => record.iter().map(str::to_owned).collect(),
        _ => vec![row.to_owned()],
    }
}

fn count_error(file: &Path, line: u64, found: usize, first_line: u64, expected: usize) -> InputError {
    let rule = "x,y or x,y,z, separated by commas";
    InputError::ColumnCount { file: file.to_owned(), line, found, expected, first_line, rule }
}
