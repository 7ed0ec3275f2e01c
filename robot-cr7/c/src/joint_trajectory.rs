//! Compiled joint trajectories: load, seek and sample.

use std::ffi::{CString, c_char};
use std::fs;
use std::ptr;

use arcfeed_interp::JointTrajectory;
use serde::Deserialize;

use crate::axes::ArcfeedMotionState;
use crate::input::{
    All, by_count, check_count, finite, hand_out, held, place, put, same_count, take_back, text, write_all,
};
use crate::status::ArcfeedStatus::{ArcfeedFile, ArcfeedInvalid};
use crate::status::{ArcfeedStatus, Outcome, guarded, refuse};

/// A motion of joints as polynomials of the time, from a file of the format "joint-trajectory/1". It does not change:
/// several threads may read it.
pub struct ArcfeedJointTrajectory {
    inner: Box<dyn Sampled>,
    names: Vec<CString>,
}

/// [`JointTrajectory`] without its number of joints.
trait Sampled {
    fn duration(&self) -> f64;
    fn at(&self, t: f64) -> All<ArcfeedMotionState>;
}

impl<const N: usize> Sampled for JointTrajectory<N> {
    fn duration(&self) -> f64 {
        self.duration()
    }

    fn at(&self, t: f64) -> All<ArcfeedMotionState> {
        let s = self.at(t);
        let of = |values: &arcfeed_kinematics::Joints<N>, k: usize| values.get(k).copied().unwrap_or(0.0);
        std::array::from_fn(|k| ArcfeedMotionState {
            position: of(&s.q, k),
            velocity: of(&s.qd, k),
            acceleration: of(&s.qdd, k),
            jerk: of(&s.jerk, k),
        })
    }
}

/// The part of a file that tells its number of joints.
#[derive(Deserialize)]
struct Names {
    joint_names: Vec<String>,
}

fn make<const N: usize>(content: &str) -> Outcome<Box<dyn Sampled>> {
    let (motion, _) = JointTrajectory::<N>::from_json(content).map_err(|error| refuse(ArcfeedFile, error))?;
    Ok(Box::new(motion))
}

fn parse(content: &str) -> Outcome<ArcfeedJointTrajectory> {
    let names: Names = serde_json::from_str(content)
        .map_err(|error| refuse(ArcfeedFile, format_args!("not a joint trajectory in JSON: {error}")))?;
    let names: Result<Vec<CString>, _> = names.joint_names.into_iter().map(CString::new).collect();
    let names =
        names.map_err(|_| refuse(ArcfeedFile, "joint_names: a name holds the character NUL; rename the joint"))?;
    check_count(names.len())?;
    let inner = by_count!(names.len(), make(content))?;
    Ok(ArcfeedJointTrajectory { inner, names })
}

/// The trajectory of a file. On success `*out` holds it, else NULL.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_joint_trajectory_load(
    path: *const c_char,
    out: *mut *mut ArcfeedJointTrajectory,
) -> ArcfeedStatus {
    guarded(|| unsafe {
        *place("out", out)? = ptr::null_mut();
        let path = text("path", path)?;
        let content = fs::read_to_string(path).map_err(|error| refuse(ArcfeedFile, format_args!("{path}: {error}")))?;
        hand_out("out", out, parse(&content)?)
    })
}

/// The trajectory of a text, for systems without files. On success `*out` holds it, else NULL.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_joint_trajectory_parse(
    json: *const c_char,
    out: *mut *mut ArcfeedJointTrajectory,
) -> ArcfeedStatus {
    guarded(|| unsafe {
        *place("out", out)? = ptr::null_mut();
        hand_out("out", out, parse(text("json", json)?)?)
    })
}

/// Frees a trajectory; NULL is nothing to free.
///
/// # Safety
/// The trajectory is not used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_joint_trajectory_free(trajectory: *mut ArcfeedJointTrajectory) {
    unsafe { take_back(trajectory) };
}

/// Number of joints; 0 for NULL.
///
/// # Safety
/// The trajectory is NULL or one that was loaded and not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_joint_trajectory_joints(trajectory: *const ArcfeedJointTrajectory) -> usize {
    unsafe { held("trajectory", trajectory) }.map_or(0, |trajectory| trajectory.names.len())
}

/// Name of a joint, counted from 0. The text belongs to the trajectory.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_joint_trajectory_joint_name(
    trajectory: *const ArcfeedJointTrajectory,
    joint: usize,
    name: *mut *const c_char,
) -> ArcfeedStatus {
    guarded(|| unsafe {
        let names = &held("trajectory", trajectory)?.names;
        let found = names.get(joint);
        let none =
            || refuse(ArcfeedInvalid, format_args!("joint is {joint}; there are {}, counted from 0", names.len()));
        put("name", name, found.ok_or_else(none)?.as_ptr())
    })
}

/// Duration (s).
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_joint_trajectory_duration(
    trajectory: *const ArcfeedJointTrajectory,
    seconds: *mut f64,
) -> ArcfeedStatus {
    guarded(|| unsafe { put("seconds", seconds, held("trajectory", trajectory)?.inner.duration()) })
}

/// The motion at time `t` (s), one entry of `states` for each joint; `t` is taken to the nearest end. Any time is found
/// in about the same time, so that seeking needs no call of its own.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused; `states` has room for `joints` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_joint_trajectory_at(
    trajectory: *const ArcfeedJointTrajectory,
    t: f64,
    joints: usize,
    states: *mut ArcfeedMotionState,
) -> ArcfeedStatus {
    guarded(|| unsafe {
        let trajectory = held("trajectory", trajectory)?;
        same_count(joints, trajectory.names.len())?;
        let all = trajectory.inner.at(finite(&"t", "", t)?);
        write_all("states", states, all.into_iter().take(joints))
    })
}
