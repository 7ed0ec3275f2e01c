//! Job and path that the flags name.

use std::path::Path;

use crate::{Job, LengthUnit, PathFile, butterfly};

use crate::cli::Failure;

/// The job of a file, or the documented defaults.
pub fn read_job(file: Option<&Path>) -> Result<Job, Failure> {
    file.map_or_else(|| Ok(Job::default()), |file| Ok(Job::read(file)?))
}

/// The path file named, or the embedded butterfly.
pub fn read_path(file: Option<&Path>, unit: Option<&str>, job: &Job) -> Result<PathFile, Failure> {
    let unit = match unit {
        None => None,
        Some(symbol) => Some(LengthUnit::from_symbol(symbol).ok_or_else(|| {
            Failure::BadInput(format!("--unit {symbol}: not a known unit of length: use mm, cm, m or in"))
        })?),
    };
    Ok(match file {
        Some(file) => PathFile::read_for_job(file, unit, job)?,
        None => butterfly()?,
    })
}
