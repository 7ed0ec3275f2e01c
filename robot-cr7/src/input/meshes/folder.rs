//! Where the mesh that a URDF names is looked for: below one folder, and nowhere else.

use std::fs::{self, File};
use std::io::Read;
use std::path::{Path, PathBuf};

use super::fault::MeshFault;
use crate::text::clip;

/// Greatest size of a file, bytes.
const MOST_BYTES: u64 = 1 << 26;
/// The kind of file that is read.
const STL: &str = "stl";

/// The bytes of the mesh `name` below `folder`, as a path or as `package://PACKAGE/PATH` (or `model://`) with or without the folder of the package.
/// Of a file of another kind the one with the ending `.stl` beside it is taken.
///
/// # Errors
/// [`MeshFault`]; [`MeshFault::Outside`] for a name that leads out of the folder, by its words or by a link of the file system.
pub(super) fn read(folder: &Path, name: &str) -> Result<Vec<u8>, MeshFault> {
    let file = found(folder, name)?;
    // Asked before: to open a pipe waits for somebody who writes into it.
    let about = fs::metadata(&file)?;
    if !about.is_file() {
        return Err(MeshFault::Missing { folder: folder.to_owned() });
    }
    let mut bytes = Vec::new();
    File::open(&file)?.take(MOST_BYTES + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > MOST_BYTES {
        return Err(MeshFault::Many { what: "bytes", count: about.len().max(bytes.len() as u64), most: MOST_BYTES });
    }
    Ok(bytes)
}

/// The file that is meant.
fn found(folder: &Path, name: &str) -> Result<PathBuf, MeshFault> {
    let (path, in_package) = match name.split_once("://") {
        Some(("package" | "model", path)) => (path, true),
        Some(_) => return Err(MeshFault::Outside),
        None => (name, false),
    };
    let parts: Vec<&str> = path.split('/').filter(|part| !part.is_empty() && *part != ".").collect();
    let leads_out = |part: &&str| *part == ".." || part.contains(['\\', ':', '\0']);
    if path.starts_with('/') || parts.iter().any(leads_out) {
        return Err(MeshFault::Outside);
    }
    let root = fs::canonicalize(folder).map_err(|_| MeshFault::Missing { folder: folder.to_owned() })?;
    let mut fault = MeshFault::Missing { folder: folder.to_owned() };
    for parts in [&parts[..], if in_package { parts.get(1..).unwrap_or_default() } else { &[] }] {
        let Some(last) = parts.last() else { continue };
        let place = parts.iter().fold(root.clone(), |place, part| place.join(part));
        let is_stl = place.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(STL));
        let stl = if is_stl { place.clone() } else { place.with_extension(STL) };
        match fs::canonicalize(stl) {
            Ok(file) if file.starts_with(&root) => return Ok(file),
            Ok(_) => return Err(MeshFault::Outside),
            Err(_) if !is_stl && place.is_file() => {
                let stand_in = clip(&Path::new(last).with_extension(STL).to_string_lossy(), 100);
                fault = MeshFault::Kind { stand_in };
            }
            Err(_) => {}
        }
    }
    Err(fault)
}

#[cfg(all(test, unix))]
mod tests {
    use std::process::Command;
    use std::sync::mpsc;
    use std::time::Duration;

    use super::*;

    #[test]
    fn a_pipe_with_the_name_of_a_mesh_is_refused_and_not_waited_for() {
        let folder = std::env::temp_dir().join(format!("arcfeed-pipe-{}", std::process::id()));
        fs::create_dir_all(&folder).expect("a folder");
        let pipe = folder.join("a.stl");
        let _ = fs::remove_file(&pipe);
        assert!(Command::new("mkfifo").arg(&pipe).status().expect("mkfifo").success());
        let (says, hears) = mpsc::channel();
        let within = folder.clone();
        std::thread::spawn(move || says.send(read(&within, "a.stl")));
        let read = hears.recv_timeout(Duration::from_secs(20));
        fs::remove_dir_all(&folder).expect("the folder");
        assert!(matches!(read, Ok(Err(MeshFault::Missing { .. }))), "{read:?}");
    }
}
