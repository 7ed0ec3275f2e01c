//! The compiled part of the Python package `arcfeed`: thin wrappers of the crates, with NumPy arrays in and out.
//!
//! Lengths are in m, angles in rad, times in s; keys of jobs carry their units in their names.
#![forbid(unsafe_op_in_unsafe_fn)]

mod array;
mod axes;
mod compiled;
mod error;
mod input;
mod motion;
mod online;
mod online_step;
mod papers;
mod plan;
mod researcher;
mod robot;
mod state_to_state;
mod tracking;
mod way_points;

use pyo3::prelude::*;

/// Paths, plans, arms and motions between states.
#[pymodule]
mod _core {
    #[pymodule_export]
    use super::compiled::JointTrajectory;
    #[pymodule_export]
    use super::error::{ArcfeedError, InputError, PlanError};
    #[pymodule_export]
    use super::input::{Job, Path};
    #[pymodule_export]
    use super::motion::Motion;
    #[pymodule_export]
    use super::online::OnlineGenerator;
    #[pymodule_export]
    use super::online_step::OnlineStep;
    #[pymodule_export]
    use super::papers::reproduce;
    #[pymodule_export]
    use super::plan::{compare, plan};
    #[pymodule_export]
    use super::researcher::{Problem, problem};
    #[pymodule_export]
    use super::robot::{Robot, robots};
    #[pymodule_export]
    use super::state_to_state::{StateToState, state_to_state};
    #[pymodule_export]
    use super::tracking::{TrackingGenerator, TrackingStep};
    #[pymodule_export]
    use super::way_points::{WayPointMotion, way_points};
}
