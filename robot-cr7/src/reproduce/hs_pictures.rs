//! Pictures of Liu et al. 2024 that are more than lines: figure 12a, the segmented butterfly, and figure 14, the event in both spaces.

use std::io;

use arcfeed_geometry::SegmentationMethod;

use super::hs_live::{EVENTS, embedded, played, table_6_scenario};
use crate::output::plot::{path_picture, run_pictures};
use crate::run::error::Cr7Error;

/// A picture with the name of its file.
pub type NamedPicture = (String, Result<String, io::Error>);

/// Figures 12a and 14.
///
/// # Errors
/// [`Cr7Error`] when an embedded scenario cannot be played, which would be a bug.
pub fn liu_2024_pictures() -> Result<Vec<NamedPicture>, Cr7Error> {
    const CHORD: f64 = 5e-5;
    let mut pictures: Vec<NamedPicture> = Vec::new();
    let (text, breaks) = table_6_scenario()?;
    pictures.push(played(&text, "table 6", |stage, _, _| {
        let curve = stage.live().path().pose_path().curve();
        let segments: Vec<Vec<[f64; 2]>> = breaks
            .windows(2)
            .map(|b| {
                let at = |i: u32| curve.point(b[0] + (b[1] - b[0]) * f64::from(i) / 8.0);
                (0..=8).map(at).map(|p| [p.x, p.y]).collect()
            })
            .collect();
        let deviations = curve
            .curve()
            .segment(SegmentationMethod::CType, CHORD)
            .map(|s| s.deviations().to_vec())
            .unwrap_or_default();
        let svg = path_picture("Figure 12a: the butterfly in its segments", &segments, &deviations, CHORD);
        ("figure_12a_path.svg".to_owned(), svg)
    })?);
    for ((file, _), name) in EVENTS.into_iter().zip(["figure_14", "figure_14_middle"]) {
        pictures.extend(played(embedded(file), file, |stage, played, report| {
            let drawn = run_pictures(stage, played, report).into_iter();
            drawn.map(|(file, svg)| (format!("{name}_{file}"), svg)).collect::<Vec<_>>()
        })?);
    }
    Ok(pictures)
}
