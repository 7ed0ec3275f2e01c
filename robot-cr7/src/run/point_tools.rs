//! The orientation of the tool at the points of a file.

use arcfeed_geometry::OrientationPath;
use nalgebra::{UnitQuaternion, Vector3};

use super::error::Cr7Error;
use super::programmed::Programmed;
use crate::input::error::InputError;
use crate::input::job::{Job, ToolOrientation};
use crate::input::path_file::{PathFile, PointTools};
use crate::text::number;

/// An angle between two orientations that is as good as half a turn, rad.
const HALF_TURN: f64 = std::f64::consts::PI - 1e-3;
/// Places looked at between two points, and how far the orientation may be off there: a part of the turn, and an angle in rad.
const LOOKS: i32 = 8;
const PART: f64 = 0.25;
const LEAST_SWING: f64 = std::f64::consts::PI / 180.0;
/// Cosine of the angle between two axes that are as good as opposite.
const OPPOSITE: f64 = -1.0 + 1e-6;

/// Orientations in the workpiece frame at the points of a file, each on a line of it.
///
/// Where the file has the axis of the tool alone, the first orientation is that of the job, turned the shortest way onto the axis, and each
/// further one that before it, turned likewise: the tool does not turn about its axis.
///
/// # Errors
/// [`InputError::Value`] where the job turns the tool, too, or the axis turns back from one point to the next.
pub(crate) fn orientations(
    file: &PathFile,
    tools: &PointTools,
    lines: &[u64],
    job: &Job,
) -> Result<Vec<UnitQuaternion<f64>>, Cr7Error> {
    let ToolOrientation::Constant(first) = job.orientation else {
        return Err(Programmed::turns_twice(&file.file).into());
    };
    let axes = match tools {
        PointTools::Rotations(rotations) => {
            let back = rotations.windows(2).position(|pair| pair[0].angle_to(&pair[1]) > HALF_TURN);
            return match back {
                Some(i) => Err(turns_back(file, lines, i + 1, "qx, qy, qz, qw", rotations[i + 1].coords.as_slice())),
                None => Ok(rotations.clone()),
            };
        }
        PointTools::Axes(axes) => axes,
    };
    let mut last = first;
    let mut all = Vec::with_capacity(axes.len());
    for (i, axis) in axes.iter().enumerate() {
        let (now, wanted) = (last * Vector3::z(), -axis.into_inner());
        let shortest = UnitQuaternion::rotation_between(&now, &wanted).filter(|_| now.dot(&wanted) > OPPOSITE);
        last = match shortest {
            Some(turn) => turn * last,
            // The opposite: at the start half a turn about the tool's own x axis.
            None if i == 0 => last * UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI),
            None => return Err(turns_back(file, lines, i, "i, j, k", axis.as_slice())),
        };
        all.push(last);
    }
    Ok(all)
}

fn turns_back(file: &PathFile, lines: &[u64], i: usize, key: &str, value: &[f64]) -> Cr7Error {
    let error = InputError::Value {
        file: file.file.clone(),
        line: lines.get(i).and_then(|&line| usize::try_from(line).ok()),
        key: key.to_owned(),
        value: format!("{value:?}"),
        rule: "the tool does not turn back between two points: the way round is not known",
        remedy: "add points in between",
    };
    error.into()
}

/// Holds that the spline through orientations stays near the shortest turn from each one to the next: within a quarter of its angle and
/// one degree.
///
/// # Errors
/// [`InputError::Value`] with the line of the point behind which it leaves it farthest.
pub(crate) fn check_swing(
    path: &OrientationPath,
    keys: &[(f64, UnitQuaternion<f64>)],
    file: &PathFile,
    lines: &[u64],
) -> Result<(), Cr7Error> {
    let swing = |pair: &[(f64, UnitQuaternion<f64>)]| {
        let [(from, first), (to, second)] = [pair[0], pair[1]];
        let turn = (first.inverse() * second).scaled_axis();
        let off = |k: i32| {
            let part = f64::from(k) / f64::from(LOOKS);
            let straight = first * UnitQuaternion::from_scaled_axis(turn * part);
            path.jet(from + (to - from) * part).rotation.angle_to(&straight)
        };
        let farthest = (1..LOOKS).map(off).fold(0.0, f64::max);
        (farthest, farthest / (PART * turn.norm() + LEAST_SWING))
    };
    let swings = keys.windows(2).map(swing).enumerate();
    let Some((i, (angle, _))) = swings.filter(|(_, (_, part))| *part > 1.0).max_by(|a, b| a.1.1.total_cmp(&b.1.1))
    else {
        return Ok(());
    };
    Err(InputError::Value {
        file: file.file.clone(),
        line: lines.get(i).and_then(|&line| usize::try_from(line).ok()),
        key: "the smooth orientation through the points".to_owned(),
        value: format!("{} deg beside the shortest turn to the next point", number(angle.to_degrees())),
        rule: "it may leave the shortest turn from point to point by a quarter of its angle and one degree",
        remedy: "give more points where the tool turns, or set path.through = \"polyline\"",
    }
    .into())
}
