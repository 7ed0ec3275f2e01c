//! Meshes of the links of an arm, for pictures: those that its URDF names, read below one folder.

mod fault;
mod folder;
mod stl;
mod visuals;

use std::path::{Path, PathBuf};

use arcfeed_kinematics::ArmDescription;
use nalgebra::{Point3, Vector3};

pub use self::fault::MeshFault;
use super::error::{InputError, read_text};

/// Most triangles of all meshes together.
const MOST_TRIANGLES: usize = 1_000_000;
/// Most meshes.
const MOST_MESHES: usize = 100;
/// Least extent of a mesh, m: ten units of the coordinates on a page.
const LEAST_SIZE: f64 = 1e-3;
/// Greatest coordinate in the frame of a joint, m.
const MOST_PLACE: f64 = 10.0;

/// The mesh of a link.
#[derive(Debug, Clone, PartialEq)]
pub struct LinkMesh {
    /// What it moves with: 0 for the base, else the number of the joint, from 1.
    pub frame: usize,
    /// The corners of its triangles in the frame behind that joint, m.
    pub triangles: Vec<[Vector3<f64>; 3]>,
}

/// The meshes of the arm `description` of the file `urdf`, which was read from the link `base` on. Files below `folder` are read, and no
/// others: a name that leads out of it is refused.
///
/// # Errors
/// [`InputError::Mesh`] naming the file and what is wrong with it.
pub fn read_meshes(
    urdf: &Path,
    folder: &Path,
    base: Option<&str>,
    description: &ArmDescription,
) -> Result<Vec<LinkMesh>, InputError> {
    let fault_of = |file: &Path, fault| InputError::Mesh { file: file.to_owned(), fault };
    if !urdf.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("urdf")) {
        return Err(fault_of(urdf, MeshFault::None("it is no .urdf file")));
    }
    let text = read_text(urdf, "a robot as URDF")?;
    let carried: Vec<&str> = description.joints.iter().map(|joint| joint.link.as_str()).collect();
    let visuals = visuals::visuals(&text, base, &carried, MOST_MESHES + 1).map_err(|fault| fault_of(urdf, fault))?;
    if visuals.is_empty() {
        return Err(fault_of(urdf, MeshFault::None("no link of the arm has a mesh")));
    }
    if visuals.len() > MOST_MESHES {
        let most = MOST_MESHES as u64;
        return Err(fault_of(urdf, MeshFault::Many { what: "meshes or more", count: most + 1, most }));
    }
    let mut left = MOST_TRIANGLES;
    let mut all = Vec::new();
    for visual in visuals {
        let wrong = |fault| fault_of(&PathBuf::from(&visual.name), fault);
        let corners = folder::read(folder, &visual.name).and_then(|bytes| stl::triangles(&bytes, left));
        let corners = corners.map_err(wrong)?;
        left -= corners.len();
        let place = |corner: [f32; 3]| {
            let scaled = Vector3::from(corner.map(f64::from)).component_mul(&visual.scale);
            (visual.pose * Point3::from(scaled)).coords
        };
        let triangles: Vec<_> = corners.into_iter().map(|corners| corners.map(place)).collect();
        for (index, corners) in triangles.iter().enumerate() {
            let value = corners.iter().map(Vector3::amax).fold(0.0, f64::max);
            // Not `>`: a NaN has to show.
            let is_near = value <= MOST_PLACE && corners.iter().all(|corner| corner.iter().all(|v| v.is_finite()));
            if !is_near {
                return Err(wrong(MeshFault::Corner { triangle: index + 1, value, most: MOST_PLACE }));
            }
        }
        let size = extent(&triangles).ok_or_else(|| wrong(MeshFault::Nothing))?;
        if size < LEAST_SIZE {
            return Err(wrong(MeshFault::Small { size, least: LEAST_SIZE }));
        }
        all.push(LinkMesh { frame: visual.frame, triangles });
    }
    Ok(all)
}

/// The greatest extent of triangles along an axis; `None` without any.
fn extent(triangles: &[[Vector3<f64>; 3]]) -> Option<f64> {
    let corners = || triangles.iter().flatten().copied();
    let (least, most) = (corners().reduce(|a, b| a.inf(&b))?, corners().reduce(|a, b| a.sup(&b))?);
    Some((most - least).max())
}
