//! `cr7 plan --format html`: the page's data are those of the trajectory beside it, and it needs nothing else.
#![cfg(all(feature = "cli", feature = "html"))]

use crate::common;

use common::Desk;
use nalgebra::{Isometry3, Quaternion, Translation3, Unit, UnitQuaternion, Vector3};
use robot_cr7::{SamplePath, TrajectoryRow};
use serde_json::Value;

/// The page and the data in it.
fn page(desk: &Desk, args: &[&str]) -> (String, Value) {
    desk.run(args).done();
    let page = std::fs::read_to_string(desk.folder.join("out/report.html")).expect("a page");
    let mark = "<script id=\"data\" type=\"application/json\">";
    let (_, rest) = page.split_once(mark).expect("data");
    let (data, _) = rest.split_once("</script>").expect("their end");
    let data = serde_json::from_str(data).expect("JSON");
    (page, data)
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|v| v.as_f64().expect("a number")).collect()
}

#[test]
fn the_page_shows_the_trajectory_beside_it() {
    let desk = Desk::new("page");
    desk.write("six.json", SamplePath::SixPoint.json());
    desk.write("job.toml", "[torque]\nlimited = true\n");
    for robot in ["ur5e", "panda"] {
        let mut args = vec!["plan", "six.json", "--robot", robot, "--format", "html"];
        if robot == "ur5e" {
            args.extend(["--job", "job.toml"]);
        }
        let (page, data) = page(&desk, &args);
        match robot {
            "panda" => agrees::<7>(&desk, &data, 4),
            _ => agrees::<6>(&desk, &data, 5),
        }
        assert!(page.len() < 6_000_000, "{} bytes", page.len());
        for outside in ["src=\"http", "href=\"http", "{{"] {
            let own = page.rsplit_once("</script>\n<script id=\"data\"").expect("data").1;
            assert!(!own.contains(outside), "{outside}");
        }
    }
}

/// Tips of the tool, joints and times of the page are those of the trajectory, to the digits that the page has.
fn agrees<const N: usize>(desk: &Desk, data: &Value, quantities: usize) {
    let rows: Vec<TrajectoryRow<N>> = desk.trajectory("out");
    let duration = rows.last().expect("rows").t;
    let at = |t: f64| rows.iter().min_by(|a, b| (a.t - t).abs().total_cmp(&(b.t - t).abs())).expect("rows");
    let poses = data["poses"].as_array().expect("poses");
    assert!((2..=801).contains(&poses.len()), "{}", poses.len());
    for pose in poses {
        let (row, points) = (at(pose["t"].as_f64().expect("t")), numbers(&pose["points"]));
        let tip = &points[points.len() - 3..];
        for (shown, real) in tip.iter().zip(row.position) {
            assert!((shown - real).abs() < 1e-5, "{tip:?} {row:?}");
        }
        // Base and joints, at least one of them apart from each other.
        assert!(points.len() >= 3 * 4 && points.len() % 3 == 0);
    }
    assert_eq!(poses.last().map(|pose| pose["t"].as_f64().map(|t| (t - duration).abs() < 1e-5)), Some(Some(true)));
    let t = numbers(&data["t"]);
    assert!(t.is_sorted() && t[0] == 0.0 && (t[t.len() - 1] - duration).abs() < 1e-5 && t.len() <= 3002);
    let shown = data["quantities"].as_array().expect("quantities");
    assert_eq!(shown.len(), quantities);
    // The greatest velocity of each joint is on the page, however few samples it keeps.
    let velocities = shown[0]["values"].as_array().expect("velocities");
    assert_eq!(velocities.len(), N);
    for (k, values) in velocities.iter().map(numbers).enumerate() {
        let most = |values: &[f64]| values.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        let own = most(&rows.iter().map(|row| row.qd[k].to_degrees()).collect::<Vec<_>>());
        let on_page = most(&values);
        assert!((own - on_page).abs() <= 1e-5 * own.max(1e-6), "{k}: {own} {on_page}");
        assert_eq!(values.len(), t.len());
    }
    assert!(!data["ceiling"].as_array().expect("ceiling").is_empty());
    assert!(data["report"]["limits"].as_array().is_some_and(|limits| limits.len() > N));
}

#[test]
fn a_name_cannot_break_out_of_the_page() {
    let desk = Desk::new("page_name");
    let hostile = "</script><script>alert(1)</script> {{data}} & <b>";
    let path = SamplePath::SixPoint.json();
    let mut path: Value = serde_json::from_str(path).expect("JSON");
    path["name"] = hostile.into();
    desk.write("six.json", &path.to_string());
    let (page, data) = page(&desk, &["plan", "six.json", "--format", "html"]);
    assert_eq!(data["report"]["name"], hostile);
    assert!(!page.contains("<script>alert"));
    assert_eq!(page.matches("</script>").count(), 3);
}

/// A box from 0 to `size` (mm), as a binary STL file.
fn box_stl(size: [f32; 3]) -> Vec<u8> {
    let corner = |bits: usize| [0, 1, 2].map(|k| if bits >> k & 1 == 1 { size[k] } else { 0.0 });
    let faces = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
    let triangles: Vec<_> = faces.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    let mut bytes = vec![b' '; 80];
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for corners in triangles {
        bytes.extend([0; 12]);
        bytes.extend(corners.iter().flat_map(|bits| corner(*bits)).flat_map(f32::to_le_bytes));
        bytes.extend([0; 2]);
    }
    bytes
}

/// A UR5e as a URDF whose links have the mesh `name` in mm.
fn with_meshes(desk: &Desk, name: &str) {
    let urdf = desk.run(&["robots", "--urdf", "ur5e"]).done().stdout;
    // Links that are empty end in "/>".
    let with_visual = |line: &str| match line.trim_start().starts_with("<link") && !line.ends_with("/>") {
        true => format!("{line}{}\n", visual(name)),
        false => format!("{line}\n"),
    };
    let urdf: String = urdf.lines().map(with_visual).collect();
    assert_eq!(urdf.matches("<visual>").count(), 6, "{urdf}");
    desk.write("arm.urdf", &urdf);
}

fn visual(name: &str) -> String {
    format!(
        "<visual><origin xyz=\"0 0 0.01\"/><geometry><mesh filename=\"{name}\" scale=\"0.001 0.001 0.001\"/></geometry></visual>"
    )
}

const MESH_PLAN: [&str; 8] = ["plan", "six.json", "--robot", "arm.urdf", "--format", "html", "--meshes", "meshes"];

#[test]
fn the_meshes_of_a_urdf_stand_at_its_joints() {
    let desk = Desk::new("page_meshes");
    desk.write("six.json", SamplePath::SixPoint.json());
    with_meshes(&desk, "package://ur/visual/box.dae");
    // The folder of the package is not part of the name, and STL stands in for what is not read.
    std::fs::create_dir_all(desk.folder.join("meshes/visual")).expect("a folder");
    desk.write("meshes/visual/box.dae", "<COLLADA/>");
    std::fs::write(desk.folder.join("meshes/visual/box.stl"), box_stl([100.0, 50.0, 20.0])).expect("a mesh");
    // The names of a package in Gazebo's way are the same.
    with_meshes(&desk, "model://ur/visual/box.dae");
    let (_, data) = page(&desk, &MESH_PLAN);
    assert_eq!(data["shape"]["meshes"].as_array().map(Vec::len), Some(6));
    with_meshes(&desk, "package://ur/visual/box.dae");
    let (page, data) = page(&desk, &MESH_PLAN);
    assert!(page.len() < 6_000_000, "{} bytes", page.len());
    let shape = &data["shape"];
    let meshes = shape["meshes"].as_array().expect("meshes");
    assert_eq!(
        meshes.iter().map(|mesh| mesh["frame"].as_u64().expect("a frame")).collect::<Vec<_>>(),
        [1, 2, 3, 4, 5, 6]
    );
    for mesh in meshes {
        let (points, triangles) = (numbers(&mesh["points"]), numbers(&mesh["triangles"]));
        assert_eq!((points.len(), triangles.len()), (8 * 3, 12 * 3));
        // In 0.1 mm, with the origin of the visual.
        let most = |axis: usize| points.iter().skip(axis).step_by(3).fold(f64::MIN, |most, v| most.max(*v));
        assert_eq!([most(0), most(1), most(2)], [1000.0, 500.0, 300.0]);
    }
    // The chain of the page leads to the joints of its poses.
    let pose = |value: &Value| {
        let v = numbers(value);
        let turn = UnitQuaternion::from_quaternion(Quaternion::new(v[6], v[3], v[4], v[5]));
        Isometry3::from_parts(Translation3::new(v[0], v[1], v[2]), turn)
    };
    for shown in data["poses"].as_array().expect("poses") {
        let (points, joints) = (numbers(&shown["points"]), numbers(&shown["joints"]));
        let mut at = pose(&shape["base"]);
        for (joint, value) in shape["joints"].as_array().expect("joints").iter().zip(&joints) {
            let axis = Vector3::from_vec(numbers(&joint["axis"]));
            at = at * pose(&joint["origin"]) * UnitQuaternion::from_axis_angle(&Unit::new_normalize(axis), *value);
            let near = points.chunks_exact(3).map(|p| (at.translation.vector - Vector3::new(p[0], p[1], p[2])).norm());
            assert!(near.fold(f64::MAX, f64::min) < 2e-5, "{at} {points:?}");
        }
        assert_eq!((joints.len(), shape["joints"][0]["slides"].as_bool()), (6, Some(false)));
    }
}

#[test]
fn meshes_that_are_not_read_are_refused_with_the_way_out() {
    let desk = Desk::new("page_bad_meshes");
    desk.write("six.json", SamplePath::SixPoint.json());
    std::fs::create_dir_all(desk.folder.join("meshes/far")).expect("a folder");
    let whole = box_stl([100.0, 50.0, 20.0]);
    let mut not_finite = whole.clone();
    not_finite[84 + 12..84 + 16].copy_from_slice(&f32::NAN.to_le_bytes());
    let mut huge = whole.clone();
    huge[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    for (name, bytes) in [
        ("meshes/cut.stl", &whole[..300]),
        ("meshes/nan.stl", &not_finite),
        ("meshes/huge.stl", &huge),
        ("meshes/large.stl", &box_stl([1e6, 1.0, 1.0])),
        ("meshes/small.stl", &box_stl([0.9, 0.5, 0.1])),
        ("meshes/none.stl", &[0; 84]),
        ("meshes/parts.stl", b"solid a\nendsolid a\nfacet normal 0 0 1\n"),
        ("meshes/only.dae", b"<COLLADA/>"),
        ("outside.stl", &whole),
    ] {
        std::fs::write(desk.folder.join(name), bytes).expect("a mesh");
    }
    #[cfg(unix)]
    std::os::unix::fs::symlink(desk.folder.join("outside.stl"), desk.folder.join("meshes/link.stl")).expect("a link");
    for (name, words) in [
        ("package://a/cut.stl", "it states 12 triangles, which need 684 bytes, and it has 300"),
        ("nan.stl", "triangle 1: a corner has the coordinate NaN"),
        ("huge.stl", "it states 4294967295 triangles"),
        ("large.stl", "a corner is at 1000 m"),
        (
            "small.stl",
            "it is 9.0e-4 m large, which nobody sees: at least 0.001 m is drawn; check the scale in the .urdf file",
        ),
        ("none.stl", "it has no triangles"),
        ("parts.stl", "line 3 is \"facet normal 0 0 1\", but only \"solid\" begins"),
        ("only.dae", "only STL is read: convert it, and put \"only.stl\" beside it"),
        ("lost.stl", "there is no such file below meshes"),
        ("far", "there is no such file below meshes"),
        ("../outside.stl", "outside of the folder of --meshes"),
        ("package://../outside.stl", "outside of the folder of --meshes"),
        ("file:///etc/passwd", "outside of the folder of --meshes"),
        ("/etc/passwd", "outside of the folder of --meshes"),
        #[cfg(unix)]
        ("link.stl", "outside of the folder of --meshes"),
    ] {
        with_meshes(&desk, name);
        desk.run(&MESH_PLAN).refused(2, &[name, words]);
    }
    // A name that is a trick fits on a line of a terminal.
    let long = format!("package://a/&#155;2J&#10;{}.stl", "a".repeat(500));
    with_meshes(&desk, &long);
    let said = desk.run(&MESH_PLAN).refused(2, &["package://a/ 2J aaa", "...: "]).stderr;
    assert!(said.len() < 500 && !said.contains('\u{9b}'), "{said}");
    with_meshes(&desk, "nan.stl\" scale=\"1 1");
    desk.run(&MESH_PLAN).refused(2, &["arm.urdf"]);
    desk.run(&["plan", "--format", "html", "--meshes", "meshes"])
        .refused(2, &["cr7", "no .urdf file", "leave --meshes out"]);
    desk.run(&["plan", "--meshes", "meshes"]).refused(2, &["add --format html"]);
    desk.run(&["plan", "--meshes", "meshes", "--stream", "20"])
        .refused(2, &["'--meshes <FOLDER>'", "cannot be used with", "--stream <N>"]);
    desk.write("arm.urdf", &desk.run(&["robots", "--urdf", "ur5e"]).done().stdout);
    desk.run(&MESH_PLAN).refused(2, &["no link of the arm has a mesh"]);
    assert!(!desk.folder.join("out/report.html").exists());
}
