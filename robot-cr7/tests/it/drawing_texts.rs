//! Texts of drawings for tests, and points of the moves that are read from them.

use std::path::Path;

use arcfeed_geometry::Curve;
use arcfeed_geometry::nalgebra::{UnitQuaternion, Vector3};
use robot_cr7::{DrawingOptions, GcodeMove, GcodeProgram, MoveKind, MoveShape, read_drawing};

/// Groups of DXF from codes and values in one line: `"0 LINE 8 cut 10 1.5"`.
pub fn entity(text: &str) -> String {
    let words: Vec<&str> = text.split_whitespace().collect();
    words.chunks(2).map(|pair| format!("{}\n{}\n", pair[0], pair[1])).collect()
}

/// A DXF file in the unit `$INSUNITS` (none where it is empty) with these entities.
pub fn dxf_in(units: &str, sections: &str, entities: &str) -> String {
    let units = if units.is_empty() { String::new() } else { format!("9\n$INSUNITS\n70\n{units}\n") };
    format!(
        "0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1015\n{units}0\nENDSEC\n{sections}0\nSECTION\n2\nENTITIES\n{entities}0\nENDSEC\n0\nEOF\n"
    )
}

/// A DXF file in mm with entities that [`entity`] understands, one in a line.
pub fn dxf(entities: &str) -> String {
    dxf_in("4", "", &entities.lines().map(entity).collect::<String>())
}

/// An SVG file of 100 mm x 100 mm, in which a user unit is 1 mm.
pub fn svg(body: &str) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:inkscape=\"http://www.inkscape.org/namespaces/inkscape\" \
         xmlns:xlink=\"http://www.w3.org/1999/xlink\" width=\"100mm\" height=\"100mm\" viewBox=\"0 0 100 100\">\n{body}\n</svg>\n"
    )
}

pub fn read(text: &str, name: &str) -> GcodeProgram {
    read_with(text, name, &DrawingOptions::default())
}

pub fn read_with(text: &str, name: &str, options: &DrawingOptions) -> GcodeProgram {
    read_drawing(text.as_bytes(), Path::new(name), options).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// What is wrong with a text.
pub fn refusal(text: &str, name: &str, options: &DrawingOptions) -> String {
    match read_drawing(text.as_bytes(), Path::new(name), options) {
        Ok(program) => panic!("read as {program:?}\n{text}"),
        Err(e) => e.to_string(),
    }
}

/// A point in mm, in m.
pub fn mm(x: f64, y: f64, z: f64) -> Vector3<f64> {
    Vector3::new(x, y, z) / 1e3
}

/// A point of the page of [`svg`]: x to the right and y down, in mm.
pub fn page(x: f64, y: f64) -> Vector3<f64> {
    mm(x, 100.0 - y, 0.0)
}

/// The place on a move after the part `t` of its parameter, m.
pub fn place(start: Vector3<f64>, step: &GcodeMove, t: f64) -> Vector3<f64> {
    match &step.shape {
        MoveShape::Line { to } => start + (to - start) * t,
        MoveShape::Arc { centre, normal, sweep, .. } => {
            centre + UnitQuaternion::from_axis_angle(normal, sweep * t) * (start - centre)
        }
        MoveShape::Curve(curve) => {
            let (a, b) = curve.domain();
            curve.point(a + (b - a) * t)
        }
    }
}

/// `count + 1` places on each feed move, in the order of the motion.
pub fn places(program: &GcodeProgram, count: u32) -> Vec<Vector3<f64>> {
    let feeds = program.moves_with_starts().filter(|(_, step)| step.kind != MoveKind::Rapid);
    feeds
        .flat_map(|(start, step)| (0..=count).map(move |i| place(start, step, f64::from(i) / f64::from(count))))
        .collect()
}

/// Length of the feed moves, m, by chords.
pub fn length(program: &GcodeProgram) -> f64 {
    places(program, 4000).windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
}

/// Area around which the feed moves run counter-clockwise, seen along -z, m^2, by chords.
pub fn area(program: &GcodeProgram) -> f64 {
    let points = places(program, 4000);
    let next = points.iter().cycle().skip(1);
    points.iter().zip(next).map(|(a, b)| 0.5 * (a.x * b.y - a.y * b.x)).sum()
}

pub fn assert_near(found: Vector3<f64>, expected: Vector3<f64>) {
    assert!((found - expected).norm() < 1e-9, "{found} is not {expected}");
}

pub fn assert_relative(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 1e-6 * expected.abs(), "{found} is not {expected}");
}

/// Start and end of each run of feed moves: the contours.
pub fn contours(program: &GcodeProgram) -> Vec<[Vector3<f64>; 2]> {
    let mut all: Vec<[Vector3<f64>; 2]> = Vec::new();
    let mut feeding = false;
    for (start, step) in program.moves_with_starts() {
        let feed = step.kind != MoveKind::Rapid;
        match all.last_mut() {
            Some(last) if feed && feeding => last[1] = step.end(),
            _ if feed => all.push([start, step.end()]),
            _ => {}
        }
        feeding = feed;
    }
    all
}
