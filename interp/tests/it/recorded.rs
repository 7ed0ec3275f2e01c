//! `LivePath::verify` has to say no: a motion that is held, stepped back, left and resumed, spoilt in one way each.

use crate::common;

use arcfeed_interp::{Command, Excursion, HybridMotion, HybridState, LeaveBy, LivePath, Quantity, Setpoint};
use arcfeed_kinematics::Joints;

/// Setpoints with whether the tool is on the path.
type Record = Vec<(Setpoint, bool)>;

fn played(motion: &mut HybridMotion<'_>, goal: Joints<6>) -> Record {
    let excursion = Excursion::new(&[goal], LeaveBy::Braking).expect("one point");
    let mut record = vec![(*motion.setpoint(), true)];
    let mut left = false;
    for cycle in 0..60_000 {
        let command = match cycle {
            300 => Command::Hold,
            700 => Command::StepBack(0.002),
            1200 => Command::Resume,
            1500 => Command::Override(0.5),
            1700 => Command::Leave(excursion),
            _ if motion.state() == HybridState::Waiting && !left => {
                left = true;
                Command::Return
            }
            _ => Command::None,
        };
        let step = motion.step(&command);
        assert!(step.refused.is_none(), "{:?} in cycle {cycle}", step.refused);
        record.push((step.setpoint, step.on_path));
        if step.state == HybridState::Done {
            return record;
        }
    }
    panic!("not done: {:?}", motion.state());
}

#[test]
fn a_live_motion_holds_and_each_spoilt_one_is_named() {
    common::live_on_the_knotted_path(each_spoilt_one_is_named);
}

fn each_spoilt_one_is_named(live: &LivePath<'_>, mut motion: HybridMotion<'_>) {
    let start = motion.setpoint().q;
    let record = played(&mut motion, start + Joints::from([0.2, -0.1, 0.1, 0.1, 0.1, 0.2]));
    let judge = |record: &Record| live.verify(&record[0].0, record[1..].iter().map(|(p, on_path)| (p, *on_path)));
    let good = judge(&record);
    assert!(good.holds(1e-6), "{:?}", good.worst());
    let off: Vec<usize> = (0..record.len()).filter(|&i| !record[i].1).collect();
    let (leaves, returns) = (off[0], off[off.len() - 1] + 1);
    assert!(leaves > 1700 && returns < record.len());
    // Cycles in motion on the path, and off it.
    let moving = (leaves + 1..record.len()).rfind(|&i| record[i].1 && record[i].0.feed > 0.3 * common::FEED);
    let moving = moving.expect("it goes on");
    let middle = (leaves + returns) / 2;

    type Spoil = Box<dyn Fn(&mut Record)>;
    let spoilt: Vec<(&str, Quantity, Spoil)> = vec![
        ("off the path by 1e-8", Quantity::PathDeviation, Box::new(move |r| r[moving].0.q[0] += 1e-8)),
        ("a jump off the path", Quantity::Continuity, Box::new(move |r| r[middle].0.q[3] += 1e-6)),
        (
            "a jump at the return",
            Quantity::Continuity,
            Box::new(move |r| {
                r[leaves..returns].iter_mut().for_each(|(p, _)| p.q[1] += 1e-6);
            }),
        ),
        ("says that it is on the path while it is off", Quantity::PathDeviation, Box::new(move |r| r[middle].1 = true)),
        (
            "velocities doubled off the path",
            Quantity::Continuity,
            Box::new(move |r| {
                r[leaves..returns].iter_mut().for_each(|(p, _)| p.qd *= 2.0);
            }),
        ),
        (
            "accelerations of the cycle before",
            Quantity::JointJerk,
            Box::new(move |r| {
                let before = r[moving - 1].0.qdd;
                r[moving].0.qdd = before * 1.5 + Joints::repeat(0.5);
            }),
        ),
        ("the feed of another place", Quantity::SetpointAgreement, Box::new(move |r| r[moving].0.feed *= 1.01)),
        ("not a number", Quantity::JointVelocity, Box::new(move |r| r[middle].0.qd[2] = f64::NAN)),
        ("an end in motion", Quantity::Ends, Box::new(|r| r.truncate(r.len() - 20))),
        ("a time stamp twice", Quantity::SetpointAgreement, Box::new(move |r| r[middle].0.t = r[middle - 1].0.t)),
        (
            "a cycle lost",
            Quantity::Continuity,
            Box::new(move |r| {
                r.remove(moving);
                // The clock goes on evenly.
                let period = r[1].0.t - r[0].0.t;
                r.iter_mut().enumerate().for_each(|(i, (p, _))| p.t = i as f64 * period);
            }),
        ),
    ];
    for (name, quantity, spoil) in spoilt {
        let mut record = record.clone();
        spoil(&mut record);
        let ratio = judge(&record).worst_of(quantity).expect("looked at").ratio;
        assert!(ratio.is_nan() || ratio > 1.0 + 1e-6, "{name}: {ratio}");
    }
}

#[test]
fn a_late_motion_is_no_false_alarm() {
    common::live_on_the_knotted_path(late);
}

fn late(live: &LivePath<'_>, mut motion: HybridMotion<'_>) {
    let start = motion.setpoint().q;
    let mut record = played(&mut motion, start + Joints::from([1.2, -0.4, 0.5, 0.1, 0.1, 1.2]));
    // The same motion after a day.
    record.iter_mut().for_each(|(p, _)| p.t += 86_400.0);
    let late = live.verify(&record[0].0, record[1..].iter().map(|(p, on_path)| (p, *on_path)));
    assert!(late.holds(1e-6), "{:?}", late.worst());
}
