//! The meshes that a URDF names for the links of an arm.

use std::collections::HashMap;

use arcfeed_kinematics::{KinematicsError, urdf_origin};
use nalgebra::{Isometry3, Vector3};
use roxmltree::{Document, Node};

use super::fault::MeshFault;
use crate::text::clip;

/// Characters of a text of the file that an error shows.
const SHOWN: usize = 100;

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

/// Where links are, each found once.
struct Places<'a> {
    base: Option<&'a str>,
    /// The number of the joint that carries a link, from 1.
    carried: HashMap<&'a str, usize>,
    hung: HashMap<&'a str, Hung<'a>>,
    /// Of links that were asked for and of those between them and the arm; `None` for one that is no part of it.
    known: HashMap<&'a str, Option<(usize, Isometry3<f64>)>>,
}

/// The first meshes, `most` at most, of an arm from the link `base` (the root where it is none) on, whose moving joints carry the links
/// `carried`. What hangs on them by other joints is drawn as these joints are at 0. It takes time in proportion to the text.
///
/// # Errors
/// [`MeshFault::Origin`], [`MeshFault::Scale`], [`MeshFault::Markup`].
pub(super) fn visuals(text: &str, base: Option<&str>, carried: &[&str], most: usize) -> Result<Vec<Visual>, MeshFault> {
    let document = Document::parse(text)?;
    let robot = document.root_element();
    let version = robot.attribute("version");
    let mut hung = HashMap::new();
    for joint in children(robot, "joint") {
        let link = |end| children(joint, end).find_map(|node| node.attribute("link"));
        if let (Some(parent), Some(child)) = (link("parent"), link("child")) {
            hung.insert(child, Hung { parent, origin: origin(joint, child, version)? });
        }
    }
    let carried = carried.iter().enumerate().map(|(index, link)| (*link, index + 1)).collect();
    let mut places = Places { base, carried, hung, known: HashMap::new() };
    let mut all = Vec::new();
    for link in children(robot, "link") {
        let name = link.attribute("name").unwrap_or_default();
        for visual in children(link, "visual") {
            let meshes = children(visual, "geometry").flat_map(|geometry| children(geometry, "mesh"));
            for (mesh, file) in meshes.filter_map(|mesh| Some((mesh, mesh.attribute("filename")?))) {
                let Some((frame, place)) = places.of(name) else { continue };
                if all.len() == most {
                    return Ok(all);
                }
                let pose = place * origin(visual, name, version)?;
                let scale = scale(mesh, name)?;
                all.push(Visual { name: file.to_owned(), frame, pose, scale });
            }
        }
    }
    Ok(all)
}

fn children<'a, 'd: 'a>(node: Node<'a, 'd>, name: &'static str) -> impl Iterator<Item = Node<'a, 'd>> {
    node.children().filter(move |child| child.has_tag_name(name))
}

impl<'a> Places<'a> {
    /// What a link moves with, and its frame in that one; `None` where it is no part of the arm.
    fn of(&mut self, link: &'a str) -> Option<(usize, Isometry3<f64>)> {
        let mut way = Vec::new();
        let mut at = link;
        let mut place = loop {
            if let Some(known) = self.known.get(at) {
                break *known;
            }
            // Links that hang on each other in a circle come back to one that has no place.
            self.known.insert(at, None);
            if let Some(joint) = self.carried.get(at) {
                break Some((*joint, Isometry3::identity()));
            }
            match self.hung.get(at) {
                _ if self.base == Some(at) => break Some((0, Isometry3::identity())),
                None => break self.base.is_none().then_some((0, Isometry3::identity())),
                Some(Hung { parent, origin }) => {
                    way.push((at, *origin));
                    at = *parent;
                }
            }
        };
        self.known.insert(at, place);
        for (link, origin) in way.into_iter().rev() {
            place = place.map(|(frame, pose)| (frame, pose * origin));
            self.known.insert(link, place);
        }
        place
    }
}

/// `<origin>` of an element that belongs to a link, as joints have it.
fn origin(of: Node<'_, '_>, link: &str, version: Option<&str>) -> Result<Isometry3<f64>, MeshFault> {
    let Some(node) = children(of, "origin").next() else { return Ok(Isometry3::identity()) };
    let fault = |error: KinematicsError| MeshFault::Origin { link: clip(link, SHOWN), error: Box::new(error) };
    urdf_origin(version, |name| node.attribute(name)).map_err(fault)
}

/// By what the coordinates of a mesh are multiplied.
fn scale(mesh: Node<'_, '_>, link: &str) -> Result<Vector3<f64>, MeshFault> {
    let Some(value) = mesh.attribute("scale") else { return Ok(Vector3::repeat(1.0)) };
    let numbers = value.split_whitespace().map(|v| v.parse().ok().filter(|v: &f64| v.is_finite()));
    let numbers = numbers.collect::<Option<Vec<f64>>>().and_then(|numbers| <[f64; 3]>::try_from(numbers).ok());
    let fault = || MeshFault::Scale { link: clip(link, SHOWN), value: clip(value, SHOWN) };
    numbers.map(Vector3::from).ok_or_else(fault)
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
        let found = visuals(ARM, Some("base"), &["one"], 100).expect("a URDF");
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
        let found = visuals(ARM, None, &["one"], 100).expect("a URDF");
        assert_eq!((found.len(), found[1].frame, at(&found[1]).z), (5, 0, 5.0));
    }

    #[test]
    fn numbers_that_are_none_are_named() {
        for (from, to, words) in [
            ("0.001 0.001 0.002", "0.001 0.001", "link \"base\": scale of its <mesh> is \"0.001 0.001\""),
            ("<origin xyz=\"0 0 1\"/>", "<origin xyz=\"0 0 nan\"/>", "link \"cover\": the origin"),
            ("<origin xyz=\"0 0 1\"/>", "<origin xyz=\"0 0 a\"/>", "link \"cover\": not a valid URDF"),
            ("</robot>", "", "root"),
        ] {
            let said = visuals(&ARM.replace(from, to), None, &["one"], 100).expect_err("no numbers").to_string();
            assert!(said.contains(words), "{said}");
        }
    }

    /// A quaternion counts where it does for joints: from version 1.1 on, alone, and not of length 0.
    #[test]
    fn an_origin_is_read_as_those_of_joints() {
        let read = |version: &str, origin: &str| {
            let text = ARM.replace("name=\"two\"", &format!("name=\"two\" version=\"{version}\""));
            visuals(&text.replace("<origin xyz=\"0 0 1\"/>", &format!("<origin {origin}/>")), None, &["one"], 100)
        };
        let angle = |version: &str| read(version, "quat_xyzw=\"0 0 3 4\"").map(|all| all[2].pose.rotation.angle());
        assert_eq!(angle("1.0").expect("not read"), 0.0);
        assert!((angle("1.1").expect("read") - 2.0 * 0.6f64.asin()).abs() < 1e-12);
        for (origin, words) in
            [("rpy=\"0 0 1\" quat_xyzw=\"0 0 3 4\"", "leave one"), ("quat_xyzw=\"0 0 0 0\"", "must not be 0")]
        {
            let said = read("1.1", origin).expect_err("no origin").to_string();
            assert!(said.contains("link \"cover\"") && said.contains(words), "{said}");
        }
    }

    #[test]
    fn links_in_a_circle_are_no_part_of_an_arm() {
        let circle = "<joint name=\"a\"><parent link=\"cover\"/><child link=\"floor\"/></joint>\
                      <joint name=\"b\"><parent link=\"floor\"/><child link=\"cover\"/></joint></robot>";
        let found = visuals(&ARM.replace("</robot>", circle), None, &["one"], 100).expect("a URDF");
        assert_eq!(found.iter().map(|visual| visual.frame).collect::<Vec<_>>(), [1, 1]);
    }

    /// A chain of links which all have meshes, 20 000 of them: each link is looked at once, and no more meshes are made than are taken.
    #[test]
    fn a_long_chain_takes_time_in_proportion_to_it() {
        const LINKS: usize = 20_000;
        let mesh = "<visual><geometry><mesh filename=\"a.stl\"/></geometry></visual>";
        let links: String = (0..LINKS).map(|k| format!("<link name=\"l{k}\">{mesh}</link>")).collect();
        let joint =
            |k| format!("<joint><parent link=\"l{k}\"/><child link=\"l{}\"/><origin xyz=\"1 0 0\"/></joint>", k + 1);
        // Apart from the arm, on it, and from the last link to the first.
        let joints: String = (0..LINKS - 1).rev().map(joint).collect();
        let text = format!("<robot>{links}{joints}</robot>");
        let begin = std::time::Instant::now();
        assert_eq!(visuals(&text, Some("other"), &["own"], 101).expect("a URDF"), []);
        let found = visuals(&text, Some("l0"), &["own"], LINKS).expect("a URDF");
        assert_eq!((found.len(), found[LINKS - 1].pose.translation.x), (LINKS, (LINKS - 1) as f64));
        assert_eq!(visuals(&text, Some("l0"), &["own"], 101).expect("a URDF").len(), 101);
        // 0.1 s in a release build; climbing from each link takes 200 million steps, twice.
        assert!(begin.elapsed().as_secs_f64() < 5.0, "{:?}", begin.elapsed());
    }
}
