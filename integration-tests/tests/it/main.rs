//! Tests of all crates together, in one binary.

mod allocation;
mod any_arm;
mod any_smooth_curve;
mod blend_shape;
mod blended_polylines;
mod cnc_curves;
mod conformance;
#[cfg(feature = "controller")]
mod controller;
#[cfg(feature = "controller")]
mod controller_live;
mod cubics;
mod fuzz;
mod hybrid;
mod motion_bench_maker;
mod moveit_paths;
mod paths_of_others;
mod pilz;
mod poses_of_others;
mod raised_limits;
mod random_jobs;
mod regressions;
mod robots_of_others;
mod security;
mod states_of_users;
mod tight_bends;
