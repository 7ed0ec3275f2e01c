//! Trajectories as CSV: one sample a line, units in the names of the columns.

use std::io::{Read, Write};
use std::path::Path;

use super::whole_file::{unwritten, write_whole};
use crate::input::error::InputError;
use crate::run::trajectory_row::TrajectoryRow;

/// Names of the columns for an arm whose joints are called `names`: `t_s`, then `q`, `qd`, `qdd` and `jerk` of every joint, then the
/// tool pose. A column of a joint has its name behind a colon, as in `q1_rad:shoulder_pan_joint`.
pub fn trajectory_columns(names: &[String]) -> Vec<String> {
    let groups = [("q", "rad"), ("qd", "rad_s"), ("qdd", "rad_s2"), ("jerk", "rad_s3")];
    let joints = || (1..).zip(names);
    let each = groups.iter().flat_map(|(name, unit)| joints().map(move |(j, of)| format!("{name}{j}_{unit}:{of}")));
    let pose = ["x_m", "y_m", "z_m", "qx", "qy", "qz", "qw"].map(str::to_owned);
    std::iter::once("t_s".to_owned()).chain(each).chain(pose).collect()
}

/// Writes a trajectory line by line, buffered, with the shortest digits that read back as the same doubles.
#[derive(Debug)]
pub struct TrajectoryWriter<W: Write, const N: usize = 6> {
    writer: csv::Writer<W>,
}

impl<W: Write, const N: usize> TrajectoryWriter<W, N> {
    /// Starts a file with its header, with the names of the joints. The writer buffers by itself.
    ///
    /// # Errors
    /// [`InvalidInput`](std::io::ErrorKind::InvalidInput) unless there are `N` names; the error of `writer`.
    pub fn new(writer: W, names: &[String]) -> std::io::Result<Self> {
        if names.len() != N {
            let words = format!("{} names for {N} joints: give one for each joint", names.len());
            return Err(std::io::Error::new(std::io::ErrorKind::InvalidInput, words));
        }
        let mut writer = csv::WriterBuilder::new().has_headers(false).buffer_capacity(1 << 16).from_writer(writer);
        writer.write_record(trajectory_columns(names)).map_err(into_io)?;
        Ok(Self { writer })
    }

    /// Adds one sample.
    ///
    /// # Errors
    /// The error of the underlying writer.
    pub fn write(&mut self, row: &TrajectoryRow<N>) -> std::io::Result<()> {
        let r = row;
        let joints = (&r.q[..], &r.qd[..], &r.qdd[..], &r.jerk[..]);
        self.writer.serialize((r.t, joints, r.position, r.quaternion)).map_err(into_io)
    }

    /// Writes what is still buffered. Dropping does it too, but swallows the error.
    ///
    /// # Errors
    /// The error of the underlying writer.
    pub fn finish(mut self) -> std::io::Result<()> {
        self.writer.flush()
    }
}

/// Writes a trajectory of joints with these names to a file, whole or not at all.
///
/// # Errors
/// Fails when the file cannot be written, or there are not `N` names.
pub fn write_trajectory<I, const N: usize>(file: &Path, names: &[String], rows: I) -> Result<(), InputError>
where
    I: IntoIterator<Item = TrajectoryRow<N>>,
{
    write_whole(file, |part| write_rows(part, names, rows).map_err(unwritten(file)))
}

/// Header and rows, to the last byte.
pub(crate) fn write_rows<W: Write, const N: usize>(
    writer: W,
    names: &[String],
    rows: impl IntoIterator<Item = TrajectoryRow<N>>,
) -> std::io::Result<()> {
    let mut writer = TrajectoryWriter::new(writer, names)?;
    for row in rows {
        writer.write(&row)?;
    }
    writer.finish()
}

/// Reads a trajectory back; `file` is the name used in messages.
///
/// # Errors
/// Fails when the header is not [`trajectory_columns`] of `N` joints, with or without their names, or a cell is not a finite number.
pub fn read_trajectory<R: Read, const N: usize>(reader: R, file: &Path) -> Result<Vec<TrajectoryRow<N>>, InputError> {
    let columns = trajectory_columns(&vec![String::new(); N]);
    let mut rows = Vec::new();
    let mut reader = csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(reader);
    let mut record = csv::StringRecord::new();
    for line in 1u64.. {
        match reader.read_record(&mut record) {
            Ok(true) => {}
            Ok(false) if line == 1 => {
                return Err(InputError::Empty { file: file.to_owned(), expected: "a trajectory with its header" });
            }
            Ok(false) => break,
            Err(e) => {
                return Err(InputError::Read { file: file.to_owned(), source: into_io(e), remedy: "write it again" });
            }
        }
        if record.len() != columns.len() {
            return Err(InputError::ColumnCount {
                file: file.to_owned(),
                line,
                found: record.len(),
                expected: columns.len(),
                first_line: 1,
                rule: "t, then q, qd, qdd and jerk of every joint, then x y z qx qy qz qw",
            });
        }
        if line == 1 {
            if let Some(column) = record.iter().zip(&columns).position(|(a, b)| quantity(a) != quantity(b)) {
                return Err(InputError::Column {
                    file: file.to_owned(),
                    line,
                    column: column + 1,
                    name: record[column].to_owned(),
                    rule: "a trajectory starts with the header t_s,q1_rad,...: write it again with this program",
                });
            }
            continue;
        }
        let mut values = vec![0.0; columns.len()];
        for (column, (value, cell)) in values.iter_mut().zip(&record).enumerate() {
            *value = cell.parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(|| InputError::Cell {
                file: file.to_owned(),
                line,
                column: column + 1,
                cell: cell.to_owned(),
                remedy: "write the trajectory again with this program",
            })?;
        }
        rows.push(row_of(&values));
    }
    Ok(rows)
}

/// A column without the name of its joint.
fn quantity(column: &str) -> &str {
    column.split_once(':').map_or(column, |(quantity, _)| quantity)
}

fn row_of<const N: usize>(v: &[f64]) -> TrajectoryRow<N> {
    let joints = |group: usize| std::array::from_fn(|i| v[1 + group * N + i]);
    let pose = 1 + 4 * N;
    TrajectoryRow {
        t: v[0],
        q: joints(0),
        qd: joints(1),
        qdd: joints(2),
        jerk: joints(3),
        position: std::array::from_fn(|i| v[pose + i]),
        quaternion: std::array::from_fn(|i| v[pose + 3 + i]),
    }
}

fn into_io(error: csv::Error) -> std::io::Error {
    match error.into_kind() {
        csv::ErrorKind::Io(e) => e,
        other => std::io::Error::other(format!("{other:?}")),
    }
}
