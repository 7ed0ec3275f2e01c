//! Random programs are written as G-code in many styles and read back.

use std::path::Path;

use robot_cr7::{GcodeMove, GcodeOptions, GcodeProgram, MoveKind, MoveShape};

use crate::gcode_writer::Writer;

fn random_program(seed: u64) -> (String, Vec<GcodeMove>) {
    let mut writer = Writer::new(seed);
    writer.end_block();
    for _ in 0..1 + writer.random.below(25) {
        writer.chatter();
        match writer.random.below(8) {
            0..=2 => writer.line(),
            3..=5 => writer.arc(),
            6 => writer.spline(),
            _ => writer.nurbs(),
        }
    }
    (writer.text, writer.moves)
}

/// Largest difference of two moves in m, rad and relative speed, or infinity where they are of different kinds.
fn difference(a: &GcodeMove, b: &GcodeMove) -> f64 {
    let ratio = |a: f64, b: f64| (a / b - 1.0).abs();
    let kind = match (a.kind, b.kind) {
        (MoveKind::Rapid, MoveKind::Rapid) => 0.0,
        (MoveKind::Feed { speed: a }, MoveKind::Feed { speed: b }) => ratio(a, b),
        (MoveKind::InverseTime { seconds: a }, MoveKind::InverseTime { seconds: b }) => ratio(a, b),
        _ => f64::INFINITY,
    };
    let far = |a: &[f64], b: &[f64]| {
        if a.len() != b.len() {
            return f64::INFINITY;
        }
        a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    let shape = match (&a.shape, &b.shape) {
        (MoveShape::Line { .. }, MoveShape::Line { .. }) => 0.0,
        (
            MoveShape::Arc { centre, normal, sweep, rise, .. },
            MoveShape::Arc { centre: c, normal: n, sweep: s, rise: r, .. },
        ) => (centre - c).norm() + (normal.into_inner() - n.into_inner()).norm() + (sweep - s).abs() + (rise - r).abs(),
        (MoveShape::Curve(a), MoveShape::Curve(b)) => {
            let points = a.control_points().iter().zip(b.control_points()).map(|(a, b)| (a - b).norm());
            let points = points.fold(0.0, f64::max);
            points + far(a.weights(), b.weights()) + far(a.knots().as_slice(), b.knots().as_slice())
        }
        _ => f64::INFINITY,
    };
    let rotary = match (a.rotary, b.rotary) {
        (None, None) => 0.0,
        (Some(a), Some(b)) => (a - b).norm(),
        _ => f64::INFINITY,
    };
    let places = if (a.line, a.number, a.control) == (b.line, b.number, b.control) { 0.0 } else { f64::INFINITY };
    kind + shape + rotary + places + (a.end() - b.end()).norm()
}

#[test]
fn random_programs_are_read_as_they_were_written() {
    for seed in 0..3000 {
        let (text, moves) = random_program(seed);
        let program = GcodeProgram::from_bytes(text.as_bytes(), Path::new("random.ngc"), &GcodeOptions::default())
            .unwrap_or_else(|e| panic!("seed {seed}: {e}\n{text}"));
        assert_eq!(program.moves.len(), moves.len(), "seed {seed}\n{text}");
        for (found, expected) in program.moves.iter().zip(&moves) {
            let difference = difference(found, expected);
            assert!(difference < 1e-9, "seed {seed}: {difference}: {found:?} is not {expected:?}\n{text}");
        }
    }
}
