//! The sample programs of `data/gcode`, against coordinates that are stated here.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::path::PathBuf;

use arcfeed_geometry::nalgebra::{Vector3, vector};
use arcfeed_geometry::{Curve, NurbsCurve};
use robot_cr7::{GcodeMove, GcodeOptions, GcodeProgram, MarkerKind, MoveKind, MoveShape, PathControl};

use crate::gcode_texts::mm;

fn sample(name: &str) -> GcodeProgram {
    let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("data/gcode").join(name);
    GcodeProgram::read(&file, &GcodeOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

fn assert_near(found: Vector3<f64>, expected: Vector3<f64>) {
    assert!((found - expected).norm() < 1e-12, "{found} is not {expected}");
}

fn assert_ends(program: &GcodeProgram, ends: &[(u64, Vector3<f64>)]) {
    assert_eq!(program.moves.len(), ends.len(), "number of moves");
    for (step, &(line, end)) in program.moves.iter().zip(ends) {
        assert_eq!(step.line, line);
        assert_near(step.end(), end);
    }
}

fn assert_feed(step: &GcodeMove, mm_per_min: f64) {
    match step.kind {
        MoveKind::Feed { speed } => assert!((speed - mm_per_min / 60_000.0).abs() < 1e-15, "{speed}"),
        kind => panic!("{kind:?} is no feed"),
    }
}

#[track_caller]
fn assert_arc(step: &GcodeMove, centre: Vector3<f64>, axis: Vector3<f64>, sweep: f64, rise: f64) {
    let MoveShape::Arc { centre: c, normal, sweep: s, rise: r, .. } = &step.shape else {
        panic!("{:?} is no arc", step.shape)
    };
    assert_near(*c, centre);
    assert_eq!(normal.into_inner(), axis);
    assert!((s - sweep).abs() < 1e-12, "sweep {s} is not {sweep}");
    assert!((r - rise).abs() < 1e-12, "rise {r} is not {rise}");
}

fn curve(step: &GcodeMove) -> &NurbsCurve<3> {
    match &step.shape {
        MoveShape::Curve(curve) => curve,
        shape => panic!("{shape:?} is no curve"),
    }
}

fn codes(program: &GcodeProgram) -> Vec<(u64, usize, MarkerKind)> {
    program.markers.iter().map(|m| (m.line, m.after, m.kind.clone())).collect()
}

fn code(text: &str) -> MarkerKind {
    MarkerKind::Code(text.to_owned())
}

#[test]
fn a_square_with_blends() {
    let program = sample("square.ngc");
    let ends = [
        (4, mm(0.0, 0.0, 5.0)),
        (5, mm(0.0, 0.0, -1.0)),
        (6, mm(40.0, 0.0, -1.0)),
        (7, mm(40.0, 40.0, -1.0)),
        (8, mm(0.0, 40.0, -1.0)),
        (9, mm(0.0, 0.0, -1.0)),
        (10, mm(0.0, 0.0, 5.0)),
    ];
    assert_ends(&program, &ends);
    assert_eq!(program.moves[2].number, Some(40));
    assert_eq!(program.moves[0].kind, MoveKind::Rapid);
    assert_feed(&program.moves[1], 300.0);
    program.moves[2..6].iter().for_each(|step| assert_feed(step, 1200.0));
    let blend = PathControl::Blend { tolerance: Some(5e-5), naive: 5e-5 };
    assert!(program.moves.iter().all(|step| step.control == Some(blend)));
    assert!(program.moves.iter().all(|step| step.rotary.is_none()));
    assert_eq!(codes(&program), [(11, 7, code("M2"))]);
    assert!(program.warnings.is_empty(), "{:?}", program.warnings);
    let starts: Vec<_> = program.moves_with_starts().map(|(start, _)| start).collect();
    assert_eq!(starts.len(), 7);
    assert_near(starts[0], mm(0.0, 0.0, 0.0));
    assert_near(starts[3], mm(40.0, 0.0, -1.0));
}

#[test]
fn a_pocket_with_corners_by_centre_and_by_radius() {
    let program = sample("pocket.ngc");
    let z = Vector3::z();
    let corners = [(52.0, 8.0), (52.0, 32.0), (8.0, 32.0), (8.0, 8.0)];
    for (depth, first) in [(-1.0, 3), (-2.0, 12)] {
        for (i, (x, y)) in corners.into_iter().enumerate() {
            assert_arc(&program.moves[first + 2 * i], mm(x, y, depth), z, FRAC_PI_2, 0.0);
        }
    }
    assert_eq!(program.moves.len(), 20);
    assert_feed(&program.moves[3], 900.0);
    assert_feed(&program.moves[10], 250.0);
    assert_near(program.moves[18].end(), mm(8.0, 0.0, -2.0));
    assert_eq!(program.moves[18].control, Some(PathControl::Blend { tolerance: Some(2e-5), naive: 1e-5 }));
    assert_eq!(program.moves[19].control, Some(PathControl::ExactPath));
    let expected = [
        (3, 0, MarkerKind::Tool(2)),
        (3, 0, code("M6")),
        (4, 0, MarkerKind::SpindleSpeed(9000.0)),
        (4, 0, code("M3")),
        (5, 0, MarkerKind::Message("pocket".to_owned())),
        (7, 1, code("M8")),
        (18, 11, MarkerKind::Dwell { seconds: 0.5 }),
        (31, 20, code("M9")),
        (32, 20, code("M5")),
        (33, 20, code("M30")),
    ];
    assert_eq!(codes(&program), expected);
}

#[test]
fn a_helix_and_arcs_in_every_plane() {
    let program = sample("helix.ngc");
    assert_eq!(program.moves.len(), 6);
    assert_arc(&program.moves[1], mm(0.0, 0.0, 0.0), Vector3::z(), -3.0 * TAU, -6e-3);
    assert_near(program.moves[1].end(), mm(10.0, 0.0, -6.0));
    assert_arc(&program.moves[2], mm(0.0, 0.0, -6.0), Vector3::z(), -TAU, 0.0);
    // From above +Y, Z leads to X: G3 from X10 to X30 passes below.
    assert_arc(&program.moves[4], mm(20.0, 0.0, 2.0), Vector3::y(), PI, 4e-3);
    assert_near(program.moves[4].end(), mm(30.0, 4.0, 2.0));
    // In the YZ plane from Y4 to Y24 with radius 12, the long way clockwise: the centre is above the chord.
    let height = (12.0f64 * 12.0 - 10.0 * 10.0).sqrt();
    let sweep = -(TAU - 2.0 * (10.0f64 / 12.0).asin());
    assert_arc(&program.moves[5], mm(30.0, 14.0, 2.0 + height), Vector3::x(), sweep, 5e-3);
    assert_near(program.moves[5].end(), mm(35.0, 24.0, 2.0));
}

/// The point that an arc reaches after the part `t` of its angle, from its definition.
fn arc_point(start: Vector3<f64>, step: &GcodeMove, t: f64) -> Vector3<f64> {
    let MoveShape::Arc { centre, normal, sweep, rise, .. } = &step.shape else { panic!("no arc") };
    let arm = start - centre;
    let (sin, cos) = (t * sweep).sin_cos();
    centre + arm * cos + normal.cross(&arm) * sin + normal.into_inner() * (t * rise)
}

#[test]
fn arcs_run_from_their_start_to_their_end() {
    for name in ["pocket.ngc", "helix.ngc", "rotary.ngc", "inch.ngc"] {
        let program = sample(name);
        let arcs: Vec<_> =
            program.moves_with_starts().filter(|(_, step)| matches!(step.shape, MoveShape::Arc { .. })).collect();
        assert!(!arcs.is_empty(), "{name} has arcs");
        for (start, step) in arcs {
            assert_near(arc_point(start, step, 1.0), step.end());
        }
    }
}

#[test]
fn cubic_and_quadratic_splines() {
    let program = sample("splines.ngc");
    let bezier = |points: [Vector3<f64>; 4], t: f64| {
        let s = 1.0 - t;
        s * s * s * points[0] + 3.0 * s * s * t * points[1] + 3.0 * s * t * t * points[2] + t * t * t * points[3]
    };
    let first = [mm(0.0, 0.0, 1.0), mm(0.0, 30.0, 1.0), mm(10.0, -20.0, 1.0), mm(10.0, 10.0, 1.0)];
    // The second spline leaves as the first one arrives: I and J are the negative P and Q.
    let second = [mm(10.0, 10.0, 1.0), mm(10.0, 40.0, 1.0), mm(20.0, -20.0, 1.0), mm(20.0, 10.0, 1.0)];
    let third = [mm(20.0, 40.0, 1.0), mm(23.0, 43.0, 1.0), mm(27.0, 43.0, 1.0), mm(30.0, 40.0, 1.0)];
    for (index, points) in [(1, first), (2, second), (5, third)] {
        for t in [0.0, 0.2, 0.5, 0.9, 1.0] {
            assert_near(curve(&program.moves[index]).point(t), bezier(points, t));
        }
        assert_feed(&program.moves[index], 500.0);
    }
    // y = x^2 / 10 in mm, as the control point lies at (0, -40).
    for t in [0.0, 0.3, 0.5, 1.0] {
        let x = -20.0 + 40.0 * t;
        assert_near(curve(&program.moves[4]).point(t), mm(x, x * x / 10.0, 1.0));
    }
}

#[test]
fn a_nurbs_block_with_uniform_knots() {
    let program = sample("nurbs_g5.ngc");
    assert_eq!(program.moves.len(), 3);
    assert_eq!(program.moves[1].line, 4);
    assert_feed(&program.moves[1], 600.0);
    let curve = curve(&program.moves[1]);
    assert_eq!(curve.degree(), 3);
    assert_eq!(curve.weights(), [2.0, 1.0, 1.5, 1.0, 1.0, 1.0]);
    assert_eq!(curve.knots().as_slice(), [0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 3.0, 3.0, 3.0]);
    assert_near(curve.point(0.0), mm(10.0, 0.0, 0.0));
    assert_near(curve.point(3.0), mm(-20.0, 10.0, 0.0));
    // At u = 1 the functions of the clamped uniform knots are 1/4, 7/12 and 1/6 for the points 1 to 3.
    let (a, b, c) = (0.25, 7.0 / 12.0 * 1.5, 1.0 / 6.0);
    let sum = a * mm(20.0, 10.0, 0.0) + b * mm(20.0, 30.0, 0.0) + c * mm(0.0, 40.0, 0.0);
    assert_near(curve.point(1.0), sum / (a + b + c));
    assert_near(program.moves[2].end(), mm(-20.0, 10.0, 5.0));
}

#[test]
fn a_nurbs_curve_with_knots_is_a_half_circle() {
    let program = sample("nurbs_g6.ngc");
    assert_eq!(program.moves.len(), 3);
    let curve = curve(&program.moves[1]);
    assert_eq!(curve.degree(), 2);
    assert_eq!(curve.knots().as_slice(), [0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 2.0]);
    for i in 0..=20 {
        let point = curve.point(0.1 * f64::from(i));
        assert!((point.norm() - 0.025).abs() < 1e-15, "{point}");
        assert!(point.y > -1e-15);
    }
    assert_near(curve.point(0.0), mm(25.0, 0.0, 0.0));
    assert_near(curve.point(1.0), mm(0.0, 25.0, 0.0));
    assert_near(curve.point(2.0), mm(-25.0, 0.0, 0.0));
}

#[test]
fn parameters_and_expressions() {
    let program = sample("variables.ngc");
    let (c, s) = (15.0, 30.0 * (PI / 3.0).sin());
    let ends = [
        (7, mm(30.0, 0.0, 0.0)),
        (8, mm(c, s, 0.0)),
        (9, mm(-c, s, 0.0)),
        (10, mm(-30.0, 0.0, 0.0)),
        (11, mm(-c, -s, 0.0)),
        (12, mm(c, -s, 0.0)),
        (13, mm(30.0, 0.0, 0.0)),
    ];
    assert_ends(&program, &ends);
    assert_feed(&program.moves[1], 800.0);
}

#[test]
fn rotary_axes() {
    let program = sample("rotary.ngc");
    let turns: Vec<_> = program.moves.iter().map(|step| step.rotary.expect("A and B were given")).collect();
    let degrees = |a: f64, b: f64, c: f64| vector![a, b, c].map(f64::to_radians);
    let expected = [
        degrees(0.0, 0.0, 0.0),
        degrees(30.0, 0.0, 0.0),
        degrees(30.0, -90.0, 0.0),
        degrees(30.0, -90.0, 45.0),
        degrees(0.0, -90.0, 45.0),
    ];
    assert_eq!(turns.len(), expected.len());
    turns.iter().zip(expected).for_each(|(&found, expected)| assert_near(found, expected));
    assert_feed(&program.moves[1], 1200.0);
    // 360 degrees a minute.
    match program.moves[2].kind {
        MoveKind::RotaryFeed { speed } => assert!((speed - TAU / 60.0).abs() < 1e-15),
        kind => panic!("{kind:?}"),
    }
    assert_near(program.moves[2].end(), mm(50.0, 0.0, 10.0));
    assert_arc(&program.moves[3], mm(60.0, 0.0, 10.0), Vector3::z(), -PI, 0.0);
    assert_eq!(program.moves[4].kind, MoveKind::InverseTime { seconds: 30.0 });
    assert_near(program.moves[4].end(), mm(0.0, 0.0, 10.0));
}

#[test]
fn inches_and_feed_per_revolution() {
    let program = sample("inch.ngc");
    let ends = [
        (4, mm(25.4, 0.0, 12.7)),
        (6, mm(50.8, 0.0, 12.7)),
        (8, mm(50.8, 25.4, 12.7)),
        (10, mm(25.4, 25.4, 12.7)),
        (13, mm(25.4, 0.0, 12.7)),
    ];
    assert_ends(&program, &ends);
    // 0.01 in a revolution at 20 revolutions a second.
    assert_feed(&program.moves[1], 0.2 * 25.4 * 60.0);
    assert_arc(&program.moves[2], mm(50.8, 12.7, 12.7), Vector3::z(), PI, 0.0);
    // 60 in/min, which G21 does not change.
    assert_feed(&program.moves[2], 60.0 * 25.4);
    assert_feed(&program.moves[3], 60.0 * 25.4);
    assert_feed(&program.moves[4], 600.0);
}

#[test]
fn the_star_is_ten_lines_within_two_millimetres() {
    let program = sample("star.ngc");
    assert_eq!(program.moves.len(), 11);
    let blend = PathControl::Blend { tolerance: Some(2e-3), naive: 2e-3 };
    assert!(program.moves.iter().all(|step| step.control == Some(blend)));
    program.moves[1..].iter().for_each(|step| assert_feed(step, 4800.0));
    assert_near(program.moves[0].end(), mm(0.0, 40.0, 0.0));
    assert_near(program.moves[5].end(), mm(0.0, -15.3, 0.0));
    assert_near(program.moves[10].end(), mm(0.0, 40.0, 0.0));
}

#[test]
fn a_plate_with_twenty_slots() {
    let program = sample("plate.ngc");
    let rapid = |step: &&GcodeMove| step.kind == MoveKind::Rapid;
    assert_eq!((program.moves.len(), program.moves.iter().filter(rapid).count()), (161, 61));
    for (row, column) in [(0, 0), (1, 3), (3, 4)] {
        let (x, y) = (45.0 * f64::from(column), 40.0 * f64::from(row));
        // Eight moves for each slot; the first one leads to it.
        let first = 8 * (5 * row + column) as usize + 1;
        let slot = &program.moves[first..first + 7];
        assert_near(slot[0].end(), mm(x, y, 2.0));
        assert_near(slot[1].end(), mm(x, y, -1.0));
        assert_near(slot[2].end(), mm(x + 24.0, y, -1.0));
        assert_arc(&slot[3], mm(x + 24.0, y + 8.0, -1.0), Vector3::z(), PI, 0.0);
        assert_arc(&slot[5], mm(x, y + 8.0, -1.0), Vector3::z(), PI, 0.0);
        assert_near(slot[6].end(), mm(x, y, 15.0));
        assert_feed(&slot[2], 3000.0);
    }
    let dwells = program.markers.iter().filter(|m| matches!(m.kind, MarkerKind::Dwell { .. }));
    assert_eq!(dwells.map(|m| m.after).collect::<Vec<_>>(), [0, 40, 80, 120]);
    assert!(program.warnings.is_empty(), "{:?}", program.warnings);
}

#[test]
fn every_sample_is_tested() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("data/gcode");
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .expect("the folder is there")
        .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    let tested = include_str!("gcode_samples.rs");
    assert_eq!(names.len(), 11);
    for name in names {
        assert!(tested.contains(&format!("sample(\"{name}\")")), "{name} has no test");
    }
}
