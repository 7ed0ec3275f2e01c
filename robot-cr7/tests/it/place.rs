//! `cr7 place`: the frames that it names are planned in, and can be moved as far as it says.

use crate::common::Desk;

fn square() -> &'static str {
    "x_mm,y_mm\n0,0\n200,0\n200,150\n0,150\n0,0\n"
}

/// A job with the workpiece at this place.
fn job(position: &[f64], rotation: &[f64], configuration: &str) -> String {
    format!(
        "[path]\nthrough = \"polyline\"\n[workpiece]\nposition_mm = {position:?}\nrotation_rpy_deg = {rotation:?}\n[start]\nconfiguration = \
         \"{configuration}\"\n"
    )
}

#[test]
fn the_named_frames_are_planned_in_even_moved_as_far_as_is_said() {
    let desk = Desk::new("place");
    desk.write("square.csv", square());
    desk.write("job.toml", "[path]\nthrough = \"polyline\"\n");
    let place = |more: &[&str]| {
        let args = [&["place", "square.csv", "--job", "job.toml", "--count", "2", "--json"], more].concat();
        desk.run(&args).done().json()
    };
    for (more, height) in [(vec!["--z-mm", "-30", "--turn"], Some(-30.0)), (vec![], None)] {
        let found = place(&more);
        let frames = found["frames"].as_array().expect("a list");
        assert_eq!(frames.len(), 2, "{found}");
        let frame = &frames[0];
        let numbers = |key: &str| -> Vec<f64> {
            frame[key].as_array().expect("three").iter().filter_map(serde_json::Value::as_f64).collect()
        };
        let position: Vec<f64> = numbers("position_m").iter().map(|v| v * 1e3).collect();
        let rotation: Vec<f64> = numbers("rotation_rpy_rad").iter().map(|v| v.to_degrees()).collect();
        if let Some(height) = height {
            assert!((position[2] - height).abs() < 1e-9, "{position:?}");
        } else {
            assert_eq!(rotation, [0.0; 3]);
            assert!(position[2] >= 0.0);
        }
        let movable = 1e3 * frame["movable_m"].as_f64().expect("a number");
        assert!(movable >= 20.0, "{frame}");
        let configuration = frame["configuration"].as_str().expect("a name");
        for way in [[0.0; 3], [movable, 0.0, 0.0], [0.0, -movable, 0.0], [0.0, 0.0, movable]] {
            let moved: Vec<f64> = position.iter().zip(way).map(|(at, by)| at + by).collect();
            desk.write("moved.toml", &job(&moved, &rotation, configuration));
            desk.run(&["plan", "square.csv", "--job", "moved.toml"]).done();
        }
    }
}

#[test]
fn what_no_frame_reaches_and_arms_of_seven_joints_are_refused() {
    let desk = Desk::new("place_refused");
    desk.write("long.csv", "x_mm,y_mm\n0,0\n4000,0\n");
    desk.run(&["place", "long.csv", "--turn"]).refused(1, &["long.csv", "in none of", "--turn"]);
    desk.write("square.csv", square());
    desk.run(&["place", "square.csv", "--robot", "panda"]).refused(1, &["six joints", "panda"]);
    desk.run(&["place", "square.csv", "--z-mm", "nan"]).refused(2, &["--z-mm"]);
}

#[test]
fn an_error_of_reach_names_place_direction_and_keys() {
    let desk = Desk::new("reach_hint");
    desk.write("square.csv", square());
    desk.write("far.toml", "[path]\nthrough = \"polyline\"\n[workpiece]\nposition_mm = [900, 0, 200]\n");
    let parts = ["mm there and points along (0.000, -0.000, -1.000)", "[workpiece]", "cr7 place", "[orientation]"];
    desk.run(&["plan", "square.csv", "--job", "far.toml"]).refused(1, &parts);
}

#[test]
fn the_configuration_at_the_start_is_chosen_by_name() {
    let desk = Desk::new("posture");
    desk.write("square.csv", square());
    let names = desk.run(&["ik", "--xyz-mm", "400", "-50", "200", "--rpy-deg", "180", "0", "0"]).done().stdout;
    let mut planned = 0;
    for name in ["front up no-flip", "front up flip", "back down flip", "back up no-flip"] {
        assert!(names.contains(name), "{names}");
        desk.write("job.toml", &format!("[path]\nthrough = \"polyline\"\n[start]\nconfiguration = \"{name}\"\n"));
        if desk.run(&["plan", "square.csv", "--job", "job.toml"]).code != 0 {
            continue;
        }
        planned += 1;
        let first = desk.trajectory::<6>("out")[0].q;
        let mut args = vec!["fk".to_owned(), "--json".to_owned(), "--rad".to_owned()];
        args.extend(first.iter().map(f64::to_string));
        let args: Vec<&str> = args.iter().map(String::as_str).collect();
        assert_eq!(desk.run(&args).done().json()["configuration"], name);
    }
    assert!(planned >= 2, "{planned}");
    let refused = |text: &str, robot: &str, parts: &[&str]| {
        desk.write("job.toml", &format!("[start]\n{text}\n"));
        desk.run(&["plan", "--job", "job.toml", "--robot", robot]).refused(2, parts);
    };
    refused("configuration = \"lefty\"", "cr7", &["job.toml:2", "start.configuration", "front or back"]);
    refused("near_deg = 0\nconfiguration = \"front up flip\"", "cr7", &["start.configuration", "one of the two"]);
    refused("configuration = \"front up flip\"", "panda", &["start.configuration", "six joints"]);
}
