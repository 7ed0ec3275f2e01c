//! Trajectories written and read back.

use std::path::Path;

use proptest::prelude::*;
use robot_cr7::{TrajectoryRow, TrajectoryWriter, read_trajectory, trajectory_columns, write_trajectory};

fn row(values: &[f64]) -> TrajectoryRow {
    let six = |from: usize| std::array::from_fn(|i| values[from + i]);
    TrajectoryRow {
        t: values[0],
        q: six(1),
        qd: six(7),
        qdd: six(13),
        jerk: six(19),
        position: std::array::from_fn(|i| values[25 + i]),
        quaternion: std::array::from_fn(|i| values[28 + i]),
    }
}

fn names() -> Vec<String> {
    (1..=6).map(|k| format!("joint {k}")).collect()
}

fn written(rows: &[TrajectoryRow]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut writer = TrajectoryWriter::new(&mut bytes, &names()).expect("memory");
    rows.iter().for_each(|r| writer.write(r).expect("memory"));
    writer.finish().expect("memory");
    bytes
}

fn refused(text: &str) -> String {
    read_trajectory::<_, 6>(text.as_bytes(), Path::new("t.csv")).expect_err("bad").to_string()
}

#[test]
fn columns_name_their_units_and_stand_in_order() {
    let values: Vec<f64> = (0..32).map(f64::from).collect();
    let text = String::from_utf8(written(&[row(&values)])).expect("text");
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 2);
    assert!(lines[0].starts_with("t_s,q1_rad:joint 1,") && lines[0].ends_with(",x_m,y_m,z_m,qx,qy,qz,qw"));
    let names: Vec<&str> = lines[0].split(',').collect();
    let cells: Vec<&str> = lines[1].split(',').collect();
    assert_eq!(names, trajectory_columns(&self::names()));
    for (name, value) in [
        ("q6_rad:joint 6", "6.0"),
        ("qd1_rad_s:joint 1", "7.0"),
        ("qdd6_rad_s2:joint 6", "18.0"),
        ("jerk1_rad_s3:joint 1", "19.0"),
    ] {
        let i = names.iter().position(|n| *n == name).expect("a column");
        assert_eq!(cells[i], value, "{name}");
    }
}

#[test]
fn a_trajectory_has_a_name_for_each_joint() {
    for count in [0, 5, 7] {
        let names: Vec<String> = (0..count).map(|k| format!("j{k}")).collect();
        let error = TrajectoryWriter::<_, 6>::new(Vec::new(), &names).expect_err("six joints");
        assert_eq!(error.to_string(), format!("{count} names for 6 joints: give one for each joint"));
    }
}

#[test]
fn files_round_trip() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let file = folder.join("trajectory.csv");
    let rows: Vec<_> =
        (0..1000).map(|i| row(&std::array::from_fn::<f64, 32, _>(|k| (i * 32 + k) as f64 / 7.0))).collect();
    write_trajectory(&file, &names(), rows.iter().copied()).expect("written");
    let read = read_trajectory(std::fs::File::open(&file).expect("there"), &file).expect("read");
    assert_eq!(read, rows);
    let m = write_trajectory(&folder.join("no/such/t.csv"), &names(), rows).expect_err("no folder").to_string();
    assert!(m.contains("no/such/t.csv") && m.contains("cannot be written") && m.contains("folder exists"), "{m}");
}

#[test]
fn bad_trajectories_say_where() {
    // The names may be missing, as in files of other sources.
    let header = trajectory_columns(&names()).join(",").replace(":joint 4", "");
    let zero =
        read_trajectory::<_, 6>(format!("{header}\n{}\n", vec!["0"; 32].join(",")).as_bytes(), Path::new("t.csv"));
    assert_eq!(zero.map_err(|e| e.to_string()), Ok(vec![row(&[0.0; 32])]));
    let zeros = vec!["0"; 32].join(",");
    assert!(refused("").contains("t.csv: the file is empty"));
    let m = refused("a,b\n");
    assert!(m.contains("t.csv:1") && m.contains("2 columns") && m.contains("32"), "{m}");
    let m = refused(&header.replace("qd3_rad_s:joint 3", "qd3"));
    assert!(m.contains("t.csv:1") && m.contains("column 10") && m.contains("\"qd3\""), "{m}");
    let m = refused(&format!("{header}\n{zeros}\n{}", zeros.replacen('0', "NaN", 1)));
    assert!(m.contains("t.csv:3") && m.contains("column 1") && m.contains("NaN"), "{m}");
    let m = refused(&format!("{header}\n{zeros},1\n"));
    assert!(m.contains("t.csv:2") && m.contains("33 columns"), "{m}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn every_finite_number_reads_back_as_itself(
        values in prop::collection::vec(any::<f64>().prop_filter("finite", |v| v.is_finite()), 32)
    ) {
        let read = read_trajectory(written(&[row(&values)]).as_slice(), Path::new("t.csv"));
        let read = read.map_err(|e| TestCaseError::fail(e.to_string()))?;
        prop_assert_eq!(read, vec![row(&values)]);
    }

    #[test]
    fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        if let Err(e) = read_trajectory::<_, 6>(bytes.as_slice(), Path::new("t.csv")) {
            prop_assert!(e.to_string().contains("t.csv"));
        }
    }
}
