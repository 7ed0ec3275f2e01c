//! Programs of short lines: they become smooth curves within the tolerance of the program.

use std::f64::consts::TAU;
use std::fmt::Write;

use nalgebra::Vector3;

use crate::common::Desk;

const JOB: &str = "[workpiece]\nposition_mm = [420, 0, 150]\n[orientation]\nrpy_deg = [180, 0, 0]\n";

/// A flower of `count` short lines, rounded to a micrometre, and a square corner at its end. Its points in mm.
fn flower(mode: &str, count: u32) -> (String, Vec<Vector3<f64>>) {
    let mut program = format!("{mode}\nG21 G90 G0 X50 Y0\nF6000\n");
    let mut points = vec![Vector3::new(50.0, 0.0, 0.0)];
    let mut line = |x: f64, y: f64| {
        let (x, y) = ((x * 1e3).round() / 1e3, (y * 1e3).round() / 1e3);
        writeln!(program, "G1 X{x:.3} Y{y:.3}").expect("memory");
        points.push(Vector3::new(x, y, 0.0));
    };
    for i in 1..=count {
        let a = TAU * f64::from(i) / f64::from(count);
        let r = 40.0 + 10.0 * (5.0 * a).cos();
        line(r * a.cos(), r * a.sin());
    }
    (1..=40).for_each(|i| line(50.0 + 0.75 * f64::from(i), 0.0));
    (1..=40).for_each(|i| line(80.0, 0.75 * f64::from(i)));
    (program, points)
}

fn planned(desk: &Desk, (mode, count): (&str, u32), job: &str) -> (serde_json::Value, Vec<Vector3<f64>>) {
    let (program, points) = flower(mode, count);
    desk.write("flower.ngc", &program);
    desk.write("job.toml", &format!("{JOB}{job}"));
    let report = desk.run(&["plan", "flower.ngc", "--job", "job.toml", "--json"]).done().json();
    for line in report["limits"].as_array().expect("a list") {
        assert!(line["ratio"].as_f64().expect("a number") <= 1.0 + 1e-6, "{line}");
    }
    (report, points)
}

/// Largest distance in mm of the tool from the lines of the program.
fn farthest(desk: &Desk, points: &[Vector3<f64>]) -> f64 {
    let mut from = 0;
    let mut worst = 0.0f64;
    for row in desk.trajectory::<6>("out") {
        let p = Vector3::from(row.position) * 1e3 - Vector3::new(420.0, 0.0, 150.0);
        let off = |pair: &[Vector3<f64>]| {
            let (a, b) = (pair[0], pair[1]);
            let share = ((p - a).dot(&(b - a)) / (b - a).norm_squared()).clamp(0.0, 1.0);
            (p - a - (b - a) * share).norm()
        };
        // The tool goes along the lines: the nearest one is ahead of the last one.
        let window = &points[from..(from + 400).min(points.len())];
        let (nearest, distance) = window
            .windows(2)
            .map(off)
            .enumerate()
            .fold((0, f64::INFINITY), |best, (i, d)| if d < best.1 { (i, d) } else { best });
        from += nearest.saturating_sub(2);
        worst = worst.max(distance);
    }
    worst
}

/// Each line within a curve has a row: it ends when the tool passes the end of the line, and the rows follow one another.
fn each_line_has_its_time(desk: &Desk, points: &[Vector3<f64>], duration: f64) {
    let table = std::fs::read_to_string(desk.folder.join("out/lines.csv")).expect("written");
    let rows: Vec<Vec<&str>> = table.lines().skip(1).map(|row| row.split(',').collect()).collect();
    let number = |text: &str| text.parse::<f64>().expect("a number");
    let tool: Vec<(f64, Vector3<f64>)> = desk
        .trajectory::<6>("out")
        .iter()
        .map(|row| (row.t, Vector3::from(row.position) * 1e3 - Vector3::new(420.0, 0.0, 150.0)))
        .collect();
    let (mut end, mut seen, mut sum) = ([0.0; 2], vec![0; points.len()], 0.0);
    for row in &rows {
        let (from, to) = ([number(row[2]), number(row[4])], [number(row[3]), number(row[5])]);
        assert!(from == end && to[0] >= from[0] && to[1] >= from[1], "rows follow one another: {row:?}");
        end = to;
        sum += to[1] - from[1];
        assert_eq!((row[6], number(row[7]) <= 5e-5), ("0.1", true), "feed and deviation of {row:?}");
        let Ok(line) = row[0].parse::<usize>() else { continue };
        // The first point stands in line 2, and the first short line is line 4.
        seen[line - 3] += 1;
        let i = tool.partition_point(|(t, _)| *t < to[1]).clamp(1, tool.len() - 1);
        let ((a, p), (b, q)) = (tool[i - 1], tool[i]);
        let (at, along) = (p + (q - p) * ((to[1] - a) / (b - a)).clamp(0.0, 1.0), (q - p).normalize());
        let off = at - points[line - 3];
        // Blends take the place of lines beside the two corners.
        let inside = [3004, 3044].iter().all(|&corner: &usize| line.abs_diff(corner) > 20) && line < 3083;
        assert!(!inside || off.dot(&along).abs() < 1e-3 && off.norm() < 0.012, "{off} mm from the end of line {line}");
    }
    assert!(seen[1..].iter().all(|&count| count == 1) && rows.len() == points.len() - 1 + 2, "{} rows", rows.len());
    assert!((sum - duration).abs() < 1e-9 && (end[1] - duration).abs() < 1e-12, "{sum} s of {duration} s");
}

#[test]
fn three_thousand_lines_become_curves_and_true_corners_stay() {
    let desk = Desk::new("flower");
    let (report, points) = planned(&desk, ("G64 P0.05 Q0.01", 3000), "");
    // Blends are within 50 um of curves that are within 10 um of the lines.
    let off = farthest(&desk, &points);
    assert!(off <= 0.06 + 1e-6 && off > 0.005, "{off} mm");
    assert_eq!(report["program"]["stops"].as_array().map(Vec::len), Some(0));
    // The corner where the flower ends, and the one between the two straight lines.
    assert_eq!(report["program"]["blended"], 2);
    let smoothed = &report["program"]["smoothed"];
    assert_eq!((smoothed["lines"].as_u64(), smoothed["curves"].as_u64()), (Some(3080), Some(3)));
    let deviation = smoothed["deviation_m"].as_f64().expect("a number");
    assert!(deviation <= 1e-5 && deviation > 5e-6, "{deviation} m");
    let smooth = report["duration_s"].as_f64().expect("a number");
    let length = report["length_m"].as_f64().expect("a number");
    assert!(length / smooth > 0.08, "{} mm/s of 100", 1e3 * length / smooth);
    // A limit names the line that is nearest, and not all lines of the curve.
    for limit in report["limits"].as_array().expect("a list") {
        let lines: Vec<u64> = limit["lines"].as_array().expect("lines").iter().filter_map(|l| l.as_u64()).collect();
        let s = limit["at_s_m"].as_f64().expect("a place") * 1e3;
        let (mut way, mut nearest) = (0.0, 4);
        for (i, pair) in points.windows(2).enumerate() {
            if way <= s {
                nearest = i as u64 + 4;
            }
            way += (pair[1] - pair[0]).norm();
        }
        let near = |line: u64| line.abs_diff(nearest) <= 2;
        assert!(
            lines[0] == lines[1] && near(lines[0]) || lines[0] <= nearest && nearest <= lines[1] + 2,
            "{limit} {nearest}"
        );
        assert!(lines[1] - lines[0] < 3000, "{limit}");
    }
    each_line_has_its_time(&desk, &points, smooth);

    // A code in the middle of the flower stands where its line ends, and rotary axes may follow a curve.
    let (program, points) = flower("G64 P0.05 Q0.01", 3000);
    let lines: Vec<&str> = program.lines().collect();
    let text = format!("{}\nM62 P1\n{}\nG1 Y60 A5\n", lines[..1503].join("\n"), lines[1503..].join("\n"));
    desk.write("flower.ngc", &text);
    let report = desk.run(&["plan", "flower.ngc", "--job", "job.toml", "--json"]).done().json();
    let mark = &report["program"]["markers"][0];
    let way: f64 = points[..1501].windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
    assert!((mark["s_m"].as_f64().expect("a number") * 1e3 - way).abs() < 0.1, "{mark}, {way} mm");
    // A job can say it for programs that do not.
    let (report, _) = planned(&desk, ("", 3000), "[path]\nsmooth_mm = 0.01\nblend_mm = 0.05\n");
    assert_eq!(report["duration_s"].as_f64(), Some(smooth));
    // Blending alone goes from one line to the next one.
    let [smooth, blended] = ["G64 P0.05 Q0.02", "G64 P0.05 Q0"].map(|mode| {
        let (report, _) = planned(&desk, (mode, 300), "");
        report["duration_s"].as_f64().expect("a number")
    });
    assert!(blended > 1.2 * smooth, "{blended} s, {smooth} s");
}

/// Rounding to a micrometre, a third of which the tolerance permits, does not make the motion slower.
#[test]
fn rounded_coordinates_do_not_turn_into_jerk() {
    let desk = Desk::new("rounded_flower");
    let [rounded, exact] = [3, 9].map(|digits: usize| {
        let mut program = String::from("G64 P0.05 Q0.003\nG21 G90 G0 X50 Y0\nF24000\n");
        for i in 1..=3000 {
            let a = TAU * f64::from(i) / 3000.0;
            let r = 40.0 + 10.0 * (5.0 * a).cos();
            writeln!(program, "G1 X{:.digits$} Y{:.digits$}", r * a.cos(), r * a.sin()).expect("memory");
        }
        desk.write("flower.ngc", &program);
        desk.write("job.toml", &format!("{JOB}[feed]\nfeed_mm_s = 400\n"));
        let report = desk.run(&["plan", "flower.ngc", "--job", "job.toml", "--json"]).done().json();
        report["duration_s"].as_f64().expect("a number")
    });
    assert!((rounded / exact - 1.0).abs() < 0.01 && exact < 3.2, "{rounded} s, {exact} s");
}

/// The rows of lines.csv, without those of blends: the line, its length and its feed.
fn rows_of_lines(desk: &Desk) -> Vec<(usize, f64, f64)> {
    let table = std::fs::read_to_string(desk.folder.join("out/lines.csv")).expect("written");
    let row = |row: &str| {
        let cells: Vec<&str> = row.split(',').collect();
        let number = |i: usize| cells[i].parse().unwrap_or_else(|_| panic!("no number in cell {i} of {row}"));
        let feed = number(6);
        cells[0].parse().ok().map(|line| (line, number(3) - number(2), feed))
    };
    table.lines().skip(1).filter_map(row).collect()
}

#[test]
fn lines_that_blends_leave_nothing_of_keep_their_row_and_feed() {
    let desk = Desk::new("swallowed");
    desk.write("job.toml", JOB);
    let plan = || desk.run(&["plan", "p.ngc", "--job", "job.toml", "--json"]).done();
    // Twenty lines of 50 um between two corners: blends of their one curve meet in its middle.
    let mut program = String::from("G64 P0.5 Q0.01\nG21 G90 G0 X50 Y0\nF6000\n");
    (1..=40).for_each(|i| writeln!(program, "G1 X{:.2} Y0", 50.0 + 0.75 * f64::from(i)).expect("memory"));
    (1..=20).for_each(|i| writeln!(program, "G1 X80 Y{:.2}", 0.05 * f64::from(i)).expect("memory"));
    (1..=40).for_each(|i| writeln!(program, "G1 X{:.2} Y1", 80.0 + 0.75 * f64::from(i)).expect("memory"));
    desk.write("p.ngc", &program);
    plan();
    let rows = rows_of_lines(&desk);
    assert_eq!(rows.iter().map(|row| row.0).collect::<Vec<_>>(), (4..=103).collect::<Vec<_>>());
    assert!(rows.iter().all(|row| row.2 == 0.1), "{rows:?}");
    assert!(rows[40..60].iter().all(|row| row.1.abs() < 1e-15), "{rows:?}");
    // The same of a line of its own, with another feed.
    desk.write("p.ngc", "G64 P0.5\nG21 G90 G0 X50 Y0\nF6000 G1 X80\nF4500 Y0.05\nF3000 X110\n");
    plan();
    let rows = rows_of_lines(&desk);
    assert_eq!(rows.iter().map(|&(line, _, feed)| (line, feed)).collect::<Vec<_>>(), [(3, 0.1), (4, 0.075), (5, 0.05)]);
    assert!(rows[1].1 == 0.0 && rows[0].1 > 0.029, "{rows:?}");
}

#[test]
fn a_stop_behind_a_curve_names_the_last_line_of_the_curve() {
    let desk = Desk::new("stop_behind_curve");
    desk.write("job.toml", JOB);
    let mut program = String::from("G64 P0.05 Q0.01\nG21 G90 G0 X50 Y0\nF6000\n");
    // Forty lines along an arc, from its end straight back along the tangent, and ahead again.
    for i in 1..=40 {
        let a = 0.01 * f64::from(i);
        writeln!(program, "G1 X{:.4} Y{:.4}", 50.0 * a.cos(), 50.0 * a.sin()).expect("memory");
    }
    let (x, y) = (50.0 * 0.4f64.cos(), 50.0 * 0.4f64.sin());
    let [back, ahead] = [20.0, 1.0].map(|way| (x + way * 0.4f64.sin(), y - way * 0.4f64.cos()));
    for (x, y) in [back, ahead] {
        writeln!(program, "G1 X{x:.4} Y{y:.4}").expect("memory");
    }
    desk.write("p.ngc", &program);
    let report = desk.run(&["plan", "p.ngc", "--job", "job.toml", "--json"]).done().json();
    let stops = report["program"]["stops"].as_array().expect("a list");
    let lines: Vec<_> = stops.iter().map(|stop| (stop["lines"][0].as_u64(), stop["lines"][1].as_u64())).collect();
    assert_eq!(lines, [(Some(43), Some(44)), (Some(44), Some(45))], "{stops:?}");
    let text = std::fs::read_to_string(desk.folder.join("out/report.txt")).expect("written");
    assert!(text.contains("2 stops, the first at line 43-44"), "{text}");
}

#[test]
fn a_program_with_more_lines_than_a_path_may_have_pieces_is_refused_by_line() {
    let desk = Desk::new("many_lines");
    let mut program = String::from("G21 G90 G61\nF600\n");
    (0..30_000).for_each(|i| writeln!(program, "G1 X{} Y{}", i % 7, 1 + i % 5).expect("memory"));
    desk.write("long.ngc", &program);
    desk.write("job.toml", JOB);
    let parts = ["long.ngc:25003", "25000", "G64"];
    desk.run(&["plan", "long.ngc", "--job", "job.toml"]).refused(2, &parts);
}
