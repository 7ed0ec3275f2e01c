//! Pictures: well-formed whatever the numbers, small whatever the length, and true to the peaks.
#![cfg(feature = "plot")]

use nalgebra::Isometry3;
use proptest::prelude::*;
use robot_cr7::plot::{
    Along, ArmAtEnds, Bound, JointQuantity, Line, PathMotion, PathPlace, feed_picture, joint_picture, lines_picture,
    path_picture, speed_path_picture,
};
use robot_cr7::{BindingLine, Pose};

/// Checks that tags are balanced, attributes quoted and no number is lost, with a reader of its own.
fn well_formed(svg: &str) {
    let mut open = Vec::new();
    let mut rest = svg;
    while let Some(start) = rest.find('<') {
        assert!(!rest[..start].contains('>'), "stray > in {}", &rest[..start]);
        let end = start + rest[start..].find('>').expect("a tag ends");
        let tag = &rest[start + 1..end];
        rest = &rest[end + 1..];
        assert_eq!(tag.matches('"').count() % 2, 0, "{tag}");
        assert!(!tag.contains("NaN") && !tag.contains("inf"), "{tag}");
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name));
        } else if !tag.ends_with('/') && !tag.starts_with(['?', '!']) {
            open.push(tag.split_whitespace().next().expect("a name"));
        }
    }
    assert!(open.is_empty(), "{open:?}");
    assert!(!svg.chars().any(|c| c.is_control() && c != '\n'), "control characters");
}

#[test]
fn a_hundred_thousand_samples_stay_below_a_megabyte() {
    let n = 100_000;
    // A value that jumps from sample to sample is the worst case for thinning.
    let noise = |i: usize| ((i * 7919) % 1009) as f64 / 1009.0;
    let t: Vec<f64> = (0..n).map(|i| i as f64 * 1e-3).collect();
    let value: Vec<f64> = (0..n).map(|i| noise(i) - 0.5).collect();
    let series: Vec<_> = t.iter().copied().zip(value.iter().map(|v| v + 0.5)).collect();
    let limit: Vec<_> = t.iter().copied().zip((0..n).map(|i| 1.0 + noise(i))).collect();
    let segments: Vec<Vec<[f64; 3]>> = (0..n)
        .map(|i| {
            let at = |a: f64| [0.05 * (a * 1e-4).cos(), 0.05 * (a * 2e-4).sin(), 1e-7 * a];
            vec![at(i as f64), at(i as f64 + 0.5), at(i as f64 + 1.0)]
        })
        .collect();
    for svg in [
        path_picture("a", &segments, &value, 0.5, None),
        feed_picture("a", Along::Time, &series, &limit),
        joint_picture("a", JointQuantity::Jerk, &t, &[value.as_slice(); 6], &[Bound::Constant(0.5); 6], &[]),
        lines_picture("a", "", ("x", "y"), &[Line { name: "noise", points: &series }], &[0.5]),
    ] {
        let svg = svg.expect("drawn");
        well_formed(&svg);
        assert!(svg.len() < 1_000_000, "{} bytes", svg.len());
    }
}

#[test]
fn key_numbers_stand_in_the_picture() {
    let segments = vec![vec![[0.0; 3], [0.03, 0.04, 0.0]], vec![[0.03, 0.04, 0.0], [0.06, 0.0, 0.0]]];
    let svg = path_picture("two lines", &segments, &[0.5e-6, 0.25e-6], 1e-6, None).expect("drawn");
    for text in ["two lines", "2 segments over 100 mm", "0.5 µm of 1 µm", "x [mm]", "y [mm]", "deviation [µm]"] {
        assert!(svg.contains(text), "{text}");
    }
    let feed = [(0.0, 0.0), (1.0, 0.08), (2.0, 0.0)];
    let svg = feed_picture("feed", Along::Time, &feed, &[(0.0, 0.1), (2.0, f64::INFINITY)]).expect("drawn");
    for text in ["fastest 80 mm/s, mean 40 mm/s", "time t [s]", "feed [mm/s]", "limit"] {
        assert!(svg.contains(text), "{text}");
    }
    let t = [0.0, 1.0];
    let flat = [0.5, 0.5];
    let svg = joint_picture(
        "j",
        JointQuantity::Velocity,
        &t,
        &[flat.as_slice(); 6],
        &[1.0, 1.0, 1.0, 1.0, 1.0, 0.4].map(Bound::Constant),
        &[0.5],
    )
    .expect("drawn");
    for text in ["J6 with 125.00 %", "used 50.00 %", "J1 [deg/s]", "peak 28.648 deg/s"] {
        assert!(svg.contains(text), "{text}");
    }
}

#[test]
fn a_path_in_space_has_its_true_length_and_the_colours_of_what_limits_it() {
    // A turn of a helix: radius 30 mm, pitch 40 mm.
    let (radius, pitch) = (0.03, 0.04);
    let length = (std::f64::consts::TAU * radius).hypot(pitch);
    let at = |f: f64| {
        let (sin, cos) = (std::f64::consts::TAU * f).sin_cos();
        [radius * cos, radius * sin, pitch * f]
    };
    let places: Vec<PathPlace> = (0..=4000)
        .map(|i| f64::from(i) / 4000.0)
        .map(|f| PathPlace { at: at(f), s: f * length, speed: 0.1 * f })
        .collect();
    let segments: Vec<Vec<[f64; 3]>> = places.windows(2).map(|w| vec![w[0].at, w[1].at]).collect();
    let line = |limit: &str, from: f64, to: f64| BindingLine {
        limit: limit.to_owned(),
        intervals: vec![[from * length, to * length]],
    };
    let binding = [line("feed", 0.1, 0.6), line("jerk of joint 3", 0.5, 0.7), line("rare", 0.7999, 0.8001)];
    let motion = PathMotion { places: &places, binding: &binding, arm: None };
    let svg = path_picture("helix", &segments, &[1e-7; 4000], 1e-6, Some(motion)).expect("drawn");
    well_formed(&svg);
    assert!(svg.contains("4000 segments over 192.69 mm") && (length - 0.1927).abs() < 1e-4, "{length}");
    for text in ["feed", "jerk of joint 3", "another limit", "no limit", "one square of the floor is 5 mm", "\nz\n"] {
        assert!(svg.contains(text), "{text}");
    }
    // The path in runs of one colour: nothing, feed, jerk, nothing, another limit, nothing.
    let colours: Vec<&str> = svg
        .split("<polyline")
        .filter(|tag| tag.contains("stroke-width=\"34\"") && tag.matches(',').count() > 4)
        .filter_map(|tag| tag.split("stroke=\"").nth(1).and_then(|rest| rest.split('"').next()))
        .collect();
    assert_eq!(colours[..4], ["#BEBEBE", "#0072B2", "#E69F00", "#BEBEBE"], "{colours:?}");
    let flat = path_picture("flat", &[vec![[0.0; 3], [0.1, 0.1, 0.0]]], &[0.0], 1e-6, None).expect("drawn");
    assert!(flat.contains("x [mm]") && !svg.contains("x [mm]"));
    let svg = speed_path_picture("helix", motion).expect("drawn");
    assert!(svg.contains("one square of the floor") && svg.contains("100 mm/s"));
}

/// Colour, width and points of every line of a picture, in their order, in tenths of a pixel.
fn polylines(svg: &str) -> Vec<(String, String, Vec<[f64; 2]>)> {
    let attribute = |tag: &str, name: &str| {
        let value = tag.split(&format!("{name}=\"")).nth(1).and_then(|rest| rest.split('"').next());
        value.expect("an attribute").to_owned()
    };
    let line = |tag: &str| {
        let points = attribute(tag, "points");
        let v: Vec<f64> = points.split([' ', ',']).filter_map(|n| n.parse().ok()).collect();
        let points = v.chunks_exact(2).map(|p| [p[0], p[1]]).collect();
        (attribute(tag, " stroke"), attribute(tag, "stroke-width"), points)
    };
    svg.split("<polyline").skip(1).map(line).collect()
}

/// An arm that goes up 400 mm from its base, then 400 mm along x, and has a tool of 300 mm down.
fn gallows() -> Pose {
    Pose {
        t: 0.0,
        points: vec![0.0, 0.0, 0.0, 0.0, 0.0, 0.4, 0.4, 0.0, 0.4, 0.4, 0.0, 0.1],
        joints: Vec::new(),
        feed: 0.0,
    }
}

/// Places along straight lines through these corners.
fn along(corners: &[[f64; 3]]) -> Vec<PathPlace> {
    let (mut places, mut s) = (Vec::new(), 0.0);
    for w in corners.windows(2) {
        let length = (0..3).map(|k| (w[1][k] - w[0][k]).powi(2)).sum::<f64>().sqrt();
        let at = |f: f64| std::array::from_fn(|k| w[0][k] + f * (w[1][k] - w[0][k]));
        places.extend((0..=50).map(|i| f64::from(i) / 50.0).map(|f| PathPlace {
            at: at(f),
            s: s + f * length,
            speed: 0.1,
        }));
        s += length;
    }
    places
}

const BODY: &str = "#D4DCE4";

#[test]
fn the_arm_stands_behind_a_large_path_at_the_same_scale() {
    let (arm, workpiece) = (gallows(), Isometry3::translation(0.3, -0.1, 0.05));
    // From the tip 300 mm up, then along y; in the frame of the workpiece.
    let places = along(&[[0.1, 0.1, 0.05], [0.1, 0.1, 0.35], [0.1, 0.4, 0.35]]);
    let segments = [vec![places[0].at, places[50].at, places[101].at]];
    let ends = ArmAtEnds { start: &arm, end: &arm, workpiece: &workpiece };
    let motion = PathMotion { places: &places, binding: &[], arm: Some(ends) };
    for svg in [path_picture("up", &segments, &[0.0], 1e-6, Some(motion)), speed_path_picture("up", motion)] {
        let svg = svg.expect("drawn");
        well_formed(&svg);
        let lines = polylines(&svg);
        let length = |p: &[[f64; 2]]| (p[1][0] - p[0][0]).hypot(p[1][1] - p[0][1]);
        let links: Vec<usize> = (0..lines.len()).filter(|&i| lines[i].0 == BODY).collect();
        let path: Vec<usize> = (0..lines.len()).filter(|&i| lines[i].1 == "34" && lines[i].2.len() > 2).collect();
        assert_eq!((links.len(), path.len()), (3, 1));
        // The first link and the first line of the path are upright.
        let (link, way) = (length(&lines[links[0]].2), length(&lines[path[0]].2));
        assert!((link / way - 400.0 / 300.0).abs() < 5e-3, "{link} {way}");
        // The path is on top, and begins at the tip of the tool.
        assert!(path[0] > links[2]);
        let (tip, start) = (lines[links[2]].2[1], lines[path[0]].2[0]);
        assert!((tip[0] - start[0]).hypot(tip[1] - start[1]) < 2.0, "{tip:?} {start:?}");
        assert!(svg.contains("the arm at the start"));
    }
}

#[test]
fn beside_a_small_path_the_arm_has_a_picture_of_its_own() {
    let (arm, workpiece) = (gallows(), Isometry3::translation(0.4, 0.0, 0.1));
    let places = along(&[[0.0; 3], [0.03, 0.02, 0.0], [0.06, 0.0, 0.0]]);
    let segments = [places.iter().map(|place| place.at).collect::<Vec<_>>()];
    let ends = ArmAtEnds { start: &arm, end: &arm, workpiece: &workpiece };
    let motion = PathMotion { places: &places, binding: &[], arm: Some(ends) };
    let svg = path_picture("small", &segments, &[0.0], 1e-6, Some(motion)).expect("drawn");
    well_formed(&svg);
    let lines = polylines(&svg);
    let of = |colour: &str, width: &str| -> Vec<[f64; 2]> {
        lines.iter().filter(|l| l.0 == colour && l.1 == width).flat_map(|l| l.2.iter().copied()).collect()
    };
    let (path, small) = (of("#BEBEBE", "34"), of("#0072B2", "16"));
    let links: Vec<[f64; 2]> = lines.iter().filter(|l| l.0 == BODY).flat_map(|l| l.2.iter().copied()).collect();
    // Nothing of the arm lies over the path.
    let right = path.iter().skip(2).map(|p| p[0]).fold(0.0, f64::max);
    assert!(links.len() == 6 && links.iter().chain(&small).all(|p| p[0] > right + 200.0), "{links:?} {right}");
    // The small path begins at the tip of the tool.
    let tip = links[5];
    assert!((tip[0] - small[0][0]).hypot(tip[1] - small[0][1]) < 2.0, "{tip:?} {small:?}");
    assert!(svg.contains("x [mm]") && svg.contains("one square of the floor is"));
    let none = PathMotion { arm: None, ..motion };
    assert!(!path_picture("small", &segments, &[0.0], 1e-6, Some(none)).expect("drawn").contains(BODY));
}

#[test]
fn both_axes_of_a_path_have_the_same_scale() {
    // A square of 40 mm: the longest polylines are its sides, as long in x as in y.
    let corners = [[0.0; 3], [0.04, 0.0, 0.0], [0.04, 0.04, 0.0], [0.0, 0.04, 0.0], [0.0; 3]];
    let segments: Vec<Vec<[f64; 3]>> = corners.windows(2).map(|w| w.to_vec()).collect();
    let svg = path_picture("square", &segments, &[0.0; 4], 1e-6, None).expect("drawn");
    let sides: Vec<f64> = svg
        .split("<polyline")
        .filter(|tag| tag.contains("stroke-width=\"22\""))
        .map(|tag| {
            let points = tag.split("points=\"").nth(1).and_then(|p| p.split('"').next()).expect("points");
            let v: Vec<f64> = points.split([' ', ',']).filter_map(|n| n.parse().ok()).collect();
            (v[2] - v[0]).hypot(v[3] - v[1])
        })
        .collect();
    assert_eq!(sides.len(), 4);
    assert!(sides.iter().all(|s| (s - sides[0]).abs() <= 2.0 && *s > 1000.0), "{sides:?}");
}

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![4 => -1.0..1.0f64, 1 => any::<f64>(), 1 => Just(f64::NAN), 1 => Just(f64::INFINITY), 1 => Just(0.0)]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn any_numbers_draw_without_panic(
        v in prop::collection::vec((number(), number()), 0..30),
        name in any::<String>(),
        limit in number(),
    ) {
        let (x, y): (Vec<f64>, Vec<f64>) = v.iter().copied().unzip();
        let segments: Vec<Vec<[f64; 3]>> = v.chunks(3).map(|c| c.iter().map(|p| [p.0, p.1, p.0]).collect()).collect();
        let places: Vec<PathPlace> = v.iter().map(|p| PathPlace { at: [p.0, p.1, p.1], s: p.0, speed: p.1 }).collect();
        let binding = [BindingLine { limit: name.clone(), intervals: v.iter().map(|p| [p.0, p.1]).collect() }];
        let arm = Pose { t: 0.0, points: x.iter().chain(&y).copied().collect(), joints: Vec::new(), feed: limit };
        let workpiece = Isometry3::rotation(nalgebra::Vector3::x() * if limit > 0.0 { 1.0 } else { 0.0 });
        let arm = Some(ArmAtEnds { start: &arm, end: &arm, workpiece: &workpiece });
        let motion = PathMotion { places: &places, binding: &binding, arm };
        for svg in [
            path_picture(&name, &segments, &y, limit, None),
            path_picture(&name, &segments, &y, limit, Some(motion)),
            speed_path_picture(&name, motion),
            feed_picture(&name, Along::Length, &v, &v),
            feed_picture(&name, Along::Time, &v, &[]),
            joint_picture(&name, JointQuantity::Acceleration, &x, &[y.as_slice(); 6], &[Bound::Constant(limit); 6], &[limit]),
            lines_picture(&name, &name, (&name, &name), &[Line { name: &name, points: &v }], &[limit]),
        ] {
            well_formed(&svg.map_err(|e| TestCaseError::fail(e.to_string()))?);
        }
    }
}
