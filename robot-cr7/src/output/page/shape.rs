//! The shape of an arm as the page draws it: meshes of its links, made coarse enough, and the chain that moves them.

use std::collections::{HashMap, HashSet};

use arcfeed_kinematics::{Chain, JointKind};
use nalgebra::{Isometry3, Vector3};
use serde::Serialize;

use crate::input::meshes::LinkMesh;

/// Most triangles on the page: a browser moves them smoothly, and they take 0.4 MB.
const MOST_TRIANGLES: usize = 12_000;
/// Most triangles of a mesh that is smaller than a cell.
const FEW: usize = 100;
/// Unit of coordinates on the page, m.
const UNIT: f64 = 1e-4;
/// By how much cells grow from one try to the next.
const COARSER: f64 = 1.4;

/// The shape of an arm.
#[derive(Debug, Serialize)]
pub(super) struct ArmShape {
    /// Pose of the base: x, y, z (m), and a quaternion x, y, z, w.
    base: [f64; 7],
    joints: Vec<ShapeJoint>,
    meshes: Vec<ShapeMesh>,
}

/// A joint of the chain.
#[derive(Debug, Serialize)]
struct ShapeJoint {
    /// Its pose behind the joint before, as that of the base.
    origin: [f64; 7],
    axis: [f64; 3],
    slides: bool,
}

/// A mesh that moves with a joint.
#[derive(Debug, Serialize)]
struct ShapeMesh {
    /// 0 for the base, else the number of the joint, from 1.
    frame: usize,
    /// x, y, z of each corner in turn, 0.1 mm.
    points: Vec<i32>,
    /// The corners of each triangle in turn.
    triangles: Vec<u32>,
}

impl ArmShape {
    /// The shape of an arm with these meshes; `None` without any.
    pub fn new<const N: usize>(chain: &Chain<N>, meshes: &[LinkMesh]) -> Option<Self> {
        let joint = |joint: &arcfeed_kinematics::Joint| ShapeJoint {
            origin: pose(joint.origin()),
            axis: (*joint.axis().as_ref()).into(),
            slides: joint.kind() == JointKind::Prismatic,
        };
        let joints = chain.joints().iter().map(joint).collect();
        (!meshes.is_empty()).then(|| Self { base: pose(chain.base()), joints, meshes: coarse(meshes) })
    }
}

fn pose(pose: &Isometry3<f64>) -> [f64; 7] {
    let (place, turn) = (&pose.translation.vector, pose.rotation.coords);
    [place.x, place.y, place.z, turn.x, turn.y, turn.z, turn.w]
}

/// The meshes with corners merged that are near to each other, as few as there have to be. A mesh that would vanish in a cell keeps some
/// triangles as they are.
fn coarse(meshes: &[LinkMesh]) -> Vec<ShapeMesh> {
    let few = FEW.min(MOST_TRIANGLES / meshes.len().max(1));
    let seen = |mesh: &LinkMesh, cell| Some(merged(mesh, cell)).filter(|shape| !shape.triangles.is_empty());
    let mut cell = UNIT;
    loop {
        let all: Vec<_> = meshes.iter().map(|mesh| seen(mesh, cell).unwrap_or_else(|| picked(mesh, few))).collect();
        let count: usize = all.iter().map(|mesh| mesh.triangles.len() / 3).sum();
        // In a cell as large as the arm hardly anything is left of a mesh.
        if count <= MOST_TRIANGLES || cell > 100.0 {
            return all;
        }
        cell *= COARSER;
    }
}

/// A mesh whose corners within a cell of this size (m) are one, in their middle (Rossignac and Borrel 1993, "Multi-resolution 3D
/// approximations for rendering complex scenes"). Triangles that have become lines are left out.
fn merged(mesh: &LinkMesh, cell: f64) -> ShapeMesh {
    let mut index: HashMap<[i64; 3], u32> = HashMap::new();
    let mut sums: Vec<(Vector3<f64>, f64)> = Vec::new();
    let mut seen: HashSet<[u32; 3]> = HashSet::new();
    let mut triangles = Vec::new();
    for corners in &mesh.triangles {
        let corners = corners.map(|corner| {
            let key = corner.map(|v| (v / cell).round() as i64).into();
            let at = *index.entry(key).or_insert(sums.len() as u32);
            if at as usize == sums.len() {
                sums.push((Vector3::zeros(), 0.0));
            }
            let (sum, count) = &mut sums[at as usize];
            *sum += corner;
            *count += 1.0;
            at
        });
        let [a, b, c] = corners;
        let mut sorted = corners;
        sorted.sort_unstable();
        if a != b && b != c && c != a && seen.insert(sorted) {
            triangles.extend(corners);
        }
    }
    // Cells that triangles are left of, in the order in which these name them.
    let mut numbers = vec![None; sums.len()];
    let mut points = Vec::new();
    for corner in &mut triangles {
        let (sum, count) = &sums[*corner as usize];
        *corner = *numbers[*corner as usize].get_or_insert_with(|| {
            points.extend(units(&(sum / *count)));
            (points.len() / 3 - 1) as u32
        });
    }
    ShapeMesh { frame: mesh.frame, points, triangles }
}

/// `most` triangles of a mesh at most, evenly taken from all, with corners of their own.
fn picked(mesh: &LinkMesh, most: usize) -> ShapeMesh {
    let step = mesh.triangles.len().div_ceil(most.max(1)).max(1);
    let points: Vec<i32> = mesh.triangles.iter().step_by(step).flatten().flat_map(units).collect();
    let triangles = (0..(points.len() / 3) as u32).collect();
    ShapeMesh { frame: mesh.frame, points, triangles }
}

/// A place in the units of the page.
fn units(place: &Vector3<f64>) -> [i32; 3] {
    [place.x, place.y, place.z].map(|v| (v / UNIT).round() as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sphere of `2 n^2` triangles.
    fn sphere(n: usize) -> LinkMesh {
        let place = |i: usize, k: usize| {
            let (u, v) = (std::f64::consts::PI * i as f64 / n as f64, std::f64::consts::TAU * k as f64 / n as f64);
            Vector3::new(0.2 * u.sin() * v.cos(), 0.2 * u.sin() * v.sin(), 0.2 * u.cos())
        };
        let mut triangles = Vec::new();
        for (i, k) in (0..n).flat_map(|i| (0..n).map(move |k| (i, k))) {
            triangles.push([place(i, k), place(i + 1, k), place(i + 1, k + 1)]);
            triangles.push([place(i, k), place(i + 1, k + 1), place(i, k + 1)]);
        }
        LinkMesh { frame: 3, triangles }
    }

    #[test]
    fn a_fine_mesh_becomes_coarse_and_keeps_its_shape() {
        let fine = [sphere(300), sphere(20)];
        let coarse = coarse(&fine);
        let count: usize = coarse.iter().map(|mesh| mesh.triangles.len() / 3).sum();
        assert!((2_000..=MOST_TRIANGLES).contains(&count), "{count}");
        for mesh in &coarse {
            assert_eq!(mesh.frame, 3);
            let radii =
                mesh.points.chunks_exact(3).map(|p| UNIT * p.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>().sqrt());
            assert!(radii.into_iter().all(|r| (r - 0.2).abs() < 0.01));
            assert!(mesh.triangles.iter().all(|corner| (*corner as usize) < mesh.points.len() / 3));
        }
    }

    /// A needle is thinner than every cell that is tried, and a mesh of needles has a corner in each cell.
    #[test]
    fn corners_that_no_triangle_has_are_not_on_the_page() {
        let needle = |k: usize| {
            let foot = Vector3::new((k % 100) as f64, (k / 100) as f64, 0.0) * 1e-2;
            [foot, foot + Vector3::new(1e-6, 0.0, 0.0), foot + Vector3::new(0.0, 1e-6, 0.0)]
        };
        let mut mesh = sphere(20);
        let alone = merged(&mesh, UNIT).points.len();
        mesh.triangles.extend((0..10_000).map(needle));
        let coarse = coarse(&[mesh]);
        assert_eq!(coarse[0].points.len(), alone);
        assert!(coarse[0].triangles.iter().all(|corner| (*corner as usize) < alone / 3));
    }

    /// Beside meshes that need large cells a screw, and a wire that is thinner than a unit, are still there, and all of it is bounded.
    #[test]
    fn no_mesh_vanishes() {
        let scaled = |mesh: LinkMesh, by: Vector3<f64>| {
            let triangles = mesh.triangles.iter().map(|corners| corners.map(|corner| corner.component_mul(&by)));
            LinkMesh { frame: 7, triangles: triangles.collect() }
        };
        let screw = scaled(sphere(40), Vector3::repeat(0.005));
        let wire = scaled(sphere(60), Vector3::new(1e-4, 1e-4, 1.0));
        let coarse = coarse(&[sphere(300), screw, wire]);
        let counts: Vec<usize> = coarse.iter().map(|mesh| mesh.triangles.len() / 3).collect();
        assert!(counts.iter().all(|count| *count > 0), "{counts:?}");
        assert!(counts.iter().sum::<usize>() <= MOST_TRIANGLES, "{counts:?}");
        for mesh in &coarse {
            assert!(mesh.points.len() <= 3 * mesh.triangles.len(), "{} corners", mesh.points.len() / 3);
            assert!(mesh.triangles.iter().all(|corner| (*corner as usize) < mesh.points.len() / 3));
        }
    }

    #[test]
    fn a_coarse_mesh_is_left_as_it_is() {
        let few = coarse(&[sphere(20)]);
        // Of each square at a pole one triangle of two is a line.
        assert_eq!(few[0].triangles.len() / 3, 2 * 20 * 20 - 2 * 20);
    }
}
