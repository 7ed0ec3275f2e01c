//! Pictures: well-formed whatever the numbers, small whatever the length, and true to the peaks.
#![cfg(feature = "plot")]

use proptest::prelude::*;
use robot_cr7::BindingLine;
use robot_cr7::plot::{
    Along, Bound, JointQuantity, Line, PathMotion, PathPlace, feed_picture, joint_picture, lines_picture, path_picture,
    speed_path_picture,
};

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
    let motion = PathMotion { places: &places, binding: &binding };
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
    let svg = speed_path_picture("helix", &places).expect("drawn");
    assert!(svg.contains("one square of the floor") && svg.contains("100 mm/s"));
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
        let motion = PathMotion { places: &places, binding: &binding };
        for svg in [
            path_picture(&name, &segments, &y, limit, None),
            path_picture(&name, &segments, &y, limit, Some(motion)),
            speed_path_picture(&name, &places),
            feed_picture(&name, Along::Length, &v, &v),
            feed_picture(&name, Along::Time, &v, &[]),
            joint_picture(&name, JointQuantity::Acceleration, &x, &[y.as_slice(); 6], &[Bound::Constant(limit); 6], &[limit]),
            lines_picture(&name, &name, (&name, &name), &[Line { name: &name, points: &v }], &[limit]),
        ] {
            well_formed(&svg.map_err(|e| TestCaseError::fail(e.to_string()))?);
        }
    }
}
