//! What is refused in G-code programs, and at which place.

use std::path::Path;

use robot_cr7::{GcodeFault, GcodeOptions, GcodeProgram, InputError, MoveKind};

use crate::gcode_texts::{moves, program, read, refused, refused_in_line};

#[test]
fn a_message_names_file_line_column_word_rule_and_remedy() {
    let e = read("G21 G0 X0 Y0\n(second)\n G41 D1 G1 X5 F100\n").expect_err("no compensation");
    let expected = "a.ngc:3:2: G41: cutter compensation is not supported; post-process with compensation in the CAM";
    assert_eq!(e.to_string(), expected);
    match e {
        InputError::Gcode { line: 3, column: 2, word, fault, .. } => {
            assert_eq!(word, "G41");
            assert!(matches!(*fault, GcodeFault::Unsupported { .. }));
        }
        e => panic!("{e:?}"),
    }
}

#[test]
fn codes_that_would_change_the_motion_are_refused() {
    let cases = [
        ("G41 D1", "cutter compensation"),
        ("G42.1 D3", "cutter compensation"),
        ("G43 H1", "tool length"),
        ("G43", "tool length"),
        ("G43.1 Z1", "tool length"),
        ("G81 X1 Z-1 R2", "canned cycle"),
        ("G83 X1", "canned cycle"),
        ("G73 X1", "canned cycle"),
        ("G92 X0", "origin"),
        ("G52 X1", "origin"),
        ("G10 L2 P1 X1", "offsets"),
        ("G28", "position of the machine"),
        ("G30 Z1", "position of the machine"),
        ("G53 G0 X1", "machine coordinates"),
        ("G33 Z1 K1", "spindle"),
        ("G33.1 Z1 K1", "spindle"),
        ("G38.2 Z1", "probing"),
        ("G76 P1", "canned cycle"),
        ("G71 Q1", "lathe"),
        ("G7", "diameter"),
        ("G18.1", "axes U V W"),
        ("G55", "coordinate system"),
        ("G59.3", "coordinate system"),
        ("M98 P1", "subroutine"),
        ("M99", "subroutine"),
        ("M70", "modal state"),
        ("O100 sub", "O word"),
        ("o<name> call", "O word"),
        ("O1 if [1 EQ 1]", "O word"),
        ("O7 X1", "O word"),
        ("U1", "axis U, V or W"),
    ];
    for (text, part) in cases {
        refused_in_line(text, 1, &[part]);
    }
    refused_in_line("G2.2 X1 Y1 P1", 1, &["NURBS block", "write G5.2"]);
    for text in ["G1.5", "G999", "G6", "G1.05", "G-1", "M1000", "M1.5"] {
        refused_in_line(text, 1, &["not known"]);
    }
}

#[test]
fn bad_words_have_their_column() {
    refused_in_line("G1 X", 4, &["X", "number is missing"]);
    refused_in_line("G1 X Y5", 4, &["known function"]);
    refused_in_line("G1 X5 Y-", 7, &["Y", "number is missing"]);
    refused_in_line("G1 X.", 4, &["no digits"]);
    refused_in_line("G1 X1.2.3", 4, &["two decimal points"]);
    refused_in_line("G1 X1e5", 6, &["E5", "no code of the block uses"]);
    refused_in_line("G1 Xnan", 4, &["known function"]);
    refused_in_line("G1 X1000000001", 4, &["1000000001", "between -1e9 and 1e9"]);
    refused_in_line("G1 X1 F1e", 9, &["number is missing"]);
    refused_in_line("G1 X[1/0]", 6, &["divides by 0"]);
    refused_in_line("G1 X5 Y2 X6", 10, &["column 4"]);
    refused_in_line("G1 X5 ? Y6", 7, &["starts with a letter"]);
    refused_in_line("G1 X5 é", 7, &["ASCII"]);
    refused_in_line("G1 X5 D2", 7, &["no code of the block uses"]);
    refused_in_line("N5 N6 X1", 4, &["column 1"]);
    refused_in_line("N-5 X1", 1, &["whole numbers"]);
    refused_in_line("X#7", 1, &["no value"]);
    refused_in_line("#5221=3", 1, &["1 to 5000"]);
    refused_in_line("#3", 1, &["without its word"]);
    refused_in_line("T1.5", 1, &["whole numbers"]);
    refused_in_line("S-1 M3", 1, &["not below 0"]);
    refused_in_line("F-1", 1, &["not below 0"]);
    refused_in_line("G4", 1, &["time"]);
    refused_in_line("G4 X2", 1, &["time"]);
    refused_in_line("G4 P-1", 4, &["not below 0"]);
    refused_in_line("G64 P-1", 5, &["not below 0"]);
    refused_in_line("G1 (never ends X5", 4, &["no end"]);
    refused_in_line(&format!("G1 X5 ({})", "x".repeat(4100)), 4097, &["4096 bytes"]);
    // A coordinate of a sum of increments.
    let far = "G91 G0 X1000000000\n".repeat(2);
    refused(&format!("G21\n{far}"), 3, 1, &["1e6 m"]);
}

#[test]
fn a_block_holds_one_code_of_a_group() {
    let pairs = [
        "G0 G1 X1",
        "G17 G18",
        "G20 G21",
        "G90 G91",
        "G90.1 G91.1",
        "G93 G94",
        "G40 G40",
        "G54 G55",
        "G61 G64",
        "G96 G97",
        "M3 M5",
        "M0 M2",
        "M6 M6",
    ];
    for pair in pairs {
        let second = 2 + pair.find(' ').expect("two codes");
        let first = &pair[..second - 2];
        refused_in_line(pair, second, &[&format!("{first} already")]);
    }
    refused_in_line("G4 G64 P1", 8, &["G4 and G64"]);
    refused_in_line("G64 G2 X0 I-5 P1", 15, &["G64 and G2"]);
    refused_in_line("M62 G3 X0 I-5 P1", 15, &["G3 and M62"]);
    assert_eq!(program("M7 M8\nM5 M9\nM62 P1\nM66 P0 L3 Q5").markers.len(), 6);
}

#[test]
fn feed_moves_need_a_feed() {
    refused("G21\nG1 X1", 2, 1, &["needs a feed", "write F"]);
    refused("G21 F0\nG1 X1", 2, 1, &["needs a feed"]);
    refused("G21\nG2 X1 R5", 2, 1, &["needs a feed"]);
    refused("G21\nG5.2 X1 Y1", 2, 1, &["needs a feed"]);
    refused("G21\nG5.1 X1 Y1 I1", 2, 1, &["needs a feed"]);
    refused("G21 F100\nG93\nG1 X1", 3, 1, &["needs a feed"]);
    refused("G21 G93 G1 X1 F2\nX2", 2, 1, &["own F"]);
    refused("G21 G95 F2\nG1 X1", 2, 1, &["spindle speed"]);
    refused("G21 G96 S100\nG95 F2\nG1 X1", 3, 1, &["G96"]);
    // A change of the mode clears F.
    refused("G21 G93 G1 X1 F2\nG94 X2", 2, 1, &["needs a feed"]);
    assert_eq!(moves("G93 G1 X20 F4")[0].kind, MoveKind::InverseTime { seconds: 15.0 });
}

#[test]
fn arcs_that_cannot_be() {
    // Each starts in X10.
    refused_in_line("G2 X0", 1, &["centre or its radius"]);
    refused_in_line("G2", 1, &["centre or its radius"]);
    refused_in_line("G2 X0 R5 I1", 7, &["either R or I"]);
    refused_in_line("G2 X0 I-5 K1", 11, &["along the axis"]);
    refused_in_line("G18 G2 X0 I-5 J1", 15, &["along the axis"]);
    refused_in_line("G2 X10 R5", 1, &["another point"]);
    refused_in_line("G2 X0 R4.9", 1, &["0.0049", "0.01 m apart"]);
    refused_in_line("G2 X0 R0", 1, &["radius"]);
    refused_in_line("G2 X0 I0 J0", 1, &["0.00127 mm"]);
    refused_in_line("G90.1 G2 X0 I5", 7, &["both coordinates"]);
    refused_in_line("G2 X0 I-5 P1.5", 11, &["whole number"]);
    refused_in_line("G2 X0 I-5 P0", 11, &["whole number"]);
    refused_in_line("G2 X0 I-5 P20000", 11, &["10000"]);
}

#[test]
fn splines_need_their_words() {
    refused_in_line("G5 X20 P1 Q1", 1, &["needs I and J"]);
    refused_in_line("G5 X20 I1 P1 Q1", 1, &["both I and J"]);
    refused_in_line("G5 X20 I1 J1 P1", 1, &["P and Q"]);
    refused_in_line("G5 X20 Z1 I1 J1 P1 Q1", 8, &["X and Y only"]);
    refused_in_line("G18 G5 X20 I1 J1 P1 Q1", 1, &["G17"]);
    refused_in_line("G5.1 X20", 1, &["I or J"]);
    refused_in_line("G5.3", 1, &["G5.2"]);
    refused_in_line("G5 X10 I0 J0 P0 Q0", 1, &["not all the same"]);
    // A line between ends the series.
    refused("G21 G90 F9\nG5 X1 I1 J1 P1 Q1\nG1 X5\nG5 X9 P1 Q1", 4, 1, &["first G5"]);
}

#[test]
fn nurbs_blocks_are_complete() {
    let start = "G21 G90 F9 G0 X0 Y0\n";
    let refused = |text: &str, line, column, parts: &[&str]| refused(&format!("{start}{text}"), line, column, parts);
    refused("G5.2 X1 Y1\nG1 X2", 3, 1, &["G5.3"]);
    refused("G5.2 X1 Y1\nM3", 3, 1, &["G5.3"]);
    refused("G5.2 X1 Y1 L3\n", 2, 1, &["ends within a NURBS block"]);
    refused("G5.2 X1 Y1\nG5.3", 3, 1, &["as many control points as its order"]);
    refused("G5.2 L4 X1 Y1\nX2\nG5.3", 4, 1, &["as many control points as its order"]);
    refused("G5.2 L1 X1 Y1", 2, 6, &["2 to 16"]);
    refused("G5.2 X1 Y1 P0", 2, 12, &["above 0"]);
    refused("G5.2 X1\nP2", 3, 1, &["first line of G5.2"]);
    refused("G5.2 X1 A3", 2, 9, &["X, Y and Z only"]);
    refused("G91 G5.2 X1", 2, 1, &["G90"]);
    refused("G6.2 X0 Y0 P3", 2, 1, &["has a knot"]);
    refused("G6.2 X5 Y0 P3 K0", 2, 1, &["present position", "0.005"]);
    refused("G6.2 X0 Y0 P3 K0 Q4", 2, 18, &["1, 2 or 3"]);
    refused("G6.2 X0 Y0 P17 K0", 2, 12, &["2 to 16"]);
    refused("G6.2 P2 K0\nX1 K0\nK1\nG1 X3", 5, 1, &["as many knots"]);
    refused("G6.2 P2 K0\nX1 K0\nK1\nX2 K2", 5, 1, &["behind a knot alone"]);
    refused("G6.2 P2 K0\nX1 K-1", 3, 4, &["must not decrease"]);
    refused("G6.2 P2 K0\nX1 K1\nK2\nK3", 5, 1, &["first P knots"]);
    refused("G6.2 P3 K0\nX1 K0\nX2 K0\nX3 K1 R-1", 5, 7, &["above 0"]);
    refused("G6.2 P2 K0\nK1\nK1", 4, 1, &["as many control points as its order"]);
    // The rules of curves of the geometry crate.
    refused("G6.2 P2 K0 R1\nX1 K0 R0.0000000000001\nX2 K0.5\nK1\nK1", 6, 1, &["weight"]);
    let good = program(&format!("{start}G6.2 P2 K0 Q1\nX1 K0\nK1\nG6.2 K1\nG1 X3"));
    assert_eq!(good.moves.len(), 2);
    // No motion is in force behind a NURBS block.
    refused("G6.2 P2 K0\nX1 K0\nK1\nK1\nX3", 6, 1, &["no motion is in force"]);
}

#[test]
fn no_motion_is_in_force_at_the_start_and_behind_g80() {
    refused("G21\nX1", 2, 1, &["no motion is in force", "G0"]);
    refused("G21 G0 X1\nG80\nX2", 3, 1, &["no motion is in force"]);
    refused("G21 G0 X1\nG80 X2", 2, 1, &["no motion is in force"]);
}

#[test]
fn files_that_are_no_programs() {
    let says = |bytes: &[u8], part: &str| {
        let e = GcodeProgram::from_bytes(bytes, Path::new("a.ngc"), &GcodeOptions::default());
        let e = e.expect_err("no program").to_string();
        assert!(e.contains(part) && e.contains("a.ngc"), "{e}");
    };
    says(b"", "empty");
    says(b" \n(comment)\n%\n", "empty");
    says(b"\x00\x01", "a.ngc:1:1");
    says(&[b'9'; 100_000], "4096 bytes");
    says(b"\xff\xfeG\x000\x00", "ASCII");
    let e = GcodeProgram::read(Path::new("no/such.ngc"), &GcodeOptions::default()).expect_err("no file").to_string();
    assert!(e.contains("such.ngc") && e.contains("check the name"), "{e}");
}
