//! Arguments that motions of several axes have in common.

use arcfeed_feedrate::{AxisLimits, AxisState};
use arcfeed_sync::Synchronisation;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::array::{Array1, Table};
use crate::error::input;

/// One array of shape (n, axes) for each of position, velocity and acceleration.
pub type Arrays<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>);

/// Evaluates an expression with the number of axes as the constant `$n`; other numbers than 1 to 10 are an error.
macro_rules! for_axes {
    ($axes:expr, $n:ident => $made:expr) => {
        $crate::axes::for_axes!(@each $axes, $n, $made, 1 2 3 4 5 6 7 8 9 10)
    };
    (@each $axes:expr, $n:ident, $made:expr, $($number:literal)*) => {
        match $axes {
            $($number => {
                const $n: usize = $number;
                $made
            })*
            other => Err($crate::error::input(format!("{other} axes: give 1 to 10"))),
        }
    };
}
pub(crate) use for_axes;

/// A state of each axis, from one to three rows: position, velocity, acceleration. `like` names what has the number of axes.
pub fn states(what: &str, rows: &[Vec<f64>], axes: usize, like: &str) -> PyResult<Vec<AxisState>> {
    if !(1..=3).contains(&rows.len()) {
        return Err(input(format!("{what} has {} rows: give position, velocity, acceleration", rows.len())));
    }
    if let Some(row) = rows.iter().find(|row| row.len() != axes) {
        return Err(input(format!("{what} has a row of {} numbers, and {like} {axes}: give one an axis", row.len())));
    }
    let value = |row: usize, k: usize| rows.get(row).map_or(0.0, |values| values[k]);
    Ok((0..axes).map(|k| AxisState::new(value(0, k), value(1, k), value(2, k))).collect())
}

/// Greatest magnitudes of velocity, acceleration and jerk: a number an axis each.
pub fn limits(velocity: &[f64], acceleration: &[f64], jerk: &[f64]) -> PyResult<Vec<AxisLimits>> {
    let axes = velocity.len();
    for (what, values) in [("acceleration", acceleration), ("jerk", jerk)] {
        if values.len() != axes {
            return Err(input(format!("{what} lists {} numbers, and velocity {axes}: give one an axis", values.len())));
        }
    }
    (0..axes).map(|k| axis_limits(k, velocity[k], acceleration[k], jerk[k])).collect()
}

/// Greatest magnitudes of one axis.
pub fn axis_limits(axis: usize, velocity: f64, acceleration: f64, jerk: f64) -> PyResult<AxisLimits> {
    AxisLimits::symmetric(velocity, acceleration, jerk).map_err(|error| input(format!("axis {}: {error}", axis + 1)))
}

/// How axes move together, by its name.
pub fn synchronisation(name: &str) -> PyResult<Synchronisation> {
    match name {
        "time" => Ok(Synchronisation::Time),
        "none" => Ok(Synchronisation::None),
        "straight" => Ok(Synchronisation::StraightLine),
        "forced-straight" => Ok(Synchronisation::ForcedStraight),
        other => Err(input(format!(
            "synchronisation {other:?}: use \"time\", \"none\", \"straight\" or \"forced-straight\""
        ))),
    }
}

/// The values of `N` axes of a list that has as many.
pub fn of<T: Copy, const N: usize>(values: &[T]) -> [T; N] {
    std::array::from_fn(|k| values[k])
}

/// Position, velocity and acceleration of axes as an array (3, axes).
pub fn state_array<'py>(py: Python<'py>, states: &[AxisState]) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let mut table = Table::new(states.len(), 3);
    for value in [|s: &AxisState| s.p, |s: &AxisState| s.v, |s: &AxisState| s.a] {
        table.push(&states.iter().map(value).collect::<Vec<_>>());
    }
    table.to_array(py)
}

/// Samples of a motion at finite times (s), from what adds a row to each of the three tables.
pub fn sampled<'py>(
    py: Python<'py>,
    axes: usize,
    times: &Array1<'py>,
    mut at: impl FnMut(f64, &mut [Table; 3]),
) -> PyResult<Arrays<'py>> {
    let times = times.as_array();
    check_times(times.iter())?;
    let mut tables: [Table; 3] = std::array::from_fn(|_| Table::new(axes, times.len()));
    times.iter().for_each(|&t| at(t, &mut tables));
    let [q, qd, qdd] = &tables;
    Ok((q.to_array(py)?, qd.to_array(py)?, qdd.to_array(py)?))
}

/// Times at which a motion is sampled are finite.
pub fn check_times<'a>(times: impl Iterator<Item = &'a f64>) -> PyResult<()> {
    match times.enumerate().find(|(_, t)| !t.is_finite()) {
        Some((i, t)) => Err(input(format!("t[{i}] is {t}: give finite times, in s"))),
        None => Ok(()),
    }
}

/// The values of one cycle as an array.
pub fn row<'py>(py: Python<'py>, values: &[f64]) -> Bound<'py, PyArray1<f64>> {
    PyArray1::from_slice(py, values)
}
