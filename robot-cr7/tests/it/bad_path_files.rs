//! Every kind of bad path file gets a message that names the file, the key or line, the value and the way out.

use std::path::Path;

use proptest::prelude::*;
use robot_cr7::{LengthUnit, PathFile, PathGeometry, SamplePath};

fn message(file: &str, text: &str) -> String {
    match PathFile::from_bytes(text.as_bytes(), Path::new(file), None) {
        Ok(path) => panic!("{text} was read as {path:?}"),
        Err(e) => e.to_string(),
    }
}

/// Checks that the message for `text` holds all of `parts`.
fn says(file: &str, text: &str, parts: &[&str]) {
    let m = message(file, text);
    assert!(m.contains(file), "the file is missing in: {m}");
    for part in parts {
        assert!(m.contains(part), "\"{part}\" is missing in: {m}");
    }
}

/// A valid cubic of five points with one value replaced.
fn cubic(from: &str, to: &str) -> String {
    let valid = r#"{
  "units": "mm",
  "degree": 3,
  "control_points": [[0, 0], [1, 2], [3, 2], [4, 0], [5, 1]],
  "weights": [1, 1, 1, 1, 1],
  "knots": [0, 0, 0, 0, 0.5, 1, 1, 1, 1]
}"#;
    PathFile::from_bytes(valid.as_bytes(), Path::new("valid.json"), None).expect("the valid file is valid");
    assert!(valid.contains(from), "{from} does not stand in the valid file");
    valid.replacen(from, to, 1)
}

#[test]
fn empty_file() {
    says("a.json", "", &["empty", "JSON object", "units", "knots"]);
    says("a.csv", " \n\t\n", &["empty", "x_mm,y_mm"]);
}

#[test]
fn not_json() {
    says("a.json", "{\n  \"degree\": 3,\n  oops\n}", &["a.json:3:3", "key must be a string", "correct it"]);
    says("a.json", "[1, 2", &["a.json:1:", "degree"]);
    says("a.json", &cubic("}", ""), &["EOF", "correct it"]);
}

#[test]
fn not_text() {
    let e = PathFile::from_bytes(b"x_mm,y_mm\n1,2\n\xff\xfe,3\n", Path::new("a.csv"), None).expect_err("not UTF-8");
    assert_eq!(e.to_string(), "a.csv:3: the line is not UTF-8 text: save the file as plain UTF-8 text");
}

#[test]
fn unknown_and_missing_and_repeated_keys() {
    says(
        "a.json",
        &cubic("weights", "wieghts"),
        &["a.json:5:", "unknown field `wieghts`", "`weights`", "remove the key"],
    );
    says("a.json", &cubic("\"degree\": 3,", ""), &["missing field `degree`", "add the key"]);
    says("a.json", &cubic("\"degree\": 3", "\"degree\": 3, \"degree\": 3"), &["a.json:3:", "duplicate field `degree`"]);
}

#[test]
fn values_of_the_wrong_kind() {
    says("a.json", &cubic("3,", "\"three\","), &["a.json:3:", "\"three\"", "a whole number"]);
    says("a.json", &cubic("3,", "-3,"), &["a.json:3:", "-3"]);
    says("a.json", &cubic("[1, 2]", "7"), &["a.json:4:", "7", "[x, y, z]"]);
}

#[test]
fn units_are_needed_and_known() {
    says("a.json", &cubic("\"units\": \"mm\",", ""), &["units", "\"mm\"", "\"cm\"", "\"m\"", "\"in\""]);
    says("a.json", &cubic("\"mm\"", "\"furlong\""), &["units is \"furlong\"", "\"mm\"", "\"in\""]);
    says("a.csv", "x,y\n0,0\n1,1\n", &["line 1", "x_mm,y_mm"]);
    says("a.csv", "0,0\n1,1\n", &["no header", "x_mm,y_mm"]);
    says("a.csv", "x_ft,y_ft\n0,0\n1,1\n", &["line 1", "\"x_ft\"", "\"ft\"", "\"mm\""]);
    says("a.csv", "x_mm,y_m\n0,0\n1,1\n", &["a.csv:1", "column 2", "\"y_m\"", "one unit"]);
    let e = PathFile::from_bytes(b"x_mm,y_mm\n0,0\n1,1\n", Path::new("a.csv"), Some(LengthUnit::Metre));
    let m = e.expect_err("units differ").to_string();
    assert!(m.contains("a.csv") && m.contains("line 1") && m.contains("\"mm\"") && m.contains("\"m\""), "{m}");
}

#[test]
fn not_a_number() {
    says("a.json", &cubic("0.5", "NaN"), &["a.json:6:", "NaN", "must be finite"]);
    says("a.json", &cubic("[1, 2]", "[Infinity, 2]"), &["a.json:4:", "Infinity", "must be finite"]);
    says("a.json", &cubic("[1, 2]", "[1e999, 2]"), &["a.json:4:", "out of range", "finite"]);
    says("a.csv", "x_mm,y_mm\n0,0\n1,nan\n", &["a.csv:3", "column 2", "\"nan\"", "finite"]);
    says("a.csv", "x_mm,y_mm\n0,0\n1,inf\n", &["a.csv:3", "column 2", "\"inf\"", "finite"]);
}

#[test]
fn weights() {
    says("a.json", &cubic("\"weights\": [1, 1", "\"weights\": [1, -2.5"), &["weights[1]", "-2.5", "above 0"]);
    says("a.json", &cubic("\"weights\": [1, 1", "\"weights\": [1, 0"), &["weights[1]", "is 0", "above 0"]);
    says("a.json", &cubic("\"weights\": [1, 1", "\"weights\": [1"), &["weights", "4 weights for 5", "one weight per"]);
}

#[test]
fn knots() {
    says("a.json", &cubic("0.5", "-0.5"), &["knots[4]", "-0.5", "must not decrease"]);
    says("a.json", &cubic("0.5, ", ""), &["knots", "8 knots", "exactly 9"]);
    says("a.json", &cubic("0.5", "0"), &["knots[0]", "5 times", "at most degree + 1"]);
}

#[test]
fn too_few_points_and_hopeless_degrees() {
    let few = r#"{"units": "mm", "degree": 3, "control_points": [[0, 0], [1, 1]], "knots": [0, 0, 1, 1]}"#;
    says("a.json", few, &["control_points", "2 points for degree 3", "lower the degree"]);
    says("a.json", &few.replace("[[0, 0], [1, 1]]", "[]"), &["control_points", "0 points"]);
    says("a.json", &few.replace("degree\": 3", "degree\": 18446744073709551615"), &["18446744073709551615"]);
    says("a.json", &few.replace("degree\": 3", "degree\": 0"), &["degree is 0"]);
    says("a.csv", "x_mm,y_mm\n0,0\n", &["1 points", "at least 2", "add points"]);
    says("a.csv", "x_mm,y_mm\n", &["0 points", "at least 2"]);
}

#[test]
fn coordinates() {
    says("a.json", &cubic("[1, 2]", "[1]"), &["control_points[1]", "[1.0]", "two or three", "[x, y]"]);
    says("a.json", &cubic("[1, 2]", "[1, 2, 3]"), &["control_points[1]", "[1.0, 2.0, 3.0]", "control_points[0]"]);
    says("a.csv", "x_mm,y_mm\n0,0\n1,1,1\n", &["a.csv:3", "3 columns", "line 1 has 2", "same columns"]);
    says("a.csv", "x_mm\n0\n1\n", &["a.csv:1", "1 columns", "x,y or x,y,z"]);
    says("a.csv", "x_mm,y_mm,t_s\n0,0,0\n", &["a.csv:1", "column 3", "\"t_s\"", "remove"]);
    says("a.csv", "x_mm,x_mm\n0,0\n", &["a.csv:1", "column 2", "twice", "remove"]);
    says("a.csv", "x_mm,y_mm\n0,0\n1,zwei\n", &["a.csv:3", "column 2", "\"zwei\"", "decimal point"]);
    says("a.csv", "x_mm,y_mm\n1;2\n", &["a.csv:2", "1 columns", "separated by commas"]);
}

#[test]
fn duplicate_points_name_both_lines() {
    says("a.csv", "x_mm,y_mm\n0,0\n1,1\n\n# again\n1,1\n2,2\n", &["a.csv:6", "line 3", "remove one"]);
    // A closed path and a path that crosses itself repeat points, but not one after the other.
    let closed = "x_mm,y_mm\n0,0\n1,0\n1,1\n0,0\n";
    assert!(PathFile::from_bytes(closed.as_bytes(), Path::new("a.csv"), None).is_ok());
}

#[test]
fn files_that_cannot_be_read() {
    let read = |file: &str| PathFile::read(Path::new(file), None).expect_err("there is no such file").to_string();
    let m = read("no/such/path.json");
    assert!(m.contains("no/such/path.json") && m.contains("cannot be read") && m.contains("check the name"), "{m}");
    let m = read("part.step");
    assert!(m.contains("part.step") && m.contains("\"step\"") && m.contains(".json") && m.contains(".csv"), "{m}");
    let m = read("part");
    assert!(m.contains("part") && m.contains("\"\"") && m.contains(".json"), "{m}");
}

#[test]
fn sizes_that_look_like_a_slip_of_the_unit_are_warned_of() {
    let metres = cubic("\"mm\"", "\"m\"").replace("[5, 1]", "[50, 1]");
    let path = PathFile::from_bytes(metres.as_bytes(), Path::new("a.json"), None).expect("valid");
    assert!(path.warnings.len() == 1 && path.warnings[0].contains("did you mean mm?"), "{:?}", path.warnings);
    let tiny = "x_mm,y_mm\n0,0\n0.01,0.02\n";
    let path = PathFile::from_bytes(tiny.as_bytes(), Path::new("a.csv"), None).expect("valid");
    assert!(path.warnings.len() == 1 && path.warnings[0].contains("did you mean m?"), "{:?}", path.warnings);
}

#[test]
fn errors_of_a_fit_name_the_line() {
    let path = PathFile::from_bytes(b"# a comment\nx_mm,y_mm\n0,0\n1,1\n", Path::new("a.csv"), None).expect("valid");
    let fail = |index| move |_: &[_]| Err(arcfeed_geometry::GeometryError::DuplicatePoints { index, distance: 0.0 });
    let m = path.curve_with(fail(1)).expect_err("it fails").to_string();
    assert!(m.starts_with("a.csv: line 4:"), "{m}");
    // An index out of range must not panic.
    let m = path.curve_with(fail(99)).expect_err("it fails").to_string();
    assert!(m.starts_with("a.csv: fitting the points:"), "{m}");
}

#[test]
fn units_are_converted() {
    for (unit, metres) in [("mm", 1e-3), ("cm", 1e-2), ("m", 1.0), ("in", 0.0254)] {
        let text = cubic("\"mm\"", &format!("\"{unit}\""));
        let path = PathFile::from_bytes(text.as_bytes(), Path::new("a.json"), None).expect("valid");
        let PathGeometry::Curve(curve) = path.geometry else { panic!("a curve") };
        let (last, y) = (curve.control_points()[4].x, curve.control_points()[2].y);
        assert!((last - 5.0 * metres).abs() < 1e-15 && (y - 2.0 * metres).abs() < 1e-15, "{unit}: {last} {y}");
    }
    let read = |text: &str, unit| PathFile::from_bytes(text.as_bytes(), Path::new("a.csv"), unit).expect("valid");
    for (text, unit) in [
        ("\u{feff}x_mm,y_mm,z_mm\r\n1,2,3\r\n4,5,6\r\n", None),
        ("Z [mm],X [mm],Y [mm]\n3,1,2\n6,4,5\n", None),
        ("x, y, z\n0.001, 0.002, 3e-3\n\n.4e-2, 0.005, 0.006\n", Some(LengthUnit::Metre)),
        ("1,2,3\n4,5,6", Some(LengthUnit::Millimetre)),
    ] {
        let path = read(text, unit);
        assert!(!path.planar);
        let PathGeometry::Points { points, .. } = path.geometry else { panic!("points") };
        for (p, expected) in points.iter().zip([[1e-3, 2e-3, 3e-3], [4e-3, 5e-3, 6e-3]]) {
            assert_eq!(p.as_slice(), expected, "{text}");
        }
    }
}

#[test]
fn sample_paths_are_what_they_say() {
    // Points, knots and spread from the printed tables: count, degree, and the first control point in mm.
    for (sample, points, first) in [
        (SamplePath::Butterfly, 51, [54.493, 52.139]),
        (SamplePath::SixPoint, 6, [5.0, 4.0]),
        (SamplePath::SevenPoint, 7, [1.0, 6.0]),
        (SamplePath::Fan, 89, [-16.0688, -56.985]),
    ] {
        let path = sample.load().expect("valid");
        assert!(path.planar && path.warnings.is_empty() && path.name == sample.name());
        assert!(path.source.as_deref().is_some_and(|s| !s.is_empty()));
        let plane = path.plane_curve().expect("a plane curve");
        let PathGeometry::Curve(curve) = path.geometry else { panic!("a curve") };
        assert_eq!((curve.degree(), curve.control_points().len()), (3, points));
        assert_eq!(curve.control_points()[0].as_slice(), [first[0] / 1e3, first[1] / 1e3, 0.0]);
        assert_eq!(plane.control_points()[points - 1], curve.control_points()[points - 1].xy());
    }
}

/// The bytes with a few of them replaced, removed or doubled.
fn mutated(text: &'static str) -> impl Strategy<Value = Vec<u8>> {
    let edit = (0usize..text.len(), prop::sample::select(b"0123456789.,-eE[]{}\":#\n x\xff\x00NaN".to_vec()), 0u8..4);
    prop::collection::vec(edit, 1..8).prop_map(move |edits| {
        let mut bytes = text.as_bytes().to_vec();
        for (at, byte, kind) in edits {
            let at = at.min(bytes.len().saturating_sub(1));
            match kind {
                0 => bytes[at] = byte,
                1 => bytes.insert(at, byte),
                2 if bytes.len() > 1 => {
                    bytes.remove(at);
                }
                _ => {
                    let end = (at + 20).min(bytes.len());
                    let copy = bytes[at..end].to_vec();
                    bytes.extend(copy);
                }
            }
        }
        bytes
    })
}

/// Reads the bytes as both kinds; what is read has finite points, and messages name the file.
fn never_panics(bytes: &[u8]) -> Result<(), TestCaseError> {
    for file in ["x.json", "x.csv"] {
        for unit in [None, Some(LengthUnit::Inch)] {
            match PathFile::from_bytes(bytes, Path::new(file), unit) {
                Ok(PathFile { geometry: PathGeometry::Points { points, lines, .. }, .. }) => {
                    prop_assert!(points.len() == lines.len() && points.iter().all(|p| p.iter().all(|v| v.is_finite())));
                }
                Ok(_) => {}
                Err(e) => prop_assert!(e.to_string().contains(file)),
            }
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        never_panics(&bytes)?;
    }

    #[test]
    fn random_csv_never_panics(text in "(x_mm,y_mm\n)?([-0-9.,e\"#\n ;a]{0,12}\n){0,8}") {
        never_panics(text.as_bytes())?;
    }

    #[test]
    fn mutated_files_never_panic(bytes in mutated(SamplePath::SixPoint.json())) {
        never_panics(&bytes)?;
    }

    #[test]
    fn mutated_csv_never_panics(bytes in mutated("x_mm,y_mm\n0,0\n1.5,2e1\n\n# note\n3,4\n-5,6\n")) {
        never_panics(&bytes)?;
    }
}
