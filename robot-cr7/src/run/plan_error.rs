//! The errors of planners, with the file and a likely cause.

use arcfeed_geometry::PosePath;
use arcfeed_interp::{LiveError, PathError, PlanError};
use arcfeed_kinematics::KinematicsError;
use nalgebra::Vector3;

use super::error::Cr7Error;
use super::outline::Outline;

/// A path this far out of reach is probably given in another unit than meant, m.
const FAR_OUT: f64 = 2.0;

/// The error of a live motion, with the file and a likely cause.
pub(crate) fn live_error(file: &str, error: LiveError) -> Cr7Error {
    match error {
        LiveError::Plan(source) => plan_error(file, source),
        source => Cr7Error::Live { file: file.to_owned(), source: Box::new(source) },
    }
}

pub(crate) fn plan_error(file: &str, source: PlanError) -> Cr7Error {
    let hint = unit_hint(&source) + branch_hint(&source);
    Cr7Error::Plan { file: file.to_owned(), source: Box::new(source), hint }
}

/// Where the tool is and how it points at a place that the arm cannot reach, with the keys that move it.
pub(crate) fn reach_hint(path: &PosePath, error: &PlanError) -> String {
    fn out_of_reach(error: &PathError) -> bool {
        match error {
            PathError::Arm { source: KinematicsError::Unreachable { distance, .. }, .. } => *distance <= FAR_OUT,
            PathError::Arm { source: KinematicsError::OutsideLimits { .. }, .. } | PathError::JointRange { .. } => true,
            PathError::NoConfiguration { best, .. } => out_of_reach(best),
            _ => false,
        }
    }
    match (error, error.place()) {
        (PlanError::Path(source), Some(place)) if out_of_reach(source) => {
            let pose = path.jet(place.s).pose;
            let at = pose.translation.vector * 1e3;
            let z = pose.rotation * Vector3::z();
            format!(
                "; the tool is at ({:.1}, {:.1}, {:.1}) mm there and points along ({:.3}, {:.3}, {:.3}), both in the base frame: move \
                 [workpiece] (`cr7 place` finds frames in reach) or turn [orientation]",
                at.x, at.y, at.z, z.x, z.y, z.z
            )
        }
        _ => String::new(),
    }
}

/// The line of the file at which a plan fails, to follow its message.
pub(crate) fn line_words(outline: &Outline, error: &PlanError) -> String {
    error.place().map(|place| outline.words_at(place.s)).unwrap_or_default()
}

/// The keys that choose another branch, where the arm is singular on this one.
fn branch_hint(error: &PlanError) -> &'static str {
    fn is_singular(error: &PathError) -> bool {
        match error {
            PathError::Arm { source: KinematicsError::Singular { .. }, .. } | PathError::Singular { .. } => true,
            PathError::NoConfiguration { best, .. } => is_singular(best),
            _ => false,
        }
    }
    match error {
        PlanError::Path(error) if is_singular(error) => {
            "; the joints would have to turn fast there: another branch is chosen by start.configuration or start.near_deg (arms of \
             six joints)"
        }
        _ => "",
    }
}

/// A mix-up of millimetres and metres shows as a path that is metres out of reach.
fn unit_hint(error: &PlanError) -> String {
    fn of(error: &PathError) -> String {
        match error {
            PathError::Arm { source: KinematicsError::Unreachable { distance, .. }, .. } if *distance > FAR_OUT => {
                format!(
                    "; {distance:.1} m is more than the arm is long: check the \"units\" of the path file and \
                     workpiece.position_mm of the job"
                )
            }
            PathError::NoConfiguration { best, .. } => of(best),
            _ => String::new(),
        }
    }
    match error {
        PlanError::Path(error) => of(error),
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use arcfeed_interp::{PathParameter, PathPlace};

    use super::*;

    #[test]
    fn a_singular_branch_is_told_with_the_keys_that_choose_another() {
        let place = PathPlace { s: 0.1, parameter: PathParameter::ArcLength, tool: None };
        let singular = KinematicsError::Singular { kind: None, sigma_min: 1e-5, required: 1e-3, condition: 1e6 };
        let error = PathError::Arm { place, source: singular };
        let keys = |error: PathError| {
            let text = plan_error("job.toml", error.into()).to_string();
            text.contains("start.configuration") && text.contains("start.near_deg")
        };
        assert!(keys(error.clone()));
        assert!(keys(PathError::NoConfiguration { candidates: 8, best: Box::new(error) }));
        let far = KinematicsError::NotFinite { what: "a pose" };
        assert!(!keys(PathError::Arm { place, source: far }));
    }
}
