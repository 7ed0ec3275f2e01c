//! Orders to a scenario that is led live: what they do to its events, and what is told of them.

use arcfeed_interp::Command;
use arcfeed_kinematics::{ForwardKinematics, Joints};
use integration_tests::controller_simulator::{Case, Disturbance, Operator, Version, on_stage};
use robot_cr7::controller::{LiveSetpoints, SetpointSource};
use robot_cr7::{Cr7, Scenario, Stage};

/// The time between two setpoints, s.
const PERIOD: f64 = 0.03;
const QUIET: Case =
    Case { version: Version::Four, fault: Disturbance::None, fault_at: 0, jitter: 0, off: false, seed: 1 };

/// Does something with the straight path of the first scenario, 445 mm at 100 mm/s, and these events.
fn on_line<R>(events: &str, then: impl FnOnce(&Stage<'_>, &dyn Fn(&Joints<6>) -> f64) -> R) -> R {
    let (begin, _) = Scenario::EXAMPLE.split_once("[[event]]\n").expect("its events");
    let scenario = Scenario::parse(&format!("{begin}\n{events}"), "line.toml".as_ref()).expect("a scenario");
    let cr7 = Cr7::of(scenario.job()).expect("its limits");
    let stage = scenario.stage(cr7.arm(), cr7.limits()).expect("in reach");
    let tool = |q: &Joints<6>| cr7.arm().forward(q).translation.vector;
    let start = tool(&LiveSetpoints::new(&stage, PERIOD).expect("it ends").start());
    then(&stage, &|q| 1e3 * (tool(q) - start).norm())
}

/// Setpoints and what is told of them.
fn play<'s>(stage: &'s Stage<'s>, operator: impl FnMut(f64) -> Command + 's) -> (Vec<Joints<6>>, Vec<String>) {
    let mut source = LiveSetpoints::new(stage, PERIOD).expect("it ends").with_operator(operator);
    let mut all = Vec::new();
    loop {
        let next = source.setpoint(all.len(), PERIOD).expect("no doubt");
        all.push(next.q);
        if next.is_last {
            return (all, source.happenings().into_iter().map(|row| row.what).collect());
        }
        assert!(all.len() < 10_000, "it does not end");
    }
}

#[test]
fn an_override_of_the_operator_multiplies_that_of_the_scenario() {
    on_line("[[event]]\nat_mm = 230.0\ndo = \"override\"\npercent = 60.0", |stage, place| {
        let places = |operator: Operator| -> Vec<f64> {
            operator.setpoints(stage).expect("it ends").iter().map(place).collect()
        };
        let check = |places: Vec<f64>, before: f64, behind: f64| {
            for two in places.windows(2) {
                let feed = (two[1] - two[0]) / PERIOD;
                let expected = if (50.0..220.0).contains(&two[0]) {
                    before
                } else if (250.0..400.0).contains(&two[0]) {
                    behind
                } else {
                    continue;
                };
                assert!((feed - expected).abs() < 0.01 * expected, "{feed} mm/s at {} mm, not {expected}", two[0]);
            }
        };
        check(places(Operator::default()), 100.0, 60.0);
        check(places(Operator::new(vec![(0.0, Command::Override(0.5))])), 50.0, 30.0);
    });
}

#[test]
fn a_hold_of_the_operator_does_not_end_a_step_back() {
    let events = "[[event]]\nat_mm = 200.0\ndo = \"hold\"\n[[event]]\nwait_s = 0.3\ndo = \"step_back\"\nto_mm = 150.0\n\
                  [[event]]\nwait_s = 0.3\ndo = \"resume\"";
    on_line(events, |stage, place| {
        let stands_at = |setpoints: &[Joints<6>], mm: f64| {
            let still = setpoints.windows(2).filter(|two| (two[1] - two[0]).amax() == 0.0);
            still.filter(|two| (place(&two[0]) - mm).abs() < 1e-3).count()
        };
        let alone = Operator::default().setpoints(stage).expect("it ends");
        let count = stands_at(&alone, 150.0);
        assert!((9..=11).contains(&count), "{count}");
        // The tool steps back somewhere between 2.5 and 3.2 s.
        for tenths in 24..34 {
            let at = 0.1 * f64::from(tenths);
            let held = Operator::new(vec![(at, Command::Hold), (at + 2.0, Command::Resume)]);
            let setpoints = held.setpoints(stage).expect("it ends");
            let count = stands_at(&setpoints, 150.0);
            assert!(count >= 9, "held at {at} s: it stands at 150 mm for {count} setpoints");
            assert!((place(&setpoints[setpoints.len() - 1]) - place(&alone[alone.len() - 1])).abs() < 1e-6);
        }
    });
}

#[test]
fn the_wait_of_an_event_goes_on_after_a_hold_of_the_operator() {
    let events = "[[event]]\nat_mm = 200.0\ndo = \"hold\"\n[[event]]\nwait_s = 1.0\ndo = \"resume\"";
    on_line(events, |stage, _| {
        let alone = Operator::default().setpoints(stage).expect("it ends").len();
        // The arm stands from 2.2 s to 3.2 s.
        let held = Operator::new(vec![(2.8, Command::Hold), (4.8, Command::Resume)]);
        let more = held.setpoints(stage).expect("it ends").len() - alone;
        assert!((66..=68).contains(&more), "{more} setpoints more for 2 s");
    });
}

#[test]
fn orders_in_every_cycle_do_not_keep_events_from_coming() {
    on_stage(0, |stage| {
        let (alone, _) = play(stage, |_| Command::None);
        let (ordered, told) = play(stage, |_| Command::Override(1.0));
        assert!(alone == ordered, "{} {}", alone.len(), ordered.len());
        assert!(told.iter().any(|what| what.starts_with("leave")) && told.iter().any(|what| what == "return"));
        assert!(told.len() < 1100 && told[told.len() - 1].contains("more orders"), "{:?}", told.last());
    });
}

#[test]
fn a_stop_ends_the_motion_on_the_way_and_is_told() {
    on_stage(0, |stage| {
        let alone = LiveSetpoints::new(stage, PERIOD).expect("it ends").count(PERIOD);
        for at in [0.5, 2.0, 4.5, 6.0] {
            let operator = Operator::new(vec![(at, Command::Stop)]);
            let expected = operator.setpoints(stage).expect("it ends");
            let judged = QUIET.run_source(operator.source(stage), &expected).expect("it is stopped within the limits");
            let outcome = judged.outcome;
            assert_eq!((outcome.fault.as_ref(), outcome.sent, outcome.setpoints), (None, expected.len(), alone));
            assert!(outcome.stopped_by_order && outcome.sent < alone, "{at}");
            assert!(outcome.to_string().contains("stopped by order"), "{outcome}");
            // It brakes from the next setpoint on, for less than a second.
            assert!(outcome.sent < ((at + 1.0) / PERIOD) as usize, "{at}: {}", outcome.sent);
        }
        // The same as an event is the scenario.
        assert!(!QUIET.run_live(stage, &Operator::default()).expect("it arrives").outcome.stopped_by_order);
    });
}

#[test]
fn refused_events_and_orders_are_told() {
    let events = "[[event]]\nat_mm = 200.0\ndo = \"step_back\"\nto_mm = 300.0\n[[event]]\nat_mm = 210.0\ndo = \"resume\"\n\
                  [[event]]\nat_mm = 220.0\ndo = \"override\"\npercent = 80.0";
    on_line(events, |stage, _| {
        let mut cycle = 0;
        let (_, told) = play(stage, move |_| {
            cycle += 1;
            match cycle {
                100 => Command::Hold,
                200 => Command::Resume,
                // There is no path to go back to.
                300 => Command::Return,
                _ => Command::None,
            }
        });
        let refused: Vec<bool> = told.iter().map(|what| what.contains("; refused: ")).collect();
        assert_eq!(refused, [false, false, true, true, false, false], "{told:?}");
        let begins =
            ["order: hold", "order: resume", "order: Return", "step back to 300 mm", "resume", "override 80 %"];
        assert!(told.iter().zip(begins).all(|(what, begin)| what.starts_with(begin)), "{told:?}");
    });
}
