//! Arms.

use arcfeed_kinematics::AnyArm;
use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion};
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::array::{Array1, Array2, Table};
use crate::error::{input, raised};

/// A built-in arm by its name, or the arm of a .urdf or .json file; base and tip are links of a URDF.
///
/// Poses are 4 x 4 matrices in the base frame, m. Joint values are rad (m for joints that slide).
#[pyclass(module = "arcfeed", frozen)]
#[derive(Debug, Clone)]
pub struct Robot {
    pub inner: robot_cr7::Robot,
    arm: AnyArm,
}

/// A robot, or the name of one.
#[derive(FromPyObject)]
pub enum RobotArgument<'py> {
    /// A Robot.
    Robot(PyRef<'py, Robot>),
    /// A name of robots(), or a file.
    Name(String),
}

/// The robot of an argument; the CR7 without one.
pub fn robot_of(argument: Option<RobotArgument<'_>>) -> PyResult<robot_cr7::Robot> {
    match argument {
        None => robot_cr7::Robot::load("cr7", None, None).map_err(raised),
        Some(RobotArgument::Robot(robot)) => Ok(robot.inner.clone()),
        Some(RobotArgument::Name(name)) => robot_cr7::Robot::load(&name, None, None).map_err(raised),
    }
}

/// The names of the built-in robots.
#[pyfunction]
pub fn robots() -> Vec<&'static str> {
    robot_cr7::Robot::NAMES.to_vec()
}

/// The pose of a 4 x 4 matrix.
fn pose_of(matrix: &Array2<'_>, what: &str) -> PyResult<Isometry3<f64>> {
    let m = matrix.as_array();
    if m.shape() != [4, 4] {
        return Err(input(format!(
            "{what} has shape {:?}: give a 4 x 4 matrix of rotation and translation",
            m.shape()
        )));
    }
    let rotation = Matrix3::from_fn(|i, j| m[[i, j]]);
    let off = (rotation * rotation.transpose() - Matrix3::identity()).amax();
    let bottom = m[[3, 0]] == 0.0 && m[[3, 1]] == 0.0 && m[[3, 2]] == 0.0 && m[[3, 3]] == 1.0;
    if !(off < 1e-6 && rotation.determinant() > 0.0 && bottom) {
        return Err(input(format!("{what}: the upper left 3 x 3 has to be a rotation, and the last row 0, 0, 0, 1")));
    }
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation));
    Ok(Isometry3::from_parts(Translation3::new(m[[0, 3]], m[[1, 3]], m[[2, 3]]), rotation))
}

/// The 16 entries of the matrix of a pose, row by row.
fn entries(pose: &Isometry3<f64>) -> [f64; 16] {
    let m = pose.to_homogeneous();
    std::array::from_fn(|k| m[(k / 4, k % 4)])
}

#[pymethods]
impl Robot {
    #[new]
    #[pyo3(signature = (name="cr7", base=None, tip=None))]
    fn new(name: &str, base: Option<&str>, tip: Option<&str>) -> PyResult<Self> {
        let inner = robot_cr7::Robot::load(name, base, tip).map_err(raised)?;
        let arm = inner.any().clone();
        Ok(Self { inner, arm })
    }

    /// The same arm with the tip of its tool at this pose (4, 4) in the flange frame. Plans take the tool from the job.
    fn with_tool(&self, tool: Array2<'_>) -> PyResult<Self> {
        let arm = self.inner.any().with_tool(pose_of(&tool, "tool")?).map_err(input)?;
        Ok(Self { inner: self.inner.clone(), arm })
    }

    /// Its name.
    #[getter]
    fn name(&self) -> &str {
        &self.inner.description().name
    }

    /// Where its numbers come from; of a URDF, its first and last link.
    #[getter]
    fn source(&self) -> &str {
        &self.inner.description().source
    }

    /// What its source does not say, and what of it is left out.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.inner.description().notes.clone()
    }

    /// Names of its joints.
    #[getter]
    fn joint_names(&self) -> Vec<String> {
        self.arm.joint_names().to_vec()
    }

    /// Least and greatest joint values, rad (2, N).
    #[getter]
    fn range<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let (lower, upper) = self.arm.range();
        let mut table = Table::new(lower.len(), 2);
        table.push(lower);
        table.push(upper);
        table.to_array(py)
    }

    /// What its source says of velocity, acceleration, jerk (rad/s and so on) and torque (N m): a list a key, None where it is silent.
    #[getter]
    fn limits<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let joints = &self.inner.description().joints;
        let dict = PyDict::new(py);
        dict.set_item("velocity", joints.iter().map(|joint| joint.velocity).collect::<Vec<_>>())?;
        dict.set_item("acceleration", joints.iter().map(|joint| joint.acceleration).collect::<Vec<_>>())?;
        dict.set_item("jerk", joints.iter().map(|joint| joint.jerk).collect::<Vec<_>>())?;
        dict.set_item("torque", joints.iter().map(|joint| joint.torque).collect::<Vec<_>>())?;
        Ok(dict)
    }

    /// How its inverse is computed.
    #[getter]
    fn inverse_method(&self) -> String {
        self.arm.method().to_string()
    }

    /// Poses of the tool (n, 4, 4) at joint values q (n, N).
    fn forward_all<'py>(&self, py: Python<'py>, q: Array2<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let rows = q.as_array();
        let mut values = Vec::with_capacity(16 * rows.nrows());
        for row in rows.rows() {
            values.extend(entries(&self.arm.forward(&row.to_vec()).map_err(input)?));
        }
        PyArray1::from_vec(py, values).reshape([rows.nrows(), 4, 4])
    }

    /// Pose of the tool (4, 4) at joint values q (N,).
    fn forward<'py>(&self, py: Python<'py>, q: Vec<f64>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let pose = self.arm.forward(&q).map_err(input)?;
        PyArray1::from_slice(py, &entries(&pose)).reshape([4, 4])
    }

    /// Jacobian (6, N) in the base frame: linear velocity of the tool tip (m), then angular velocity (rad), per rad/s of a joint.
    fn jacobian<'py>(&self, py: Python<'py>, q: Vec<f64>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let dexterity = self.arm.dexterity(&q).map_err(input)?;
        let mut table = Table::new(q.len(), 6);
        for i in 0..6 {
            table.push(&dexterity.jacobian.iter().map(|column| column[i]).collect::<Vec<_>>());
        }
        table.to_array(py)
    }

    /// Joint values (N,) near seed (N,) that put the tool at pose (4, 4).
    fn inverse<'py>(
        &self,
        py: Python<'py>,
        pose: Array2<'py>,
        seed: Array1<'py>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let q = self.arm.inverse(&pose_of(&pose, "pose")?, &seed.as_array().to_vec()).map_err(input)?;
        Ok(PyArray1::from_vec(py, q))
    }

    /// All joint values (k, N) that put the tool at pose (4, 4), or several for a numeric inverse; and whether these are all.
    fn inverse_all<'py>(&self, py: Python<'py>, pose: Array2<'py>) -> PyResult<(Bound<'py, PyArray2<f64>>, bool)> {
        let (all, complete) = self.arm.inverse_all(&pose_of(&pose, "pose")?).map_err(input)?;
        let mut table = Table::new(self.arm.joints(), all.len());
        all.iter().for_each(|q| table.push(q));
        Ok((table.to_array(py)?, complete))
    }

    /// Torques (N,) of a motion, N m: joint values, velocities and accelerations (N,) each.
    fn torque<'py>(
        &self,
        py: Python<'py>,
        q: Vec<f64>,
        qd: Vec<f64>,
        qdd: Vec<f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(PyArray1::from_vec(py, self.arm.torque(&q, &qd, &qdd).map_err(input)?))
    }

    /// The arm as URDF.
    fn to_urdf(&self) -> String {
        self.inner.description().to_urdf()
    }

    fn __repr__(&self) -> String {
        format!("Robot({:?}, {} joints)", self.name(), self.arm.joints())
    }
}
