//! Rules of G-code programs: tolerances, modes, markers, and which texts are the same program.

use std::path::Path;

use robot_cr7::{GcodeMove, GcodeOptions, GcodeProgram, LengthUnit, MarkerKind, MoveShape, PathControl};

use crate::gcode_texts::{mm, moves, program, read, refused, refused_in_line};

#[test]
fn codes_without_effect_are_read() {
    let text = "O1234\nG8 G40 G43 H0 G49 G54 G80 G94 G97 G98 G92.1\nG49 G54\nG96 D2000 S200 M3\nG99\nG54 G0 X1\nG54";
    // G43 and G49 set the same.
    refused(text, 2, 15, &["G43 already", "tool length"]);
    let found = program(&text.replace("H0 G49", "H0"));
    assert_eq!(found.moves.len(), 1);
    assert_eq!(program("G21 G90 G80 G40 G00 X1 G54").moves.len(), 1);
    let found = program("G21 G55 G0 X1\nG55 X2");
    assert!(found.warnings[0].contains("G55 is taken as the workpiece frame"), "{:?}", found.warnings);
    refused("G21 G0 X0\nG55 X0", 2, 1, &["coordinate system"]);
}

/// The tolerances of LinuxCNC, in mm: 0.005, or a thousandth of the radius, and never more than 0.5.
#[test]
fn the_radii_of_an_arc_differ_as_linuxcnc_allows() {
    for (radius, good, bad) in [(1.0, 0.0049, 0.0051), (100.0, 0.099, 0.101), (2000.0, 0.49, 0.51)] {
        let quarter = |gap: f64| format!("G2 X{} Y{} I{radius}", 10.0 + radius, radius + gap);
        assert_eq!(moves(&quarter(good)).len(), 1, "{radius}");
        refused_in_line(&quarter(bad), 1, &["starts", "ends"]);
        assert_eq!(moves(&quarter(-good)).len(), 1, "{radius}");
        refused_in_line(&quarter(-bad), 1, &["starts", "ends"]);
    }
    let inches = |gap: f64| read(&format!("G20 G90 F10 G0 X1\nG2 X1.1 Y{} I0.1\n", 0.1 + gap));
    assert!(inches(0.00049).is_ok());
    assert!(inches(0.00051).is_err());
}

#[test]
fn the_centre_of_an_arc_fits_both_ends() {
    for (text, start) in [("G3 X0.004 Y10 I-10", mm(10.0, 0.0, 0.0)), ("G2 X0.004 Y10 I-10", mm(10.0, 0.0, 0.0))] {
        let found = moves(text);
        let MoveShape::Arc { centre, to, sweep, .. } = &found[0].shape else { panic!("no arc") };
        assert!(((start - centre).norm() - (to - centre).norm()).abs() < 1e-15);
        assert!(centre.norm() < 1e-5, "{centre}");
        assert!((to - mm(0.004, 10.0, 0.0)).norm() < 1e-15);
        // The circle through both ends turns by the angle that it is seen under from its centre.
        let turned = (start - centre).angle(&(to - centre));
        let expected = if text.starts_with("G3") { turned } else { turned - std::f64::consts::TAU };
        assert!((sweep - expected).abs() < 1e-9, "{sweep} is not {expected}");
    }
    // 359 degrees with a radius that is 0.004 mm off: the circle through both ends lies 0.23 mm aside.
    let (sin, cos) = 359.0f64.to_radians().sin_cos();
    let text = format!("G3 X{} Y{} I-10", 10.004 * cos, 10.004 * sin);
    refused_in_line(&text, 1, &["at most 0.00005 m"]);
}

#[test]
fn full_circles_and_half_circles() {
    let sweep = |text: &str| match &moves(text)[0].shape {
        MoveShape::Arc { sweep, .. } => sweep.to_degrees(),
        shape => panic!("{shape:?}"),
    };
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a} is not {b}");
    near(sweep("G2 I-5"), -360.0);
    near(sweep("G3 X10 Y0 I3 J4"), 360.0);
    near(sweep("G3 I-5 P3"), 1080.0);
    near(sweep("G3 I-5 Z7 P2"), 720.0);
    near(sweep("G2 X0 R5"), -180.0);
    near(sweep("G3 X0 R-5"), 180.0);
    near(sweep("G3 X0 R4.999"), 180.0);
    near(sweep("G3 X0 I-5 P2"), 540.0);
    near(sweep("G3 X5 Y5 R5"), 90.0);
    near(sweep("G3 X5 Y5 R-5"), 270.0);
    near(sweep("G2 X5 Y5 R5"), -90.0);
    near(sweep("G2 X5 Y5 R-5"), -270.0);
}

#[test]
fn texts_that_are_the_same_program() {
    let plain = "G21 G90\nG0 X1 Y2\nG1 X3 F60\nM2\n";
    let expected = program(plain);
    let same = [
        plain.replace('\n', "\r\n"),
        plain.to_lowercase(),
        plain.trim_end().to_owned(),
        format!("\u{feff}{plain}"),
        plain.replace(' ', ""),
        plain.replace("X1", "  X +0 1 . 0 0 "),
        plain.replace("M2\n", "M2\nG41 this is not read"),
        plain.replace("M2\n", "M2\n%"),
        plain.replace("G0", "(one) G00 (é;)"),
        plain.replace("F60", "F60 ; a (comment (") + "(another)\n;",
    ];
    for text in same {
        let found = program(&text);
        assert_eq!(found.moves, expected.moves, "{text:?}");
        assert_eq!(found.warnings, expected.warnings, "{text:?}");
    }
    let framed = program(&format!("\n%\n{plain}%\nG41"));
    assert_eq!(framed.moves.len(), 2);
    assert_eq!(framed.moves[0].line, 4);
    assert_eq!(program("G21 G0 X1\n%\nX2").moves.len(), 1);
    // Comments need not be UTF-8.
    let latin = GcodeProgram::from_bytes(b"(\xfcber) G21 G0 X1 ; \xe9\n", Path::new("a.ngc"), &GcodeOptions::default());
    assert_eq!(latin.expect("is read").moves.len(), 1);
}

#[test]
fn lines_with_a_slash_are_skipped_unless_told_otherwise() {
    let text = b"G21 G0 X1\n/X2\n/G41\n";
    let with = |block_delete| {
        let options = GcodeOptions { block_delete, ..GcodeOptions::default() };
        GcodeProgram::from_bytes(text, Path::new("a.ngc"), &options)
    };
    assert_eq!(with(true).expect("is read").moves.len(), 1);
    let e = with(false).expect_err("G41 is not skipped").to_string();
    assert!(e.starts_with("a.ngc:3:2: G41"), "{e}");
}

#[test]
fn units_starts_and_limits_are_options() {
    let options = GcodeOptions { unit: LengthUnit::Inch, start: mm(0.0, 5.0, 0.0), ..GcodeOptions::default() };
    let found = GcodeProgram::from_bytes(b"G0 X1\nG91 Y1", Path::new("a.ngc"), &options).expect("is read");
    assert!((found.moves[1].end() - mm(25.4, 30.4, 0.0)).norm() < 1e-15);
    assert_eq!(found.start, options.start);
    assert_eq!(found.warnings, ["line 1: no G20 or G21 before the first coordinate: lengths are taken in in"]);
    let limited = GcodeOptions { most_moves: 3, ..GcodeOptions::default() };
    let read = |text: &str| GcodeProgram::from_bytes(text.as_bytes(), Path::new("a.ngc"), &limited);
    assert!(read("G21 G0 X1\nX2\nM3\n").is_ok());
    let e = read("G21 G0 X1\nX2\nM3\nX4\n").expect_err("four are too many").to_string();
    assert_eq!(e, "a.ngc:4:1: X4: the program has more than 3 moves and markers; divide it");
    assert!(std::mem::size_of::<GcodeMove>() <= 208, "5 million moves take about 1 GB");
}

#[test]
fn assumptions_are_warnings() {
    let found = program("G21 G0 X1 Y0\nX1\nG1 X2 F60\nX2");
    let expected = [
        "line 3: the first feed move starts before Z is given: the start is assumed",
        "line 2: moves without length are left out, 2 in the program",
    ];
    assert_eq!(found.warnings, expected);
    assert_eq!(found.moves.len(), 2);
    // Increments do not say where the tool is.
    let found = program("G21 G91 G0 X1 Y1 Z1\nG1 X1 F60");
    assert!(found.warnings[0].contains("before X Y Z are given"), "{:?}", found.warnings);
}

#[test]
fn a_rotary_axis_that_stays_makes_no_move() {
    assert_eq!(moves("G0 X10 A30\nX10 A30\nG1 A30\nA31").len(), 2);
}

#[test]
fn the_first_line_of_a_nurbs_block_has_one_weight() {
    let weights = |text: &str| match &moves(text)[0].shape {
        MoveShape::Curve(curve) => curve.weights().to_vec(),
        shape => panic!("{shape:?}"),
    };
    // With a point the weight is that of the point, else that of the present position.
    assert_eq!(weights("G5.2 X20 Y1 P2\nX30 Y0 P3\nG5.3"), [1.0, 2.0, 3.0]);
    assert_eq!(weights("G5.2 P2\nX20 Y1\nX30 Y0 P3\nG5.3"), [2.0, 1.0, 3.0]);
}

#[test]
fn path_control_stays_until_it_changes() {
    let found = program("G21 G0 X1\nG61.1 X2\nG64 X3\nG64 P0.1\nX4\nG64 P0.1 Q0 X5\nG64 Q0.2 X6\nG61 X7");
    let controls: Vec<_> = found.moves.iter().map(|step| step.control).collect();
    let blend = |tolerance, naive| Some(PathControl::Blend { tolerance, naive });
    let expected = [
        None,
        Some(PathControl::ExactStop),
        blend(None, 0.0),
        blend(Some(1e-4), 1e-4),
        blend(Some(1e-4), 0.0),
        blend(None, 2e-4),
        Some(PathControl::ExactPath),
    ];
    assert_eq!(controls, expected);
}

#[test]
fn markers_stand_before_the_move_of_their_block_and_stops_behind_it() {
    let found = program("G21 G0 X1\nG4 P2 M3 S5 T7 X2 M0 (MSG, hold)\nM62 P3\nM2 X3");
    let kinds: Vec<_> = found.markers.iter().map(|m| (m.line, m.after, m.kind.clone())).collect();
    let code = |text: &str| MarkerKind::Code(text.to_owned());
    let expected = [
        (2, 1, MarkerKind::Message("hold".to_owned())),
        (2, 1, MarkerKind::SpindleSpeed(5.0)),
        (2, 1, MarkerKind::Tool(7)),
        (2, 1, code("M3")),
        (2, 1, MarkerKind::Dwell { seconds: 2.0 }),
        (2, 2, code("M0")),
        (3, 2, code("M62 P3")),
        (4, 3, code("M2")),
    ];
    assert_eq!(kinds, expected);
}

#[test]
fn parameters_of_a_block_take_effect_behind_it() {
    let found = program("G21 #1=5\nG0 X#1 #1=[#1+1]\nX#1\n#<Far Side>=9 G91\nX#<farside>");
    let ends: Vec<f64> = found.moves.iter().map(|step| step.end().x * 1e3).collect();
    for (end, expected) in ends.iter().zip([5.0, 6.0, 15.0]) {
        assert!((end - expected).abs() < 1e-12, "{ends:?}");
    }
}
