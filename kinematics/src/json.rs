//! Arms from JSON and back, format "arm-params/1": m, rad, kg, kg m^2, N m.
//!
//! ```json
//! { "format": "arm-params/1", "name": "pendulum", "source": "made up", "notes": [],
//!   "joints": [ { "name": "swing", "type": "revolute", "axis": [0, 1, 0],
//!                 "origin": { "xyz": [0, 0, 1], "rpy": [0, 0, 0] },
//!                 "limits": { "lower": -3, "upper": 3, "velocity": 2, "acceleration": null, "jerk": null, "effort": 10 },
//!                 "inertial": { "mass": 1, "com": [0, 0, -0.5],
//!                               "inertia": { "ixx": 0.1, "ixy": 0, "ixz": 0, "iyy": 0.1, "iyz": 0, "izz": 0.01 } } } ],
//!   "flange": { "xyz": [0, 0, -1], "rpy": [0, 0, 0] } }
//! ```
//!
//! `rot` (3 x 3 by rows) in place of `rpy` (fixed axes, R = Rz Ry Rx) is exact where angles are not; it wins if both are
//! there. A joint's `link` is named after the joint if it has no name of its own. A body flagged `"physically_consistent": false` is taken as identified, not checked as a body. Fields that are
//! not known are passed over.

use crate::{
    description::{ArmDescription, JointDescription, have_usable_names},
    dynamics::Inertial,
    error::{KinematicsError, Part},
    joint::JointKind,
};
use nalgebra::{Isometry3, Matrix3, Rotation3, UnitQuaternion, Vector3};
use serde::Deserialize;
use serde_json::{Value, json};

const FORMAT: &str = "arm-params/1";
/// Largest deviation of a rotation matrix in a file from one.
const ROTATION_ROUNDING: f64 = 1e-6;

#[derive(Deserialize)]
struct File {
    format: String,
    name: String,
    #[serde(default)]
    source: Value,
    #[serde(default)]
    notes: Vec<String>,
    joints: Vec<JointRecord>,
    #[serde(default)]
    flange: Option<Frame>,
    #[serde(default)]
    base: Option<Frame>,
}

#[derive(Deserialize)]
struct Frame {
    xyz: [f64; 3],
    #[serde(default)]
    rpy: [f64; 3],
    rot: Option<[[f64; 3]; 3]>,
}

#[derive(Deserialize)]
struct JointRecord {
    name: String,
    link: Option<String>,
    #[serde(rename = "type")]
    kind: String,
    axis: [f64; 3],
    origin: Frame,
    limits: Option<Limits>,
    inertial: Option<Body>,
    rotor: Option<Rotor>,
    friction: Option<FrictionRecord>,
}

#[derive(Deserialize)]
struct Limits {
    lower: Option<f64>,
    upper: Option<f64>,
    velocity: Option<f64>,
    acceleration: Option<f64>,
    jerk: Option<f64>,
    effort: Option<f64>,
}

#[derive(Deserialize)]
struct Body {
    mass: f64,
    com: [f64; 3],
    inertia: Tensor,
    physically_consistent: Option<bool>,
}

#[derive(Deserialize)]
struct Tensor {
    ixx: f64,
    ixy: f64,
    ixz: f64,
    iyy: f64,
    iyz: f64,
    izz: f64,
}

#[derive(Deserialize)]
struct Rotor {
    reflected_inertia: f64,
}

#[derive(Deserialize)]
struct FrictionRecord {
    joint_side: JointSide,
}

/// `coulomb_neg` is a torque and so negative.
#[derive(Deserialize)]
struct JointSide {
    viscous: f64,
    coulomb_pos: f64,
    coulomb_neg: f64,
}

impl Frame {
    fn pose(&self) -> Result<Isometry3<f64>, KinematicsError> {
        let rotation = match self.rot {
            None => UnitQuaternion::from_euler_angles(self.rpy[0], self.rpy[1], self.rpy[2]),
            Some(rows) => {
                let matrix = Matrix3::from_fn(|r, c| rows[r][c]);
                let off = (matrix * matrix.transpose() - Matrix3::identity()).amax();
                if !(off < ROTATION_ROUNDING && matrix.determinant() > 0.0) {
                    let (what, rule) = ("the deviation of 'rot' from a rotation", "nothing but rounding");
                    return Err(KinematicsError::InvalidSetting { what, value: off, rule });
                }
                UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix))
            }
        };
        Ok(Isometry3::from_parts(self.xyz.into(), rotation))
    }
}

impl JointRecord {
    fn described(self) -> Result<JointDescription, KinematicsError> {
        let kind = match self.kind.as_str() {
            "revolute" | "continuous" => JointKind::Revolute,
            "prismatic" => JointKind::Prismatic,
            other => return Err(KinematicsError::UnsupportedJoint { kind: other.to_owned() }),
        };
        let limits = self.limits.as_ref();
        let range = limits.and_then(|limits| Some([limits.lower?, limits.upper?]));
        let inertial = self.inertial.map(|body| {
            let t = &body.inertia;
            let tensor = Matrix3::new(t.ixx, t.ixy, t.ixz, t.ixy, t.iyy, t.iyz, t.ixz, t.iyz, t.izz);
            if body.physically_consistent == Some(false) {
                Inertial::identified(body.mass, body.com.into(), tensor)
            } else {
                Inertial::new(body.mass, body.com.into(), tensor)
            }
        });
        Ok(JointDescription {
            link: self.link.unwrap_or_else(|| format!("{}_link", self.name)),
            origin: self.origin.pose()?,
            axis: Vector3::from(self.axis),
            kind,
            range: range.filter(|_| self.kind != "continuous"),
            velocity: limits.and_then(|limits| limits.velocity),
            acceleration: limits.and_then(|limits| limits.acceleration),
            jerk: limits.and_then(|limits| limits.jerk),
            torque: limits.and_then(|limits| limits.effort),
            inertial: inertial.transpose()?,
            rotor_inertia: self.rotor.map(|rotor| rotor.reflected_inertia),
            friction: self.friction.map(|friction| {
                let side = friction.joint_side;
                [side.viscous, side.coulomb_pos, -side.coulomb_neg]
            }),
            name: self.name,
        })
    }
}

impl ArmDescription {
    /// Reads a description in the format "arm-params/1".
    ///
    /// # Errors
    /// [`KinematicsError::Unreadable`] with line and column, or what is wrong with a joint, by name. [`KinematicsError::Structure`] for a
    /// name of a joint that is empty, begins or ends with a blank, holds a control character or is there twice.
    pub fn from_json(text: &str) -> Result<Self, KinematicsError> {
        let unreadable = |reason: String| KinematicsError::Unreadable { format: "JSON", reason };
        // Editors on Windows begin a file with a byte order mark.
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let file: File = serde_json::from_str(text).map_err(|error| unreadable(error.to_string()))?;
        if file.format != FORMAT {
            return Err(unreadable(format!("its format is '{}', not '{FORMAT}'", file.format)));
        }
        let mut joints = Vec::with_capacity(file.joints.len());
        for joint in file.joints {
            let name = joint.name.clone();
            joints.push(joint.described().map_err(|error| error.in_part(Part::Joint, &name))?);
        }
        have_usable_names(&joints)?;
        let pose = |frame: Option<Frame>| frame.map_or(Ok(Isometry3::identity()), |frame| frame.pose());
        let (source, licence) = match &file.source {
            Value::Object(fields) => {
                let text = |key: &str| fields.get(key).and_then(Value::as_str).unwrap_or_default();
                let parts: Vec<&str> =
                    ["repo", "path", "commit"].map(text).into_iter().filter(|t| !t.is_empty()).collect();
                (parts.join(", "), text("licence").to_owned())
            }
            Value::String(text) => (text.clone(), String::new()),
            _ => (String::new(), String::new()),
        };
        Ok(Self {
            name: file.name,
            source,
            licence,
            notes: file.notes,
            base: pose(file.base)?,
            joints,
            flange: pose(file.flange)?,
        })
    }

    /// The description in the format "arm-params/1", which [`ArmDescription::from_json`] reads. Numbers that are not finite
    /// become `null`.
    ///
    /// ```
    /// use arcfeed_kinematics::{ArmDescription, models};
    /// let panda = models::description("panda").expect("built in");
    /// let read = ArmDescription::from_json(&panda.to_json())?;
    /// assert_eq!((&read.name, read.missing()), (&panda.name, panda.missing()));
    /// # Ok::<(), arcfeed_kinematics::KinematicsError>(())
    /// ```
    pub fn to_json(&self) -> String {
        let object = json!({
            "format": FORMAT,
            "name": self.name,
            "source": { "repo": self.source, "licence": self.licence },
            "notes": self.notes,
            "base": frame(&self.base),
            "joints": self.joints.iter().map(joint).collect::<Vec<_>>(),
            "flange": frame(&self.flange),
        });
        format!("{object:#}")
    }
}

fn frame(pose: &Isometry3<f64>) -> Value {
    let r = pose.rotation.to_rotation_matrix().into_inner();
    let rows = [0, 1, 2].map(|i| [r[(i, 0)], r[(i, 1)], r[(i, 2)]]);
    json!({ "xyz": <[f64; 3]>::from(pose.translation.vector), "rot": rows })
}

fn joint(joint: &JointDescription) -> Value {
    let [lower, upper] = joint.range.map_or([None; 2], |range| range.map(Some));
    let body = |body: &Inertial| {
        let t = body.tensor();
        json!({
            "mass": body.mass(),
            "com": <[f64; 3]>::from(*body.centre()),
            "inertia": {
                "ixx": t[(0, 0)], "ixy": t[(0, 1)], "ixz": t[(0, 2)], "iyy": t[(1, 1)], "iyz": t[(1, 2)], "izz": t[(2, 2)],
            },
            "physically_consistent": body.is_physical(),
        })
    };
    json!({
        "name": joint.name,
        "link": joint.link,
        "type": match joint.kind { JointKind::Revolute => "revolute", JointKind::Prismatic => "prismatic" },
        "axis": <[f64; 3]>::from(joint.axis),
        "origin": frame(&joint.origin),
        "limits": {
            "lower": lower, "upper": upper, "velocity": joint.velocity, "acceleration": joint.acceleration,
            "jerk": joint.jerk, "effort": joint.torque,
        },
        "inertial": joint.inertial.as_ref().map(body),
        "rotor": joint.rotor_inertia.map(|inertia| json!({ "reflected_inertia": inertia })),
        "friction": joint.friction.map(|[viscous, forward, backward]| {
            json!({ "joint_side": { "viscous": viscous, "coulomb_pos": forward, "coulomb_neg": -backward } })
        }),
    })
}
