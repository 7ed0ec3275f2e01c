//! Limits that depend on speed, position or payload, as tables.

use arcfeed_feedrate::Quantity;

use crate::error::LimitError;

/// A limit as a function of one argument: straight lines through points, constant before the first and after the last one.
///
/// ```
/// use arcfeed_interp::LimitTable;
/// // rad/s, rad/s^2: full acceleration up to 1 rad/s, half of it from 3 rad/s on.
/// let table = LimitTable::new(&[[1.0, 8.0], [3.0, 4.0]])?;
/// assert_eq!((table.at(0.5), table.at(2.0), table.at(9.0)), (8.0, 6.0, 4.0));
/// assert_eq!(table.least_between(0.0, 2.0), 6.0);
/// assert!(LimitTable::new(&[[1.0, 8.0], [1.0, 4.0]]).is_err());
/// # Ok::<(), arcfeed_interp::LimitError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct LimitTable {
    points: Vec<[f64; 2]>,
}

/// The rules of a table.
pub(crate) const INCREASING: &str = "arguments have to be finite and to increase from row to row: sort the rows";
pub(crate) const ABOVE_ZERO: &str = "limits have to be finite and above 0: correct the row, or leave it out";
const NOT_EMPTY: &str = "a table has one row at the least: add one, or leave out the table";

impl LimitTable {
    /// A table through points `[argument, limit]`, SI.
    ///
    /// # Errors
    /// [`LimitError::Table`] for no points, arguments that do not increase, or a limit that is not a finite number above 0.
    pub fn new(points: &[[f64; 2]]) -> Result<Self, LimitError> {
        if points.is_empty() {
            return Err(LimitError::Table { row: 0, value: f64::NAN, rule: NOT_EMPTY });
        }
        for (row, &[argument, limit]) in points.iter().enumerate() {
            let increases = row.checked_sub(1).is_none_or(|before| points[before][0] < argument);
            if !(argument.is_finite() && increases) {
                return Err(LimitError::Table { row, value: argument, rule: INCREASING });
            }
            if !(limit.is_finite() && limit > 0.0) {
                return Err(LimitError::Table { row, value: limit, rule: ABOVE_ZERO });
            }
        }
        Ok(Self { points: points.to_vec() })
    }

    /// The points `[argument, limit]`, by argument.
    pub fn points(&self) -> &[[f64; 2]] {
        &self.points
    }

    /// The limit at an argument.
    pub fn at(&self, argument: f64) -> f64 {
        let after = self.points.partition_point(|point| point[0] <= argument);
        let last = self.points.len() - 1;
        match after.checked_sub(1) {
            None => self.points[0][1],
            Some(before) if before == last => self.points[last][1],
            Some(before) => {
                let ([x0, y0], [x1, y1]) = (self.points[before], self.points[after]);
                y0 + (y1 - y0) * ((argument - x0) / (x1 - x0))
            }
        }
    }

    /// The least limit between two arguments.
    pub fn least_between(&self, from: f64, to: f64) -> f64 {
        let inside = self.points.iter().filter(|[x, _]| from <= *x && *x <= to).map(|[_, y]| *y);
        inside.fold(self.at(from).min(self.at(to)), f64::min)
    }

    /// The table with every limit times `factor`.
    ///
    /// # Errors
    /// As [`LimitTable::new`].
    pub fn scaled(&self, factor: f64) -> Result<Self, LimitError> {
        let points: Vec<[f64; 2]> = self.points.iter().map(|[x, y]| [*x, y * factor]).collect();
        Self::new(&points)
    }
}

/// A table of limits with a column for each of several payloads, as makers of robots publish it.
///
/// ```
/// use arcfeed_interp::PayloadTable;
/// // kg; then rad/s and the limits with 0 kg and with 10 kg, rad/s^2.
/// let table = PayloadTable::new(&[0.0, 10.0], &[(0.0, vec![12.0, 4.0]), (3.0, vec![6.0, 3.0])])?;
/// assert_eq!(table.with_payload(10.0)?.at(0.0), 4.0);
/// // 2 / (1/12 + 1/4): less than the mean.
/// assert!((table.with_payload(5.0)?.at(0.0) - 6.0).abs() < 1e-12);
/// assert!(table.with_payload(11.0).is_err());
/// # Ok::<(), arcfeed_interp::LimitError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct PayloadTable {
    payloads: Vec<f64>,
    rows: Vec<(f64, Vec<f64>)>,
}

impl PayloadTable {
    /// Rows of an argument and one limit for each of `payloads` (kg).
    ///
    /// # Errors
    /// [`LimitError::Table`] for payloads or arguments that do not increase, payloads below 0, limits that are not finite numbers above 0,
    /// and rows of another length.
    pub fn new(payloads: &[f64], rows: &[(f64, Vec<f64>)]) -> Result<Self, LimitError> {
        let wrong = |row, value, rule| Err(LimitError::Table { row, value, rule });
        let increase = payloads.windows(2).all(|pair| pair[0] < pair[1]);
        if let Some(&value) = payloads.iter().find(|kg| !(kg.is_finite() && **kg >= 0.0)) {
            return wrong(0, value, "payloads are finite numbers of 0 kg or more: correct them");
        }
        if payloads.is_empty() || !increase {
            return wrong(
                0,
                payloads.len() as f64,
                "payloads have to increase from column to column: sort the columns",
            );
        }
        for (row, (_, limits)) in rows.iter().enumerate() {
            if limits.len() != payloads.len() {
                return wrong(row, limits.len() as f64, "limits: a row has one for each payload: complete it");
            }
        }
        for column in 0..payloads.len() {
            let points: Vec<[f64; 2]> = rows.iter().map(|(x, limits)| [*x, limits[column]]).collect();
            LimitTable::new(&points)?;
        }
        Ok(Self { payloads: payloads.to_vec(), rows: rows.to_vec() })
    }

    /// The payloads, kg.
    pub fn payloads(&self) -> &[f64] {
        &self.payloads
    }

    /// The table for a payload (kg).
    ///
    /// Between two columns the inverse of the limit is linear in the payload, which is exact for a drive whose force is constant. The
    /// harmonic mean is never above the arithmetic one, so that the table is below linear interpolation of the limits as well. Below the
    /// least payload its column counts.
    ///
    /// # Errors
    /// [`LimitError::Payload`] for a payload beyond the last column, below 0, or not a number.
    pub fn with_payload(&self, payload: f64) -> Result<LimitTable, LimitError> {
        let most = self.payloads[self.payloads.len() - 1];
        if !(0.0..=most).contains(&payload) {
            return Err(LimitError::Payload { payload, most });
        }
        let after = self.payloads.partition_point(|kg| *kg < payload);
        let before = after.saturating_sub(1);
        let part = if before == after {
            1.0
        } else {
            (payload - self.payloads[before]) / (self.payloads[after] - self.payloads[before])
        };
        let mix = |limits: &[f64]| match part {
            1.0 => limits[after],
            _ => 1.0 / ((1.0 - part) / limits[before] + part / limits[after]),
        };
        let points: Vec<[f64; 2]> = self.rows.iter().map(|(x, limits)| [*x, mix(limits)]).collect();
        LimitTable::new(&points)
    }
}

/// What a table limits, and by what.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum TableKind {
    /// Acceleration (rad/s^2) by the magnitude of the joint's speed (rad/s).
    AccelerationBySpeed,
    /// Jerk (rad/s^3) by the magnitude of the joint's speed (rad/s).
    JerkBySpeed,
    /// Torque (N m) by the magnitude of the joint's speed (rad/s).
    TorqueBySpeed,
    /// Acceleration (rad/s^2) by the joint's position (rad).
    AccelerationByPosition,
    /// Jerk (rad/s^3) by the joint's position (rad).
    JerkByPosition,
}

impl TableKind {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::AccelerationBySpeed,
        Self::JerkBySpeed,
        Self::TorqueBySpeed,
        Self::AccelerationByPosition,
        Self::JerkByPosition,
    ];

    /// What the table limits.
    pub const fn quantity(self) -> Quantity {
        match self {
            Self::AccelerationBySpeed | Self::AccelerationByPosition => Quantity::JointAcceleration,
            Self::JerkBySpeed | Self::JerkByPosition => Quantity::JointJerk,
            Self::TorqueBySpeed => Quantity::JointTorque,
        }
    }

    /// True if the argument is a speed.
    pub const fn is_by_speed(self) -> bool {
        matches!(self, Self::AccelerationBySpeed | Self::JerkBySpeed | Self::TorqueBySpeed)
    }
}

/// Limits of joints as tables. They count beside the constant limits of [`Limits`](crate::Limits): the least holds.
///
/// ```
/// use arcfeed_interp::{JointTables, LimitTable, TableKind};
/// let falling = LimitTable::new(&[[1.0, 8.0], [3.0, 4.0]])?;
/// let tables = JointTables::<6>::new().with(TableKind::AccelerationBySpeed, 0, falling)?;
/// assert!(tables.of(TableKind::AccelerationBySpeed, 0).is_some());
/// # Ok::<(), arcfeed_interp::LimitError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct JointTables<const N: usize = 6> {
    tables: [[Option<LimitTable>; N]; 5],
}

impl<const N: usize> Default for JointTables<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> JointTables<N> {
    /// No tables yet.
    pub fn new() -> Self {
        Self { tables: std::array::from_fn(|_| std::array::from_fn(|_| None)) }
    }

    /// With a table of one joint, counted from 0, in place of one of this kind that it had. A limit by speed counts as falling: where its table rises with the speed, the least
    /// limit at lower speeds goes on.
    ///
    /// # Errors
    /// [`LimitError::NoSuchJoint`] for a joint that the arm has not, [`LimitError::Table`] for speeds below 0.
    pub fn with(mut self, kind: TableKind, joint: usize, table: LimitTable) -> Result<Self, LimitError> {
        if joint >= N {
            return Err(LimitError::NoSuchJoint { what: "a table of limits", joint, joints: N });
        }
        let first = table.points[0][0];
        if kind.is_by_speed() && first < 0.0 {
            let rule = "speeds are magnitudes of 0 or more: drop the sign";
            return Err(LimitError::Table { row: 0, value: first, rule });
        }
        self.tables[kind as usize][joint] = Some(table);
        Ok(self)
    }

    /// The table of one joint.
    pub fn of(&self, kind: TableKind, joint: usize) -> Option<&LimitTable> {
        self.tables[kind as usize].get(joint)?.as_ref()
    }

    /// True if some joint has a table of this kind.
    pub fn has(&self, kind: TableKind) -> bool {
        self.tables[kind as usize].iter().any(Option::is_some)
    }

    /// True without any table.
    pub fn is_empty(&self) -> bool {
        !TableKind::ALL.into_iter().any(|kind| self.has(kind))
    }

    /// The tables with those of some kinds of one joint times `factor`.
    ///
    /// # Errors
    /// [`LimitError::Table`] where a limit leaves the range of numbers.
    pub fn scaled(&self, kinds: &[TableKind], joint: usize, factor: f64) -> Result<Self, LimitError> {
        let mut scaled = self.clone();
        for kind in kinds {
            if let Some(table) = self.of(*kind, joint) {
                scaled.tables[*kind as usize][joint] = Some(table.scaled(factor)?);
            }
        }
        Ok(scaled)
    }
}
