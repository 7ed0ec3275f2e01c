//! Joint trajectories of any source in CSV: columns are known by their names.

use std::io::{BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use arcfeed_kinematics::Joints;

use super::csv_points::cells_of;
use super::error::InputError;
use super::named_column::NamedColumn;

const RULE: &str = "the columns are t_s or t_ms, and of every joint q1_rad or q1_deg; also known are qd1_rad_s, qd1_deg_s, \
                    qdd1_rad_s2, qdd1_deg_s2";

/// One row: a moment of a joint motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecordedRow<const N: usize> {
    /// Line of the file, from 1.
    pub line: u64,
    /// Time, s.
    pub t: f64,
    /// Joint positions, rad.
    pub q: Joints<N>,
    /// Joint velocities, rad/s, where the file has them.
    pub qd: Option<Joints<N>>,
    /// Joint accelerations, rad/s^2, where the file has them.
    pub qdd: Option<Joints<N>>,
}

/// By how much values can be off because the file rounds them: half of the last digit of the column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecordedRounding<const N: usize> {
    /// Time, s.
    pub t: f64,
    /// Joint positions (rad), velocities (rad/s) and accelerations (rad/s^2).
    pub joints: [Joints<N>; 3],
}

/// Reads a trajectory row by row, in memory that does not grow with it. The file is read twice: first for the digits of each column.
///
/// The header names the columns, in any order: `t_s` or `t_ms`; `q1_rad` or `q1_deg` and so on for every joint; velocities
/// (`qd1_rad_s`, `qd1_deg_s`) and accelerations (`qdd1_rad_s2`, `qdd1_deg_s2`) of all joints or of none. The name of a joint may stand behind
/// a colon (`q1_rad:shoulder`). Other columns are passed over, and so are blank lines, which count in the line numbers of messages.
pub struct RecordedRows<R, const N: usize> {
    reader: BufReader<R>,
    /// The last line that was read.
    text: String,
    /// Its number, from 1.
    line: u64,
    /// Its cells.
    record: csv::StringRecord,
    file: PathBuf,
    columns: Columns<N>,
    rounding: RecordedRounding<N>,
    before: Option<f64>,
}

/// Where the values stand, and what they are multiplied with.
struct Columns<const N: usize> {
    /// The line of the header.
    line: u64,
    count: usize,
    t: (usize, f64),
    joints: [Option<[(usize, f64); N]>; 3],
    named: Vec<NamedColumn>,
    ignored: Vec<String>,
}

impl<R: Read + Seek, const N: usize> RecordedRows<R, N> {
    /// Reads the header; `file` is the name used in messages.
    ///
    /// # Errors
    /// [`InputError::Empty`], [`InputError::Column`] for a column that is missing or there twice, [`InputError::Read`].
    pub fn new(reader: R, file: &Path) -> Result<Self, InputError> {
        let (reader, text) = (BufReader::new(reader), String::new());
        let columns =
            Columns { line: 0, count: 0, t: (0, 1.0), joints: [None; 3], named: Vec::new(), ignored: Vec::new() };
        let record = csv::StringRecord::new();
        let rounding = RecordedRounding { t: 0.0, joints: [Joints::zeros(); 3] };
        let mut rows = Self { reader, text, line: 0, record, file: file.to_owned(), columns, rounding, before: None };
        if !rows.read()? {
            return Err(InputError::Empty { file: file.to_owned(), expected: "a trajectory with its header" });
        }
        rows.columns = Columns::of(&rows.record, rows.line, file)?;
        let line = rows.line;
        let data = rows.reader.stream_position().map_err(|error| rows.unreadable(error))?;
        rows.rounding = rows.digits()?;
        rows.reader.seek(SeekFrom::Start(data)).map_err(|error| rows.unreadable(error))?;
        rows.line = line;
        Ok(rows)
    }

    /// By how much the values of the file can be off.
    pub fn rounding(&self) -> RecordedRounding<N> {
        self.rounding
    }

    /// The rounding of each column, from all of its cells: zeros behind the last digit may be left out in some.
    fn digits(&mut self) -> Result<RecordedRounding<N>, InputError> {
        let none = Digits::default();
        let (mut t, mut joints) = (none, [[none; N]; 3]);
        while self.read()? {
            t.see(self.record.get(self.columns.t.0).unwrap_or_default());
            for (digits, columns) in joints.iter_mut().zip(&self.columns.joints) {
                for (digits, (column, _)) in digits.iter_mut().zip(columns.iter().flatten()) {
                    digits.see(self.record.get(*column).unwrap_or_default());
                }
            }
        }
        let factor = |group: usize, k: usize| self.columns.joints[group].map_or(0.0, |columns| columns[k].1);
        let of_joints = |group: usize| Joints::from_fn(|k, _| factor(group, k) * joints[group][k].rounding());
        Ok(RecordedRounding { t: self.columns.t.1 * t.rounding(), joints: std::array::from_fn(of_joints) })
    }

    fn unreadable(&self, source: std::io::Error) -> InputError {
        InputError::Read { file: self.file.clone(), source, remedy: "give a CSV file in UTF-8" }
    }

    /// The columns that name a joint of the arm, in the order of the file.
    pub fn named_columns(&self) -> &[NamedColumn] {
        &self.columns.named
    }

    /// Names of the columns that are passed over.
    pub fn ignored(&self) -> &[String] {
        &self.columns.ignored
    }

    /// Reads the cells of the next line that is not blank.
    fn read(&mut self) -> Result<bool, InputError> {
        loop {
            self.text.clear();
            if self.reader.read_line(&mut self.text).map_err(|error| self.unreadable(error))? == 0 {
                return Ok(false);
            }
            self.line += 1;
            let row = self.text.trim();
            if row.is_empty() {
                continue;
            }
            self.record.clear();
            if row.contains('"') {
                self.record.extend(cells_of(row));
            } else {
                self.record.extend(row.split(',').map(str::trim));
            }
            return Ok(true);
        }
    }

    fn number(&self, (column, factor): (usize, f64)) -> Result<f64, InputError> {
        let cell = self.record.get(column).unwrap_or_default();
        cell.parse::<f64>().ok().filter(|v| v.is_finite()).map(|v| v * factor).ok_or_else(|| InputError::Cell {
            file: self.file.clone(),
            line: self.line,
            column: column + 1,
            cell: cell.to_owned(),
            remedy: "write a finite number",
        })
    }

    fn row(&mut self) -> Result<RecordedRow<N>, InputError> {
        let (file, line) = (self.file.clone(), self.line);
        if self.record.len() != self.columns.count {
            let (found, expected) = (self.record.len(), self.columns.count);
            return Err(InputError::ColumnCount {
                file,
                line,
                found,
                expected,
                first_line: self.columns.line,
                rule: "a cell a column",
            });
        }
        let t = self.number(self.columns.t)?;
        if self.before.is_some_and(|before| t <= before) {
            return Err(InputError::Value {
                file,
                line: usize::try_from(line).ok(),
                key: "the time".to_owned(),
                value: format!("{t} s"),
                rule: "times increase from row to row",
                remedy: "remove rows that are there twice, or sort them",
            });
        }
        self.before = Some(t);
        let mut values = [None; 3];
        for (value, columns) in values.iter_mut().zip(self.columns.joints) {
            let Some(columns) = columns else { continue };
            let mut of_joints = Joints::zeros();
            for (k, column) in columns.into_iter().enumerate() {
                of_joints[k] = self.number(column)?;
            }
            *value = Some(of_joints);
        }
        let [q, qd, qdd] = values;
        Ok(RecordedRow { line, t, q: q.unwrap_or_else(Joints::zeros), qd, qdd })
    }
}

impl<R: Read + Seek, const N: usize> Iterator for RecordedRows<R, N> {
    type Item = Result<RecordedRow<N>, InputError>;

    fn next(&mut self) -> Option<Self::Item> {
        match self.read() {
            Ok(true) => Some(self.row()),
            Ok(false) => None,
            Err(error) => Some(Err(error)),
        }
    }
}

impl<const N: usize> Columns<N> {
    /// The columns that a header names, which is at `line`.
    fn of(header: &csv::StringRecord, line: u64, file: &Path) -> Result<Self, InputError> {
        let wrong = |column: usize, name: &str, rule| InputError::Column {
            file: file.to_owned(),
            line,
            column: column + 1,
            name: name.to_owned(),
            rule,
        };
        let mut known: Vec<(String, (usize, f64))> = Vec::new();
        let (mut ignored, mut named) = (Vec::new(), Vec::new());
        for (column, name) in header.iter().enumerate() {
            let name = name.trim_start_matches('\u{feff}');
            named.extend(NamedColumn::of(name).filter(|column| column.joint < N));
            let Some((quantity, factor)) = quantity_of(name) else {
                ignored.push(name.to_owned());
                continue;
            };
            if known.iter().any(|(other, _)| *other == quantity) {
                return Err(wrong(column, name, "a quantity has one column"));
            }
            known.push((quantity, (column, factor)));
        }
        let find = |quantity: &str| known.iter().find(|(other, _)| other == quantity).map(|(_, place)| *place);
        let missing = |name: &str| wrong(header.len(), &format!("{name} is missing"), RULE);
        let t = find("t").ok_or_else(|| missing("t_s"))?;
        let mut joints = [None; 3];
        for (found, group) in joints.iter_mut().zip(["q", "qd", "qdd"]) {
            let places: [_; N] = std::array::from_fn(|k| find(&format!("{group}{}", k + 1)));
            let some = places.iter().any(Option::is_some);
            if !some && group != "q" {
                continue;
            }
            let mut whole = [(0, 1.0); N];
            for (k, (whole, place)) in whole.iter_mut().zip(places).enumerate() {
                *whole = place.ok_or_else(|| missing(&format!("{group}{}", k + 1)))?;
            }
            *found = Some(whole);
        }
        // A file of an arm with more joints is of another arm.
        if let Some((name, (column, _))) = known.iter().find(|(name, _)| *name == format!("q{}", N + 1)) {
            return Err(wrong(
                *column,
                name,
                "the arm has fewer joints: name the one that the file is of with --robot",
            ));
        }
        Ok(Self { line, count: header.len(), t, joints, named, ignored })
    }
}

/// The quantity of a column, without its unit and the name of its joint, and the factor to SI.
fn quantity_of(name: &str) -> Option<(String, f64)> {
    let degree = std::f64::consts::PI / 180.0;
    let (column, joint) = name.split_once(':').map_or((name, None), |(column, joint)| (column, Some(joint)));
    let (quantity, unit) = column.split_once('_')?;
    let group = quantity.trim_end_matches(|c: char| c.is_ascii_digit());
    let factor = match (group, unit) {
        ("t", "s") | ("q", "rad") | ("qd", "rad_s") | ("qdd", "rad_s2") => 1.0,
        ("t", "ms") => 1e-3,
        ("q", "deg") | ("qd", "deg_s") | ("qdd", "deg_s2") => degree,
        _ => return None,
    };
    // The time has neither a number nor the name of a joint.
    let is_time = group == "t";
    (is_time == (group == quantity) && !(is_time && joint.is_some())).then(|| (quantity.to_owned(), factor))
}

/// The digits of a column.
#[derive(Debug, Clone, Copy, Default)]
struct Digits {
    /// Decimals behind the point, at the most; `None` before the first number.
    decimals: Option<i32>,
    /// The greatest value.
    size: f64,
}

impl Digits {
    fn see(&mut self, cell: &str) {
        let Some(value) = cell.parse::<f64>().ok().filter(|v| v.is_finite()) else { return };
        let (mantissa, exponent) = cell.split_once(['e', 'E']).unwrap_or((cell, "0"));
        let decimals = mantissa.split_once('.').map_or(0, |(_, after)| after.len());
        // A zero tells no more with an exponent.
        let exponent = if value == 0.0 { 0 } else { exponent.parse::<i32>().unwrap_or(0).clamp(-400, 400) };
        let decimals = i32::try_from(decimals).unwrap_or(400).min(400) - exponent;
        self.decimals = Some(self.decimals.map_or(decimals, |most| most.max(decimals)));
        self.size = self.size.max(value.abs());
    }

    /// Half of the last digit, and no less than the rounding of a double.
    fn rounding(self) -> f64 {
        self.decimals.map_or(0.0, |decimals| (0.5 * 10f64.powi(-decimals)).max(f64::EPSILON * self.size))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Vec<RecordedRow<2>>, InputError> {
        RecordedRows::<_, 2>::new(std::io::Cursor::new(text), Path::new("a.csv"))?.collect()
    }

    #[test]
    fn columns_are_known_by_name_in_any_order_and_unit() {
        let rows = read("note,q2_deg,t_ms,q1_rad\n-,90,0,0.125\n-,-45.5,10,1e-3\n").expect("rows");
        assert_eq!(rows.len(), 2);
        assert_eq!((rows[1].line, rows[1].t, rows[1].qd), (3, 0.01, None));
        assert!((rows[0].q[1] - std::f64::consts::FRAC_PI_2).abs() < 1e-15 && rows[0].q[0] == 0.125);
        let rows =
            RecordedRows::<_, 1>::new(std::io::Cursor::new("t_s,q1_rad,x_m\n"), Path::new("a.csv")).expect("a header");
        assert_eq!(rows.ignored(), ["x_m"]);
    }

    #[test]
    fn the_longest_cell_of_a_column_tells_its_rounding() {
        let text = "t_s,q1_rad,q2_deg\n0,0.0,1\n0.001,0.0001234,-2.5\n0.002,1e-3,0e2147483647\n";
        let rows = RecordedRows::<_, 2>::new(std::io::Cursor::new(text), Path::new("a.csv")).expect("a header");
        let RecordedRounding { t, joints: [q, qd, _] } = rows.rounding();
        assert!((t - 0.0005).abs() < 1e-12 && (q[0] - 0.5e-7).abs() < 1e-20, "{t} {q}");
        assert!((q[1] - 0.05f64.to_radians()).abs() < 1e-12 && qd[0] == 0.0, "{q} {qd}");
        assert_eq!(rows.count(), 3);
    }

    #[test]
    fn the_name_of_a_joint_may_stand_behind_a_colon() {
        let text = "t_s,q2_deg:fore:arm,q1_rad,qd1_rad_s:upper arm,qd2_rad_s\n0,90,1,2,3\n";
        let mut rows = RecordedRows::<_, 2>::new(std::io::Cursor::new(text), Path::new("a.csv")).expect("a header");
        let named =
            |column: &str, joint, name: &str| NamedColumn { column: column.to_owned(), joint, name: name.to_owned() };
        assert_eq!(rows.named_columns(), &[named("q2_deg", 1, "fore:arm"), named("qd1_rad_s", 0, "upper arm")]);
        let row = rows.next().expect("a row").expect("numbers");
        assert!(row.q[0] == 1.0 && (row.q[1] - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
        assert_eq!(row.qd.map(|qd| (qd[0], qd[1])), Some((2.0, 3.0)));
    }

    #[test]
    fn blank_lines_count() {
        for end in ["\n", "\r\n"] {
            let text =
                ["", "t_s,q1_rad,q2_rad,\"a, b\"", "  ", "0,1,1,", "", "", "1,1,1,\"x, y\"", "", "1,2,2,"].join(end);
            let rows = RecordedRows::<_, 2>::new(std::io::Cursor::new(&text), Path::new("a.csv")).expect("a header");
            assert_eq!(rows.ignored(), ["a, b"]);
            let rows: Vec<_> = rows.collect();
            let lines: Vec<u64> = rows.iter().flatten().map(|row| row.line).collect();
            assert_eq!(lines, [4, 7], "{text:?}");
            let error = rows[2].as_ref().expect_err("the time stands").to_string();
            assert!(error.contains(":9"), "{error}");
            let error = read(&text.replace("0,1,1,", "0,1")).expect_err("cells are missing").to_string();
            assert!(error.contains(":4") && error.contains("line 2"), "{error}");
            let error = read(&text.replace("q2_rad", "q3_rad")).expect_err("no q2").to_string();
            assert!(error.contains(":2"), "{error}");
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (text, parts) in [
            ("", &["a.csv", "header"] as &[_]),
            ("q1_rad,q2_rad\n", &["t_s is missing"]),
            ("t_s:shoulder,q1_rad,q2_rad\n", &["t_s is missing"]),
            ("t_s,q1_rad\n", &["q2 is missing"]),
            ("t_s,q1_rad,q2_rad,qd1_rad_s\n", &["qd2 is missing"]),
            ("t_s,q1_rad,q1_deg,q2_rad\n", &["q1_deg", "one column"]),
            ("t_s,q1_rad,q2_rad,q3_rad\n", &["q3", "--robot"]),
            ("t_s,q1_rad,q2_rad\n0,1\n", &[":2", "3"]),
            ("t_s,q1_rad,q2_rad\n0,1,nan\n", &[":2", "nan", "finite"]),
            ("t_s,q1_rad,q2_rad\n0,1,1\n0,1,1\n", &[":3", "increase"]),
        ] {
            let error = read(text).expect_err(text).to_string();
            assert!(parts.iter().all(|part| error.contains(part)), "{text}: {error}");
        }
    }
}
