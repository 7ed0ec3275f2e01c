//! Reads path files: a curve that comes with the program, points from a CSV file, and files with mistakes in them, to
//! show what the messages say.

use std::path::Path;

use arcfeed_geometry::Curve;
use robot_cr7::{PathFile, PathGeometry, butterfly};

fn main() -> Result<(), robot_cr7::InputError> {
    let path = butterfly()?;
    if let PathGeometry::Curve(curve) = &path.geometry {
        let (start, end) = curve.domain();
        println!("{}: degree {}, {} control points", path.name, curve.degree(), curve.control_points().len());
        println!("  starts at {:?} m, ends at {:?} m", curve.point(start).as_slice(), curve.point(end).as_slice());
    }

    let csv = "x_mm, y_mm\n0, 0\n40, 60\n80, 0\n";
    let path = PathFile::from_bytes(csv.as_bytes(), Path::new("arch.csv"), None)?;
    println!("{}: {:?}", path.name, path.geometry);

    println!("\nFiles with mistakes:");
    for (file, text) in [
        ("units.json", r#"{"degree": 1, "control_points": [[0, 0], [1, 0]], "knots": [0, 0, 1, 1]}"#),
        ("knots.json", r#"{"units": "mm", "degree": 1, "control_points": [[0, 0], [1, 0]], "knots": [0, 1, 0, 1]}"#),
        ("typo.json", r#"{"units": "mm", "degre": 1, "control_points": [[0, 0], [1, 0]], "knots": [0, 0, 1, 1]}"#),
        ("twice.csv", "x_mm,y_mm\n0,0\n1,1\n\n1,1\n"),
        ("comma.csv", "x_mm,y_mm\n\"0,5\",1\n"),
    ] {
        if let Err(e) = PathFile::from_bytes(text.as_bytes(), Path::new(file), None) {
            println!("  {e}");
        }
    }
    Ok(())
}
