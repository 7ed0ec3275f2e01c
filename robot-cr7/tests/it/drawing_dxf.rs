//! Each entity of a DXF drawing against its closed form.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use arcfeed_geometry::nalgebra::{Rotation3, Vector3};
use robot_cr7::{MarkerKind, MoveShape};

use crate::drawing_texts::{
    area, assert_near, assert_relative, contours, dxf, dxf_in, entity, length, mm, place, places, read,
};

#[test]
fn a_line_has_its_ends_in_space() {
    let program = read(&dxf("0 LINE 8 0 10 1 20 2 30 3 11 -4 21 5 31 6"), "a.dxf");
    assert_near(program.start, mm(1.0, 2.0, 3.0));
    assert_near(program.moves[0].end(), mm(-4.0, 5.0, 6.0));
    assert!(program.warnings.is_empty(), "{:?}", program.warnings);
}

#[test]
fn circles_and_arcs_run_counter_clockwise_on_their_circle() {
    let program = read(&dxf("0 CIRCLE 8 0 10 10 20 -5 30 2 40 7"), "a.dxf");
    let MoveShape::Arc { centre, sweep, .. } = &program.moves[0].shape else { panic!("{program:?}") };
    assert_near(*centre, mm(10.0, -5.0, 2.0));
    assert_eq!((*sweep, program.moves.len()), (TAU, 1));
    assert_near(program.start, mm(17.0, -5.0, 2.0));
    assert_near(program.moves[0].end(), program.start);
    assert_relative(area(&program), PI * 49e-6);

    // Over 0 degrees, and a turn from an angle to itself.
    for (from, to, sweep) in [(300.0, 60.0, 120.0), (10.0, 250.0, 240.0), (-90.0, 90.0, 180.0), (45.0, 45.0, 360.0)] {
        let program = read(&dxf(&format!("0 ARC 8 0 10 1 20 2 40 5 50 {from} 51 {to}")), "a.dxf");
        let at = |degrees: f64| {
            mm(1.0, 2.0, 0.0) + 5e-3 * Vector3::new(degrees.to_radians().cos(), degrees.to_radians().sin(), 0.0)
        };
        assert_near(program.start, at(from));
        assert_near(place(program.start, &program.moves[0], 0.5), at(from + 0.5 * sweep));
        assert_near(program.moves[0].end(), at(to));
        assert_relative(length(&program), 5e-3 * f64::to_radians(sweep));
    }
}

#[test]
fn an_extrusion_against_z_mirrors_x() {
    let program = read(&dxf("0 ARC 8 0 10 10 20 5 40 4 50 0 51 90 210 0 220 0 230 -1"), "a.dxf");
    assert_near(program.start, mm(-14.0, 5.0, 0.0));
    assert_near(program.moves[0].end(), mm(-10.0, 9.0, 0.0));
    let middle = mm(-10.0, 5.0, 0.0) + 4e-3 * Vector3::new(-0.5f64.sqrt(), 0.5f64.sqrt(), 0.0);
    assert_near(place(program.start, &program.moves[0], 0.5), middle);

    let bulged = "0 LWPOLYLINE 8 0 90 2 70 0 210 0 220 0 230 -1 10 0 20 0 42 1 10 2 20 0";
    let program = read(&dxf(bulged), "a.dxf");
    // Counter-clockwise from (0, 0) to (2, 0) lies below; x is mirrored.
    assert_near(place(program.start, &program.moves[0], 0.5), mm(-1.0, -1.0, 0.0));
}

#[test]
fn a_tilted_circle_lies_in_the_plane_of_the_arbitrary_axis_algorithm() {
    let normal = Vector3::new(1.0, -2.0, 2.0) / 3.0;
    let x = Vector3::z().cross(&normal).normalize();
    let y = normal.cross(&x);
    let text = format!("0 CIRCLE 8 0 10 3 20 4 30 5 40 2 210 {} 220 {} 230 {}", normal.x, normal.y, normal.z);
    let program = read(&dxf(&text), "a.dxf");
    let centre = (x * 3.0 + y * 4.0 + normal * 5.0) / 1e3;
    for (i, p) in places(&program, 12).into_iter().enumerate() {
        let t = TAU * i as f64 / 12.0;
        assert_near(p, centre + (x * t.cos() + y * t.sin()) * 2e-3);
    }
}

#[test]
fn ellipses_and_their_arcs_lie_on_the_ellipse() {
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), 0.5f64.atan2(1.0));
    let [a, b] = [f64::hypot(8.0, 4.0), 0.25 * f64::hypot(8.0, 4.0)];
    for (from, to) in [(0.0, TAU), (0.3, 2.0), (5.0, 1.0)] {
        let text = format!("0 ELLIPSE 8 0 10 1 20 2 11 8 21 4 40 0.25 41 {from} 42 {to}");
        let program = read(&dxf(&text), "a.dxf");
        let on = |t: f64| mm(1.0, 2.0, 0.0) + turn * mm(a * t.cos(), b * t.sin(), 0.0);
        assert_near(program.start, on(from));
        assert_near(program.moves[0].end(), on(to));
        for p in places(&program, 200) {
            let q = turn.inverse() * (p * 1e3 - Vector3::new(1.0, 2.0, 0.0));
            let off = (q.x / a).powi(2) + (q.y / b).powi(2) - 1.0;
            assert!(off.abs() < 1e-12, "{off}");
        }
        if to == TAU {
            assert_relative(area(&program), PI * a * b * 1e-6);
        }
    }
    // A ratio of 1 makes a circle, which stays an arc; the normal of the ellipse sets its direction.
    let program = read(&dxf("0 ELLIPSE 8 0 10 0 20 0 11 5 21 0 40 1 41 0 42 1.5707963267948966 230 -1"), "a.dxf");
    assert!(matches!(program.moves[0].shape, MoveShape::Arc { .. }));
    assert_near(program.moves[0].end(), mm(0.0, -5.0, 0.0));
}

#[test]
fn bulges_are_arcs() {
    for bulge in [1.0, -1.0, 0.3, -2.5, 1e-3, -1e-6] {
        let text = format!("0 LWPOLYLINE 8 0 90 2 70 0 38 4 10 1 20 1 42 {bulge} 10 21 20 1");
        let program = read(&dxf(&text), "a.dxf");
        assert_eq!(program.moves.len(), 1);
        assert_near(program.moves[0].end(), mm(21.0, 1.0, 4.0));
        // The sagitta is the bulge times half the chord, to the right of it.
        assert_near(place(program.start, &program.moves[0], 0.5), mm(11.0, 1.0 - 10.0 * bulge, 4.0));
        // The arc of the angle 4 atan(bulge) on its radius.
        let half: f64 = 2.0 * f64::atan(bulge);
        let arc = if bulge.abs() < 1e-5 { 20e-3 } else { 20e-3 * half / half.sin() };
        assert_relative(length(&program), arc);
    }
    // A slot: a rectangle and two half circles, in both kinds of polyline.
    let light = "0 LWPOLYLINE 8 0 90 4 70 1 10 0 20 -5 10 30 20 -5 42 1 10 30 20 5 10 0 20 5 42 1";
    let old = "0 POLYLINE 8 0 66 1 70 1 10 0 20 0 30 2\n0 VERTEX 10 0 20 -5\n0 VERTEX 10 30 20 -5 42 1\n0 VERTEX 10 30 20 5\n0 VERTEX 10 0 20 5 42 1\n0 SEQEND 8 0";
    for text in [light, old] {
        let program = read(&dxf(text), "a.dxf");
        assert_eq!(program.moves.len(), 4);
        assert_near(program.moves[3].end(), program.start);
        assert_relative(area(&program), 1e-6 * (300.0 + PI * 25.0));
        assert_relative(length(&program), 1e-3 * (60.0 + PI * 10.0));
        let height = if text == old { 2e-3 } else { 0.0 };
        assert!(places(&program, 3).iter().all(|p| p.z == height));
    }
}

#[test]
fn polylines_in_space_and_with_frame_points() {
    let spatial = "0 POLYLINE 8 0 66 1 70 9\n0 VERTEX 70 32 10 0 20 0 30 0\n0 VERTEX 70 32 10 10 20 0 30 5\n0 VERTEX 70 32 10 10 20 10 30 9\n0 SEQEND";
    let program = read(&dxf(spatial), "a.dxf");
    let ends: Vec<_> = program.moves.iter().map(robot_cr7::GcodeMove::end).collect();
    let expected = [mm(10.0, 0.0, 5.0), mm(10.0, 10.0, 9.0), mm(0.0, 0.0, 0.0)];
    assert_eq!(ends.len(), 3);
    ends.iter().zip(expected).for_each(|(end, expected)| assert_near(*end, expected));
    // Control points of a spline (16) are not on the line.
    let fitted = "0 POLYLINE 8 0 66 1 70 4\n0 VERTEX 70 8 10 0 20 0\n0 VERTEX 70 16 10 99 20 99\n0 VERTEX 70 8 10 5 20 5\n0 SEQEND";
    let program = read(&dxf(fitted), "a.dxf");
    assert_eq!(program.moves.len(), 1);
    assert_near(program.moves[0].end(), mm(5.0, 5.0, 0.0));
}

#[test]
fn a_rational_spline_is_its_circle() {
    let w = 0.5f64.sqrt();
    let text = format!(
        "0 SPLINE 8 0 70 12 71 2 72 6 73 3 40 0 40 0 40 0 40 1 40 1 40 1 41 1 41 {w} 41 1 10 10 20 0 10 10 20 10 10 0 20 10"
    );
    let program = read(&dxf(&text), "a.dxf");
    assert!(places(&program, 50).iter().all(|p| (p.norm() - 0.01).abs() < 1e-15));
    assert_relative(length(&program), 0.01 * FRAC_PI_2);
    // A cubic without weights, by the sum of Bernstein polynomials; one that is not clamped, by the uniform basis.
    let points = [(0.0, 0.0), (10.0, 20.0), (20.0, -5.0), (30.0, 7.0)];
    let written: String = points.iter().map(|(x, y)| format!(" 10 {x} 20 {y} 30 1")).collect();
    let sum = |basis: [f64; 4]| {
        points.iter().zip(basis).fold(mm(0.0, 0.0, 1.0), |sum, ((x, y), b)| sum + mm(x * b, y * b, 0.0))
    };
    for knots in ["0 0 0 0 1 1 1 1", "0 1 2 3 4 5 6 7"] {
        let knots: Vec<&str> = knots.split(' ').collect();
        let clamped = knots[1] == "0";
        let text = format!("0 SPLINE 8 0 71 3 40 {}{written}", knots.join(" 40 "));
        let program = read(&dxf(&text), "a.dxf");
        for i in 0..=20 {
            let t = f64::from(i) / 20.0;
            let u = 1.0 - t;
            let basis = match clamped {
                true => [u * u * u, 3.0 * t * u * u, 3.0 * t * t * u, t * t * t],
                false => [
                    u * u * u / 6.0,
                    (3.0 * t.powi(3) - 6.0 * t * t + 4.0) / 6.0,
                    (-3.0 * t.powi(3) + 3.0 * t * t + 3.0 * t + 1.0) / 6.0,
                    t.powi(3) / 6.0,
                ],
            };
            assert_near(place(program.start, &program.moves[0], t), sum(basis));
        }
    }
}

#[test]
fn inserted_blocks_are_moved_turned_and_scaled() {
    let block = |name: &str, base: &str, entities: &str| {
        format!("{}{entities}{}", entity(&format!("0 BLOCK 8 0 2 {name} 70 0 {base}")), entity("0 ENDBLK 8 0"))
    };
    let inner = block("INNER", "10 1 20 1", &entity("0 LINE 8 0 10 1 20 1 11 5 21 1"));
    let outer = block(
        "OUTER",
        "10 0 20 0",
        &(entity("0 CIRCLE 8 0 10 2 20 0 40 1") + &entity("0 INSERT 8 0 2 INNER 10 0 20 3 50 90")),
    );
    let sections = format!("0\nSECTION\n2\nBLOCKS\n{inner}{outer}0\nENDSEC\n");
    let insert = entity("0 INSERT 8 cut 2 OUTER 10 100 20 50 41 2 42 -2 50 30");
    let program = read(&dxf_in("4", &sections, &insert), "a.dxf");
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), f64::to_radians(30.0));
    let at = |x: f64, y: f64| mm(100.0, 50.0, 0.0) + turn * mm(2.0 * x, -2.0 * y, 0.0);
    // Names in upper and lower case are the same.
    let other = read(&dxf_in("4", &sections, &insert.replace("OUTER", "Outer")), "a.dxf");
    assert_eq!(other.moves, program.moves);
    // What is on the layer "0" of a block is on that of its insertion.
    let MarkerKind::Message(mark) = &program.markers[0].kind else { panic!("{program:?}") };
    assert!(mark.starts_with("contour 1: CIRCLE of block \"OUTER\"") && mark.ends_with("layer \"cut\""), "{mark}");
    let ends = contours(&program);
    assert_eq!(ends.len(), 2);
    assert_near(ends[0][0], at(3.0, 0.0));
    // The mirrored circle runs the other way round.
    assert_near(place(program.start, &program.moves[0], 0.25), at(2.0, 1.0));
    assert!(matches!(program.moves[0].shape, MoveShape::Arc { sweep, .. } if sweep < 0.0));
    assert_near(ends[1][0], at(0.0, 3.0));
    assert_near(ends[1][1], at(0.0, 7.0));
    // Another scale along x and y makes an ellipse; rows and columns make copies.
    let insert = entity("0 INSERT 8 cut 2 OUTER 10 0 20 0 41 2 42 1 70 3 71 2 44 50 45 70");
    let program = read(&dxf_in("4", &sections, &insert), "a.dxf");
    assert!(matches!(program.moves[0].shape, MoveShape::Curve(_)));
    let starts: Vec<_> = contours(&program).iter().step_by(2).map(|ends| ends[0]).collect();
    let expected = [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (2, 1)];
    assert_eq!(starts.len(), expected.len());
    for (start, (column, row)) in starts.iter().zip(expected) {
        assert_near(*start, mm(6.0 + 50.0 * f64::from(column), 70.0 * f64::from(row), 0.0));
    }
    assert!(program.warnings[0].contains("count the moves from 1"), "{:?}", program.warnings);
    assert!(program.moves.iter().zip(1..).all(|(step, number)| step.line == number));
}

#[test]
fn comments_stand_anywhere() {
    let line = entity("0 LINE 8 cut 10 1 20 2 11 3 21 4");
    let plain = dxf_in("1", "", &line);
    let comment = "999\nfrom a program\n";
    let mut commented = plain.replace("SECTION\n", &format!("SECTION\n{comment}"));
    commented = commented.replace("$INSUNITS\n", &format!("$INSUNITS\n{comment}"));
    commented = format!("{comment}{}", commented.replace("20\n2\n", &format!("{comment}20\n2\n{comment}")));
    let (plain, commented) = (read(&plain, "a.dxf"), read(&commented, "a.dxf"));
    assert_eq!((commented.start, commented.moves[0].end()), (plain.start, plain.moves[0].end()));
    assert!(commented.warnings.is_empty(), "{:?}", commented.warnings);
}
