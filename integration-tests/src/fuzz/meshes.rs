//! Meshes of an arm: STL files, and the URDF that names them.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use arcfeed_kinematics::{ArmDescription, models};
use robot_cr7::{LinkMesh, read_meshes};

use super::readers::{text, verdict};
use super::verdict::Verdict;

/// A triangle as text.
const SOLID: &str = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1e-1 0 0\nvertex 0 0.25 0\nendloop\nendfacet\nendsolid a\n";
/// A link with a mesh, a link that hangs on it, and one that moves.
const ARM: &str = r#"<robot name="a" version="1.1"><link name="base"><visual><origin xyz="0 0 1" quat_xyzw="0 0 3 4"/>
<geometry><mesh filename="package://a/a.stl" scale="0.1 0.1 0.1"/></geometry></visual></link>
<link name="arm"><visual><origin rpy="0 1 0"/><geometry><mesh filename="a.stl"/></geometry></visual></link>
<link name="cover"><visual><geometry><mesh filename="model://a/a.dae"/></geometry></visual></link>
<joint name="swing" type="revolute"><origin xyz="0 0 1"/><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="on" type="fixed"><origin xyz="0 1 0" rpy="1 0 0"/><parent link="arm"/><child link="cover"/></joint></robot>"#;

/// A folder that goes with its files, after a panic, too.
struct Folder(PathBuf);

impl Folder {
    fn new() -> Option<Self> {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let name = format!("arcfeed-meshes-{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let folder = std::env::temp_dir().join(name);
        fs::create_dir(&folder).ok().map(|()| Self(folder))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // What cannot be removed stays among temporary files.
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Texts of one and of two solids, and a binary file of each kind of head.
pub(super) fn stl_files() -> Vec<Vec<u8>> {
    let binary = |head: &[u8]| {
        let mut bytes = head.to_vec();
        bytes.resize(80, b' ');
        bytes.extend(2u32.to_le_bytes());
        for triangle in 0..2 {
            bytes.extend([0; 12]);
            bytes.extend((0..9).flat_map(|k| (0.1 * (k * k + triangle) as f32).to_le_bytes()));
            bytes.extend([0; 2]);
        }
        bytes
    };
    vec![SOLID.as_bytes().to_vec(), SOLID.repeat(2).into_bytes(), binary(b"made by"), binary(b"solid a")]
}

/// An arm whose links have meshes.
pub(super) fn urdf_files() -> Vec<Vec<u8>> {
    let visual = "<visual><geometry><mesh filename=\"a.stl\"/></geometry></visual></link>";
    let built_in = models::description("ur5e").map(|arm| arm.to_urdf().replace("</link>", visual).into_bytes());
    built_in.into_iter().chain([ARM.as_bytes().to_vec()]).collect()
}

/// A mesh of an arm that is whole.
pub(super) fn stl(bytes: &[u8]) -> Verdict {
    read(ARM, bytes)
}

/// An arm whose mesh is whole. It is read before its meshes are, as the command does.
pub(super) fn urdf(bytes: &[u8]) -> Verdict {
    text(bytes).map_or(Verdict::Refused, |text| read(text, SOLID.as_bytes()))
}

fn read(urdf: &str, stl: &[u8]) -> Verdict {
    let Ok(arm) = ArmDescription::from_urdf(urdf, None, None) else { return Verdict::Refused };
    let Some(folder) = Folder::new() else { return Verdict::Broken("no folder of its own".to_owned()) };
    let file = folder.0.join("arm.urdf");
    if fs::write(&file, urdf).is_err() || fs::write(folder.0.join("a.stl"), stl).is_err() {
        return Verdict::Broken("no file of its own".to_owned());
    }
    verdict(read_meshes(Path::new(&file), &folder.0, None, &arm), |meshes| {
        let near = |mesh: &LinkMesh| mesh.triangles.iter().flatten().all(|corner| corner.amax() <= 10.0);
        let whole = |mesh: &LinkMesh| !mesh.triangles.is_empty() && mesh.frame <= arm.joints.len() && near(mesh);
        (!meshes.iter().all(whole)).then(|| "a mesh that is empty, far away or of no joint".to_owned())
    })
}
