//! Each element of an SVG drawing against its closed form.

use std::f64::consts::{PI, TAU};

use arcfeed_geometry::nalgebra::{Matrix3, Vector2, Vector3};
use robot_cr7::{GcodeProgram, MoveShape};

use crate::drawing_texts::{area, assert_near, assert_relative, contours, length, page, place, places, read, svg};

fn drawn(body: &str) -> GcodeProgram {
    read(&svg(body), "a.svg")
}

fn path(d: &str) -> GcodeProgram {
    drawn(&format!("<path d=\"{d}\"/>"))
}

fn ends(program: &GcodeProgram) -> Vec<Vector3<f64>> {
    program.moves.iter().map(robot_cr7::GcodeMove::end).collect()
}

fn assert_all_near(found: &[Vector3<f64>], expected: &[(f64, f64)]) {
    assert_eq!(found.len(), expected.len(), "{found:?}");
    found.iter().zip(expected).for_each(|(found, &(x, y))| assert_near(*found, page(x, y)));
}

#[test]
fn lines_of_paths_are_absolute_and_relative() {
    let program = path("M10 20 L30 20 H50 V40 l-10 5 h-5 v-5 z");
    assert_near(program.start, page(10.0, 20.0));
    let corners = [(30.0, 20.0), (50.0, 20.0), (50.0, 40.0), (40.0, 45.0), (35.0, 45.0), (35.0, 40.0), (10.0, 20.0)];
    assert_all_near(&ends(&program), &corners);
    // Pairs behind a move are lines, and a path goes on where z led.
    let program = path("m10,20 5,0 0,5z l-5,-5");
    assert_all_near(&ends(&program), &[(15.0, 20.0), (15.0, 25.0), (10.0, 20.0), (5.0, 15.0)]);
}

/// A Bezier curve by its Bernstein polynomials.
fn bezier(points: &[(f64, f64)], t: f64) -> Vector3<f64> {
    let n = points.len() as i32 - 1;
    let choose = |k: i32| (1..=k).fold(1.0, |c, i| c * f64::from(n + 1 - i) / f64::from(i));
    let sum = points.iter().zip(0..).fold((0.0, 0.0), |sum, (&(x, y), k)| {
        let b = choose(k) * t.powi(k) * (1.0 - t).powi(n - k);
        (sum.0 + b * x, sum.1 + b * y)
    });
    page(sum.0, sum.1)
}

#[test]
fn bezier_curves_and_their_smooth_forms_are_exact() {
    let check = |d: &str, curves: &[&[(f64, f64)]]| {
        let program = path(d);
        assert_eq!(program.moves.len(), curves.len(), "{d}");
        for ((start, step), points) in program.moves_with_starts().zip(curves) {
            assert!(matches!(step.shape, MoveShape::Curve(_)), "{d}");
            (0..=10).map(|i| f64::from(i) / 10.0).for_each(|t| assert_near(place(start, step, t), bezier(points, t)));
        }
    };
    let first: &[_] = &[(10.0, 10.0), (20.0, 0.0), (30.0, 25.0), (40.0, 10.0)];
    let second: &[_] = &[(40.0, 10.0), (50.0, -5.0), (60.0, 20.0), (70.0, 30.0)];
    check("M10 10 C20 0 30 25 40 10 S60 20 70 30", &[first, second]);
    check("m10 10 c10-10 20 15 30 0 s20 10 30 20", &[first, second]);
    let first: &[_] = &[(10.0, 10.0), (20.0, 30.0), (30.0, 10.0)];
    let second: &[_] = &[(30.0, 10.0), (40.0, -10.0), (50.0, 10.0)];
    let third: &[_] = &[(50.0, 10.0), (60.0, 30.0), (70.0, 15.0)];
    check("M10 10 Q20 30 30 10 T50 10 t20 5", &[first, second, third]);
    check("m10 10 q10 20 20 0 t20 0 T70 15", &[first, second, third]);
}

#[test]
fn a_retracted_handle_stays_within_a_micrometre() {
    let square = |a: f64| a * a;
    let mut farthest = 0.0f64;
    for (d, points) in [
        ("M10 10 C10 10 40 0 60 40", [(10.0, 10.0), (10.0, 10.0), (40.0, 0.0), (60.0, 40.0)]),
        ("M10 10 C30 60 60 40 60 40", [(10.0, 10.0), (30.0, 60.0), (60.0, 40.0), (60.0, 40.0)]),
        ("M10 10 C10 10 10.5 30 60 10", [(10.0, 10.0), (10.0, 10.0), (10.5, 30.0), (60.0, 10.0)]),
        // A handle of 99 nm, which is left out, on the side of the curve from which the parabola bends away.
        ("M10 10 C10 10.000099 20 10 40 10.38", [(10.0, 10.0), (10.0, 10.000099), (20.0, 10.0), (40.0, 10.38)]),
    ] {
        let program = path(d);
        assert_eq!(program.moves.len(), 2, "{d}");
        let exact: Vec<Vector3<f64>> = (0..=20_000).map(|i| bezier(&points, square(f64::from(i) / 20_000.0))).collect();
        let from_chord = |p: &Vector3<f64>, a: Vector3<f64>, b: Vector3<f64>| {
            let share = ((p - a).dot(&(b - a)) / (b - a).norm_squared()).clamp(0.0, 1.0);
            (p - a - (b - a) * share).norm()
        };
        let near = |p: &Vector3<f64>| {
            exact.windows(2).map(|pair| from_chord(p, pair[0], pair[1])).fold(f64::INFINITY, f64::min)
        };
        let off = places(&program, 60).iter().map(near).fold(0.0, f64::max);
        assert!(off <= 1e-6, "{off} in {d}");
        farthest = farthest.max(off);
        // The pieces meet without a corner, so that the tool does not stop.
        let joined = program.joined().expect("a path");
        assert!(joined.joints().iter().all(|joint| joint.angle < 1e-9), "{:?}", joined.joints());
    }
    assert!(farthest > 0.2e-6, "the tolerance is used: {farthest}");
    // Both handles retracted, and handles on the ends, make lines.
    for d in ["M0 0 C0 0 50 50 50 50", "M0 0 C0 0 0 0 50 50", "M0 0 Q0 0 50 50", "M0 0 Q50 50 50 50"] {
        assert!(matches!(path(d).moves[..], [ref step] if matches!(step.shape, MoveShape::Line { .. })), "{d}");
    }
}

#[test]
fn elliptical_arcs_take_the_way_that_their_flags_say() {
    // Four arcs of a circle of radius 10 through (20, 50) and (30, 50 + sqrt(75) ...): the ends are 10 apart.
    let height = 75.0f64.sqrt();
    for (large, sweep) in [(false, false), (false, true), (true, false), (true, true)] {
        let program = path(&format!("M20 50 A10 10 0 {} {} 30 50", u8::from(large), u8::from(sweep)));
        // Sweep is towards +y of the page first, as seen from +x.
        let up = large == sweep;
        let centre = (25.0, if up { 50.0 - height } else { 50.0 + height });
        assert!(places(&program, 40).iter().all(|p| ((p - page(centre.0, centre.1)).norm() - 0.01).abs() < 1e-12));
        let angle = if large { TAU - PI / 3.0 } else { PI / 3.0 };
        assert_relative(length(&program), 0.01 * angle);
        let MoveShape::Arc { sweep: turned, .. } = program.moves[0].shape else { panic!("{program:?}") };
        assert!((turned.abs() - angle).abs() < 1e-12 && (turned < 0.0) == sweep, "{turned}");
    }
    // Radii that are too small grow; a radius of 0 is a line; an arc to itself is left out.
    assert_relative(length(&path("M20 50 A1 1 0 0 1 40 50")), 0.01 * PI);
    assert_relative(length(&path("M20 50 A0 5 0 0 1 40 50")), 0.02);
    assert_eq!(path("M20 50 A5 5 0 0 1 20 50 L30 50").moves.len(), 1);
}

#[test]
fn an_arc_of_a_turned_ellipse_lies_on_it() {
    let (rx, ry, turn) = (30.0, 10.0, f64::to_radians(20.0));
    let on = |t: f64| {
        let (x, y) = (rx * t.cos(), ry * t.sin());
        (50.0 + x * turn.cos() - y * turn.sin(), 50.0 + x * turn.sin() + y * turn.cos())
    };
    for (from, to) in [(0.2, 1.9), (1.0, 5.5), (2.0, 0.5), (0.0, 1e-4)] {
        let ((x0, y0), (x1, y1)) = (on(from), on(to));
        let (large, sweep) = (u8::from((to - from).abs() > PI), u8::from(to > from));
        let program = path(&format!("M{x0} {y0} A{rx} {ry} 20 {large} {sweep} {x1} {y1}"));
        assert_near(program.moves[0].end(), page(x1, y1));
        for p in places(&program, 64) {
            let (x, y) = (p.x * 1e3 - 50.0, 50.0 - p.y * 1e3);
            let (u, v) = ((x * turn.cos() + y * turn.sin()) / rx, (y * turn.cos() - x * turn.sin()) / ry);
            assert!((u.hypot(v) - 1.0).abs() < 1e-9, "{}", u.hypot(v));
        }
        let (x, y) = on(0.5 * (from + to));
        let middle = places(&program, 64).iter().map(|p| (p - page(x, y)).norm()).fold(f64::INFINITY, f64::min);
        assert!(middle < 2e-3, "{middle}");
    }
}

#[test]
fn basic_shapes_have_their_sizes() {
    // Signs: SVG draws rectangles, circles and ellipses clockwise on the page, and y is turned round.
    let cases = [
        ("<rect x='10' y='20' width='30' height='15'/>", 450.0, 90.0),
        ("<rect x='10' y='20' width='30' height='15' rx='4'/>", 450.0 - (4.0 - PI) * 16.0, 90.0 - 32.0 + TAU * 4.0),
        ("<rect width='30' height='20' rx='99' ry='99'/>", PI * 150.0, f64::NAN),
        ("<circle cx='50' cy='40' r='12'/>", PI * 144.0, TAU * 12.0),
        ("<ellipse cx='50' cy='40' rx='12' ry='7'/>", PI * 84.0, f64::NAN),
        ("<polygon points='10,10 40,10 40,30'/>", 300.0, 50.0 + 1300f64.sqrt()),
    ];
    for (body, expected, around) in cases {
        let program = drawn(body);
        assert_relative(area(&program), -expected * 1e-6);
        if around.is_finite() {
            assert_relative(length(&program), around * 1e-3);
        }
        assert_eq!(contours(&program).len(), 1);
        assert_near(program.moves.last().expect("moves").end(), program.start);
    }
    let program = drawn("<rect x='10' y='20' width='30' height='15' ry='4'/>");
    assert_near(program.start, page(14.0, 20.0));
    let corner = (40.0 - 4.0 + 4.0 * 0.5f64.sqrt(), 24.0 - 4.0 * 0.5f64.sqrt());
    let start = program.moves[0].end();
    assert_near(place(start, &program.moves[1], 0.5), page(corner.0, corner.1));
    let program = drawn("<line x1='1' y1='2' x2='3' y2='4'/><polyline points='10,10 20,10 20 20'/>");
    let ends = contours(&program);
    assert_eq!(ends.len(), 2);
    assert_near(ends[0][0], page(1.0, 2.0));
    assert_near(ends[1][1], page(20.0, 20.0));
    let program = drawn("<circle cx='50' cy='40' r='12'/>");
    assert_near(program.start, page(62.0, 40.0));
    assert_near(place(program.start, &program.moves[0], 0.25), page(50.0, 52.0));
}

#[test]
fn transforms_are_products_of_matrices() {
    let matrix = |[a, b, c, d, e, f]: [f64; 6]| Matrix3::new(a, c, e, b, d, f, 0.0, 0.0, 1.0);
    let turn = |degrees: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        matrix([cos, sin, -sin, cos, 0.0, 0.0])
    };
    let shift = |x: f64, y: f64| matrix([1.0, 0.0, 0.0, 1.0, x, y]);
    let skew = f64::to_radians(15.0).tan();
    let cases = [
        ("translate(5)", shift(5.0, 0.0)),
        ("translate(5,-3) rotate(30)", shift(5.0, -3.0) * turn(30.0)),
        ("rotate(40 50 60)", shift(50.0, 60.0) * turn(40.0) * shift(-50.0, -60.0)),
        ("scale(0.5) skewX(15)", matrix([0.5, 0.0, 0.0, 0.5, 0.0, 0.0]) * matrix([1.0, 0.0, skew, 1.0, 0.0, 0.0])),
        ("skewY(15)scale(.5,.25)", matrix([1.0, skew, 0.0, 1.0, 0.0, 0.0]) * matrix([0.5, 0.0, 0.0, 0.25, 0.0, 0.0])),
        ("matrix(0.6 0.2 -0.3 0.5 7 8)", matrix([0.6, 0.2, -0.3, 0.5, 7.0, 8.0])),
    ];
    for (outer, first) in &cases {
        for (inner, second) in &cases {
            let body = "<path d='M10 10L40 10Q50 20 40 30A20 10 0 0 1 20 30'/><circle cx='30' cy='30' r='9'/>";
            let plain = drawn(body);
            let program = drawn(&format!("<g transform='{outer}'><g transform='{inner}'>{body}</g></g>"));
            let whole = first * second;
            let (plain, program) = (places(&plain, 7), places(&program, 7));
            assert_eq!(plain.len(), program.len());
            for (i, (plain, found)) in plain.iter().zip(&program).enumerate() {
                let p = whole * Vector3::new(plain.x * 1e3, 100.0 - plain.y * 1e3, 1.0);
                // The parameter of a circle that becomes an ellipse is another one.
                if i < 24 {
                    assert_near(*found, page(p.x, p.y));
                }
            }
            let back = whole.try_inverse().expect("no flat transform");
            for p in &program[program.len() - 8..] {
                let q = back * Vector3::new(p.x * 1e3, 100.0 - p.y * 1e3, 1.0);
                let radius = (Vector2::new(q.x, q.y) - Vector2::new(30.0, 30.0)).norm();
                assert!((radius - 9.0).abs() < 1e-9, "{radius} in {outer} {inner}");
            }
        }
    }
}

#[test]
fn a_circle_that_is_turned_and_scaled_alike_stays_an_arc() {
    let program = drawn("<circle cx='30' cy='30' r='9' transform='rotate(33) scale(0.5,-0.5) translate(3,-90)'/>");
    assert!(matches!(program.moves[0].shape, MoveShape::Arc { .. }));
    let program = drawn("<circle cx='30' cy='30' r='9' transform='scale(0.5,0.51)'/>");
    assert!(matches!(program.moves[0].shape, MoveShape::Curve(_)));
}

#[test]
fn copies_are_shown_where_use_says() {
    let body = "<defs><g id='a' transform='scale(2)'><line id='b' x1='1' y1='1' x2='4' y2='1'/></g></defs>\
                <use href='#a' x='10' y='20'/><use xlink:href='#b' transform='translate(50 0)'/>\
                <symbol id='s'><line x1='0' y1='90' x2='5' y2='90'/></symbol><use href='#s'/>";
    let ends = contours(&drawn(body));
    assert_eq!(ends.len(), 3);
    assert_near(ends[0][0], page(12.0, 22.0));
    assert_near(ends[0][1], page(18.0, 22.0));
    assert_near(ends[1][0], page(51.0, 1.0));
    assert_near(ends[2][1], page(5.0, 90.0));
}

#[test]
fn what_is_not_shown_is_not_drawn() {
    let hidden = [
        "<line x2='9' display='none'/>",
        "<g style='fill:red; display:none'><line x2='9'/></g>",
        "<g visibility='hidden'><line x2='9'/></g>",
        "<clipPath><rect width='5' height='5'/></clipPath><mask><line x2='9'/></mask>",
        "<pattern><line x2='9'/></pattern><marker><line x2='9'/></marker><symbol><line x2='9'/></symbol>",
    ];
    for body in hidden {
        let program = drawn(&format!("{body}<line x1='20' y1='20' x2='30' y2='20'/>"));
        assert_eq!(program.moves.len(), 1, "{body}");
        assert!(program.warnings.is_empty(), "{body}: {:?}", program.warnings);
    }
    assert_eq!(drawn("<g visibility='hidden'><line x2='9' visibility='visible'/></g>").moves.len(), 1);
    let switch = "<switch><foreignObject requiredExtensions='x'/><g><line x2='9'/></g><line x2='50'/></switch>";
    assert_eq!(drawn(switch).moves.len(), 1);
    // What is drawn otherwise than on the screen is said.
    let program = drawn("<g clip-path='url(#c)'><line x2='9'/></g><text>a</text><text>b</text><image href='a.png'/>");
    let warnings = program.warnings.join("\n");
    for part in ["1 x clip-path of <g>", "2 x <text>, first at line 2", "1 x <image>"] {
        assert!(warnings.contains(part), "{warnings}");
    }
}

#[test]
fn rules_of_style_sheets_are_named_wherever_they_stand() {
    let rule = |name: &str| format!("1 x rule for \"{name}\" in <style>, which is not applied, first at line 2");
    let line = "<line x2='9'/>";
    let cases: [(&str, &[&str]); 6] = [
        ("<style>.a { DISPLAY : none }</style>", &["display"]),
        ("<defs><style>.a{fill:red;visibility:hidden}</style></defs>", &["visibility"]),
        // A comment divides the text into two nodes.
        ("<style>.a{fill:red}<!-- b -->.b{rotate:9deg;scale:2}</style>", &["rotate", "scale"]),
        ("<style><![CDATA[.a{translate:1px}]]> .b{transform:none}</style>", &["translate", "transform"]),
        ("<symbol><g><style>circle{/* wide */r:5px}</style></g></symbol>", &["r"]),
        ("<style>.a{text-transform:none} #d:hover{fill:red} /* display:none */</style>", &[]),
    ];
    for (body, names) in cases {
        let program = drawn(&format!("{body}{line}"));
        assert_eq!(program.warnings.len(), names.len(), "{body}: {:?}", program.warnings);
        for name in names {
            assert!(program.warnings.iter().any(|warning| warning.contains(&rule(name))), "{:?}", program.warnings);
        }
    }
}

#[test]
fn keywords_of_css_are_read_in_any_case_and_with_importance() {
    let count = |attributes: &str| {
        let program = drawn(&format!("<g {attributes}><line x2='9'/></g>\n\n\n\n<line x1='20' x2='30'/>"));
        assert!(program.warnings.is_empty(), "{attributes}: {:?}", program.warnings);
        contours(&program).len()
    };
    for hidden in [
        "style='display:none !important'",
        "style='display: NONE'",
        "style='Display:none!IMPORTANT;display:inline'",
        "style='/* off */display:none'",
        "display='None'",
        "style='visibility:Hidden ! important'",
        "visibility='COLLAPSE'",
    ] {
        assert_eq!(count(hidden), 1, "{hidden}");
    }
    for shown in [
        "style='display:none;display:inline'",
        "style='display:none;display:inline !important'",
        "style='/* display:none */'",
        "display='none' style='display:inline'",
        "style='visibility:visible !important;visibility:hidden'",
        "style='fill:none'",
    ] {
        assert_eq!(count(shown), 2, "{shown}");
    }
    let visible = "<g visibility='hidden'><line x2='9' style='visibility: VISIBLE'/></g>";
    assert_eq!(drawn(visible).moves.len(), 1);
}

#[test]
fn conditional_children_of_a_switch_are_named() {
    let line = "<line x1='20' x2='30'/>";
    let switch =
        "<switch><g systemLanguage='en'><line x2='9'/></g>\n<g systemLanguage='de'><line x2='5'/></g></switch>";
    let program = drawn(&format!("{switch}{line}"));
    assert_eq!(program.moves.len(), 1);
    let expected = "2 x conditional child of <switch>, first at line 2: not a part of the motion";
    assert_eq!(program.warnings, [expected]);
    // One that is hidden, and one with a child for every reader.
    let program = drawn(&format!("<g visibility='hidden'>{switch}</g>{line}"));
    assert!(program.warnings.is_empty() && program.moves.len() == 1, "{:?}", program.warnings);
    let program = drawn("<switch><g requiredFeatures='x'><line x2='9'/></g><line x2='5'/></switch>");
    assert!(program.warnings.is_empty() && program.moves.len() == 1, "{:?}", program.warnings);
}
