//! A path file where its job places it: curve, orientation and feeds, ready for an arm.

use arcfeed_geometry::{
    ArcLengthCurve, Curve, Fit, GeometryError, JoinedPathBuilder, NurbsCurve, OrientationPath, PosePath, Spacing,
};
use arcfeed_interp::{FeedSection, LimitError, ToolLimits};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use serde::Serialize;

use super::error::Cr7Error;
use super::feed_notes::FeedNotes;
use super::outline::Outline;
use super::point_tools::{check_swing, orientations};
use super::programmed::Programmed;
use super::stretch::Stretch;
use crate::input::error::InputError;
use crate::input::job::{Job, ToolOrientation};
use crate::input::path_file::{MOST_CONTROL_POINTS, PathFile, PathGeometry};
use crate::text::number;

/// Positions along the path are good to this, m: far below what any encoder resolves.
pub(crate) const ARC_LENGTH_TOLERANCE: f64 = 1e-15;
/// Stretches of a curve that stands still are replaced within this, m.
const STANDING_TOLERANCE: f64 = 1e-6;
/// Largest angle between the tangent and a tool that follows it, rad.
const HEADING_TOLERANCE: f64 = 1e-3;
/// Degree of curves laid through points.
const FIT_DEGREE: usize = 3;

/// A path in the base frame, with what its file says of the feed.
#[derive(Debug, Clone)]
pub(crate) struct PlacedPath {
    pub path: PosePath,
    /// Feeds of the job, or of the program.
    pub sections: Vec<FeedSection>,
    /// Where the tool stops because the file says so, by arc length.
    pub stops: Vec<f64>,
    /// Lines of the file along the path, where it has such.
    pub outline: Option<Outline>,
    /// How near a smooth curve is to the points of the file.
    pub fit: Option<PointFit>,
    /// The highest feed anywhere on it, m/s.
    pub fastest: f64,
    pub notes: FeedNotes,
    warnings: Vec<String>,
}

impl PlacedPath {
    /// The path of a file where the job places it, with the orientation that the job asks for.
    pub fn new(job: &Job, file: &PathFile) -> Result<Self, Cr7Error> {
        let programmed = match &file.geometry {
            PathGeometry::Program(program) => Some(Programmed::of_program(program, job)?),
            PathGeometry::Points { points, lines, .. } if job.polyline => {
                Some(Programmed::of_polyline(file, points, lines, job)?)
            }
            PathGeometry::Points { .. } | PathGeometry::Curve(_) => None,
        };
        Self::placed(job, file, programmed)
    }

    /// Moves of the program that `file` holds, where the job places them.
    pub fn of_stretch(job: &Job, file: &PathFile, stretch: &Stretch<'_>) -> Result<Self, Cr7Error> {
        Self::placed(job, file, Some(Programmed::of_stretch(stretch, job)?))
    }

    /// Turns the tool from one orientation in the base to another one, in step with the arc length.
    pub fn turn(&mut self, from: UnitQuaternion<f64>, to: UnitQuaternion<f64>) -> Result<(), GeometryError> {
        let curve = self.path.curve().clone();
        let turn = OrientationPath::slerp(curve.length(), from, to)?;
        self.path = PosePath::new(curve, turn);
        Ok(())
    }

    /// What a person should know beside the notes on the feed.
    pub fn own_warnings(&self) -> &[String] {
        &self.warnings
    }

    /// What a person should know.
    pub fn warnings(&self, job: &Job) -> Vec<String> {
        self.notes.words(job).into_iter().chain(self.warnings.iter().cloned()).collect()
    }

    fn placed(job: &Job, file: &PathFile, programmed: Option<Programmed>) -> Result<Self, Cr7Error> {
        let error = |source| curve_error(file, source);
        let tools = match &file.geometry {
            PathGeometry::Points { lines, tools: Some(tools), .. } => Some(orientations(file, tools, lines, job)?),
            _ => None,
        };
        let SmoothCurve { curve, fit } = match &programmed {
            Some(programmed) => SmoothCurve { curve: programmed.path.to_curve().map_err(error)?, fit: None },
            None => smooth_curve(file, job)?,
        };
        let curve = small_enough(file, curve.transformed(&job.workpiece).map_err(error)?)?;
        let mut warnings = Vec::new();
        let curve = match ArcLengthCurve::new(curve.clone(), ARC_LENGTH_TOLERANCE) {
            // Sections and points of the tool may be given by the parameter of the curve.
            Err(GeometryError::StandsStill { .. }) if job.sections.is_empty() && tools.is_none() => {
                let (curve, words) = moving(&curve).map_err(error)?;
                warnings.push(words);
                ArcLengthCurve::new(curve, ARC_LENGTH_TOLERANCE).map_err(error)?
            }
            other => other.map_err(error)?,
        };
        let Some(programmed) = programmed else {
            let orientation = match (&tools, &fit, &file.geometry) {
                (Some(tools), Some((_, parameters)), PathGeometry::Points { lines, .. }) => {
                    let key = |(u, tool): (&f64, &UnitQuaternion<f64>)| {
                        (curve.arc_length_at(*u), job.workpiece.rotation * tool)
                    };
                    let keys: Vec<_> = parameters.iter().zip(tools).map(key).collect();
                    let path = OrientationPath::through(&keys).map_err(error)?;
                    check_swing(&path, &keys, file, lines)?;
                    path
                }
                _ => orientation_of(job, &curve).map_err(error)?,
            };
            let path = PosePath::new(curve, orientation);
            return Ok(Self {
                path,
                sections: job.sections.clone(),
                stops: Vec::new(),
                outline: None,
                fit: fit.map(|(fit, _)| fit),
                fastest: job.feed.feed,
                notes: FeedNotes::default(),
                warnings,
            });
        };
        let turned = match (&programmed.turns, job.orientation) {
            (None, _) => tools,
            (Some(turns), ToolOrientation::Constant(rotation)) => {
                Some(turns.iter().map(|turn| turn * rotation).collect())
            }
            (Some(_), _) => return Err(Programmed::turns_twice(&file.file).into()),
        };
        let orientation = match turned {
            Some(turned) => {
                let keys: Vec<_> = turned.iter().map(|tool| job.workpiece.rotation * tool).collect();
                programmed.path.orientation(&curve, &keys, job.blend_angle).map_err(error)?
            }
            None => orientation_of(job, &curve).map_err(error)?,
        };
        Ok(Self {
            sections: programmed.sections(job),
            stops: programmed.stops(&curve),
            outline: Some(programmed.outline(&curve, &job.workpiece)),
            fit: None,
            fastest: programmed.highest_feed().map_or(job.feed.feed, |feed| feed.max(job.feed.feed)),
            path: PosePath::new(curve, orientation),
            notes: programmed.notes,
            warnings: programmed.warnings,
        })
    }
}

/// A curve that stands still somewhere with short stretches replaced there, and what is said of them.
fn moving(curve: &NurbsCurve<3>) -> Result<(NurbsCurve<3>, String), GeometryError> {
    let mut path = JoinedPathBuilder::new(curve.clamped()?.control_points()[0], STANDING_TOLERANCE)?;
    path.curve(curve, 1)?;
    let path = path.build()?;
    let most = path.pieces().iter().map(|piece| piece.deviation).fold(0.0, f64::max);
    let most = number(most * 1e6);
    let words = format!(
        "control points of the curve coincide, or it has a cusp, where the curvature has no bound: short stretches there are replaced within {most} um"
    );
    Ok((path.to_curve()?, words))
}

fn curve_error(file: &PathFile, source: GeometryError) -> Cr7Error {
    Cr7Error::Curve { file: file.file.display().to_string(), source }
}

/// A curve, and the parameters of the points that it was laid through.
struct SmoothCurve {
    curve: NurbsCurve<3>,
    fit: Option<(PointFit, Vec<f64>)>,
}

/// The curve of a file, or the smooth one through its points, which may not bulge far beside the lines between them.
fn smooth_curve(file: &PathFile, job: &Job) -> Result<SmoothCurve, Cr7Error> {
    let mut fit = None;
    let curve = file.curve_with(|points| {
        let degree = FIT_DEGREE.min(points.len().saturating_sub(1));
        let found = NurbsCurve::approximate(points, degree, Spacing::default(), job.fit_tolerance)?;
        Ok(fit.insert(found).curve.clone())
    })?;
    let (Some(fit), PathGeometry::Points { points, lines, .. }) = (fit, &file.geometry) else {
        return Ok(SmoothCurve { curve, fit: None });
    };
    let bulges: Vec<Bulge> = (0..points.len().saturating_sub(1)).map(|i| Bulge::after(i, &fit, points)).collect();
    let over = |bulge: &Bulge| bulge.distance / job.bulge.unwrap_or(Bulge::PART * bulge.chord);
    if let Some(worst) = bulges.iter().max_by(|a, b| over(a).total_cmp(&over(b))).filter(|bulge| over(bulge) > 1.0) {
        return Err(worst.error(file, lines).into());
    }
    let largest = bulges.iter().max_by(|a, b| a.distance.total_cmp(&b.distance));
    let known = PointFit {
        points: points.len(),
        control_points: curve.control_points().len(),
        deviation_m: fit.max_deviation,
        bulge_m: largest.map_or(0.0, |bulge| bulge.distance),
        bulge_line: largest.and_then(|bulge| lines.get(bulge.point).copied()).unwrap_or_default(),
    };
    Ok(SmoothCurve { curve, fit: Some((known, fit.parameters)) })
}

/// How near a smooth curve is to the points of a file, and to the lines between them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PointFit {
    /// Number of points.
    pub points: usize,
    /// Number of control points of the curve.
    pub control_points: usize,
    /// Largest distance of a point from the curve, m.
    pub deviation_m: f64,
    /// Largest distance of the curve from the line between two neighbouring points, m.
    pub bulge_m: f64,
    /// Line in the file of the first of these two points.
    pub bulge_line: u64,
}

/// Where a curve through points is beside the line from one point to the next.
#[derive(Debug, Clone, Copy)]
struct Bulge {
    /// The point before it.
    point: usize,
    /// m.
    distance: f64,
    /// Distance of the two points, m.
    chord: f64,
}

impl Bulge {
    /// Places looked at between two points.
    const LOOKS: i32 = 8;
    /// A smooth curve through points of a circle bulges by this part of their distance where there are four of them.
    const PART: f64 = 0.25;

    /// The bulge between the points `i` and `i + 1`.
    fn after(i: usize, fit: &Fit<3>, points: &[Vector3<f64>]) -> Self {
        let (a, b) = (points[i], points[i + 1]);
        let (from, to) = (fit.parameters[i], fit.parameters[i + 1]);
        let chord = (b - a).norm();
        let along = (b - a) / chord;
        let distance = |k: i32| {
            let off = fit.curve.point(from + (to - from) * f64::from(k) / f64::from(Self::LOOKS)) - a;
            (off - along * off.dot(&along).clamp(0.0, chord)).norm()
        };
        Self { point: i, distance: (1..Self::LOOKS).map(distance).fold(0.0, f64::max), chord }
    }

    fn error(&self, file: &PathFile, lines: &[u64]) -> InputError {
        let line = |i: usize| lines.get(i).copied().unwrap_or_default();
        let (from, to) = (line(self.point), line(self.point + 1));
        let [distance, chord] = [self.distance, self.chord].map(|m| number(m * 1e3));
        InputError::Value {
            file: file.file.clone(),
            line: usize::try_from(from).ok(),
            key: "the smooth curve through the points".to_owned(),
            value: format!("{distance} mm beside the line of {chord} mm from line {from} to line {to}"),
            rule: "it may leave the lines between its points by a quarter of their length, or by path.bulge_mm of the job",
            remedy: "set path.through = \"polyline\" if the points are corners, give more points, or path.bulge_mm",
        }
    }
}

fn small_enough(file: &PathFile, curve: NurbsCurve<3>) -> Result<NurbsCurve<3>, Cr7Error> {
    let count = curve.control_points().len();
    if count <= MOST_CONTROL_POINTS {
        return Ok(curve);
    }
    let (key, remedy) = match &file.geometry {
        PathGeometry::Program(_) => ("the curve of the program", "split the program"),
        _ => ("the curve through the points", "raise path.fit_tolerance_mm of the job, or split the path"),
    };
    Err(Cr7Error::Input(InputError::Value {
        file: file.file.clone(),
        line: None,
        key: key.to_owned(),
        value: format!("one of {count} control points"),
        rule: "a path has at most 25000 control points",
        remedy,
    }))
}

/// The limits of the tool in a job, on a path whose highest feed is `fastest` (m/s).
pub(crate) fn tool_of(job: &Job, fastest: f64) -> Result<ToolLimits, LimitError> {
    let feed = &job.feed;
    let mut tool = ToolLimits::new()
        .with_feed(fastest)?
        .with_tangential_acceleration(feed.tangential_acceleration)?
        .with_tangential_jerk(feed.tangential_jerk)?
        .with_normal_acceleration(feed.normal_acceleration)?;
    if let Some(jerk) = feed.normal_jerk {
        tool = tool.with_normal_jerk(jerk)?;
    }
    if let Some(limit) = feed.tool_acceleration {
        tool = tool.with_acceleration(limit)?;
    }
    if let Some(limit) = feed.tool_jerk {
        tool = tool.with_jerk(limit)?;
    }
    if let Some(speed) = feed.angular_speed {
        tool = tool.with_angular_speed(speed)?;
    }
    Ok(tool)
}

fn orientation_of(job: &Job, curve: &ArcLengthCurve<3>) -> Result<OrientationPath, GeometryError> {
    let frame = job.workpiece.rotation;
    match job.orientation {
        ToolOrientation::Constant(rotation) => Ok(OrientationPath::Constant(frame * rotation)),
        ToolOrientation::Slerp { from, to } => OrientationPath::slerp(curve.length(), frame * from, frame * to),
        ToolOrientation::Tangent { axis } => {
            let z = frame * axis;
            let tangent = curve.jet(0.0).d1;
            let x = (tangent - z.as_ref() * z.dot(&tangent))
                .try_normalize(1e-6)
                .ok_or(GeometryError::NoHeading { s: 0.0 })?;
            let axes = Matrix3::from_columns(&[x, z.cross(&x), z.into_inner()]);
            let start = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
            OrientationPath::following_tangent(curve, z, start, HEADING_TOLERANCE)
        }
    }
}
