//! Whole-system tests and benchmarks live in `tests/` and `benches/`; the code of the README and of `docs/crates.md` is compiled and run here.

#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct Readme;

#[cfg(doctest)]
#[doc = include_str!("../../docs/crates.md")]
struct Crates;

pub mod blend_corner;
pub mod blended_polylines;
pub mod cnc_curves;
#[cfg(feature = "controller")]
pub mod controller_simulator;
pub mod fuzz;
pub mod hybrid_scenario;
pub mod on_cr7;
pub mod raised_limits;
pub mod random_jobs;
pub mod tight_bends;
