//! Jobs and paths.

use std::path::{Path as FilePath, PathBuf};

use arcfeed_geometry::NurbsCurve;
use nalgebra::Vector3;
use pyo3::prelude::*;
use robot_cr7::{LengthUnit, PathFile, PathGeometry, butterfly};

use crate::array::{Array1, Array2};
use crate::error::input;

/// Settings of a plan: workpiece, tool, feed, limits, tolerance, period.
///
/// Made from a dict, from TOML text or from a file; the keys are those of job files, with their units in their names
/// (`Job.example()` shows all of them). Keys that are left out have documented defaults; unknown ones are refused.
#[pyclass(module = "arcfeed", frozen)]
#[derive(Debug, Clone)]
pub struct Job {
    pub inner: robot_cr7::Job,
}

#[pymethods]
impl Job {
    /// From keys as keyword arguments, tables as dicts: `Job(feed={"feed_mm_s": 50})`.
    #[new]
    #[pyo3(signature = (**tables))]
    fn new(py: Python<'_>, tables: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        match tables {
            None => Ok(Self { inner: robot_cr7::Job::default() }),
            Some(tables) => {
                let text: String = py.import("arcfeed.tables")?.call_method1("to_json", (tables,))?.extract()?;
                let value: serde_json::Value = serde_json::from_str(&text).map_err(input)?;
                Self::from_toml(&toml::to_string(&value).map_err(input)?)
            }
        }
    }

    /// From the text of a job file (TOML). Relative names of files are taken from the current folder.
    #[staticmethod]
    fn from_toml(text: &str) -> PyResult<Self> {
        let inner = robot_cr7::Job::from_bytes(text.as_bytes(), FilePath::new("job")).map_err(input)?;
        Ok(Self { inner })
    }

    /// From a job file (TOML).
    #[staticmethod]
    fn load(file: PathBuf) -> PyResult<Self> {
        Ok(Self { inner: robot_cr7::Job::read(&file).map_err(input)? })
    }

    /// The text of a job file with every key, its default and its meaning.
    #[staticmethod]
    fn example() -> &'static str {
        robot_cr7::Job::EXAMPLE
    }

    /// Control period, s.
    #[getter]
    fn period(&self) -> f64 {
        self.inner.period
    }

    /// Values that are allowed but look like a slip.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.inner.warnings.clone()
    }

    fn __repr__(&self) -> String {
        format!("Job(feed {} m/s, period {} s)", self.inner.feed.feed, self.inner.period)
    }
}

/// A path of the tool tip in the workpiece frame, m.
#[pyclass(module = "arcfeed", frozen)]
#[derive(Debug, Clone)]
pub struct Path {
    pub inner: PathFile,
}

impl Path {
    fn of(name: &str, geometry: PathGeometry) -> Self {
        let inner = PathFile {
            name: name.to_owned(),
            source: None,
            file: PathBuf::from(name),
            geometry,
            planar: false,
            warnings: Vec::new(),
        };
        Self { inner }
    }
}

/// The rows of an array of two or three columns as points.
fn points(array: &Array2<'_>, what: &str) -> PyResult<Vec<Vector3<f64>>> {
    let view = array.as_array();
    let columns = view.ncols();
    if !(2..=3).contains(&columns) {
        return Err(input(format!("{what} has {columns} columns: give x and y, or x, y and z, in m")));
    }
    let at =
        |row: numpy::ndarray::ArrayView1<'_, f64>| Vector3::new(row[0], row[1], row.get(2).copied().unwrap_or(0.0));
    Ok(view.rows().into_iter().map(at).collect())
}

#[pymethods]
impl Path {
    /// From a file: .json (NURBS curve), .csv (points), .ngc and its kin (G-code), .dxf or .svg (drawings).
    ///
    /// unit ("mm", "cm", "m", "in") is that of a file that names none. Layers, lift and feed of a drawing come from job.
    #[staticmethod]
    #[pyo3(signature = (file, unit=None, job=None))]
    fn load(file: PathBuf, unit: Option<&str>, job: Option<&Job>) -> PyResult<Self> {
        let unit = match unit {
            None => None,
            Some(symbol) => Some(LengthUnit::from_symbol(symbol).ok_or_else(|| {
                input(format!("unit {symbol:?} is not a known unit of length: use \"mm\", \"cm\", \"m\" or \"in\""))
            })?),
        };
        let default = robot_cr7::Job::default();
        let job = job.map_or(&default, |job| &job.inner);
        Ok(Self { inner: PathFile::read_for_job(&file, unit, job).map_err(input)? })
    }

    /// A NURBS curve: degree, control points (n, 2) or (n, 3) in m, knots (n + degree + 1), weights (n; all 1 if left out).
    #[staticmethod]
    #[pyo3(signature = (degree, control_points, knots, weights=None, name="nurbs"))]
    fn nurbs(
        degree: usize,
        control_points: Array2<'_>,
        knots: Array1<'_>,
        weights: Option<Array1<'_>>,
        name: &str,
    ) -> PyResult<Self> {
        let points = points(&control_points, "control_points")?;
        let weights = weights.map_or_else(|| vec![1.0; points.len()], |weights| weights.as_array().to_vec());
        let curve = NurbsCurve::new(degree, points, weights, knots.as_array().to_vec()).map_err(input)?;
        Ok(Self::of(name, PathGeometry::Curve(curve)))
    }

    /// A smooth curve through points (n, 2) or (n, 3) in m. Job(path={"through": "polyline"}) makes them corners.
    #[staticmethod]
    #[pyo3(signature = (points, name="points"))]
    fn through(points: Array2<'_>, name: &str) -> PyResult<Self> {
        let points = self::points(&points, "points")?;
        let lines = (1..=points.len() as u64).collect();
        Ok(Self::of(name, PathGeometry::Points { points, lines, tools: None }))
    }

    /// The butterfly of the CNC literature, 383 mm long.
    #[staticmethod]
    fn butterfly() -> PyResult<Self> {
        Ok(Self { inner: butterfly().map_err(input)? })
    }

    /// Its name.
    #[getter]
    fn name(&self) -> &str {
        &self.inner.name
    }

    /// Things that are allowed but look like a slip.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.inner.warnings.clone()
    }

    fn __repr__(&self) -> String {
        let kind = match &self.inner.geometry {
            PathGeometry::Curve(curve) => format!("NURBS curve of degree {}", curve.degree()),
            PathGeometry::Points { points, .. } => format!("{} points", points.len()),
            PathGeometry::Program(program) => format!("program of {} moves", program.moves.len()),
        };
        format!("Path({:?}, {kind})", self.inner.name)
    }
}
