//! arcfeed for C and C++.
//!
//! Each function checks what it is given, calls one function of the libraries, and copies the result. A function that can
//! fail returns an [`ArcfeedStatus`](status::ArcfeedStatus) and leaves a text for `arcfeed_last_error`. No panic leaves a
//! function.
//!
//! Calls of a control cycle (`set`, `stop`, `jog`, `step`, `at`, `forward`, `inverse` and the like) allocate nothing, nor do
//! their errors. Functions that make or free a value allocate.

mod arm;
mod axes;
mod generator;
mod generator_cycle;
mod generator_route;
mod input;
mod joint_trajectory;
mod pose;
mod projection;
mod route;
mod status;
mod tracking;
mod trajectory;
