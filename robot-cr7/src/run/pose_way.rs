//! The way of an arm between the two places of a [`ScheduleFile`], in the joints that the file asks for.

use std::f64::consts::TAU;

use arcfeed_geometry::PoseMotion;
use arcfeed_interp::{MotionPath, PathError, PoseMove};
use arcfeed_kinematics::{Arm, ForwardKinematics, Joints};

use super::error::Cr7Error;
use super::plan_error::plan_error;
use crate::input::joint_values::JointValues;
use crate::input::schedule_file::{ScheduleFile, SchedulePlace};
use crate::text::number;

/// Joints that differ by less are the same, rad: more than an inverse leaves near a singular pose.
const SAME: f64 = 1e-6;
/// Steps in which a motion is followed to its end.
const STEPS: usize = 256;

/// The path from one place to the other. A tool motion keeps the configuration of the arm: joints
/// given at the goal choose that of the start, where the file leaves it open.
///
/// # Errors
/// [`Cr7Error::Input`] for joints outside their range, [`Cr7Error::Configuration`] for joints that
/// the motion does not lead to, [`Cr7Error::Plan`] where the arm cannot follow.
pub(crate) fn pose_way<'a>(
    file: &ScheduleFile,
    arm: &'a Arm<6>,
    places: [&SchedulePlace; 2],
    near: Option<&JointValues>,
) -> Result<PoseMove<'a>, Cr7Error> {
    let failed = |source: PathError| plan_error(&file.file.display().to_string(), source.into());
    let ends = [joints(file, arm, KEYS[0], places[0])?, joints(file, arm, KEYS[1], places[1])?];
    let poses = [0, 1].map(|i| match (places[i], &ends[i]) {
        (SchedulePlace::Pose(pose), _) => *pose,
        (SchedulePlace::Joints(_), q) => arm.forward(&q.unwrap_or_default()),
    });
    let motion = PoseMotion::new(&poses[0], &poses[1]).map_err(|e| failed(e.into()))?;
    let near = near.map(|near| file.of::<6>("start.near_deg", near)).transpose()?.map(Joints::from);
    let path = match (near, ends[1]) {
        (Some(near), _) => PoseMove::starting_near(arm, motion, &near).map_err(failed)?,
        (None, Some(goal)) => {
            let back = PoseMotion::new(&poses[1], &poses[0]).map_err(|e| failed(e.into()))?;
            let start = PoseMove::starting_near(arm, back, &goal).and_then(|back| followed(&back)).map_err(|e| {
                let problem = format!("the tool cannot be led back from these joints to [start]: {e}");
                configuration(file, KEYS[1], problem)
            })?;
            PoseMove::starting_near(arm, motion, &start).map_err(failed)?
        }
        (None, None) => PoseMove::new(arm, motion, arm.range()).map_err(failed)?,
    };
    check_ends(file, &path, ends).map(|()| path)
}

/// Checks that the motion starts and ends in the joints asked for.
fn check_ends(file: &ScheduleFile, path: &PoseMove<'_>, ends: [Option<Joints<6>>; 2]) -> Result<(), Cr7Error> {
    if let Some(start) = ends[0].filter(|start| (path.start() - start).amax() > SAME) {
        return Err(configuration(file, KEYS[0], misses("start", &start, &path.start())));
    }
    let Some(goal) = ends[1] else { return Ok(()) };
    // Where the arm cannot follow, the planner says so, with the place.
    let Ok(end) = followed(path) else { return Ok(()) };
    if (end - goal).amax() > SAME {
        return Err(configuration(file, KEYS[1], misses("end", &goal, &end)));
    }
    Ok(())
}

const KEYS: [&str; 2] = ["start.q_deg", "goal.q_deg"];

fn configuration(file: &ScheduleFile, key: &'static str, problem: String) -> Cr7Error {
    Cr7Error::Configuration { file: file.file.clone(), line: file.line_of(key), key, problem }
}

/// That the motion starts or ends in `got` in place of `asked`, and why.
fn misses(end: &str, asked: &Joints<6>, got: &Joints<6>) -> String {
    let degrees = |q: &Joints<6>| {
        let each: Vec<String> = q.iter().map(|q| number((q.to_degrees() * 1e4).round() * 1e-4)).collect();
        format!("[{}] deg", each.join(", "))
    };
    let turns = (got - asked).map(|d| (d / TAU).round());
    let got_words = degrees(got);
    if (got - asked - turns * TAU).amax() <= SAME {
        let joints: Vec<String> = (0..6).filter(|&k| turns[k] != 0.0).map(|k| format!("J{}", k + 1)).collect();
        let joints = joints.join(", ");
        return format!(
            "the motion would {end} at {got_words}, which is the same pose with {joints} full turns away: give joints the \
             same turns at both ends, or go through joint way-points ([[waypoint]])"
        );
    }
    format!(
        "the motion would {end} at {got_words}, which is the same pose in another configuration of the arm, and a tool motion \
         keeps its configuration: give start.q_deg or start.near_deg in that of the goal, or go through joint way-points \
         ([[waypoint]])"
    )
}

/// The joints of a place that is given by joints, inside their range.
fn joints(
    file: &ScheduleFile,
    arm: &Arm<6>,
    key: &'static str,
    place: &SchedulePlace,
) -> Result<Option<Joints<6>>, Cr7Error> {
    let SchedulePlace::Joints(values) = place else { return Ok(None) };
    let q = Joints::from(file.of::<6>(key, values)?);
    let (lower, upper) = (arm.range().lower(), arm.range().upper());
    if let Some(k) = (0..6).find(|&k| !(lower[k]..=upper[k]).contains(&q[k])) {
        let [at, low, high] = [q[k], lower[k], upper[k]].map(|v| number(v.to_degrees()));
        let problem =
            format!("joint {} is at {at} deg, outside its range of {low} to {high} deg: choose joints inside", k + 1);
        return Err(configuration(file, key, problem));
    }
    Ok(Some(q))
}

/// The joints at the end of a motion.
fn followed(path: &PoseMove<'_>) -> Result<Joints<6>, PathError> {
    let mut last = path.jet(0.0, &path.start())?;
    for i in 1..=STEPS {
        let s = path.length() * (i as f64 / STEPS as f64);
        last = path.jet(s, &last.ahead(s - last.s))?;
    }
    Ok(last.q)
}
