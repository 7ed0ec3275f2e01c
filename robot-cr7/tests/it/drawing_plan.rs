//! `cr7 plan` on drawings: the tool follows the contours, and lifts between them.

use nalgebra::Vector3;
use robot_cr7::{DrawingOptions, MoveKind};

use crate::common::Desk;
use crate::drawing_texts::{dxf, place, read_with, svg};

/// A tool that points down over a workpiece in front of the arm.
const JOB: &str =
    "[workpiece]\nposition_mm = [420, 0, 150]\n[orientation]\nrpy_deg = [180, 0, 0]\n[feed]\nfeed_mm_s = 150\n";
const SAMPLES: [(&str, &str); 4] = [
    ("plate.dxf", include_str!("../../data/drawings/plate.dxf")),
    ("leaf.dxf", include_str!("../../data/drawings/leaf.dxf")),
    ("badge.svg", include_str!("../../data/drawings/badge.svg")),
    ("bracket.svg", include_str!("../../data/drawings/bracket.svg")),
];

fn planned(desk: &Desk, file: &str, job: &str) -> serde_json::Value {
    desk.write("job.toml", &format!("{JOB}{job}"));
    let report = desk.run(&["plan", file, "--job", "job.toml", "--json"]).done().json();
    let limits = report["limits"].as_array().expect("a list");
    assert!(limits.len() > 5);
    for line in limits {
        assert!(line["ratio"].as_f64().expect("a number") <= 1.0 + 1e-6, "{line}");
    }
    report
}

fn tool_points(desk: &Desk) -> Vec<Vector3<f64>> {
    let rows = desk.trajectory::<6>("out");
    rows.iter().map(|row| Vector3::from(row.position) - Vector3::new(0.42, 0.0, 0.15)).collect()
}

fn distance_from(p: &Vector3<f64>, line: &[Vector3<f64>]) -> f64 {
    let from_chord = |pair: &[Vector3<f64>]| {
        let (a, b) = (pair[0], pair[1]);
        let share = ((p - a).dot(&(b - a)) / (b - a).norm_squared().max(1e-300)).clamp(0.0, 1.0);
        (p - a - (b - a) * share).norm()
    };
    line.windows(2).map(from_chord).fold(f64::INFINITY, f64::min)
}

#[test]
fn every_sample_is_planned_along_its_contours() {
    for (name, text) in SAMPLES {
        let desk = Desk::new(&format!("drawing_{}", name.replace('.', "_")));
        desk.write(name, text);
        let report = planned(&desk, name, "[path]\nblend_mm = 0.05\nlift_mm = 8\n");
        let program = read_with(text, name, &DrawingOptions { lift: 8e-3, feed: 0.15, ..DrawingOptions::default() });
        let drawn: Vec<Vector3<f64>> = program
            .moves_with_starts()
            .flat_map(|(start, step)| {
                let count = if step.kind == MoveKind::Rapid { 1 } else { 200 };
                (0..=count).map(move |i| place(start, step, f64::from(i) / f64::from(count)))
            })
            .collect();
        let points = tool_points(&desk);
        // Every tenth point, against chords that are 2 um from their arcs at the most.
        for p in points.iter().step_by(10) {
            let off = distance_from(p, &drawn);
            assert!(off < 0.054e-3, "{name}: {off} m at {p}");
        }
        // The corners of the lifts are reached, and the ends of every contour.
        for pair in program.moves.windows(2) {
            if (pair[0].kind == MoveKind::Rapid) != (pair[1].kind == MoveKind::Rapid) {
                let near = points.iter().map(|p| (p - pair[0].end()).norm()).fold(f64::INFINITY, f64::min);
                assert!(near < 1e-6, "{name}: {near} m at the end of line {}", pair[0].line);
            }
        }
        let highest = points.iter().map(|p| p.z).fold(0.0, f64::max);
        assert!((highest - 8e-3).abs() < 1e-9, "{name}: {highest}");
        // Lines of the table go on from one another, up to the end.
        let table = std::fs::read_to_string(desk.folder.join("out/lines.csv")).expect("written");
        let rows: Vec<Vec<&str>> = table.lines().skip(1).map(|row| row.split(',').collect()).collect();
        assert!(rows.len() >= program.moves.len(), "{name}");
        assert!(rows.iter().all(|row| row[6] == "0.15"), "{name}: the feed is that of the job");
        let end: f64 = rows[rows.len() - 1][5].parse().expect("a number");
        assert!((end - report["duration_s"].as_f64().expect("a number")).abs() < 1e-12, "{name}");
        let marks = report["program"]["markers"].as_array().expect("a list");
        assert_eq!(marks.len(), program.markers.len(), "{name}");
        for mark in marks {
            let at = points[(mark["t_s"].as_f64().expect("a number") * 1e3).round() as usize];
            assert!(at.z.abs() < 1e-5, "{name}: {mark} at {at}");
        }
        let fastest = points.windows(2).map(|pair| (pair[1] - pair[0]).norm() / 1e-3).fold(0.0, f64::max);
        assert!(fastest <= 0.15 * (1.0 + 1e-6), "{name}: {fastest}");
    }
}

#[test]
fn layers_and_units_of_the_job_are_those_of_the_drawing() {
    let desk = Desk::new("drawing_layers");
    desk.write("plate.dxf", SAMPLES[0].1);
    let whole = planned(&desk, "plate.dxf", "");
    let cut = planned(&desk, "plate.dxf", "[path]\nlayers = [\"engrave\"]\n");
    let length = |report: &serde_json::Value| report["length_m"].as_f64().expect("a number");
    assert!((length(&cut) - 1e-3 * (50.0 + 1.5 * std::f64::consts::PI)).abs() < 1e-9, "{}", length(&cut));
    assert!(length(&whole) > 0.8);
    let bad = |job: &str, parts: &[&str]| {
        desk.write("job.toml", &format!("{JOB}{job}"));
        desk.run(&["plan", "plate.dxf", "--job", "job.toml"]).refused(2, parts);
    };
    bad("[path]\nlayers = [\"slot\"]\n", &["plate.dxf", "\"slot\"", "\"0\", \"cut\", \"engrave\", \"notes\""]);
    bad("[path]\nlayers = []\n", &["job.toml", "path.layers", "remove the key"]);
    bad("[path]\nlift_mm = 0\n", &["job.toml:8", "path.lift_mm", "above 0"]);
    bad("[path]\nlift_mm = 20000\n", &["path.lift_mm", "10000 mm at the most"]);
    bad("[[sections]]\nfrom_mm = 1\nto_mm = 2\nfeed_mm_s = 3\n", &["[[sections]]", "feed.feed_mm_s"]);

    desk.write("job.toml", &format!("{JOB}[path]\ncsv_unit = \"cm\"\n"));
    desk.write("line.dxf", &dxf("0 LINE 8 0 10 0 20 0 11 3 21 0").replace("$INSUNITS", "$OTHER"));
    let length = |arguments: &[&str]| {
        let all = [&["plan", "line.dxf", "--job", "job.toml", "--json"], arguments].concat();
        desk.run(&all).done().json()["length_m"].as_f64().expect("a number")
    };
    assert!((length(&[]) - 0.03).abs() < 1e-12);
    assert!((length(&["--unit", "in"]) - 0.0762).abs() < 1e-12);
    desk.write("page.svg", &svg("<text>hello</text>"));
    desk.run(&["plan", "page.svg"]).refused(2, &["page.svg", "1 x <text>"]);
    desk.run(&["plan", "page.pdf"]).refused(2, &["page.pdf", ".dxf, .svg (a drawing)"]);
    desk.run(&["inspect", "plate.dxf"]).done();
    let help = desk.run(&["plan", "--help"]).done().stdout;
    assert!(help.contains("cr7 plan part.dxf") && help.contains(".svg (drawings)"), "{help}");
}

#[test]
fn every_sample_is_tested() {
    let folder = std::path::PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("data/drawings");
    let names = std::fs::read_dir(folder).expect("the folder is there");
    let mut names: Vec<_> =
        names.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    assert_eq!(names, ["badge.svg", "bracket.svg", "leaf.dxf", "plate.dxf"]);
    assert!(SAMPLES.iter().all(|(name, _)| names.iter().any(|file| file == name)));
}
