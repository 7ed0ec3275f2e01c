//! Tests of profiles, planners, live feed and state to state, in one binary.

mod allocation;
#[cfg(feature = "clarabel")]
mod baseline;
mod bounded;
mod change;
mod common;
mod exact_begin;
mod exact_problems;
mod hostile;
mod jerk_limited;
mod jerk_limited_grids;
mod liu_2024;
mod live;
mod lower_bound;
mod online;
mod online_allocation;
mod part_of_grid;
mod position_range;
mod return_inside;
mod row_families;
mod rows;
mod scan;
mod scurve;
mod speed_law;
mod state_to_state;
mod state_to_state_allocation;
mod stream;
mod time_constrained;
mod tracker;
mod velocity_targets;
mod windowed;

#[path = "common/row_families.rs"]
mod row_families_cases;
#[path = "common/spline_paths.rs"]
mod spline_paths;

#[global_allocator]
static ALLOCATOR: arcfeed_testing::Counting = arcfeed_testing::Counting;
