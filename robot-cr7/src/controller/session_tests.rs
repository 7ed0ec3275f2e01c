//! Sessions with an arm of one joint that does what a test wants.

use arcfeed_interp::{Interpolation, JointTrajectory};
use arcfeed_kinematics::{JointRange, Joints};

use super::arm_state::{ArmMode, ArmState};
use super::fault::Fault;
use super::session::Session;
use super::setpoints::{NextSetpoint, SetpointSource};
use super::settings::SendSettings;
use super::stream::{Event, Order};
use super::verified_motion::VerifiedMotion;

/// One joint from 0 to 1 rad in 1 s.
fn motion() -> VerifiedMotion<1> {
    let piece = [0.0, 0.0, 0.0, 10.0, -15.0, 6.0].map(Joints::<1>::repeat);
    let motion = JointTrajectory::from_pieces(vec![0.0, 1.0], vec![piece], Interpolation::Quintic).expect("a motion");
    let range = JointRange::new(Joints::repeat(-2.0), Joints::repeat(2.0)).expect("a range");
    let limits = [2.0, 6.0, 60.0].map(Joints::repeat);
    VerifiedMotion::new(motion, &range.with_rates(limits[0], limits[1], limits[2]).expect("limits"))
        .expect("it keeps them")
}

/// An arm that follows at once, or does what a test wants.
struct Bench<'m> {
    session: Session<&'m VerifiedMotion<1>, 1>,
    now: f64,
    state: ArmState<1>,
    orders: Vec<Order<1>>,
}

impl<'m> Bench<'m> {
    fn new(motion: &'m VerifiedMotion<1>, enable: bool) -> Self {
        let settings = SendSettings { enable, models: &[7], ..SendSettings::new(0.03).expect("a period") };
        let state = ArmState {
            mode: ArmMode::Idle,
            enabled: true,
            alarm: false,
            clock_ms: 0,
            model: 7,
            q: Joints::zeros(),
            qd: Joints::zeros(),
            q_target: Joints::zeros(),
        };
        Self { session: Session::new(motion, &settings, 0.0), now: 0.0, state, orders: Vec::new() }
    }

    /// Runs until `until`, s; `change` may change what the arm says.
    fn run(&mut self, until: f64, mut change: impl FnMut(f64, &mut ArmState<1>)) -> &mut Self {
        while self.now < until && !self.session.is_over() {
            self.now += 0.008;
            loop {
                let Some(order) = self.session.next_order(self.now) else {
                    if self.session.has_planned() {
                        continue;
                    }
                    break;
                };
                match order {
                    Order::Setpoint { q, .. } => self.state.q = q,
                    Order::Enable => (self.state.mode, self.state.enabled) = (ArmMode::Idle, true),
                    Order::AskErrors => self.session.see(self.now, &Event::Errors { count: 0, first: 0 }),
                    Order::Stop => self.session.stop_is_sent(self.now),
                }
                self.orders.push(order);
            }
            self.state.clock_ms += 8;
            let mut state = self.state;
            change(self.now, &mut state);
            self.session.see(self.now, &Event::State(state));
        }
        self
    }

    fn fault(&self) -> Option<&Fault> {
        self.session.outcome().fault.as_ref()
    }

    /// Setpoints and stops that were ordered; no setpoint follows a stop.
    fn counts(&self) -> (usize, usize) {
        let is_setpoint = |order: &&Order<1>| matches!(order, Order::Setpoint { .. });
        let stops = self.orders.iter().skip_while(|order| **order != Order::Stop);
        assert_eq!(stops.clone().find(is_setpoint), None);
        (self.orders.iter().filter(is_setpoint).count(), stops.filter(|order| **order == Order::Stop).count())
    }
}

#[test]
fn a_motion_without_doubt_is_led_to_its_end_and_ends_with_a_stop() {
    let motion = motion();
    let mut bench = Bench::new(&motion, false);
    bench.run(5.0, |_, _| {});
    assert_eq!((bench.fault(), bench.session.is_over()), (None, true));
    // A stop every 0.2 s, until the arm was at rest for 1 s.
    let (setpoints, stops) = bench.counts();
    assert!(setpoints == 35 && (5..=6).contains(&stops), "{stops}");
    assert!(bench.session.outcome().rests_at >= bench.session.outcome().stopped_at);
    let words = bench.session.outcome().to_string();
    assert!(words.contains("is done") && words.contains("rests"), "{words}");
    assert!((bench.state.q[0] - 1.0).abs() < 1e-12);
}

/// A change of the state at a time, s.
type Change = fn(f64, &mut ArmState<1>);

/// The fault that each change is, and within which time it shows, s.
fn doubts() -> [(&'static str, Change, f64); 9] {
    [
        (
            "Mode",
            |t, state| {
                if t > 0.5 {
                    state.mode = ArmMode::Alarm
                }
            },
            0.02,
        ),
        ("Mode", |t, state| state.alarm = t > 0.5, 0.02),
        (
            "Mode",
            |t, state| {
                if t > 0.5 {
                    state.mode = ArmMode::Other("paused")
                }
            },
            0.02,
        ),
        (
            "Disabled",
            |t, state| {
                if t > 0.5 {
                    state.mode = ArmMode::Disabled
                }
            },
            0.02,
        ),
        ("Disabled", |t, state| state.enabled = t <= 0.5, 0.02),
        // 2 deg behind, of 1.875 rad/s at most, and what was asked 0.3 s ago counts.
        (
            "Following",
            |t, state| {
                if t > 0.5 {
                    state.q[0] = 0.4
                }
            },
            0.4,
        ),
        (
            "Following",
            |t, state| {
                if t > 0.5 {
                    state.q[0] = f64::NAN
                }
            },
            0.02,
        ),
        (
            "Clock",
            |t, state| {
                if t > 0.5 {
                    state.clock_ms -= 100
                }
            },
            0.02,
        ),
        (
            "Silence",
            |t, state| {
                if t > 0.5 {
                    state.clock_ms = 496
                }
            },
            0.13,
        ),
    ]
}

#[test]
fn every_doubt_on_the_way_stops_the_arm_at_once() {
    let motion = motion();
    for (name, change, within) in doubts() {
        let mut bench = Bench::new(&motion, false);
        bench.run(0.5, change).run(0.5 + within, change);
        let fault = format!("{:?}", bench.fault());
        assert!(fault.contains(name), "{name}: {fault}");
        bench.run(bench.now + 0.02, change);
        assert_eq!(bench.counts().1, 1, "{name}");
        assert!(bench.session.outcome().sent < 35, "{name}");
    }
}

#[test]
fn what_is_refused_late_or_unwanted_stops_the_arm() {
    let motion = motion();
    type Happening = fn(&mut Bench<'_>);
    let events: [(&str, Happening); 4] = [
        ("Refused", |bench| bench.session.see(bench.now, &Event::Refused { order: "ServoJ", code: -1 })),
        ("Interrupted", |bench| bench.session.interrupt(bench.now)),
        ("Link", |bench| bench.session.lose(bench.now, "down")),
        ("Late", |bench| bench.now += 0.05),
    ];
    for (name, event) in events {
        let mut bench = Bench::new(&motion, false);
        bench.run(0.5, |_, _| {});
        event(&mut bench);
        bench.run(bench.now + 0.02, |_, _| {});
        let fault = format!("{:?}", bench.fault());
        assert!(fault.contains(name), "{name}: {fault}");
        assert_eq!(bench.counts().1, 1, "{name}");
    }
}

#[test]
fn an_arm_that_is_not_ready_is_left_alone() {
    let motion = motion();
    type Change = fn(f64, &mut ArmState<1>);
    let cases: [(&str, Change); 7] = [
        ("Disabled", |_, state| (state.mode, state.enabled) = (ArmMode::Disabled, false)),
        ("Mode", |_, state| state.mode = ArmMode::Running),
        ("Mode", |_, state| state.alarm = true),
        ("Model", |_, state| state.model = 10),
        ("Model", |_, state| state.model = 0),
        ("Elsewhere", |_, state| state.q[0] = 0.001),
        ("Moving", |_, state| state.qd[0] = 0.01),
    ];
    for (name, change) in cases {
        let mut bench = Bench::new(&motion, false);
        bench.run(5.0, change);
        let fault = format!("{:?}", bench.fault());
        assert!(fault.contains(name), "{name}: {fault}");
        assert_eq!((bench.orders.as_slice(), bench.session.is_over()), (&[Order::AskErrors][..], true), "{name}");
    }
}

#[test]
fn drives_are_switched_on_only_where_that_is_allowed() {
    let motion = motion();
    for enable in [false, true] {
        let mut bench = Bench::new(&motion, enable);
        (bench.state.mode, bench.state.enabled) = (ArmMode::Disabled, false);
        bench.run(5.0, |_, _| {});
        assert_eq!(bench.orders.contains(&Order::Enable), enable);
        assert_eq!(bench.fault().is_none(), enable);
    }
}

#[test]
fn an_alarm_while_the_drives_come_on_is_a_doubt() {
    let motion = motion();
    let mut bench = Bench::new(&motion, true);
    (bench.state.mode, bench.state.enabled) = (ArmMode::Disabled, false);
    bench.run(9.0, |_, state| state.alarm = state.enabled);
    assert!(matches!(bench.fault(), Some(Fault::Mode { mode: ArmMode::Alarm })), "{:?}", bench.fault());
    assert_eq!(bench.counts().0, 0);
}

#[test]
fn a_stop_is_repeated_until_the_arm_rests_and_unrest_is_told() {
    let motion = motion();
    let mut bench = Bench::new(&motion, false);
    bench.run(0.5, |_, _| {});
    bench.session.interrupt(bench.now);
    bench.run(9.0, |_, state| state.qd[0] = 0.5);
    assert_eq!((bench.counts().1, bench.session.outcome().rests_at), (20, None));
    let words = bench.session.outcome().to_string();
    assert!(words.contains("NOT SEEN AT REST") && words.contains("interrupted"), "{words}");

    let mut bench = Bench::new(&motion, false);
    bench.run(9.0, |t, state| {
        if t > 1.07 {
            state.qd[0] = 0.5
        }
    });
    assert!(matches!(bench.fault(), Some(Fault::NotResting { .. })), "{:?}", bench.session.outcome());
}

#[test]
fn an_arm_that_leaves_rest_after_the_stop_is_stopped_for_longer() {
    let motion = motion();
    let mut bench = Bench::new(&motion, false);
    bench.run(0.5, |_, _| {});
    bench.session.interrupt(bench.now);
    // A setpoint that was on its way moves it again 0.8 s after the stop.
    bench.run(9.0, |t, state| state.qd[0] = if (1.3..1.4).contains(&t) { 0.1 } else { 0.0 });
    let (stops, outcome) = (bench.counts().1, bench.session.outcome());
    assert!(outcome.rests_at > Some(1.39) && stops >= 9, "{stops}: {outcome:?}");
}

#[test]
fn a_stop_that_cannot_be_sent_is_tried_again() {
    let motion = motion();
    let mut bench = Bench::new(&motion, false);
    bench.run(0.5, |_, _| {});
    bench.session.interrupt(bench.now);
    // The link takes no bytes, and what comes cannot be read: for a second, then all is well.
    let mut tries = 0;
    while bench.now < 1.5 {
        bench.now += 0.008;
        if let Some(order) = bench.session.next_order(bench.now) {
            assert_eq!(order, Order::Stop);
            tries += 1;
        }
        bench.session.lose(bench.now, "no room");
    }
    assert!((4..=6).contains(&tries), "{tries}");
    assert_eq!(bench.session.outcome().stopped_at, None);
    assert!(bench.session.outcome().to_string().contains("COULD NOT BE SENT"));
    bench.run(9.0, |_, _| {});
    let outcome = bench.session.outcome();
    assert!(outcome.stopped_at > Some(1.5) && outcome.rests_at.is_some(), "{outcome:?}");
}

#[test]
fn a_gap_in_what_is_seen_is_not_rest() {
    let motion = motion();
    let mut bench = Bench::new(&motion, false);
    bench.run(0.5, |_, _| {});
    bench.session.interrupt(bench.now);
    // Nothing new comes from 0.9 to 1.3 s.
    let clock = bench.state.clock_ms + 400;
    bench.run(9.0, |t, state| {
        if (0.9..1.3).contains(&t) {
            state.clock_ms = clock
        }
    });
    let outcome = bench.session.outcome();
    assert!(outcome.rests_at > Some(1.29), "{outcome:?}");
}

/// A source that is `VerifiedMotion`, and stopped on the way by somebody.
struct Stopped<'m>(&'m VerifiedMotion<1>);

impl SetpointSource<1> for Stopped<'_> {
    fn start(&self) -> Joints<1> {
        self.0.start()
    }

    fn limits(&self) -> &arcfeed_kinematics::JointLimits<1> {
        self.0.limits()
    }

    fn count(&self, period: f64) -> usize {
        self.0.count(period)
    }

    fn setpoint(&mut self, index: usize, _: f64) -> Result<NextSetpoint<1>, Fault> {
        Ok(NextSetpoint { q: self.0.start(), is_last: index == 3 })
    }

    fn is_stopped_by_order(&self) -> bool {
        true
    }
}

/// Sends what is due until a session has sent so many setpoints, with a state every 10 ms; the time then, s.
fn led<M: SetpointSource<1>>(session: &mut Session<M, 1>, setpoints: usize) -> f64 {
    let mut state = Bench::new(&motion(), false).state;
    for i in 1..1000u32 {
        let now = f64::from(i) * 0.01;
        state.clock_ms += 10;
        session.see(now, &Event::State(state));
        loop {
            match session.next_order(now) {
                Some(Order::AskErrors) => session.see(now, &Event::Errors { count: 0, first: 0 }),
                Some(Order::Stop) => session.stop_is_sent(now),
                Some(_) if session.outcome().sent == setpoints => return now,
                None if !session.has_planned() => break,
                _ => {}
            }
        }
        if session.is_over() {
            return now;
        }
    }
    panic!("{:?}", session.outcome());
}

#[test]
fn a_planner_that_makes_a_setpoint_late_is_named() {
    let motion = motion();
    let settings = SendSettings { models: &[7], ..SendSettings::new(0.03).expect("a period") };
    let mut session = Session::new(&motion, &settings, 0.0);
    let now = led(&mut session, 2);
    // It is planned after that, and the clock says how long that took.
    assert!(session.next_order(now).is_none() && session.has_planned());
    assert_eq!(session.next_order(now + 0.06), Some(Order::Stop));
    let Some(Fault::Late { index: 2, late, planning }) = session.outcome().fault else {
        panic!("{:?}", session.outcome());
    };
    // States come every 10 ms, and a setpoint with one of them.
    assert!((0.029..0.041).contains(&late) && (planning - 0.06).abs() < 1e-9, "{late} {planning}");
    let words = session.outcome().to_string();
    assert!(words.contains("ms late, and planning it took 60.0 ms"), "{words}");
}

#[test]
fn the_clock_is_asked_anew_after_a_setpoint_was_planned() {
    let motion = motion();
    let settings = SendSettings { models: &[7], ..SendSettings::new(0.03).expect("a period") };
    let mut session = Session::new(&motion, &settings, 0.0);
    let now = led(&mut session, 2);
    // Asked for only when it is due, by a clock from before it was planned.
    assert!(session.next_order(now + 0.03).is_none() && session.has_planned());
    assert_eq!(session.next_order(now + 0.03 + 0.02), Some(Order::Stop));
    assert!(matches!(session.outcome().fault, Some(Fault::Late { index: 2, .. })), "{:?}", session.outcome());
}

#[test]
fn a_motion_that_an_order_stops_is_not_done() {
    let motion = motion();
    let settings = SendSettings { models: &[7], ..SendSettings::new(0.03).expect("a period") };
    let mut session = Session::new(Stopped(&motion), &settings, 0.0);
    led(&mut session, usize::MAX);
    let outcome = session.outcome();
    assert_eq!((outcome.fault.as_ref(), outcome.sent, outcome.stopped_by_order), (None, 4, true));
    let words = outcome.to_string();
    assert!(words.contains("stopped by order") && !words.contains("is done"), "{words}");
}
