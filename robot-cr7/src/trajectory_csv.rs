//! Trajectories as CSV: one sample a line, units in the names of the columns.

use std::fs::File;
use std::io::{BufWriter, Read, Write};
use std::path::Path;

use crate::error::InputError;

/// Names of the columns.
pub const TRAJECTORY_COLUMNS: [&str; 32] = [
    "t_s",
    "q1_rad",
    "q2_rad",
    "q3_rad",
    "q4_rad",
    "q5_rad",
    "q6_rad",
    "qd1_rad_s",
    "qd2_rad_s",
    "qd3_rad_s",
    "qd4_rad_s",
    "qd5_rad_s",
    "qd6_rad_s",
    "qdd1_rad_s2",
    "qdd2_rad_s2",
    "qdd3_rad_s2",
    "qdd4_rad_s2",
    "qdd5_rad_s2",
    "qdd6_rad_s2",
    "jerk1_rad_s3",
    "jerk2_rad_s3",
    "jerk3_rad_s3",
    "jerk4_rad_s3",
    "jerk5_rad_s3",
    "jerk6_rad_s3",
    "x_m",
    "y_m",
    "z_m",
    "qx",
    "qy",
    "qz",
    "qw",
];

/// One sample of a joint trajectory with the pose of the tool tip in the base frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TrajectoryRow {
    /// Time in s.
    pub t: f64,
    /// Joint positions in rad.
    pub q: [f64; 6],
    /// Joint velocities in rad/s.
    pub qd: [f64; 6],
    /// Joint accelerations in rad/s^2.
    pub qdd: [f64; 6],
    /// Joint jerks in rad/s^3.
    pub jerk: [f64; 6],
    /// Tool tip in m.
    pub position: [f64; 3],
    /// Tool orientation as a unit quaternion x, y, z, w.
    pub quaternion: [f64; 4],
}

/// Writes a trajectory line by line, buffered, with the shortest digits that read back as the same doubles.
#[derive(Debug)]
pub struct TrajectoryWriter<W: Write> {
    writer: csv::Writer<W>,
}

impl<W: Write> TrajectoryWriter<W> {
    /// Starts a file with its header. The writer buffers by itself.
    ///
    /// # Errors
    /// What `writer` returns.
    pub fn new(writer: W) -> std::io::Result<Self> {
        let mut writer = csv::WriterBuilder::new().has_headers(false).buffer_capacity(1 << 16).from_writer(writer);
        writer.write_record(TRAJECTORY_COLUMNS).map_err(into_io)?;
        Ok(Self { writer })
    }

    /// Adds one sample.
    ///
    /// # Errors
    /// What the underlying writer returns.
    pub fn write(&mut self, row: &TrajectoryRow) -> std::io::Result<()> {
        let r = row;
        self.writer.serialize((r.t, r.q, r.qd, r.qdd, r.jerk, r.position, r.quaternion)).map_err(into_io)
    }

    /// Writes what is still buffered. Dropping does it too, but swallows the error.
    ///
    /// # Errors
    /// What the underlying writer returns.
    pub fn finish(mut self) -> std::io::Result<()> {
        self.writer.flush()
    }
}

/// Writes a whole trajectory to a file.
///
/// # Errors
/// When the file cannot be written.
pub fn write_trajectory<I>(file: &Path, rows: I) -> Result<(), InputError>
where
    I: IntoIterator<Item = TrajectoryRow>,
{
    let write = || {
        let mut writer = TrajectoryWriter::new(BufWriter::new(File::create(file)?))?;
        for row in rows {
            writer.write(&row)?;
        }
        writer.finish()
    };
    write().map_err(|source| InputError::Write { file: file.to_owned(), source })
}

/// Reads a trajectory back; `file` is the name used in messages.
///
/// # Errors
/// When the header is not [`TRAJECTORY_COLUMNS`], or a cell is not a finite number.
pub fn read_trajectory<R: Read>(reader: R, file: &Path) -> Result<Vec<TrajectoryRow>, InputError> {
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
        if record.len() != TRAJECTORY_COLUMNS.len() {
            return Err(InputError::ColumnCount {
                file: file.to_owned(),
                line,
                found: record.len(),
                expected: TRAJECTORY_COLUMNS.len(),
                first_line: 1,
                rule: "t, then q, qd, qdd and jerk of six joints, then x y z qx qy qz qw",
            });
        }
        if line == 1 {
            if let Some(column) = record.iter().zip(TRAJECTORY_COLUMNS).position(|(a, b)| a != b) {
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
        let mut values = [0.0; 32];
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

fn row_of(v: &[f64; 32]) -> TrajectoryRow {
    let six = |from: usize| std::array::from_fn(|i| v[from + i]);
    TrajectoryRow {
        t: v[0],
        q: six(1),
        qd: six(7),
        qdd: six(13),
        jerk: six(19),
        position: [v[25], v[26], v[27]],
        quaternion: [v[28], v[29], v[30], v[31]],
    }
}

fn into_io(error: csv::Error) -> std::io::Error {
    match error.into_kind() {
        csv::ErrorKind::Io(e) => e,
        other => std::io::Error::other(format!("{other:?}")),
    }
}
