//! Limits as tables, and vibrations, in a job.

use arcfeed_interp::{LimitTable, Oscillator, PayloadTable, TableKind};

use super::error::InputError;
use super::job::{TableJob, VibrationJob};
use super::job_file::{RawColumns, RawJob, RawTable, RawVibration};
use super::job_reader::JobCheck;

/// Degrees per radian.
const PER_RADIAN: f64 = 180.0 / std::f64::consts::PI;

impl JobCheck<'_> {
    /// The limits as tables, for the payload of the job.
    pub(crate) fn tables(&self, raw: &RawJob) -> Result<Vec<TableJob>, InputError> {
        if let (None, Some(i)) = (raw.torque.payload_kg, raw.tables.iter().position(|table| table.payload_kg.is_some()))
        {
            let rule = "a table with payloads is for the payload of the job";
            return Err(self.0.wrong(
                &format!("tables[{i}].payload_kg"),
                "given",
                rule,
                "give torque.payload_kg, 0 for none",
            ));
        }
        let payload = raw.torque.payload_kg.unwrap_or(0.0);
        let tables: Vec<TableJob> = raw
            .tables
            .iter()
            .enumerate()
            .map(|(i, table)| self.table(i, table, payload, raw))
            .collect::<Result<_, _>>()?;
        for (i, table) in tables.iter().enumerate() {
            let same = |other: &TableJob| {
                other.kind == table.kind
                    && (other.joint == table.joint || other.joint.is_none() || table.joint.is_none())
            };
            if let Some(before) = tables[..i].iter().position(same) {
                let rule = "a joint has one table of a kind";
                let value = format!("for a joint and a limit that tables[{before}] has too");
                return Err(self.0.wrong(
                    &format!("tables[{i}]"),
                    value,
                    rule,
                    "make one table of both, with the least limits",
                ));
            }
        }
        Ok(tables)
    }

    fn table(&self, index: usize, raw: &RawTable, payload: f64, job: &RawJob) -> Result<TableJob, InputError> {
        let key = |name: &str| format!("tables[{index}].{name}");
        let joint = self.joint(&key("joint"), raw.joint)?;
        let (by_speed, argument, arguments) = match (&raw.speed_deg_s, &raw.position_deg) {
            (Some(speeds), None) => (true, "speed_deg_s", speeds),
            (None, Some(positions)) => (false, "position_deg", positions),
            _ => {
                let rule = "a table has one argument: speed_deg_s or position_deg";
                return Err(self.0.wrong(
                    &format!("tables[{index}]"),
                    "not one of them",
                    rule,
                    "give exactly one of the two",
                ));
            }
        };
        let given = [
            ("acceleration_deg_s2", &raw.acceleration_deg_s2),
            ("jerk_deg_s3", &raw.jerk_deg_s3),
            ("torque_nm", &raw.torque_nm),
        ];
        let mut limits = given.into_iter().filter_map(|(name, columns)| Some((name, columns.as_ref()?)));
        let (Some((name, columns)), None) = (limits.next(), limits.next()) else {
            let rule = "a table limits one thing: acceleration_deg_s2, jerk_deg_s3 or torque_nm";
            return Err(self.0.wrong(
                &format!("tables[{index}]"),
                "not one of them",
                rule,
                "give exactly one of the three",
            ));
        };
        let kind = match (name, by_speed) {
            ("acceleration_deg_s2", true) => TableKind::AccelerationBySpeed,
            ("acceleration_deg_s2", false) => TableKind::AccelerationByPosition,
            ("jerk_deg_s3", true) => TableKind::JerkBySpeed,
            ("jerk_deg_s3", false) => TableKind::JerkByPosition,
            (_, true) => TableKind::TorqueBySpeed,
            (_, false) => {
                let rule = "torque is limited by speed";
                return Err(self.0.wrong(
                    &key("torque_nm"),
                    "by position",
                    rule,
                    "give speed_deg_s in place of position_deg",
                ));
            }
        };
        if kind == TableKind::TorqueBySpeed && !job.torque.limited.unwrap_or(job.torque.limit_nm.is_some()) {
            let rule = "a table of torque counts only where the torque is limited";
            return Err(self.0.wrong(
                &key("torque_nm"),
                "given",
                rule,
                "add torque.limited = true, or remove the table",
            ));
        }
        self.arguments(&key(argument), arguments, by_speed)?;
        let arguments: Vec<f64> = arguments.iter().map(|degrees| degrees / PER_RADIAN).collect();
        let per_si = if kind == TableKind::TorqueBySpeed { 1.0 } else { PER_RADIAN };
        let columns = self.columns(&key(name), columns, arguments.len(), per_si)?;
        let table = self.for_payload(index, raw, &arguments, &columns, payload)?;
        Ok(TableJob { joint, kind, table })
    }

    /// A joint as a job counts them, from 1.
    fn joint(&self, key: &str, joint: Option<i64>) -> Result<Option<usize>, InputError> {
        let Some(number) = joint else { return Ok(None) };
        match usize::try_from(number).ok().and_then(|number| number.checked_sub(1)) {
            Some(joint) => Ok(Some(joint)),
            None => {
                Err(self.0.wrong(key, number, "joints count from 1", "give the number of a joint, or remove the key"))
            }
        }
    }

    fn arguments(&self, key: &str, arguments: &[f64], by_speed: bool) -> Result<(), InputError> {
        if arguments.is_empty() {
            return Err(self.0.wrong(key, "[]", "a table has one row at the least", "add a row, or remove the table"));
        }
        for (row, &value) in arguments.iter().enumerate() {
            let key = format!("{key}[{row}]");
            if !value.is_finite() || by_speed && value < 0.0 {
                let rule =
                    if by_speed { "a speed is a finite number, 0 or more" } else { "it has to be a finite number" };
                return Err(self.0.wrong(&key, value, rule, "write a plain number"));
            }
            if row > 0 && arguments[row - 1] >= value {
                return Err(self.0.wrong(
                    &key,
                    value,
                    "arguments increase from row to row",
                    "sort the rows of the table",
                ));
            }
        }
        Ok(())
    }

    /// The limits, column by column, SI.
    fn columns(&self, key: &str, raw: &RawColumns, rows: usize, per_si: f64) -> Result<Vec<Vec<f64>>, InputError> {
        let (columns, nested) = match raw {
            RawColumns::One(column) => (vec![column.clone()], false),
            RawColumns::PerPayload(columns) => (columns.clone(), true),
        };
        let mut all = Vec::with_capacity(columns.len());
        for (i, column) in columns.iter().enumerate() {
            let key = if nested { format!("{key}[{i}]") } else { key.to_owned() };
            if column.len() != rows {
                let value = format!("{} limits for {rows} arguments", column.len());
                let rule = "a table has one limit for each speed or position";
                return Err(self.0.wrong(&key, value, rule, "give both lists the same length"));
            }
            let mut limits = Vec::with_capacity(rows);
            for (row, &value) in column.iter().enumerate() {
                limits.push(self.0.limit_or(&format!("{key}[{row}]"), Some(value), per_si, value)?);
            }
            all.push(limits);
        }
        Ok(all)
    }

    fn for_payload(
        &self,
        index: usize,
        raw: &RawTable,
        arguments: &[f64],
        columns: &[Vec<f64>],
        payload: f64,
    ) -> Result<LimitTable, InputError> {
        let key = format!("tables[{index}].payload_kg");
        let table = |column: &[f64]| {
            let points: Vec<[f64; 2]> =
                arguments.iter().copied().zip(column.iter().copied()).map(|(x, y)| [x, y]).collect();
            LimitTable::new(&points).map_err(|error| {
                let rule = "a table has limits above 0 at increasing arguments";
                self.0.wrong(&format!("tables[{index}]"), error, rule, "correct the table")
            })
        };
        let Some(payloads) = &raw.payload_kg else {
            return match columns {
                [column] => table(column),
                _ => {
                    let value = format!("missing for {} lists of limits", columns.len());
                    let rule = "several lists of limits are for several payloads";
                    Err(self.0.wrong(&key, value, rule, "add the key with one mass for each list, or give one list"))
                }
            };
        };
        if payloads.len() != columns.len() {
            let value = format!("{} payloads for {} lists of limits", payloads.len(), columns.len());
            return Err(self.0.wrong(
                &key,
                value,
                "each payload has a list of limits",
                "give one list for each payload",
            ));
        }
        let row = |i: usize| (arguments[i], columns.iter().map(|column| column[i]).collect::<Vec<f64>>());
        let rows: Vec<(f64, Vec<f64>)> = (0..arguments.len()).map(row).collect();
        let all = PayloadTable::new(payloads, &rows).map_err(|_| {
            let rule = "payloads are finite numbers of 0 or more that increase";
            self.0.wrong(&key, format!("{payloads:?}"), rule, "sort the payloads, each with its list of limits")
        })?;
        all.with_payload(payload).map_err(|_| {
            let rule = "the payload of the job has to be within those of each table";
            let most = payloads.last().copied().unwrap_or_default();
            let value = format!("{payload} above {most} of {key}");
            self.0.wrong("torque.payload_kg", value, rule, "take off load, or add a list of limits for this payload")
        })
    }

    /// The vibrations that are reported, and kept small where the job says so.
    pub(crate) fn vibrations(&self, raw: &RawJob) -> Result<Vec<VibrationJob>, InputError> {
        raw.vibration.iter().enumerate().map(|(i, vibration)| self.vibration(i, vibration)).collect()
    }

    fn vibration(&self, index: usize, raw: &RawVibration) -> Result<VibrationJob, InputError> {
        let key = |name: &str| format!("vibration[{index}].{name}");
        let joint = self.joint(&key("joint"), raw.joint)?;
        let Some(frequency) = raw.frequency_hz else {
            let rule = "a vibration has a natural frequency";
            return Err(self.0.wrong(&key("frequency_hz"), "missing", rule, "add the key, or remove the vibration"));
        };
        let damping = raw.damping.unwrap_or(0.0);
        if Oscillator::new(frequency, 0.0).is_err() {
            let rule = "a natural frequency is from 0.001 to 10000";
            return Err(self.0.wrong(&key("frequency_hz"), frequency, rule, "give the frequency in Hz"));
        }
        let oscillator = Oscillator::new(frequency, damping).map_err(|_| {
            let rule = "damping is a part of the critical one, from 0 to below 1";
            self.0.wrong(&key("damping"), damping, rule, "write 0.02 for 2 %")
        })?;
        let unsuited = |name: &str, rule, remedy| Err(self.0.wrong(&key(name), "given", rule, remedy));
        let limit = match (joint, raw.residual_limit_deg, raw.residual_limit_mm) {
            (None, Some(_), _) => {
                let rule = "the tool is deflected by a length";
                return unsuited("residual_limit_deg", rule, "give residual_limit_mm, or the number of a joint");
            }
            (Some(_), _, Some(_)) => {
                let rule = "a joint is deflected by an angle";
                return unsuited("residual_limit_mm", rule, "give residual_limit_deg, or remove joint for the tool");
            }
            (Some(_), degrees, None) => self.0.limit(&key("residual_limit_deg"), degrees, PER_RADIAN)?,
            (None, None, mm) => self.0.limit(&key("residual_limit_mm"), mm, 1e3)?,
        };
        Ok(VibrationJob { joint, oscillator, limit })
    }
}
