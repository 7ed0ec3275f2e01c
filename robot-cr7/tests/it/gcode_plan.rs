//! `cr7 plan` on G-code programs and polylines: the tool stays where it was told to, and as fast.

use nalgebra::Vector3;

use crate::common::{Desk, Run};

/// A tool that points down over a workpiece in front of the arm.
const JOB: &str = "[workpiece]\nposition_mm = [420, 0, 150]\n[orientation]\nrpy_deg = [180, 0, 0]\n";
const SQUARE: &str = "x_mm,y_mm\n0,0\n100,0\n100,100\n0,100\n0,0\n";

/// The tool points of a plan in mm, in the frame of the workpiece, with their times.
fn tool_points(desk: &Desk) -> Vec<(f64, Vector3<f64>)> {
    let rows = desk.trajectory::<6>("out");
    rows.iter().map(|row| (row.t, Vector3::from(row.position) * 1e3 - Vector3::new(420.0, 0.0, 150.0))).collect()
}

fn distance_from_polyline(p: &Vector3<f64>, corners: &[Vector3<f64>]) -> f64 {
    let from_line = |pair: &[Vector3<f64>]| {
        let (a, b) = (pair[0], pair[1]);
        let share = ((p - a).dot(&(b - a)) / (b - a).norm_squared()).clamp(0.0, 1.0);
        (p - a - (b - a) * share).norm()
    };
    corners.windows(2).map(from_line).fold(f64::INFINITY, f64::min)
}

/// Runs a plan of `file` with `job` added to [`JOB`], every limit of which has to hold.
fn planned(desk: &Desk, file: &str, job: &str) -> serde_json::Value {
    desk.write("job.toml", &format!("{JOB}{job}"));
    let report = desk.run(&["plan", file, "--job", "job.toml", "--json"]).done().json();
    for line in report["limits"].as_array().expect("a list") {
        assert!(line["ratio"].as_f64().expect("a number") <= 1.0 + 1e-6, "{line}");
        assert!(line["lines"].is_array() || report["program"].is_null(), "{line}");
    }
    report
}

#[test]
fn a_program_is_followed_within_the_tolerance_of_its_lines_and_at_their_feeds() {
    let desk = Desk::new("gcode_square");
    desk.write("square.ngc", include_str!("../../data/gcode/square.ngc"));
    let report = planned(&desk, "square.ngc", "");
    assert_eq!(report["program"]["blended"], 5);
    assert_eq!(report["program"]["stops"].as_array().map(Vec::len), Some(0));
    let mm = |x: f64, y: f64, z: f64| Vector3::new(x, y, z);
    let corners = [
        mm(0.0, 0.0, 5.0),
        mm(0.0, 0.0, -1.0),
        mm(40.0, 0.0, -1.0),
        mm(40.0, 40.0, -1.0),
        mm(0.0, 40.0, -1.0),
        mm(0.0, 0.0, -1.0),
        mm(0.0, 0.0, 5.0),
    ];
    let points = tool_points(&desk);
    let mut farthest = 0.0f64;
    for (t, p) in &points {
        let off = distance_from_polyline(p, &corners);
        farthest = farthest.max(off);
        assert!(off <= 0.05 + 1e-6, "{off} mm at {t} s");
    }
    assert!(farthest > 0.049, "the tolerance is used: {farthest} mm");
    // F of the lines by number, mm/s; a blend has the lower one of both.
    let feed = |line: &str| {
        line.split('-')
            .map(|n| [5.0, 20.0, 20.0, 20.0, 20.0, 100.0][n.parse::<usize>().expect("a line") - 5])
            .fold(1e9, f64::min)
    };
    let table = std::fs::read_to_string(desk.folder.join("out/lines.csv")).expect("written");
    let rows: Vec<Vec<&str>> = table.lines().skip(1).map(|row| row.split(',').collect()).collect();
    assert_eq!(rows.len(), 11);
    let number = |text: &str| text.parse::<f64>().expect("a number");
    let mut end = [0.0, 0.0];
    for row in &rows {
        assert_eq!([number(row[2]), number(row[4])], end, "lines follow one another");
        end = [number(row[3]), number(row[5])];
        let mut fastest = 0.0f64;
        for pair in points.windows(2).filter(|pair| pair[0].0 >= number(row[4]) && pair[1].0 <= number(row[5])) {
            fastest = fastest.max((pair[1].1 - pair[0].1).norm() / (pair[1].0 - pair[0].0));
        }
        assert!(fastest <= feed(row[0]) * (1.0 + 1e-6), "{fastest} mm/s in line {}", row[0]);
    }
    assert!((end[1] - report["duration_s"].as_f64().expect("a number")).abs() < 1e-12);
    assert_eq!(report["program"]["markers"][0]["what"], "M2");
}

#[test]
fn corners_without_a_tolerance_are_stops_and_blends_are_faster() {
    let desk = Desk::new("gcode_stops");
    let program = |mode: &str| {
        format!("{mode}\nG21 G0 X0 Y0\nG1 X60 F6000\nG1 Y60\nG3 X0 Y60 I-30 J0\n(MSG,half way)\nG1 X0 Y0\nX60 Y0\n")
    };
    let run = |mode: &str, job: &str| {
        desk.write("p.ngc", &program(mode));
        let report = planned(&desk, "p.ngc", job);
        let stops = report["program"]["stops"].as_array().expect("a list").len();
        (report["duration_s"].as_f64().expect("a number"), stops, report)
    };
    let (exact, stops, report) = run("G61", "[path]\nblend_mm = 1.0\n");
    assert_eq!((stops, &report["program"]["stops"][0]["lines"]), (2, &serde_json::json!([3, 4])));
    let (unstated, stops, _) = run("", "");
    assert_eq!((stops, unstated), (2, exact));
    let (blended, stops, report) = run("", "[path]\nblend_mm = 1.0\n");
    assert_eq!(stops, 0);
    let deviation = report["program"]["blend_deviation_m"].as_f64().expect("a number");
    assert!(blended < 0.95 * exact && deviation <= 1e-3 && deviation > 9e-4, "{blended} s, {exact} s, {deviation} m");
    let (wide, ..) = run("G64 P3", "");
    assert!(wide < blended, "{wide} s, {blended} s");
    // A message stands where it was written, between the arc and the line after it.
    let mark = &report["program"]["markers"][0];
    assert_eq!((mark["what"].as_str(), mark["line"].as_u64()), (Some("half way"), Some(6)));
}

/// The speed of the tool in mm/s where it is nearest to x = `at` mm.
fn speed_at(desk: &Desk, at: f64) -> f64 {
    let points = tool_points(desk);
    let i = (1..points.len()).min_by(|&i, &k| (points[i].1.x - at).abs().total_cmp(&(points[k].1.x - at).abs()));
    let i = i.expect("points");
    (points[i].1 - points[i - 1].1).norm() / (points[i].0 - points[i - 1].0)
}

#[test]
fn the_tool_stops_on_a_smooth_line_where_the_program_says_so() {
    let desk = Desk::new("gcode_exact_stops");
    let stop = |middle: &str| {
        desk.write("p.ngc", &format!("G21 G64 P1 G0 X0 Y0\nG1 X40 F6000\n{middle}\nX120\n"));
        let report = planned(&desk, "p.ngc", "");
        (speed_at(&desk, 80.0), report["program"]["stops"].clone(), report)
    };
    let (speed, stops, _) = stop("X80");
    assert!(speed > 99.0 && stops.as_array().is_some_and(Vec::is_empty), "{speed} mm/s, {stops}");
    let (speed, stops, _) = stop("G61.1 X80\nG64 P1");
    assert!(speed < 2.0 && stops[0]["lines"] == serde_json::json!([3, 5]), "{speed} mm/s, {stops}");
    let (speed, _, report) = stop("X80\nG4 P0.5");
    assert!(speed < 2.0, "{speed} mm/s");
    let kinds: Vec<_> = report["parts"].as_array().expect("a list").iter().map(|part| part["kind"].clone()).collect();
    assert_eq!(kinds, ["path", "dwell", "path"]);
    // The dwell is a mark at the place where the tool stands.
    let mark = &report["program"]["markers"][0];
    assert_eq!(mark["what"], "dwell of 0.5 s");
    assert!((mark["s_m"].as_f64().expect("a number") - 0.08).abs() < 1e-9, "{mark}");
}

#[test]
fn rotary_axes_turn_the_tool_in_step_with_the_way() {
    let desk = Desk::new("gcode_rotary");
    desk.write("r.ngc", "G21 G0 X0 Y0 A0\nG1 X40 A10 F1200\nG1 X80 A10\nG1 X120 A0 C15\n");
    planned(&desk, "r.ngc", "");
    let turned = |axis: Vector3<f64>, degrees: f64| {
        nalgebra::UnitQuaternion::from_scaled_axis(axis * f64::to_radians(degrees))
            * nalgebra::UnitQuaternion::from_scaled_axis(Vector3::x() * std::f64::consts::PI)
    };
    let rows = desk.trajectory::<6>("out");
    let mut seen = 0;
    for row in &rows {
        let [x, y, z, w] = row.quaternion;
        let tool = nalgebra::UnitQuaternion::new_normalize(nalgebra::Quaternion::new(w, x, y, z));
        let along = row.position[0] * 1e3 - 420.0;
        let expected = match along {
            s if s < 38.0 => turned(Vector3::x(), s / 4.0),
            s if (42.0..78.0).contains(&s) => turned(Vector3::x(), 10.0),
            _ => continue,
        };
        seen += 1;
        let off = tool.angle_to(&expected).to_degrees();
        assert!(off < 0.06, "{off} deg at {along} mm");
    }
    assert!(seen > 100);
}

/// Both curves stand still where they start. The first one is x = 60 t^2, y = 20 t^3, the second one a line.
#[test]
fn a_curve_whose_control_points_coincide_is_followed() {
    let desk = Desk::new("gcode_standing");
    let job = "[path]\nblend_mm = 0.1\n[tolerance]\nchord_mm = 0.01\n";
    desk.write("p.ngc", "G21 F600 G0 X0 Y0 Z0\nG5.2 P1 L4\nX0 Y0 P1\nX20 Y0 P1\nX60 Y20 P1\nG5.3\n");
    let report = planned(&desk, "p.ngc", job);
    let mut farthest = 0.0f64;
    for (t, p) in tool_points(&desk) {
        // The slope is 1/2 at most, so that the distance is nearly that along y.
        let off = (p.y - 20.0 * (p.x / 60.0).max(0.0).powf(1.5)).abs();
        farthest = farthest.max(off);
        assert!(off <= 1.12e-3, "{off} mm at {t} s");
    }
    assert!(farthest > 5e-4, "the tolerance is used: {farthest} mm");
    assert!(report["warnings"].to_string().contains("coincide, first at line 2"), "{}", report["warnings"]);
    desk.write("q.ngc", "G21 F600 G0 X0 Y0 Z0\nG5.2 P1 L3\nX0 Y0 P1\nX30 Y40 P1\nG5.3\n");
    let report = planned(&desk, "q.ngc", job);
    assert!((report["length_m"].as_f64().expect("a number") - 0.05).abs() < 1e-12);
    assert!(!report["warnings"].to_string().contains("coincide"), "{}", report["warnings"]);
}

#[test]
fn points_of_a_csv_file_are_a_polyline_where_asked_and_no_blob() {
    let desk = Desk::new("csv_square");
    desk.write("square.csv", SQUARE);
    desk.write("job.toml", JOB);
    let refused: Run = desk.run(&["plan", "square.csv", "--job", "job.toml"]);
    refused.refused(2, &["square.csv:", "beside the line of 100 mm", "path.through = \"polyline\""]);
    let corners: Vec<_> = [[0.0, 0.0], [100.0, 0.0], [100.0, 100.0], [0.0, 100.0], [0.0, 0.0]]
        .map(|[x, y]| Vector3::new(x, y, 0.0))
        .into();
    let exact = planned(&desk, "square.csv", "[path]\nthrough = \"polyline\"\n");
    assert_eq!(exact["program"]["stops"].as_array().map(Vec::len), Some(3));
    let report = planned(&desk, "square.csv", "[path]\nthrough = \"polyline\"\nblend_mm = 1.0\n");
    let points = tool_points(&desk);
    assert!(points.iter().all(|(_, p)| distance_from_polyline(p, &corners) <= 1.0 + 1e-6));
    let [exact, blended] = [exact, report].map(|report| report["duration_s"].as_f64().expect("a number"));
    assert!(blended < 0.95 * exact, "{blended} s, {exact} s with stops");
    // The bulge that is allowed can be stated.
    planned(&desk, "square.csv", "[path]\nbulge_mm = 40.0\n");
}

#[test]
fn what_a_program_cannot_do_is_said_with_its_line() {
    let desk = Desk::new("gcode_bad");
    let cases: [(&str, &str, i32, &[&str]); 6] = [
        ("G21 G1 X10 F600\nG41 X20\n", "", 2, &["p.ngc:2:1", "cutter compensation"]),
        ("G21 G1 X10 F600\nG1 A20\nG1 X20\n", "", 2, &["p.ngc:2", "rotary axes alone"]),
        ("G21\nM2\n", "", 2, &["p.ngc", "without a move"]),
        (
            "G21 G1 X10 F600\n",
            "[[sections]]\nfrom_mm = 1\nto_mm = 2\nfeed_mm_s = 3\n",
            2,
            &["a program states its own feeds"],
        ),
        ("G21 G0 X0\nG1 X100 F6000\nN7 X1900\n", "", 1, &["line 3 (N7)"]),
        ("G21 G0 X0\nG1 X100 F6000\nX200 Z-0.0000001\nX300 F\n", "", 2, &["p.ngc:4"]),
    ];
    for (program, job, code, parts) in cases {
        desk.write("p.ngc", program);
        desk.write("job.toml", &format!("{JOB}{job}"));
        desk.run(&["plan", "p.ngc", "--job", "job.toml"]).refused(code, parts);
    }
}

/// Points of all lines of a picture that are drawn as a path is, pixels, line by line.
fn drawn_path(desk: &Desk) -> Vec<Vec<[f64; 2]>> {
    let svg = std::fs::read_to_string(desk.folder.join("out/path.svg")).expect("a picture");
    let lines = svg.split("<polyline").filter(|tag| tag.contains("stroke-width=\"34\""));
    let points = |tag: &str| {
        let text = tag.split("points=\"").nth(1).and_then(|p| p.split('"').next()).expect("points");
        let values: Vec<f64> = text.split([' ', ',']).filter_map(|n| n.parse().ok()).collect();
        values.chunks_exact(2).map(|p| [p[0], p[1]]).collect::<Vec<_>>()
    };
    // The legend has lines of two points.
    lines.map(points).filter(|line| line.len() > 2).collect()
}

#[test]
fn circles_are_round_in_the_picture_however_few_setpoints_they_have() {
    let desk = Desk::new("gcode_laps");
    // Some ten setpoints a lap, in one part and in several.
    for dwell in ["", "G4 P0.5\n"] {
        let laps = "G2 X0 Y0 I5 J0 F6000\n".repeat(5);
        desk.write("laps.ngc", &format!("G21 G90 G17\nG1 X0 Y0 F6000\n{dwell}{laps}{dwell}G2 X10 Y0 I5 J0\nM2\n"));
        let report = planned(
            &desk,
            "laps.ngc",
            "[feed]\nfeed_mm_s = 100\n[tolerance]\nchord_mm = 2\n[sampling]\nperiod_ms = 50\n",
        );
        assert!(report["samples"].as_u64().is_some_and(|samples| samples < 150), "{}", report["samples"]);
        let lines = drawn_path(&desk);
        let all = || lines.iter().flatten();
        let ends = |k: usize| all().fold([f64::MAX, f64::MIN], |e, p| [e[0].min(p[k]), e[1].max(p[k])]);
        let [[left, right], [top, bottom]] = [ends(0), ends(1)];
        let (centre, radius) = ([0.5 * (left + right), 0.5 * (top + bottom)], 0.5 * (right - left));
        assert!(radius > 1000.0 && (bottom - top - right + left).abs() < 0.01 * radius, "{radius}");
        for pair in lines.iter().flat_map(|line| line.windows(2)) {
            let middle = [0, 1].map(|k| 0.5 * (pair[0][k] + pair[1][k]) - centre[k]);
            let inside = 1.0 - middle[0].hypot(middle[1]) / radius;
            assert!(inside.abs() < 5e-3, "{dwell:?}: {inside} inside, {pair:?}");
        }
        // The end of the last, half lap is on the right.
        let last = lines.last().and_then(|line| line.last()).expect("a point");
        assert!((last[0] - right).abs() < 3.0 && (last[1] - centre[1]).abs() < 3.0, "{last:?}");
    }
}
