//! Joint trajectories of any source in CSV: columns are known by their names.

use std::io::Read;
use std::path::{Path, PathBuf};

use arcfeed_kinematics::Joints;

use super::error::InputError;

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
    /// By how much a position can be off because the file rounds it, rad.
    pub rounding: f64,
}

/// Reads a trajectory row by row, in memory that does not grow with it.
///
/// The header names the columns, in any order: `t_s` or `t_ms`; `q1_rad` or `q1_deg` and so on for every joint; velocities
/// (`qd1_rad_s`, `qd1_deg_s`) and accelerations (`qdd1_rad_s2`, `qdd1_deg_s2`) of all joints or of none. Other columns are passed over.
pub struct RecordedRows<R, const N: usize> {
    reader: csv::Reader<R>,
    record: csv::StringRecord,
    file: PathBuf,
    columns: Columns<N>,
    line: u64,
    before: Option<f64>,
}

/// Where the values stand, and what they are multiplied with.
struct Columns<const N: usize> {
    count: usize,
    t: (usize, f64),
    joints: [Option<[(usize, f64); N]>; 3],
    ignored: Vec<String>,
}

impl<R: Read, const N: usize> RecordedRows<R, N> {
    /// Reads the header; `file` is the name used in messages.
    ///
    /// # Errors
    /// [`InputError::Empty`], [`InputError::Column`] for a column that is missing or there twice, [`InputError::Read`].
    pub fn new(reader: R, file: &Path) -> Result<Self, InputError> {
        let reader =
            csv::ReaderBuilder::new().has_headers(false).flexible(true).trim(csv::Trim::All).from_reader(reader);
        let columns = Columns { count: 0, t: (0, 1.0), joints: [None; 3], ignored: Vec::new() };
        let record = csv::StringRecord::new();
        let mut rows = Self { reader, record, file: file.to_owned(), columns, line: 0, before: None };
        if !rows.read()? {
            return Err(InputError::Empty { file: file.to_owned(), expected: "a trajectory with its header" });
        }
        rows.columns = Columns::of(&rows.record, file)?;
        Ok(rows)
    }

    /// Names of the columns that are passed over.
    pub fn ignored(&self) -> &[String] {
        &self.columns.ignored
    }

    fn read(&mut self) -> Result<bool, InputError> {
        self.line += 1;
        self.reader.read_record(&mut self.record).map_err(|error| InputError::Read {
            file: self.file.clone(),
            source: std::io::Error::other(error.to_string()),
            remedy: "give a CSV file in UTF-8",
        })
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
                first_line: 1,
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
        let places = self.columns.joints[0].iter().flatten();
        let rounding = places.map(|&(column, factor)| factor * last_digit(self.record.get(column).unwrap_or_default()));
        let rounding = rounding.fold(0.0, f64::max);
        Ok(RecordedRow { line, t, q: q.unwrap_or_else(Joints::zeros), qd, qdd, rounding })
    }
}

impl<R: Read, const N: usize> Iterator for RecordedRows<R, N> {
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
    fn of(header: &csv::StringRecord, file: &Path) -> Result<Self, InputError> {
        let wrong = |column: usize, name: &str, rule| InputError::Column {
            file: file.to_owned(),
            line: 1,
            column: column + 1,
            name: name.to_owned(),
            rule,
        };
        let mut known: Vec<(String, (usize, f64))> = Vec::new();
        let mut ignored = Vec::new();
        for (column, name) in header.iter().enumerate() {
            let name = name.trim_start_matches('\u{feff}');
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
        Ok(Self { count: header.len(), t, joints, ignored })
    }
}

/// The quantity of a column, without its unit, and the factor to SI.
fn quantity_of(name: &str) -> Option<(String, f64)> {
    let degree = std::f64::consts::PI / 180.0;
    let (quantity, unit) = name.split_once('_')?;
    let group = quantity.trim_end_matches(|c: char| c.is_ascii_digit());
    let factor = match (group, unit) {
        ("t", "s") | ("q", "rad") | ("qd", "rad_s") | ("qdd", "rad_s2") => 1.0,
        ("t", "ms") => 1e-3,
        ("q", "deg") | ("qd", "deg_s") | ("qdd", "deg_s2") => degree,
        _ => return None,
    };
    ((group == "t") == (group == quantity)).then(|| (quantity.to_owned(), factor))
}

/// Half of the last digit of a number as it is written; with 15 digits and more the rounding of a double.
fn last_digit(cell: &str) -> f64 {
    let (mantissa, exponent) = cell.split_once(['e', 'E']).unwrap_or((cell, "0"));
    let decimals = mantissa.split_once('.').map_or(0, |(_, after)| after.len());
    let digits = mantissa.chars().filter(char::is_ascii_digit).count();
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if digits >= 15 {
        return 1e-16 * (1.0 + cell.parse::<f64>().map_or(0.0, f64::abs));
    }
    0.5 * 10f64.powi(exponent - i32::try_from(decimals).unwrap_or(i32::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Vec<RecordedRow<2>>, InputError> {
        RecordedRows::<_, 2>::new(text.as_bytes(), Path::new("a.csv"))?.collect()
    }

    #[test]
    fn columns_are_known_by_name_in_any_order_and_unit() {
        let rows = read("note,q2_deg,t_ms,q1_rad\n-,90,0,0.125\n-,-45.5,10,1e-3\n").expect("rows");
        assert_eq!(rows.len(), 2);
        assert_eq!((rows[1].line, rows[1].t, rows[1].qd), (3, 0.01, None));
        assert!((rows[0].q[1] - std::f64::consts::FRAC_PI_2).abs() < 1e-15 && rows[0].q[0] == 0.125);
        // Half a degree of 90, more than half of the last digit of 0.125.
        assert!((rows[0].rounding - 0.5f64.to_radians()).abs() < 1e-15, "{}", rows[0].rounding);
        let rows = RecordedRows::<_, 1>::new("t_s,q1_rad,x_m\n".as_bytes(), Path::new("a.csv")).expect("a header");
        assert_eq!(rows.ignored(), ["x_m"]);
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (text, parts) in [
            ("", &["a.csv", "header"] as &[_]),
            ("q1_rad,q2_rad\n", &["t_s is missing"]),
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
