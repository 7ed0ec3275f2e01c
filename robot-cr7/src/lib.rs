//! The Dobot CR7 on arcfeed: path and job files, plots, reports and the command line.
#![forbid(unsafe_code)]

mod error;
mod path_file;
mod sample_paths;
mod unit;

pub use error::InputError;
pub use path_file::{PathFile, PathGeometry};
pub use sample_paths::{SamplePath, butterfly};
pub use unit::LengthUnit;
