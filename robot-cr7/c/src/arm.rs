//! Forward and inverse kinematics.

use std::ffi::{CString, c_char};
use std::fs;
use std::ptr;

use arcfeed_kinematics::{
    AnalyticInverse, Arm, ArmDescription, ForwardKinematics, InverseKinematics, Joints, KinematicsError, models,
};
use nalgebra::Isometry3;

use crate::axes::{self, ArcfeedRange, of_axes};
use crate::input::{
    All, by_count, check_count, hand_out, held, optional_text, place, put, read, read_all, same_count, take_back, text,
    write_all,
};
use crate::pose::{ArcfeedPose, pose};
use crate::status::ArcfeedStatus::{ArcfeedFile, ArcfeedInvalid, ArcfeedRefused};
use crate::status::{ArcfeedStatus, Outcome, guarded, refuse};

/// An arm of 1 to 8 joints. Several threads may read it while none sets its tool.
pub struct ArcfeedArm {
    inner: Box<dyn Kinematics>,
    names: Vec<CString>,
}

/// The most solutions of `arcfeed_arm_inverse_all`.
pub const ARCFEED_MAX_SOLUTIONS: usize = 8;

/// Solutions of an inverse and their number.
type Found = ([All<f64>; ARCFEED_MAX_SOLUTIONS], usize);

/// [`Arm`] without its number of joints.
trait Kinematics {
    fn with_tool(&self, tool: Isometry3<f64>) -> Result<Box<dyn Kinematics>, KinematicsError>;
    fn range(&self) -> All<ArcfeedRange>;
    fn forward(&self, q: &All<f64>) -> Isometry3<f64>;
    fn inverse(&self, target: &Isometry3<f64>, seed: &All<f64>) -> Result<All<f64>, KinematicsError>;
    fn inverse_all(&self, target: &Isometry3<f64>) -> Result<Found, KinematicsError>;
}

fn joints<const N: usize>(q: &All<f64>) -> Joints<N> {
    Joints::from(of_axes::<f64, N>(q))
}

fn values<const N: usize>(q: &Joints<N>) -> All<f64> {
    std::array::from_fn(|k| q.get(k).copied().unwrap_or(0.0))
}

impl<const N: usize> Kinematics for Arm<N> {
    fn with_tool(&self, tool: Isometry3<f64>) -> Result<Box<dyn Kinematics>, KinematicsError> {
        Ok(Box::new(self.with_tool(tool)?))
    }

    fn range(&self) -> All<ArcfeedRange> {
        let (lower, upper) = (values(self.range().lower()), values(self.range().upper()));
        std::array::from_fn(|k| ArcfeedRange { lower: lower[k], upper: upper[k] })
    }

    fn forward(&self, q: &All<f64>) -> Isometry3<f64> {
        ForwardKinematics::forward(self, &joints(q))
    }

    fn inverse(&self, target: &Isometry3<f64>, seed: &All<f64>) -> Result<All<f64>, KinematicsError> {
        InverseKinematics::inverse(self, target, &joints(seed)).map(|q| values(&q))
    }

    fn inverse_all(&self, target: &Isometry3<f64>) -> Result<Found, KinematicsError> {
        let mut all = [[0.0; _]; ARCFEED_MAX_SOLUTIONS];
        let found = AnalyticInverse::inverse_all(self, target)?;
        for (place, q) in all.iter_mut().zip(found.iter()) {
            *place = values(q);
        }
        Ok((all, found.len()))
    }
}

fn make<const N: usize>(description: &ArmDescription) -> Outcome<Box<dyn Kinematics>> {
    Ok(Box::new(description.build::<N>().map_err(|error| refuse(ArcfeedFile, error))?))
}

fn build(description: &ArmDescription) -> Outcome<ArcfeedArm> {
    let names: Result<Vec<CString>, _> = description.joints.iter().map(|joint| CString::new(&*joint.name)).collect();
    let names = names.map_err(|_| refuse(ArcfeedFile, "the name of a joint holds the character NUL; rename it"))?;
    check_count(names.len())?;
    let inner = by_count!(names.len(), make(description))?;
    Ok(ArcfeedArm { inner, names })
}

/// A target out of reach is refused, everything else is invalid.
fn of_kinematics(error: KinematicsError) -> ArcfeedStatus {
    let status = match error {
        KinematicsError::Unreachable { .. } | KinematicsError::OutsideLimits { .. } => ArcfeedRefused,
        _ => ArcfeedInvalid,
    };
    refuse(status, error)
}

/// A built-in arm by its name, for example "cr7" or "ur5e". On success `*out` holds it, else NULL.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_arm_builtin(name: *const c_char, out: *mut *mut ArcfeedArm) -> ArcfeedStatus {
    guarded(|| unsafe {
        *place("out", out)? = ptr::null_mut();
        let name = text("name", name)?;
        let unknown =
            || refuse(ArcfeedInvalid, format_args!("name is {name:?}; it must be one of {:?}", models::NAMES));
        hand_out("out", out, build(&models::description(name).ok_or_else(unknown)?)?)
    })
}

/// The arm of a file: JSON of the format "arm-params/1" if the name ends in ".json", else URDF. `base` and `tip` name
/// links of a URDF; NULL for the root, and for the hand, `tool0` or the only end of its chain. On success `*out` holds the arm,
/// else NULL.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_arm_load(
    path: *const c_char,
    base: *const c_char,
    tip: *const c_char,
    out: *mut *mut ArcfeedArm,
) -> ArcfeedStatus {
    guarded(|| unsafe {
        *place("out", out)? = ptr::null_mut();
        let path = text("path", path)?;
        let (base, tip) = (optional_text("base", base)?, optional_text("tip", tip)?);
        let content = fs::read_to_string(path).map_err(|error| refuse(ArcfeedFile, format_args!("{path}: {error}")))?;
        let description = if path.to_ascii_lowercase().ends_with(".json") {
            ArmDescription::from_json(&content)
        } else {
            ArmDescription::from_urdf(&content, base, tip)
        };
        let description = description.map_err(|error| refuse(ArcfeedFile, format_args!("{path}: {error}")))?;
        hand_out("out", out, build(&description)?)
    })
}

/// Frees an arm; NULL is nothing to free.
///
/// # Safety
/// The arm is not used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_arm_free(arm: *mut ArcfeedArm) {
    unsafe { take_back(arm) };
}

/// Number of joints; 0 for NULL.
///
/// # Safety
/// The arm is NULL or one that was made and not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_arm_joints(arm: *const ArcfeedArm) -> usize {
    unsafe { held("arm", arm) }.map_or(0, |arm| arm.names.len())
}

/// Name of a joint, counted from 0. The text belongs to the arm.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_arm_joint_name(
    arm: *const ArcfeedArm,
    joint: usize,
    name: *mut *const c_char,
) -> ArcfeedStatus {
    guarded(|| unsafe {
        let names = &held("arm", arm)?.names;
        let none =
            || refuse(ArcfeedInvalid, format_args!("joint is {joint}; there are {}, counted from 0", names.len()));
        put("name", name, names.get(joint).ok_or_else(none)?.as_ptr())
    })
}

/// The range of each joint (rad or m).
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused; `ranges` has room for `joints` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_arm_ranges(
    arm: *const ArcfeedArm,
    joints: usize,
    ranges: *mut ArcfeedRange,
) -> ArcfeedStatus {
    guarded(|| unsafe {
        let arm = held("arm", arm)?;
        same_count(joints, arm.names.len())?;
        write_all("ranges", ranges, arm.inner.range().into_iter().take(joints))
    })
}

/// Sets the tool point in the frame of the flange. Allocates.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_arm_set_tool(arm: *mut ArcfeedArm, tool: *const ArcfeedPose) -> ArcfeedStatus {
    guarded(|| unsafe {
        let arm = place("arm", arm)?;
        arm.inner = arm.inner.with_tool(pose("tool", &read("tool", tool)?)?).map_err(of_kinematics)?;
        Ok(())
    })
}

/// The pose of the tool in the base for the joint values `q` (rad or m).
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_arm_forward(
    arm: *const ArcfeedArm,
    joints: usize,
    q: *const f64,
    pose: *mut ArcfeedPose,
) -> ArcfeedStatus {
    guarded(|| unsafe {
        let arm = held("arm", arm)?;
        same_count(joints, arm.names.len())?;
        let q = read_all("q", q, joints, axes::number)?;
        put("pose", pose, ArcfeedPose::from(&arm.inner.forward(&q)))
    })
}

/// Joint values inside the range of the joints that put the tool at `target`, as near to `seed` as can be. `q` and
/// `seed` may be the same array.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused; `q` has room for `joints` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_arm_inverse(
    arm: *const ArcfeedArm,
    target: *const ArcfeedPose,
    joints: usize,
    seed: *const f64,
    q: *mut f64,
) -> ArcfeedStatus {
    guarded(|| unsafe {
        let arm = held("arm", arm)?;
        same_count(joints, arm.names.len())?;
        let target = pose("target", &read("target", target)?)?;
        let seed = read_all("seed", seed, joints, axes::number)?;
        let found = arm.inner.inverse(&target, &seed).map_err(of_kinematics)?;
        write_all("q", q, found.into_iter().take(joints))
    })
}

/// All joint values that put the tool at `target`, each angle in (-pi, pi], without regard to the range of the joints;
/// of a numeric inverse several. `q` gets one solution after the other, `*count` their number.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused; `q` has room for `ARCFEED_MAX_SOLUTIONS` times `joints` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_arm_inverse_all(
    arm: *const ArcfeedArm,
    target: *const ArcfeedPose,
    joints: usize,
    q: *mut f64,
    count: *mut usize,
) -> ArcfeedStatus {
    guarded(|| unsafe {
        let arm = held("arm", arm)?;
        same_count(joints, arm.names.len())?;
        let target = pose("target", &read("target", target)?)?;
        put("count", count, 0)?;
        let (all, found) = arm.inner.inverse_all(&target).map_err(of_kinematics)?;
        write_all("q", q, all.iter().take(found).flat_map(|q| q.iter().take(joints).copied()))?;
        put("count", count, found)
    })
}
