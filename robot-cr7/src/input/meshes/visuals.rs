//! The meshes that a URDF names for the links of an arm.

use std::collections::HashMap;

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use roxmltree::{Document, Node};

use super::fault::MeshFault;

/// A mesh of a link.
#[derive(Debug, PartialEq)]
pub(super) struct Visual {
    /// The name of the file, as it stands in the URDF.
    pub name: String,
    /// What it moves with: 0 for the base, else the number of the joint, from 1.
    pub frame: usize,
    /// Its frame in that one.
    pub pose: Isometry3<f64>,
    /// By what its coordinates are multiplied.
    pub scale: Vector3<f64>,
}

/// How a link hangs on another one.
struct Hung<'a> {
    parent: &'a str,
    origin: Isometry3<f64>,
}

/// The meshes of an arm from the link `base` (the root where it is none) on, whose moving joints carry the links `carried`. What hangs
/// on them by other joints is drawn as these joints are at 0.
///
/// # Errors
/// [`MeshFault::Visual`], [`MeshFault::Markup`].
pub(super) fn visuals(text: &str, base: Option<&str>, carried: &[&str]) -> Result<Vec<Visual>, MeshFault> {
    let document = Document::parse(text)?;
    let robot = document.root_element();
    let mut hung = HashMap::new();
    for joint in children(robot, "joint") {
        let link = |end| children(joint, end).find_map(|node| node.attribute("link"));
        if let (Some(parent), Some(child)) = (link("parent"), link("child")) {
            hung.insert(child, Hung { parent, origin: origin(joint, child)? });
        }
    }
    let mut all = Vec::new();
    for link in children(robot, "link") {
        let name = link.attribute("name").unwrap_or_default();
        for visual in children(link, "visual") {
            let meshes = children(visual, "geometry").flat_map(|geometry| children(geometry, "mesh"));
            for (mesh, file) in meshes.filter_map(|mesh| Some((mesh, mesh.attribute("filename")?))) {
                let Some((frame, place)) = placed(name, base, carried, &hung) else { continue };
                let pose = place * origin(visual, name)?;
                let scale = triple(mesh, "scale", name)?.map_or(Vector3::repeat(1.0), Vector3::from);
                all.push(Visual { name: file.to_owned(), frame, pose, scale });
            }
        }
    }
    Ok(all)
}

fn children<'a, 'd: 'a>(node: Node<'a, 'd>, name: &'static str) -> impl Iterator<Item = Node<'a, 'd>> {
    node.children().filter(move |child| child.has_tag_name(name))
}

/// What a link moves with, and its frame in that one; `None` where it is no part of the arm.
fn placed(
    link: &str,
    base: Option<&str>,
    carried: &[&str],
    hung: &HashMap<&str, Hung<'_>>,
) -> Option<(usize, Isometry3<f64>)> {
    let (mut link, mut pose) = (link, Isometry3::identity());
    // A tree has no way that is longer.
    for _ in 0..=hung.len() {
        if let Some(joint) = carried.iter().position(|carried| *carried == link) {
            return Some((joint + 1, pose));
        }
        match hung.get(link) {
            _ if base == Some(link) => return Some((0, pose)),
            None => return base.is_none().then_some((0, pose)),
            Some(Hung { parent, origin }) => (link, pose) = (parent, origin * pose),
        }
    }
    None
}

/// `<origin>` of an element that belongs to a link.
fn origin(of: Node<'_, '_>, link: &str) -> Result<Isometry3<f64>, MeshFault> {
    let Some(node) = children(of, "origin").next() else { return Ok(Isometry3::identity()) };
    let place = triple(node, "xyz", link)?.unwrap_or_default();
    let [roll, pitch, yaw] = triple(node, "rpy", link)?.unwrap_or_default();
    let turn = match numbers::<4>(node, "quat_xyzw", link)? {
        Some([x, y, z, w]) => UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-9).unwrap_or_default(),
        None => UnitQuaternion::from_euler_angles(roll, pitch, yaw),
    };
    Ok(Isometry3::from_parts(Translation3::from(place), turn))
}

fn triple(node: Node<'_, '_>, what: &'static str, link: &str) -> Result<Option<[f64; 3]>, MeshFault> {
    numbers(node, what, link)
}

/// Finite numbers of an attribute, where there is one.
fn numbers<const N: usize>(node: Node<'_, '_>, what: &'static str, link: &str) -> Result<Option<[f64; N]>, MeshFault> {
    let Some(value) = node.attribute(what) else { return Ok(None) };
    let all: Option<Vec<f64>> =
        value.split_whitespace().map(|v| v.parse().ok().filter(|v: &f64| v.is_finite())).collect();
    let wrong = || MeshFault::Visual { link: link.to_owned(), what, value: value.chars().take(100).collect() };
    all.and_then(|all| all.try_into().ok()).map(Some).ok_or_else(wrong)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ARM: &str = r#"<robot name="two">
      <link name="floor"><visual><geometry><mesh filename="floor.stl"/></geometry></visual></link>
      <link name="base"><visual><geometry><mesh filename="base.stl" scale="0.001 0.001 0.002"/></geometry></visual>
        <visual><geometry><box size="1 1 1"/></geometry></visual></link>
      <link name="cover"><visual><origin xyz="0 0 1"/><geometry><mesh filename="cover.stl"/></geometry></visual></link>
      <link name="one"><visual><origin rpy="0 0 1.5707963267948966"/><geometry><mesh filename="one.stl"/></geometry></visual></link>
      <link name="tool"><visual><geometry><mesh filename="tool.stl"/></geometry></visual></link>
      <joint name="on" type="fixed"><parent link="floor"/><child link="base"/><origin xyz="0 0 5"/></joint>
      <joint name="fix" type="fixed"><parent link="base"/><child link="cover"/><origin xyz="2 0 0"/></joint>
      <joint name="j" type="revolute"><parent link="base"/><child link="one"/><origin xyz="0 0 3"/></joint>
      <joint name="grip" type="prismatic"><parent link="one"/><child link="tool"/><origin xyz="0 4 0"/></joint>
    </robot>"#;

    #[test]
    fn each_mesh_stands_where_its_link_does() {
        let found = visuals(ARM, Some("base"), &["one"]).expect("a URDF");
        let at = |visual: &Visual| visual.pose.translation.vector;
        let names: Vec<_> = found.iter().map(|v| (v.name.as_str(), v.frame, at(v))).collect();
        let place = Vector3::new;
        assert_eq!(
            names,
            [
                ("base.stl", 0, place(0.0, 0.0, 0.0)),
                ("cover.stl", 0, place(2.0, 0.0, 1.0)),
                ("one.stl", 1, place(0.0, 0.0, 0.0)),
                ("tool.stl", 1, place(0.0, 4.0, 0.0)),
            ]
        );
        assert_eq!(found[0].scale, place(1e-3, 1e-3, 2e-3));
        let turned = found[2].pose * nalgebra::Point3::new(1.0, 0.0, 0.0);
        assert!((turned.coords - place(0.0, 1.0, 0.0)).norm() < 1e-12);
        // From the root on the floor is a part of it.
        let found = visuals(ARM, None, &["one"]).expect("a URDF");
        assert_eq!((found.len(), found[1].frame, at(&found[1]).z), (5, 0, 5.0));
    }

    #[test]
    fn numbers_that_are_none_are_named() {
        for (from, to, words) in [
            ("0.001 0.001 0.002", "0.001 0.001", "link \"base\": scale of its <visual> is \"0.001 0.001\""),
            ("<origin xyz=\"0 0 1\"/>", "<origin xyz=\"0 0 nan\"/>", "link \"cover\": xyz"),
            ("</robot>", "", "root"),
        ] {
            let said = visuals(&ARM.replace(from, to), None, &["one"]).expect_err("no numbers").to_string();
            assert!(said.contains(words), "{said}");
        }
    }
}
