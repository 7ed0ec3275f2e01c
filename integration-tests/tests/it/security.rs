//! What `SECURITY.md` promises.

use std::fs;
use std::path::{Path, PathBuf};

use arcfeed_kinematics::ArmDescription;
use robot_cr7::{PathFile, PathGeometry};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Every source file of the repository, by its path from the root.
fn sources() -> Vec<(String, String)> {
    let root = root();
    let mut open = vec![root.clone()];
    let mut found = Vec::new();
    while let Some(folder) = open.pop() {
        for path in fs::read_dir(&folder).expect("a folder").flatten().map(|entry| entry.path()) {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            if path.is_dir() && name != "target" && !name.starts_with('.') {
                open.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let shown = path.strip_prefix(&root).unwrap_or(&path).to_string_lossy().replace('\\', "/");
                found.push((shown, fs::read_to_string(&path).expect("a source")));
            }
        }
    }
    found
}

/// Lines that hold `word` on its own, without comments.
fn lines_with<'t>(text: &'t str, word: &str) -> Vec<&'t str> {
    let holds = |line: &str| {
        let code = line.split("//").next().unwrap_or_default();
        code.split(|c: char| !c.is_alphanumeric() && c != '_').any(|part| part == word)
    };
    text.lines().filter(|line| holds(line)).collect()
}

#[test]
fn unsafe_code_is_nowhere_but_at_the_borders() {
    // The C interface, the Python module, and programs that only tests run: an allocator that counts, a machine without operating system.
    const BORDERS: [&str; 4] =
        ["robot-cr7/c/", "robot-cr7/python/", "integration-tests/testing/src/counting.rs", "integration-tests/bare/"];
    let sources = sources();
    assert!(sources.len() > 500, "{} files", sources.len());
    for (file, text) in &sources {
        let border = BORDERS.iter().any(|border| file.starts_with(border));
        let this = file.ends_with("tests/it/security.rs");
        let found = lines_with(text, "unsafe");
        assert!(border || this || found.is_empty(), "{file}: {found:?}");
    }
    for library in ["geometry", "feedrate", "kinematics", "sync", "interp", "robot-cr7"] {
        let text = fs::read_to_string(root().join(library).join("src/lib.rs")).expect("a library");
        assert!(text.contains("#![forbid(unsafe_code)]"), "{library}");
    }
}

#[test]
fn the_network_is_behind_a_feature_that_is_off() {
    // `cr7 send`, and the simulated controller that tests hold it against.
    const NETWORK: [&str; 4] =
        ["robot-cr7/src/controller/", "robot-cr7/src/cli/send", "robot-cr7/tests/", "integration-tests/"];
    for (file, text) in sources() {
        let found: Vec<&str> =
            ["TcpStream", "TcpListener", "UdpSocket"].iter().flat_map(|word| lines_with(&text, word)).collect();
        let module = |line: &&str| line.contains("std::") || line.contains("net::") || line.contains("use ");
        let quiet = found.is_empty() && !lines_with(&text, "net").iter().any(module);
        assert!(quiet || NETWORK.iter().any(|of| file.starts_with(of)), "{file}: {found:?}");
    }
    let manifest = fs::read_to_string(root().join("robot-cr7/Cargo.toml")).expect("a manifest");
    let default = manifest.lines().find(|line| line.starts_with("default =")).expect("default features");
    assert!(!default.contains("controller"), "{default}");
    let library = fs::read_to_string(root().join("robot-cr7/src/lib.rs")).expect("a library");
    assert!(library.contains("#[cfg(feature = \"controller\")]\npub mod controller;"), "the module has its feature");
}

/// The clock of the system can be set, and then it jumps. Time is measured by the clock that only goes on.
#[test]
fn no_source_reads_the_clock_of_the_system() {
    for (file, text) in sources().iter().filter(|(file, _)| !file.ends_with("tests/it/security.rs")) {
        let found: Vec<&str> = ["SystemTime", "UNIX_EPOCH"].iter().flat_map(|word| lines_with(text, word)).collect();
        assert!(found.is_empty(), "{file}: {found:?}");
    }
}

const ARM: &str = r#"<link name="base"/><link name="arm"><visual><geometry>MESH</geometry></visual></link>
<joint name="swing" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>"#;

#[test]
fn nothing_that_a_robot_file_names_is_opened() {
    // Only libraries that open no file read robots.
    for (file, text) in sources() {
        let library = ["geometry/src/", "feedrate/src/", "kinematics/src/", "sync/src/", "interp/src/"];
        if library.iter().any(|library| file.starts_with(library)) {
            // By whatever words they are brought in: `std::fs`, `std::{fs, io}`, `std as s`.
            let found: Vec<&str> = ["fs", "OpenOptions"].iter().flat_map(|word| lines_with(&text, word)).collect();
            assert!(
                found.is_empty() && lines_with(&text, "std").iter().all(|line| !line.contains("std as")),
                "{file}: {found:?}"
            );
        }
    }
    let read = |text: String| ArmDescription::from_urdf(&text, None, None);
    let plain = read(format!("<robot name=\"a\">{ARM}</robot>")).expect("an arm");
    for mesh in ["package://none/a.stl", "file:///etc/passwd", "/etc/passwd", "../../a.dae", "http://127.0.0.1:9/a.stl"]
    {
        let text = ARM.replace("MESH", &format!("<mesh filename=\"{mesh}\"/>"));
        assert_eq!(read(format!("<robot name=\"a\">{text}</robot>")).expect("an arm"), plain, "{mesh}");
    }
    let include = "<xi:include href=\"file:///etc/passwd\" xmlns:xi=\"http://www.w3.org/2001/XInclude\"/>";
    assert_eq!(read(format!("<robot name=\"a\">{include}{ARM}</robot>")).expect("an arm"), plain);
    // An entity stands for nothing, from wherever it is to come.
    for entity in ["SYSTEM \"file:///etc/passwd\"", "\"base\"", "SYSTEM \"http://127.0.0.1:9/\""] {
        let text = format!("<!DOCTYPE robot [<!ENTITY x {entity}>]><robot name=\"a\">{ARM}</robot>");
        let error = read(text.replace("link name=\"base\"", "link name=\"&x;\"")).expect_err("an entity").to_string();
        assert!(error.contains("'x'") || error.contains("x;") || error.contains("entity"), "{error}");
        assert!(!error.contains("root:"), "{error}");
    }
}

/// Files of the command's crate that open files at all. Another one is added here when it is clear that no name in an input reaches it.
const OPENERS: [&str; 13] = [
    "robot-cr7/src/cli/batch.rs",
    "robot-cr7/src/cli/joint_space.rs",
    "robot-cr7/src/cli/plan_files.rs",
    "robot-cr7/src/cli/ros.rs",
    "robot-cr7/src/cli/verify.rs",
    "robot-cr7/src/input/drawing/reader.rs",
    "robot-cr7/src/input/error.rs",
    "robot-cr7/src/input/gcode/reader.rs",
    MESHES,
    "robot-cr7/src/output/folder_lock.rs",
    "robot-cr7/src/output/staging.rs",
    "robot-cr7/src/output/whole_file.rs",
    "robot-cr7/src/run/batch.rs",
];
/// The one place where a mesh is opened.
const MESHES: &str = "robot-cr7/src/input/meshes/folder.rs";

#[test]
fn a_mesh_is_opened_in_one_place_alone() {
    let own: Vec<_> = sources().into_iter().filter(|(file, _)| file.starts_with("robot-cr7/src/")).collect();
    for (file, text) in &own {
        let found: Vec<&str> = ["fs", "OpenOptions"].iter().flat_map(|word| lines_with(text, word)).collect();
        assert_eq!(OPENERS.contains(&file.as_str()), !found.is_empty(), "{file}: {found:?}");
        // Names of meshes are read in one place, and go to no other opener.
        let names = text.contains("\"filename\"") || file != MESHES && text.contains("folder::read(");
        let meshes = file.starts_with("robot-cr7/src/input/meshes/");
        assert!(meshes || !names, "{file}");
    }
    let calls = own.iter().map(|(_, text)| text.matches("folder::read(").count()).sum::<usize>();
    let module = own.iter().find(|(file, _)| file.ends_with("input/meshes/mod.rs")).map(|(_, text)| text.as_str());
    assert!(calls == 1 && module.is_some_and(|text| text.contains("\nmod folder;\n")), "{calls} calls");
}

#[test]
fn nothing_that_a_drawing_names_is_opened() {
    let line = "<path d=\"M0 0 L10 10\"/>";
    let svg = |head: &str, inside: &str| {
        let text = format!(
            "{head}<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" width=\"40mm\" height=\"20mm\" viewBox=\"0 0 40 20\">{inside}</svg>"
        );
        PathFile::from_bytes(text.as_bytes(), Path::new("a.svg"), None)
    };
    let moves = |file: PathFile| match file.geometry {
        PathGeometry::Program(program) => program.moves,
        other => panic!("{other:?}"),
    };
    let plain = moves(svg("", line).expect("a drawing"));
    for foreign in ["<image xlink:href=\"file:///etc/passwd\"/>", "<use xlink:href=\"other.svg#a\"/>"] {
        match svg("", &format!("{foreign}{line}")) {
            Ok(file) => assert_eq!(moves(file), plain, "{foreign}"),
            Err(error) => assert!(!error.to_string().contains("root:"), "{error}"),
        }
    }
    let entity = "<!DOCTYPE svg [<!ENTITY x SYSTEM \"file:///etc/passwd\">]>";
    let error = svg(entity, &format!("<desc>&x;</desc>{line}")).expect_err("an entity").to_string();
    assert!(error.contains("a.svg") && !error.contains("root:"), "{error}");
}
