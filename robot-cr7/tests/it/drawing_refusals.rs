//! What is wrong with a drawing is said with its place, and the way out.

use robot_cr7::DrawingOptions;

use crate::drawing_texts::{dxf, dxf_in, entity, read, refusal, svg};

fn says(text: &str, name: &str, parts: &[&str]) {
    let message = refusal(text, name, &DrawingOptions::default());
    for part in [name].iter().chain(parts) {
        assert!(message.contains(part), "\"{part}\" is missing in: {message}");
    }
    assert!(!message.contains('\n') && message.len() < 700, "{message}");
}

#[test]
fn of_dxf_entities() {
    let cases: [(&str, &[&str]); 23] = [
        ("0 CIRCLE 5 2F 8 0 10 1 20 2 40 0", &["a.dxf:20", "CIRCLE (handle 2F)", "radius", "above 0"]),
        ("0 CIRCLE 8 0 10 1 20 2 40 -3", &["radius", "-3"]),
        ("0 CIRCLE 8 0 10 1 20 2", &["group 40", "missing"]),
        ("0 LINE 8 0 10 1 20 nan 11 2 21 3", &["a.dxf:26", "group 20", "\"nan\"", "finite number"]),
        ("0 LINE 8 0 10 1 20 1e999 11 2 21 3", &["\"1e999\"", "finite number"]),
        ("0 LINE 8 0 10 1 20 1,5 11 2 21 3", &["\"1,5\"", "finite number"]),
        ("0 LINE 8 0 10 1 20 1e308 11 2 21 3", &["a coordinate", "1000 km"]),
        ("0 LINE 8 0 10 1 11 2 21 3", &["group 20", "missing"]),
        ("0 ARC 8 0 10 1 20 1 40 1e308 50 0 51 90", &["a coordinate", "1000 km"]),
        ("0 ELLIPSE 8 0 10 1 20 1 11 0 21 0 40 0.5", &["ELLIPSE", "axis of 0", "both axes"]),
        ("0 ELLIPSE 8 0 10 1 20 1 11 5 21 0 40 0", &["ratio of 0", "both axes"]),
        ("0 ARC 8 0 10 1 20 1 40 2 50 0 51 90 210 0 220 0 230 0", &["extrusion direction", "(0, 0, 0)"]),
        ("0 SPLINE 8 0 71 3 11 0 21 0 11 5 21 5", &["none, and 2 fit points", "control points", "polyline"]),
        ("0 SPLINE 8 0 71 0 10 0 20 0 10 5 20 5", &["degree (71)", "0"]),
        ("0 SPLINE 8 0 71 16 10 0 20 0 10 5 20 5", &["degree (71)", "16", "from 1 to 15", "lower degree in CAD"]),
        ("0 SPLINE 8 0 71 999999999999 10 0 20 0 10 5 20 5", &["degree (71)", "999999999999"]),
        ("0 SPLINE 5 7 8 0 71 1 40 0 40 0 40 1 10 0 20 0 10 5 20 5", &["SPLINE (handle 7)", "knots"]),
        ("0 SPLINE 8 0 71 1 40 0 40 0 40 1 40 1 41 1 41 -1 10 0 20 0 10 5 20 5", &["SPLINE", "weight"]),
        ("0 LWPOLYLINE 8 0 90 1 10 0 20 0", &["vertices", "1", "two vertices"]),
        ("0 LWPOLYLINE 8 0 90 2 10 0 10 5 20 0", &["a point", "without y"]),
        ("0 INSERT 5 9 8 0 2 EYE 10 0 20 0", &["INSERT (handle 9)", "\"EYE\"", "has to be in the file"]),
        ("0 TEXT 8 notes 10 0 20 0 1 hello", &["without a line", "1 x TEXT on layer \"notes\"", "path.layers"]),
        ("0 LINE 8 0 10 1 20 1 11 2 21 3 67 x", &["group 67", "\"x\"", "whole number"]),
    ];
    for (text, parts) in cases {
        says(&dxf(text), "a.dxf", parts);
    }
}

#[test]
fn of_dxf_files() {
    let whole = dxf("0 LINE 8 0 10 1 20 2 11 3 21 4");
    let cut = |at: &str| whole[..whole.find(at).expect("it is there") + at.len()].to_owned();
    says("", "a.dxf", &["empty", "ASCII DXF"]);
    says(" \n\n", "a.dxf", &["empty"]);
    says("AutoCAD Binary DXF\r\n\u{1a}\0", "a.dxf", &["binary DXF", "ASCII DXF"]);
    says("hello\nworld\n", "a.dxf", &["a.dxf:1:1", "\"hello\" is not a group code"]);
    says("1\nSECTION\n", "a.dxf", &["group code 1 where a section begins"]);
    says(&cut("LINE\n8\n0\n10\n"), "a.dxf", &["ends within a group", "cut off"]);
    says(&cut("LINE\n8\n0\n10\n1\n"), "a.dxf", &["a.dxf:24", "ends within LINE", "cut off"]);
    says(&cut("ENDSEC\n"), "a.dxf", &["no section ENTITIES"]);
    says(&whole.replace("0\nENDSEC\n0\nEOF\n", ""), "a.dxf", &["ends within LINE", "cut off"]);
    says(&whole.replace("0\nENDSEC\n0\nEOF\n", "0\nEOF\n"), "a.dxf", &["ends before ENDSEC", "cut off"]);
    let nested = |inner: &str| {
        let block = entity("0 BLOCK 8 0 2 A 70 0 10 0 20 0") + inner + &entity("0 ENDBLK 8 0");
        dxf_in("4", &format!("0\nSECTION\n2\nBLOCKS\n{block}0\nENDSEC\n"), &entity("0 INSERT 8 0 2 A 10 0 20 0"))
    };
    says(&nested(&entity("0 INSERT 8 0 2 A 10 0 20 0")), "a.dxf", &["32 deep", "\"A\""]);
    let scaled =
        nested(&entity("0 LINE 8 0 10 0 20 0 11 1 21 1")).replace("20\n0\n0\nENDSEC", "20\n0\n41\n0\n0\nENDSEC");
    says(&scaled, "a.dxf", &["the scale (41, 42, 43)", "(0, 1, 1)"]);
    // A block that another file holds is not opened.
    let external = nested("").replace("70\n0\n10", "70\n4\n10");
    says(&external, "a.dxf", &["1 x INSERT of another file"]);
}

#[test]
fn of_svg_elements() {
    let cases: [(&str, &[&str]); 33] = [
        ("<path id='p' d='M 1 2 L 3'/>", &["a.svg:2", "path \"p\"", "d", "grammar"]),
        ("<path d='L 3 4'/>", &["grammar"]),
        ("<path d='M 0 0 L 1e308 4'/>", &["a coordinate", "1000 km"]),
        ("<path d='M 0 0 L nan 4'/>", &["grammar"]),
        ("<path d='M 0 0 A 1e300 1e-300 0 0 1 5 5'/>", &["path"]),
        ("<circle r='-3'/>", &["circle", "r", "\"-3\"", "below 0"]),
        ("<circle r='3em'/>", &["circle", "\"3em\"", "mm"]),
        ("<circle r='0'/>", &["without a line", "1 x <circle> without a size"]),
        ("<rect width='50%' height='5'/>", &["rect", "\"50%\""]),
        ("<ellipse rx='1' ry='x'/>", &["ellipse", "ry", "\"x\""]),
        ("<polygon points='1 2 3'/>", &["points", "3 numbers"]),
        ("<polyline points='1 2 3 a'/>", &["points", "\"1 2 3 a\"", "finite"]),
        ("<g transform='scale(0)'><line x2='5'/></g>", &["transform", "scale(0)", "areas above 0"]),
        ("<line x2='5' transform='turn(5)'/>", &["transform", "turn(5)"]),
        ("<line x2='5' transform='translate(1e999)'/>", &["transform"]),
        ("<line x2='5' style='transform: rotate(5deg)'/>", &["style", "attribute transform"]),
        (
            "<line id='l' x2='5' transform='scale(2)' style='transform: rotate(5deg)'/>",
            &["line \"l\"", "transform in style", "rotate(5deg)", "attribute transform"],
        ),
        ("<g transform-origin='5 5'><line x2='5'/></g>", &["g: transform-origin", "\"5 5\"", "origin", "matrix"]),
        ("<line x2='5' style='transform-origin:center'/>", &["line: transform-origin in style", "\"center\""]),
        ("<g style='transform-box:fill-box'><line x2='5'/></g>", &["g: transform-box in style", "remove it"]),
        ("<g style='Translate: 5px'><line x2='5'/></g>", &["g: translate in style", "\"5px\"", "attribute transform"]),
        ("<use href='#a' style='rotate:9deg !important'/>", &["use: rotate in style", "\"9deg\""]),
        ("<line x2='5' style='fill:none;scale:2'/>", &["line: scale in style", "\"2\""]),
        ("<circle r='3' style='r:5px'/>", &["circle: r in style", "\"5px\"", "as an attribute"]),
        ("<rect width='3' height='3' style='width:9px'/>", &["rect: width in style", "\"9px\"", "as an attribute"]),
        ("<path d='M0 0H5' style='d:none'/>", &["path: d in style", "\"none\""]),
        ("<use href='#a' style='x:5px'/>", &["use: x in style", "\"5px\""]),
        ("<use href='#none'/>", &["use", "\"#none\"", "has to be in the file"]),
        ("<use href='other.svg#a'/>", &["1 x use of another file"]),
        ("<svg width='5'/>", &["svg within svg", "group"]),
        ("<symbol id='s' viewBox='0 0 1 1'/><use href='#s'/>", &["symbol with a viewBox"]),
        ("<text>hello</text>", &["without a line", "1 x <text>"]),
        ("<line x2='5'", &["a.svg:3", "XML"]),
    ];
    for (body, parts) in cases {
        says(&svg(body), "a.svg", parts);
    }
}

#[test]
fn of_svg_files() {
    says("", "a.svg", &["empty"]);
    says("hello", "a.svg", &["a.svg:1:1", "XML"]);
    says("<html/>", "a.svg", &["outermost element", "svg"]);
    says("<svg></svg>", "a.svg", &["without a line"]);
    for (page, part) in [
        ("width='0'", "above 0"),
        ("height='-5mm'", "above 0"),
        ("width='5em'", "5em"),
        ("width='nan'", "nan"),
        ("viewBox='0 0 100'", "viewBox"),
        ("viewBox='0 0 0 5'", "viewBox"),
        ("viewBox='0 0 5 5' width='5mm' height='9mm' preserveAspectRatio='left'", "preserveAspectRatio"),
    ] {
        says(&format!("<svg {page}><line x2='5'/></svg>"), "a.svg", &["a.svg:1", part]);
    }
    let options = [
        (DrawingOptions { lift: 0.0, ..DrawingOptions::default() }, "lift"),
        (DrawingOptions { lift: f64::NAN, ..DrawingOptions::default() }, "lift"),
        (DrawingOptions { feed: f64::INFINITY, ..DrawingOptions::default() }, "feed"),
        (DrawingOptions { most_pieces: 2, ..DrawingOptions::default() }, "more than the 2 pieces"),
    ];
    for (options, part) in options {
        let message = refusal(&svg("<rect width='5' height='5'/>"), "a.svg", &options);
        assert!(message.contains(part), "{message}");
    }
}

#[test]
fn the_highest_degree_of_a_spline_and_sizes_of_the_page_in_its_style_are_read() {
    let knots = [" 40 0".repeat(16), " 40 1".repeat(16)].concat();
    let points: String = (0..16).map(|i| format!(" 10 {i} 20 {}", i % 2)).collect();
    let text = dxf(&format!("0 SPLINE 8 0 71 15{knots}{points}"));
    assert_eq!(read(&text, "a.dxf").moves.len(), 1);
    let text = svg("<g style='width:5px'><line x2='5'/></g>").replace("<svg ", "<svg style='width:100%;height:auto' ");
    assert_eq!(read(&text, "a.svg").moves.len(), 1);
}
