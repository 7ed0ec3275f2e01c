//! Columns of the tool in CSV files: its axis, or its orientation.

use std::f64::consts::PI;
use std::path::Path;

use arcfeed_kinematics::ForwardKinematics;
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use robot_cr7::{Job, PathFile, Robot, Task};

/// Poses of the tool at the setpoints of a planned file, in the workpiece frame.
fn poses(csv: &str, job: &Job) -> Result<Vec<Isometry3<f64>>, String> {
    let file = PathFile::from_bytes(csv.as_bytes(), Path::new("tools.csv"), None).map_err(|e| e.to_string())?;
    let task = Task::of_cr7(job, &file).map_err(|e| e.to_string())?;
    let motion = task.plan().map_err(|e| e.to_string())?;
    let arm = Robot::load("cr7", None, None).expect("built in").arm::<6>(job.tool).expect("six joints");
    let back = job.workpiece.inverse();
    let setpoints = motion.setpoints().expect("a period").map(|p| p.map(|p| back * arm.forward(&p.q)));
    setpoints.collect::<Result<_, _>>().map_err(|e| e.to_string())
}

fn job(text: &str) -> Job {
    Job::from_bytes(text.as_bytes(), Path::new("job.toml")).expect("a job")
}

/// Points on an arc of 100 mm of radius; the axis leans outwards by up to half a radian.
fn leaning() -> Vec<(Vector3<f64>, Vector3<f64>)> {
    (0..=40)
        .map(|i| {
            let angle = PI / 2.0 * f64::from(i) / 40.0;
            let out = Vector3::new(angle.cos(), angle.sin(), 0.0);
            let lean = 0.5 * (angle * 2.0).sin();
            (out * 0.1, out * lean.sin() + Vector3::z() * lean.cos())
        })
        .collect()
}

fn csv(points: &[(Vector3<f64>, Vector3<f64>)]) -> String {
    let row = |(p, a): &(Vector3<f64>, Vector3<f64>)| {
        format!("{},{},{},{:.9},{:.9},{:.9}\n", p.x * 1e3, p.y * 1e3, p.z * 1e3, a.x, a.y, a.z)
    };
    "x_mm,y_mm,z_mm,i,j,k\n".to_owned() + &points.iter().map(row).collect::<String>()
}

/// The pose nearest to a point.
fn nearest<'a>(poses: &'a [Isometry3<f64>], point: &Vector3<f64>) -> &'a Isometry3<f64> {
    let distance = |pose: &Isometry3<f64>| (pose.translation.vector - point).norm();
    poses.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("poses")
}

#[test]
fn the_tool_has_the_axis_of_each_point_and_does_not_turn_about_it() {
    let points = leaning();
    for text in ["[path]\n", "[path]\nthrough = \"polyline\"\nblend_mm = 0.05\n"] {
        let poses = poses(&csv(&points), &job(text)).expect("a motion");
        for (point, axis) in &points {
            let z = nearest(&poses, point).rotation * Vector3::z();
            // A cycle is up to 0.1 mm long, on which the tool leans by a milliradian.
            assert!((z + axis).norm() < 2e-3, "{point} {axis}: {z}");
        }
        let twist: f64 = poses
            .windows(2)
            .map(|pair| {
                (pair[1].rotation * pair[0].rotation.inverse()).scaled_axis().dot(&(pair[0].rotation * Vector3::z()))
            })
            .sum();
        assert!(twist.abs() < 0.02, "{twist}");
    }
}

#[test]
fn the_tool_has_the_orientation_of_each_point() {
    let turned = |i: usize| {
        let turn = UnitQuaternion::from_euler_angles(0.1 * (i as f64 / 5.0).sin(), 0.0, 0.02 * i as f64);
        turn * UnitQuaternion::from_euler_angles(PI, 0.0, 0.0)
    };
    let points: Vec<Vector3<f64>> = leaning().iter().map(|(point, _)| *point).collect();
    let row = |(i, p): (usize, &Vector3<f64>)| {
        let q = turned(i);
        format!("{},{},{},{},{},{}\n", q.i, p.y * 1e3, q.j, q.k, p.x * 1e3, q.w)
    };
    // Columns in any order; a plane path.
    let text = "qx,y_mm,qy,qz,x_mm,qw\n".to_owned() + &points.iter().enumerate().map(row).collect::<String>();
    let poses = poses(&text, &Job::default()).expect("a motion");
    for (i, point) in points.iter().enumerate() {
        let off = nearest(&poses, point).rotation.angle_to(&turned(i));
        assert!(off < 2e-3, "point {i}: {off}");
    }
}

#[test]
fn columns_that_do_not_say_where_the_tool_points_are_refused() {
    let refused = |text: &str, parts: &[&str]| {
        let error = poses(text, &Job::default()).expect_err(text);
        assert!(parts.iter().all(|part| error.contains(part)), "{error}: {parts:?}");
    };
    refused("x_mm,y_mm,i,j\n0,0,0,1\n", &["tools.csv:1", "i,j,k"]);
    refused("x_mm,y_mm,i,j,k,qx,qy,qz,qw\n0,0,0,0,1,1,0,0,0\n", &["tools.csv:1", "all of qx,qy,qz,qw"]);
    refused("x_mm,y_mm,i,j,j\n0,0,0,1,0\n", &["twice"]);
    refused("x_mm,y_mm,i,j,k\n0,0,0,0,1\n10,0,0,0,0.9\n", &["tools.csv:3", "length 0.9", "length 1"]);
    refused("x_mm,y_mm,qx,qy,qz,qw\n0,0,1,0,0,0\n10,0,1,1,0,0\n", &["tools.csv:3", "quaternion"]);
    refused("x_mm,y_mm,i,j,k\n0,0,0,0,1\n10,0,0,0,-1\n20,0,0,0,1\n", &["tools.csv:3", "turn back", "add points"]);
    refused("x_mm,y_mm,i,j,k\n0,0,0,0,1\n10,0,0,NaN,1\n", &["tools.csv:3", "column 4", "NaN"]);
    refused("x_mm,y_mm,qx,qy,qz,qw\n0,0,1,0,0,0\n10,0,0,1,0,0\n", &["tools.csv:3", "turn back"]);
    let slerp = job("[orientation]\nmode = \"slerp\"\nfrom_rpy_deg = [180, 0, 0]\nto_rpy_deg = [180, 0, 90]\n");
    let error = poses("x_mm,y_mm,i,j,k\n0,0,0,0,1\n10,0,0,0,1\n", &slerp).expect_err("turned twice");
    assert!(error.contains("orientation of the job") && error.contains("constant"), "{error}");
}

#[test]
fn the_report_tells_how_near_the_curve_is_to_the_points() {
    let text: String = leaning().iter().map(|(p, _)| format!("{},{}\n", p.x * 1e3, p.y * 1e3)).collect();
    let file =
        PathFile::from_bytes(format!("x_mm,y_mm\n{text}").as_bytes(), Path::new("arc.csv"), None).expect("points");
    let task = Task::of_cr7(&Job::default(), &file).expect("in reach");
    let motion = task.plan().expect("a motion");
    let report = motion.report(1, std::time::Duration::from_secs(1));
    let fit = report.fit.expect("points");
    assert_eq!(fit.points, 41);
    assert!(fit.deviation_m <= 1e-6, "{fit:?}");
    // The height of the arc over its chords.
    let height = 0.1 * (1.0 - (PI / 160.0).cos());
    assert!((fit.bulge_m / height - 1.0).abs() < 0.1, "{} {height}", fit.bulge_m);
    assert!((2..=42).contains(&fit.bulge_line));
    assert!(report.to_string().contains("points     41,"), "{report}");
    let json = serde_json::to_value(&report).expect("JSON");
    assert_eq!(json["fit"]["points"], 41);
}

#[test]
fn an_orientation_that_swings_past_its_points_is_refused_by_line() {
    // Upright at five points, then leaning by 60 degrees at five others.
    let lean = |i: usize| if i < 5 { 0.0 } else { PI / 3.0 };
    let point = |i: usize| (Vector3::new(0.01 * i as f64, 0.0, 0.0), Vector3::new(0.0, -lean(i).sin(), lean(i).cos()));
    let text = csv(&(0..10).map(point).collect::<Vec<_>>());
    let error = poses(&text, &Job::default()).expect_err("it swings");
    for part in ["tools.csv:", "smooth orientation", "polyline"] {
        assert!(error.contains(part), "{error}");
    }
    assert!(!error.contains("tools.csv:2:"), "{error}");
    let blended = job("[path]\nthrough = \"polyline\"\nblend_mm = 0.05\nblend_deg = 0.5\n");
    poses(&text, &blended).expect("turns in step with the lines");
}
