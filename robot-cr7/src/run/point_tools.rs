//! The orientation of the tool at the points of a file.

use nalgebra::{UnitQuaternion, Vector3};

use super::error::Cr7Error;
use super::programmed::Programmed;
use crate::input::error::InputError;
use crate::input::job::{Job, ToolOrientation};
use crate::input::path_file::{PathFile, PointTools};

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
        PointTools::Rotations(rotations) => return Ok(rotations.clone()),
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
            None => {
                return Err(InputError::Value {
                    file: file.file.clone(),
                    line: lines.get(i).and_then(|&line| usize::try_from(line).ok()),
                    key: "i, j, k".to_owned(),
                    value: format!("{:?}", axis.as_slice()),
                    rule: "the axis of the tool does not turn back between two points: the way round is not known",
                    remedy: "add points with axes in between",
                }
                .into());
            }
        };
        all.push(last);
    }
    Ok(all)
}
