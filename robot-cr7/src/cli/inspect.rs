//! `cr7 inspect`: what a path is like before anything is planned.

use std::path::PathBuf;

use crate::plot::path_picture;
use crate::{Cr7Error, Job, PathFile, Robot, Staging};
use arcfeed_geometry::{ArcLengthCurve, Curve, NurbsCurve, SegmentationMethod, Spacing};
use nalgebra::Vector3;

use crate::cli::Failure;
use crate::cli::output::say;
use crate::cli::picture_files::PictureArgs;
use crate::cli::robots;
use crate::cli::tool_path::read_path;

/// Arguments of `cr7 inspect`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  cr7 inspect part.json
  cr7 inspect points.csv --unit mm --fit-mm 0.01 --tolerance-mm 0.05
  cr7 inspect                              the embedded butterfly
  cr7 inspect --robot panda                limits, geometry, reach and inverse of a robot")]
pub struct Args {
    /// Look at a robot in place of a path: a built-in name (`cr7 robots` lists them), or a file .urdf or .json
    #[arg(long, conflicts_with_all = ["path", "format"])]
    robot: Option<String>,
    /// Link of a .urdf file where the arm begins [default: its root]
    #[arg(long, requires = "robot")]
    base_link: Option<String>,
    /// Link of a .urdf file where the arm ends, the flange [default: the hand, tool0 or the only end of its chain]
    #[arg(long, requires = "robot")]
    tip_link: Option<String>,
    /// Path file: .json (NURBS curve), .csv (points), .ngc, .nc, .gcode (G-code) or .dxf, .svg (drawings). Without it: an embedded butterfly
    path: Option<PathBuf>,
    /// Chord tolerance of the segmentations, mm
    #[arg(long, default_value_t = 0.001)]
    tolerance_mm: f64,
    /// Largest distance of a curve from the points of a .csv file that it is fitted to, mm
    #[arg(long, default_value_t = 0.001)]
    fit_mm: f64,
    /// Unit of a file that names none (.csv, .dxf, .svg, G-code): mm, cm, m or in
    #[arg(long)]
    unit: Option<String>,
    /// Folder for the picture; created when missing
    #[arg(long, default_value = "out")]
    out: PathBuf,
    #[command(flatten)]
    pictures: PictureArgs,
}

/// The file that is written.
const FILES: [&str; 1] = ["inspect.svg"];

/// Places a knot span at which curvature and extent are taken.
const SAMPLES: u32 = 5_000;

pub fn run(args: &Args) -> Result<(), Failure> {
    if let Some(name) = &args.robot {
        return robots::inspect(&Robot::load(name, args.base_link.as_deref(), args.tip_link.as_deref())?);
    }
    let painter = args.pictures.painter()?;
    let mut staging = Staging::new(&args.out, &FILES, args.path.as_deref().as_slice())?;
    painter.draw(&mut staging);
    let file = read_path(args.path.as_deref(), args.unit.as_deref(), &Job::default())?;
    staging.clear()?;
    let shown = file.file.display().to_string();
    let geometry = |source| Failure::from(Cr7Error::Curve { file: shown.clone(), source });
    let curve = file.curve_with(|points| {
        let degree = points.len().saturating_sub(1).min(3);
        let fit = NurbsCurve::approximate(points, degree, Spacing::default(), args.fit_mm * 1e-3)?;
        say!("fitted to {} points, none farther away than {:.3e} mm", points.len(), fit.max_deviation * 1e3);
        Ok(fit.curve)
    })?;
    let path = ArcLengthCurve::new(curve.clone(), 1e-15).map_err(geometry)?;

    describe(&file, &path);
    say!("\n  segments for a chord tolerance of {} mm    count   largest deviation", args.tolerance_mm);
    let tolerance = args.tolerance_mm * 1e-3;
    let mut drawn = None;
    for (name, method) in [
        ("longest pieces within knot spans", SegmentationMethod::Greedy { across_knots: false }),
        ("longest pieces across knots", SegmentationMethod::Greedy { across_knots: true }),
        ("C-type pieces, bisected", SegmentationMethod::CType),
        ("convex hull, bisected", SegmentationMethod::Hull),
    ] {
        let result = curve.segment(method, tolerance).map_err(geometry)?;
        say!("    {name:<44}{:>6}   {:.6} mm", result.len(), result.max_deviation() * 1e3);
        drawn.get_or_insert(result);
    }
    let Some(segmentation) = drawn else { return Ok(()) };
    let lines: Vec<Vec<[f64; 3]>> = segmentation
        .pieces()
        .map(|(u0, u1, _)| (0..=8).map(|i| curve.point(u0 + (u1 - u0) * f64::from(i) / 8.0).into()).collect())
        .collect();
    let picture = args.out.join(FILES[0]);
    let svg = path_picture(&file.name, &lines, segmentation.deviations(), tolerance, None);
    staging.write_picture(FILES[0], svg)?;
    staging.publish_pictures()?;
    say!("\n  wrote {}", picture.display());
    Ok(())
}

/// Prints what is known of the curve.
fn describe(file: &PathFile, path: &ArcLengthCurve<3>) {
    let curve = path.curve();
    say!("{}", file.name);
    if let Some(source) = &file.source {
        say!("  source       {source}");
    }
    let kind = if curve.is_rational() { "rational" } else { "polynomial" };
    let spans = curve.knots().spans().count();
    say!(
        "  curve        degree {}, {} control points, {spans} knot spans, {kind}",
        curve.degree(),
        curve.control_points().len()
    );
    say!("  length       {:.9} mm", path.length() * 1e3);
    let (a, b) = curve.domain();
    let closed = (curve.point(a) - curve.point(b)).norm();
    say!("  ends         {:.3e} mm apart{}", closed * 1e3, if closed < 1e-9 { " (closed)" } else { "" });
    let ([low, high], (sharpest, at)) = extent(curve);
    let at = path.arc_length_at(at);
    let size = (high - low) * 1e3;
    say!("  extent       {:.3} x {:.3} x {:.3} mm", size.x, size.y, size.z);
    if sharpest > 0.0 {
        say!(
            "  curvature    up to {:.3} /mm (radius {:.4} mm) at s = {:.3} mm, over {SAMPLES} samples a knot span",
            sharpest * 1e-3,
            1e3 / sharpest,
            at * 1e3
        );
    } else {
        say!("  curvature    0 (straight)");
    }
    for corner in path.corners(1e-6) {
        say!(
            "  corner       {:.2} deg at s = {:.3} mm: the tool has to stop there",
            corner.angle.to_degrees(),
            corner.s * 1e3
        );
    }
}

/// The corners of a box around the curve, and its largest curvature with the parameter there.
fn extent(curve: &NurbsCurve<3>) -> ([Vector3<f64>; 2], (f64, f64)) {
    let a = curve.domain().0;
    let (mut low, mut high) = (curve.point(a), curve.point(a));
    let (mut sharpest, mut at) = (0.0f64, a);
    // Evenly in every knot span by the curve's own parameter, which dwells where the curve bends.
    for k in curve.knots().spans() {
        let (u0, u1) = (curve.knots().as_slice()[k], curve.knots().as_slice()[k + 1]);
        for i in 0..=SAMPLES {
            let u = u0 + (u1 - u0) * f64::from(i) / f64::from(SAMPLES);
            let jet = curve.jet(u);
            (low, high) = (low.inf(&jet.point), high.sup(&jet.point));
            let kappa = jet.curvature();
            if kappa > sharpest {
                (sharpest, at) = (kappa, u);
            }
        }
    }
    ([low, high], (sharpest, at))
}
