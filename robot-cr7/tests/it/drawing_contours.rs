//! Contours of drawings: order, direction, layers, lifts, units and lines.

use std::path::Path;

use robot_cr7::{
    DrawingOptions, GcodeMarker, GcodeProgram, LengthUnit, MarkerKind, MoveKind, MoveShape, PathControl, read_drawing,
};

use crate::drawing_texts::{
    assert_near, contours, dxf, dxf_in, entity, mm, page, places, read, read_with, refusal, svg,
};

fn layers(names: &[&str]) -> DrawingOptions {
    DrawingOptions { layers: names.iter().map(|&name| name.to_owned()).collect(), ..DrawingOptions::default() }
}

fn unit(unit: LengthUnit) -> DrawingOptions {
    DrawingOptions { unit: Some(unit), ..DrawingOptions::default() }
}

fn marks(program: &GcodeProgram) -> Vec<String> {
    let text = |mark: &GcodeMarker| match &mark.kind {
        MarkerKind::Message(text) => text.clone(),
        kind => panic!("{kind:?}"),
    };
    program.markers.iter().map(text).collect()
}

#[test]
fn touching_entities_are_one_contour_in_the_order_of_the_file() {
    let text = "0 LINE 8 0 10 0 20 0 11 10 21 0\n0 ARC 8 0 10 10 20 5 40 5 50 270 51 90\n0 LINE 8 0 10 10 20 10 11 0 21 10\n\
                0 LINE 8 0 10 50 20 0 11 40 21 0\n0 LINE 8 0 10 50 20 0 11 60 21 0";
    let program = read(&dxf(text), "a.dxf");
    let expected = [[(0.0, 0.0), (0.0, 10.0)], [(50.0, 0.0), (40.0, 0.0)], [(50.0, 0.0), (60.0, 0.0)]];
    let found = contours(&program);
    assert_eq!(found.len(), 3, "the last two touch with the same ends: their directions are kept");
    for (found, expected) in found.iter().zip(expected) {
        found.iter().zip(expected).for_each(|(found, (x, y))| assert_near(*found, mm(x, y, 0.0)));
    }
    assert_eq!(program.markers.iter().map(|mark| mark.after).collect::<Vec<_>>(), [0, 6, 10]);
}

#[test]
fn ends_within_a_micrometre_touch_and_are_moved_together() {
    // The arc, the spline and the line are off by less than 1 um each; the last gap closes the contour.
    let text = |gap: f64| {
        format!(
            "0 LINE 8 0 10 0 20 0 11 10 21 0\n0 ARC 8 0 10 10 20 {} 40 5 50 270 51 90\n\
             0 SPLINE 8 0 71 2 40 0 40 0 40 0 40 1 40 1 40 1 10 10 20 {} 10 5 20 20 10 0 20 10\n\
             0 LINE 8 0 10 0 20 {} 11 {gap} 21 0",
            5.0 + gap,
            10.0 + 2.0 * gap,
            10.0 + gap
        )
    };
    let program = read(&dxf(&text(6e-4)), "a.dxf");
    assert_eq!((contours(&program).len(), program.moves.len()), (1, 4));
    assert_eq!(program.moves[3].end(), program.start);
    let mut end = program.start;
    for (start, step) in program.moves_with_starts() {
        assert!((start - end).norm() < 1e-9);
        end = step.end();
        if let MoveShape::Curve(curve) = &step.shape {
            assert_near(curve.control_points()[0], start);
        }
    }
    let joined = program.joined().expect("a path");
    assert!((joined.start() - joined.end()).norm() < 1e-12);
    // No point is farther off than the gaps.
    for p in places(&program, 40).iter().skip(41).take(41) {
        assert!(((p - mm(10.0, 5.0, 0.0)).norm() - 5e-3).abs() < 1.3e-6, "{p}");
    }
    assert_eq!(contours(&read(&dxf(&text(0.0)), "a.dxf")).len(), 1);
    assert_eq!(contours(&read(&dxf(&text(1.1e-3)), "a.dxf")).len(), 4);
    // An arc that touches exactly stays one.
    let program = read(&dxf(&text(0.0)), "a.dxf");
    assert!(matches!(program.moves[1].shape, MoveShape::Arc { .. }));
}

/// The knot in the middle stands twice, and the two points there are moved together.
#[test]
fn a_curve_with_a_full_knot_is_moved_to_close_its_contour() {
    let text = "0 LINE 8 0 10 0 20 0 11 10 21 0\n\
                0 SPLINE 8 0 71 1 40 0 40 0 40 1 40 1 40 2 40 2 10 10 20 0 10 10 20 10 10 10 20 10 10 0 20 5e-4";
    for more in ["", "\n0 LINE 8 0 10 50 20 0 11 60 21 0"] {
        let program = read(&dxf(&format!("{text}{more}")), "a.dxf");
        let MoveShape::Curve(curve) = &program.moves[1].shape else { panic!("{:?}", program.moves[1]) };
        let points = curve.control_points();
        assert_eq!((points[1], points[3]), (points[2], mm(0.0, 0.0, 0.0)));
        assert!((points[1] - mm(10.0, 10.0, 0.0)).norm() < 3e-7);
    }
}

#[test]
fn pieces_without_length_are_left_out_with_a_warning() {
    let text = "0 LINE 8 0 10 0 20 0 11 10 21 0\n0 LINE 8 0 10 99 20 9 11 99 21 9\n0 LINE 8 0 10 10 20 0 11 10 21 5";
    let program = read(&dxf(text), "a.dxf");
    assert_eq!((program.moves.len(), contours(&program).len()), (2, 1));
    assert!(program.warnings[0].contains("1 pieces shorter than 1e-9 m"), "{:?}", program.warnings);
}

#[test]
fn the_tool_is_lifted_between_contours_and_not_otherwise() {
    let text = "0 LINE 8 0 10 0 20 0 30 2 11 10 21 0 31 2\n0 LINE 8 0 10 30 20 5 30 9 11 40 21 5 31 9\n0 CIRCLE 8 0 10 70 20 0 40 3";
    let options = DrawingOptions { lift: 7e-3, feed: 0.03, ..DrawingOptions::default() };
    let program = read_with(&dxf(text), "a.dxf", &options);
    // Above the highest point.
    let ends = [
        mm(10.0, 0.0, 2.0),
        mm(10.0, 0.0, 16.0),
        mm(30.0, 5.0, 16.0),
        mm(30.0, 5.0, 9.0),
        mm(40.0, 5.0, 9.0),
        mm(40.0, 5.0, 16.0),
        mm(73.0, 0.0, 16.0),
        mm(73.0, 0.0, 0.0),
        mm(73.0, 0.0, 0.0),
    ];
    assert_eq!(program.moves.len(), ends.len());
    program.moves.iter().zip(ends).for_each(|(step, end)| assert_near(step.end(), end));
    let rapid: Vec<bool> = program.moves.iter().map(|step| step.kind == MoveKind::Rapid).collect();
    assert_eq!(rapid, [false, true, true, true, false, true, true, true, false]);
    assert!(program.moves.iter().all(|s| s.kind == MoveKind::Rapid || s.kind == MoveKind::Feed { speed: 0.03 }));
    // The ends of contours are reached: no blend in front of the lift and behind it.
    let exact: Vec<bool> = program.moves.iter().map(|step| step.control == Some(PathControl::ExactPath)).collect();
    assert_eq!(exact, [true, false, false, true, true, false, false, true, false]);
    assert!(program.moves.windows(2).all(|pair| pair[0].line < pair[1].line));
    let one = read(&dxf("0 CIRCLE 8 0 10 70 20 0 40 3"), "a.dxf");
    assert!(one.moves.iter().all(|step| step.kind != MoveKind::Rapid));
    // Also above what lies in between: a line, the bow of an arc on edge, the control points of a curve.
    let between = [
        ("0 LINE 8 0 10 30 20 0 30 9 11 40 21 0 31 9", 9.0),
        ("0 ARC 8 0 10 30 20 5 30 0 40 5 50 10 51 170 210 0 220 -1 230 0", 10.0),
        ("0 ARC 8 0 10 30 20 5 30 0 40 5 50 190 51 350 210 0 220 -1 230 0", 5.0 - 5.0 * f64::to_radians(10.0).sin()),
        ("0 ARC 8 0 10 -30 20 5 30 0 40 5 50 10 51 170 210 0 220 1 230 0", 10.0),
        ("0 SPLINE 8 0 71 2 40 0 40 0 40 0 40 1 40 1 40 1 10 30 20 0 30 1 10 35 20 0 30 7 10 40 20 0 30 2", 7.0),
    ];
    for (entity, top) in between {
        let ends = ["0 LINE 8 0 10 0 20 0 11 10 21 0", "0 LINE 8 0 10 60 20 0 11 70 21 0"];
        let program = read_with(&dxf(&[ends[0], entity, ends[1]].join("\n")), "a.dxf", &options);
        let crossings: Vec<f64> = program
            .moves_with_starts()
            .filter(|(start, step)| (step.end() - start).xy().norm() > 1e-9 && step.kind == MoveKind::Rapid)
            .map(|(_, step)| step.end().z)
            .collect();
        assert_eq!(crossings.len(), 2, "{entity}");
        assert!(crossings.iter().all(|z| (z - 1e-3 * (top + 7.0)).abs() < 1e-12), "{crossings:?} over {entity}");
    }
    // Above one another: up and down alone.
    let above = read(&dxf("0 CIRCLE 8 0 10 0 20 0 40 3\n0 CIRCLE 8 0 10 0 20 0 30 9 40 3"), "a.dxf");
    assert_eq!(above.moves.len(), 4);
}

#[test]
fn moves_have_the_lines_of_their_entities_and_vertices() {
    let text =
        dxf("0 LINE 5 1F 8 cut 10 0 20 0 11 10 21 0\n0 LWPOLYLINE 8 cut 90 3 70 1 10 50 20 0 10 60 20 0 10 60 20 9");
    let line = |what: &str, nth: usize| {
        let mut lines = (1u64..).zip(text.lines()).filter(|(_, line)| *line == what);
        lines.nth(nth).expect("a line").0
    };
    let program = read(&text, "a.dxf");
    let second = line("LWPOLYLINE", 0);
    let found: Vec<u64> = program.moves.iter().map(|step| step.line).collect();
    let vertices = [line("50", 0), line("60", 0), line("60", 1)];
    assert_eq!(found, [line("LINE", 0), second - 3, second - 2, second - 1, vertices[0], vertices[1], vertices[2]]);
    assert!(program.warnings.is_empty(), "{:?}", program.warnings);
    let expected = [
        format!("contour 1: LINE (handle 1F) at line {}, layer \"cut\"", line("LINE", 0)),
        format!("contour 2: LWPOLYLINE at line {second}, layer \"cut\""),
    ];
    assert_eq!(marks(&program), expected);
    assert_eq!(program.markers[1].line, vertices[0]);
    // Several moves of a line are counted.
    let program = read(&svg("<rect width='5' height='5'/>\n<g id='a'><line id='b' x1='50' x2='60'/></g>"), "a.svg");
    assert_eq!(program.moves.iter().map(|step| step.line).collect::<Vec<_>>(), [1, 2, 3, 4, 5, 6, 7, 8]);
    assert!(program.warnings[0].contains("count the moves from 1"), "{:?}", program.warnings);
    assert_eq!(marks(&program), ["contour 1: rect at line 2", "contour 2: line \"b\" at line 3, layer \"a\""]);
    assert_eq!(program.markers[1].line, 8);
}

#[test]
fn layers_of_a_dxf_drawing_are_selected_by_name() {
    let table = "0\nSECTION\n2\nTABLES\n0\nTABLE\n2\nLAYER\n".to_owned()
        + &entity("0 LAYER 2 cut 70 0 62 1 0 LAYER 2 off 70 0 62 -1 0 LAYER 2 frozen 70 1 62 1 0 ENDTAB 0 ENDSEC");
    let line = |layer: &str, x: f64| entity(&format!("0 LINE 8 {layer} 10 {x} 20 0 11 {x} 21 9"));
    let lines = line("cut", 1.0) + &line("off", 2.0) + &line("frozen", 3.0) + &line("more", 4.0);
    let text = dxf_in("4", &table, &lines);
    let starts = |options: &DrawingOptions| {
        let program = read_with(&text, "a.dxf", options);
        let starts = contours(&program).iter().map(|ends| (ends[0].x * 1e3).round()).collect::<Vec<_>>();
        (starts, program.warnings.join("\n"))
    };
    let (all, warnings) = starts(&layers(&[]));
    assert_eq!(all, [1.0, 4.0]);
    for part in ["1 x LINE on a layer that is off on layer \"off\"", "1 x LINE on a layer that is frozen"] {
        assert!(warnings.contains(part), "{warnings}");
    }
    assert_eq!(starts(&layers(&["cut"])), (vec![1.0], String::new()));
    assert_eq!(starts(&layers(&["more", "off"])), (vec![2.0, 4.0], String::new()));
    // Upper and lower case are the same, in the job and in the file.
    assert_eq!(starts(&layers(&["CUT", "cut", "OfF"])), (vec![1.0, 2.0], String::new()));
    let mixed = read(&text.replace("8\noff\n", "8\nOFF\n").replace("8\ncut\n", "8\nCut\n"), "a.dxf");
    assert_eq!(contours(&mixed).len(), 2);
    assert!(mixed.warnings[1].contains("1 x LINE on a layer that is off on layer \"OFF\""), "{:?}", mixed.warnings);
    assert!(marks(&mixed)[0].ends_with("layer \"Cut\""), "{:?}", marks(&mixed));
    let message = refusal(&text, "a.dxf", &layers(&["cut", "engave"]));
    for part in ["path.layers", "\"engave\"", "\"cut\", \"frozen\", \"more\", \"off\""] {
        assert!(message.contains(part), "{message}");
    }
}

#[test]
fn layers_of_an_svg_drawing_are_groups_by_label_or_id() {
    let text = svg(
        "<g id='l1' inkscape:label='cut'><line x1='1' x2='1' y2='5'/><g id='deep'><line x1='2' x2='2' y2='5'/></g></g>\n\
                    <g id='l2' inkscape:label='engrave'><line x1='3' x2='3' y2='5'/></g><line x1='4' x2='4' y2='5'/>",
    );
    let starts = |names: &[&str]| {
        let program = read_with(&text, "a.svg", &layers(names));
        contours(&program).iter().map(|ends| (ends[0].x * 1e3).round()).collect::<Vec<_>>()
    };
    assert_eq!(starts(&[]), [1.0, 2.0, 3.0, 4.0]);
    assert_eq!(starts(&["cut"]), [1.0, 2.0]);
    assert_eq!(starts(&["deep"]), [2.0]);
    assert_eq!(starts(&["l2", "deep"]), [2.0, 3.0]);
    let message = refusal(&text, "a.svg", &layers(&["Cut"]));
    assert!(message.contains("\"Cut\"") && message.contains("\"cut\", \"deep\", \"engrave\""), "{message}");
}

#[test]
fn units_of_dxf_are_those_of_the_header() {
    let line = entity("0 LINE 8 0 10 0 20 0 11 12 21 0");
    let metres = [
        (1, 0.3048),
        (2, 3.6576),
        (4, 0.012),
        (5, 0.12),
        (6, 12.0),
        (8, 3.048e-7),
        (9, 3.048e-4),
        (10, 10.9728),
        (13, 1.2e-5),
        (14, 1.2),
    ];
    for (code, expected) in metres {
        let program = read(&dxf_in(&code.to_string(), "", &line), "a.dxf");
        assert!((program.moves[0].end().x - expected).abs() < 1e-15 * 16.0, "unit {code}");
        assert_eq!(program.warnings.len(), usize::from(!(1e-4..=5.0).contains(&expected)), "{:?}", program.warnings);
    }
    for code in ["0", ""] {
        let text = dxf_in(code, "", &line);
        let program = read(&text, "a.dxf");
        assert!((program.moves[0].end().x - 0.012).abs() < 1e-15);
        assert!(program.warnings[0].contains("names no unit"), "{:?}", program.warnings);
        let program = read_with(&text, "a.dxf", &unit(LengthUnit::Inch));
        assert!((program.moves[0].end().x - 0.3048).abs() < 1e-15 && program.warnings.is_empty());
    }
    for code in ["3", "20", "-4", "mm"] {
        let message = refusal(&dxf_in(code, "", &line), "a.dxf", &layers(&[]));
        assert!(message.contains("$INSUNITS") && message.contains(code) && message.contains("4 (mm)"), "{message}");
    }
}

#[test]
fn units_of_svg_are_those_of_the_page() {
    let at = |page: &str, options: &DrawingOptions| {
        let text = format!("<svg {page}><line x1='10' y1='20' x2='30' y2='20'/></svg>");
        let program = read_with(&text, "a.svg", options);
        (program.start * 1e3, program.moves[0].end() * 1e3, program.warnings.join(""))
    };
    let inch = 25.4;
    // The start (10, 20) on the page, in mm from its lower left corner, and the length of the line of 20 units.
    let cases = [
        ("width='100mm' height='50mm' viewBox='0 0 100 50'", (10.0, 30.0), 20.0, true),
        ("width='10cm' height='5cm' viewBox='0 0 200 100'", (5.0, 40.0), 10.0, true),
        ("width='2in' height='1in' viewBox='0 0 100 50'", (10.0 * 0.508, 30.0 * 0.508), 20.0 * 0.508, true),
        ("width='72pt' height='72pt' viewBox='0 0 100 100'", (0.1 * inch, 0.8 * inch), 0.2 * inch, true),
        ("width='100mm' height='50mm'", (10.0 * inch / 96.0, 50.0 - 20.0 * inch / 96.0), 20.0 * inch / 96.0, true),
        ("width='96' height='96px'", (10.0 * inch / 96.0, 76.0 * inch / 96.0), 20.0 * inch / 96.0, false),
        (
            "width='100%' height='100%' viewBox='0 0 96 96'",
            (10.0 * inch / 96.0, 76.0 * inch / 96.0),
            20.0 * inch / 96.0,
            false,
        ),
        ("width='100mm' viewBox='0 0 100 50'", (10.0, 30.0), 20.0, true),
        ("height='50mm' viewBox='0 0 100 50'", (10.0, 30.0), 20.0, true),
        // The box begins elsewhere, and fits into the page with room beside it.
        ("width='100mm' height='50mm' viewBox='-10 -20 50 50'", (25.0 + 20.0, 10.0), 20.0, true),
        (
            "width='100mm' height='50mm' viewBox='0 0 50 50' preserveAspectRatio='xMinYMin meet'",
            (10.0, 30.0),
            20.0,
            true,
        ),
        (
            "width='100mm' height='50mm' viewBox='0 0 50 50' preserveAspectRatio='xMidYMax slice'",
            (20.0, 60.0),
            40.0,
            true,
        ),
        ("width='100mm' height='50mm' viewBox='0 0 50 50' preserveAspectRatio='none'", (20.0, 30.0), 40.0, true),
    ];
    for (page, (x, y), length, stated) in cases {
        let (start, end, warnings) = at(page, &layers(&[]));
        assert!((start.x - x).abs() < 1e-9 && (start.y - y).abs() < 1e-9, "{page}: {start}");
        assert!((end.x - x - length).abs() < 1e-9 && (end.y - y).abs() < 1e-9, "{page}: {end}");
        assert_eq!(warnings.is_empty(), stated, "{page}: {warnings}");
    }
    // Without a height the origin is that of the drawing.
    let (start, ..) = at("", &layers(&[]));
    assert!((start.y + 20.0 * inch / 96.0).abs() < 1e-12, "{start}");
    // The unit of the job is that of a drawing that names none.
    let (start, end, warnings) = at("viewBox='5 0 90 60'", &unit(LengthUnit::Centimetre));
    assert!((start.x - 50.0).abs() < 1e-9 && (start.y - 400.0).abs() < 1e-9 && (end.x - 250.0).abs() < 1e-9, "{start}");
    assert!(warnings.is_empty(), "{warnings}");
    let (start, ..) = at("width='100mm' height='50mm' viewBox='0 0 100 50'", &unit(LengthUnit::Inch));
    assert!((start.x - 10.0).abs() < 1e-9);
    // Lengths of shapes have units of their own, of which 96 px are an inch.
    let program =
        read(&svg("<line x1='1in' y1='2.54cm' x2='72pt' y2='25.4mm'/><line x1='96px' y1='6pc' y2='9'/>"), "a.svg");
    assert_near(program.start, page(96.0, 96.0));
}

#[test]
fn other_entities_are_counted_by_kind_and_layer() {
    let text = "0 TEXT 8 notes 10 0 20 0 1 a\n0 LINE 8 cut 10 0 20 0 11 9 21 0\n0 TEXT 8 notes 10 0 20 0 1 b\n0 TEXT 8 cut 10 0 20 0 1 c\n0 POINT 8 cut 10 0 20 0\n0 HATCH 8 cut\n0 LINE 8 cut 67 1 10 0 20 0 11 9 21 0";
    let warnings = read(&dxf(text), "a.dxf").warnings.join("\n");
    for part in [
        "2 x TEXT on layer \"notes\", first at line 20",
        "1 x TEXT on layer \"cut\"",
        "1 x POINT on layer \"cut\"",
        "1 x HATCH",
        "1 x LINE in paper space",
    ] {
        assert!(warnings.contains(part), "{part} in {warnings}");
    }
    let many: String = (0..3000).map(|i| entity(&format!("0 KIND{i} 8 cut"))).collect();
    let program = read(&dxf_in("4", "", &(many + &entity("0 LINE 8 cut 10 0 20 0 11 9 21 0"))), "a.dxf");
    assert_eq!(program.warnings.len(), 41);
    assert!(program.warnings[40].contains("2960 more entities"), "{}", program.warnings[40]);
}

#[test]
fn names_that_are_not_utf_8_are_read_as_latin_1() {
    let text = dxf("0 LINE 8 kante_? 10 0 20 0 11 9 21 0\n0 LINE 8 more 10 0 20 0 11 9 21 0");
    let bytes: Vec<u8> = text.bytes().map(|byte| if byte == b'?' { 0xfc } else { byte }).collect();
    let program = read_drawing(&bytes, Path::new("a.dxf"), &layers(&["kante_\u{fc}"])).expect("a drawing");
    assert_eq!(program.moves.len(), 1);
    assert!(program.warnings[0].contains("line 22 is not UTF-8"), "{:?}", program.warnings);
}
