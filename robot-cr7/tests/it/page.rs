//! `cr7 plan --format html`: the page's data are those of the trajectory beside it, and it needs nothing else.
#![cfg(all(feature = "cli", feature = "html"))]

use crate::common;

use common::Desk;
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
