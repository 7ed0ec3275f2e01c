//! Tests of motions of several axes, in one binary.

mod allocation;
mod arrival;
mod common;
mod generator;
mod interrupts;
mod line;
mod norm;
mod projection;
mod projection_allocation;
mod projection_pose;
mod ranges;
mod rest_to_rest;
mod route_edges;
mod routes;
mod scaled_changes;
mod so3;
mod soak;
mod state_to_state;
mod straight_routes;
mod tracking;
mod way_points;

#[path = "../../examples/02_soak/soak/mod.rs"]
mod soak_cases;

#[global_allocator]
static ALLOCATOR: arcfeed_testing::Counting = arcfeed_testing::Counting;
