//! Tests of paths, plans, verification and live motion, in one binary.

mod ahead;
mod allocation;
mod certificate;
mod common;
mod compiled;
mod compiled_plan;
mod excursions;
mod joint_check;
mod joint_lines;
mod joint_path;
mod joint_points;
mod limit_tables;
mod limits;
mod limits_certificate;
mod live_tool;
mod locked;
mod mutations;
mod parameter;
mod pose_moves;
mod recorded;
mod refusals;
mod sampling;
mod singular;
mod singular_passages;
mod six_joints;
mod torque_certificate;
mod verify;
mod vibration;
mod windows;

#[path = "common/qb.rs"]
mod qb;
#[path = "common/six_joints.rs"]
mod six_joints_cases;
