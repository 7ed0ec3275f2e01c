//! What the tests of G-code programs share.

use std::path::Path;

use arcfeed_geometry::nalgebra::{Vector3, vector};
use robot_cr7::{GcodeMove, GcodeOptions, GcodeProgram, InputError};

/// Reads a text as the file `a.ngc`.
pub fn read(text: &str) -> Result<GcodeProgram, InputError> {
    GcodeProgram::from_bytes(text.as_bytes(), Path::new("a.ngc"), &GcodeOptions::default())
}

pub fn program(text: &str) -> GcodeProgram {
    read(text).unwrap_or_else(|e| panic!("{text}: {e}"))
}

/// Checks that `text` is refused at this line and column, with a message that holds all `parts`.
#[track_caller]
pub fn refused(text: &str, line: u64, column: usize, parts: &[&str]) {
    let message = match read(text) {
        Ok(program) => panic!("{text:?} was read as {program:?}"),
        Err(e) => e.to_string(),
    };
    let place = format!("a.ngc:{line}:{column}: ");
    assert!(message.starts_with(&place), "{text:?}: {place} is not the place of: {message}");
    for part in parts {
        assert!(message.contains(part), "{text:?}: \"{part}\" is missing in: {message}");
    }
}

/// As [`refused`], behind a first line that makes moves possible.
#[track_caller]
pub fn refused_in_line(text: &str, column: usize, parts: &[&str]) {
    refused(&format!("G21 G90 G17 G0 X10 Y0 Z0 F600\n{text}\n"), 2, column, parts);
}

/// The moves of `text` behind a first line that goes to X10.
pub fn moves(text: &str) -> Vec<GcodeMove> {
    program(&format!("G21 G90 G17 G0 X10 Y0 Z0 F600\n{text}\n")).moves.split_off(1)
}

/// Millimetres as a point in metres.
pub fn mm(x: f64, y: f64, z: f64) -> Vector3<f64> {
    vector![x, y, z] * 1e-3
}
