//! Random operators on random limit curves: whatever is asked for, and whenever, the motion keeps its bounds.

use std::f64::consts::TAU;

use arcfeed_feedrate::{LiveCurve, LiveFeed, LiveSection, LiveStatus, LiveStep, MotionState};
use proptest::prelude::*;

/// What an operator does in a cycle.
#[derive(Debug, Clone, Copy)]
enum Act {
    Feed(f64),
    Override(f64),
    Hold,
    Resume,
    /// To this part of the way made.
    Back(f64),
    /// Start and length as parts of the path, feed.
    Section(f64, f64, f64),
}

fn act() -> impl Strategy<Value = Act> {
    prop_oneof![
        (0.002..0.4f64).prop_map(Act::Feed),
        (0.0..1.5f64).prop_map(Act::Override),
        Just(Act::Hold),
        Just(Act::Resume),
        (0.0..1.0f64).prop_map(Act::Back),
        (0.0..1.0f64, 0.01..0.4f64, 0.005..0.1f64).prop_map(|(s, l, v)| Act::Section(s, l, v)),
    ]
}

#[derive(Debug, Clone)]
struct Scenario {
    length: f64,
    /// Waves of the cap: amplitude, waves over the path, phase.
    waves: Vec<(f64, f64, f64)>,
    stops: Vec<usize>,
    acceleration: f64,
    /// Time constant acceleration / jerk, s.
    build_up: f64,
    period: f64,
    acts: Vec<(u16, Act)>,
}

const POINTS: usize = 240;

fn scenario() -> impl Strategy<Value = Scenario> {
    (
        0.02..1.0f64,
        prop::collection::vec((0.0..1.0f64, 0.5..40.0f64, 0.0..6.3f64), 1..4),
        prop::collection::btree_set(1..POINTS, 0..3),
        0.2..8.0f64,
        0.01..0.2f64,
        prop_oneof![Just(1e-3), Just(2e-3), Just(8e-3)],
        prop::collection::vec((0..1500u16, act()), 0..12),
    )
        .prop_map(|(length, waves, stops, acceleration, build_up, period, acts)| Scenario {
            length,
            waves,
            stops: stops.into_iter().collect(),
            acceleration,
            build_up,
            period,
            acts,
        })
}

impl Scenario {
    fn curve(&self) -> LiveCurve {
        let grid: Vec<f64> = (0..=POINTS).map(|i| self.length * i as f64 / POINTS as f64).collect();
        let cap = |i: usize| {
            let x = (i as f64 + 0.5) / POINTS as f64;
            let sum: f64 = self.waves.iter().map(|&(size, n, phase)| size * (TAU * n * x + phase).sin()).sum();
            0.15 * (1.0 + sum).max(0.05)
        };
        let caps: Vec<f64> = (0..POINTS).map(cap).collect();
        LiveCurve::new(&grid, &caps, &self.stops, self.acceleration, self.acceleration / self.build_up)
            .expect("a curve")
    }
}

/// Holds a cycle against the bounds.
fn check(curve: &LiveCurve, period: f64, before: MotionState, step: &LiveStep) {
    let now = step.state;
    let (a, j) = (curve.acceleration(), curve.jerk());
    assert!(now.a.abs() <= a * (1.0 + 1e-9), "acceleration {} of {a} at {}", now.a, now.p);
    assert!((now.a - before.a).abs() <= j * period * (1.0 + 1e-9), "jerk {} of {j}", (now.a - before.a) / period);
    // Inside the cycle the speed is on the straight line between both to within this.
    let bow = j * period * period / 8.0;
    for i in 0..=8 {
        let x = f64::from(i) / 8.0;
        let v = before.v + x * (now.v - before.v);
        let inside = before.p + period * x * (before.v + 0.5 * x * (now.v - before.v));
        let p = if i == 8 { now.p } else { inside };
        let cap = curve.lowest_cap(p, p);
        let slack = if i == 8 { 0.0 } else { bow + 1e-3 * cap };
        assert!(v.abs() <= cap + slack, "speed {v} over the curve {cap} at {p}");
    }
    // What any motion with jerk below J satisfies from one sample to the next.
    let v_gap = now.v - before.v - 0.5 * period * (before.a + now.a);
    let s_gap = now.p - before.p - 0.5 * period * (before.v + now.v);
    assert!(v_gap.abs() <= j * period.powi(2) / 4.0 * (1.0 + 1e-9) + 1e-12, "a jump of the speed: {v_gap}");
    assert!(s_gap.abs() <= j * period.powi(3) / 12.0 * 1.5 + 1e-12, "a jump of the place: {s_gap}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, max_shrink_iters: 200, ..ProptestConfig::default() })]

    #[test]
    fn keeps_every_bound_whatever_the_operator_does(scenario in scenario()) {
        let curve = scenario.curve();
        let mut feed = LiveFeed::new(&curve, scenario.period, 0.1).expect("valid");
        let mut acts = scenario.acts.clone();
        acts.sort_by_key(|act| act.0);
        let last = acts.last().map_or(0, |act| act.0);
        let mut acts = acts.into_iter().peekable();
        let mut before = MotionState::default();
        let mut finished = false;
        for cycle in 0..400_000u32 {
            while let Some((_, act)) = acts.next_if(|act| u32::from(act.0) <= cycle) {
                match act {
                    Act::Feed(v) => feed.set_feed(v).expect("valid"),
                    Act::Override(f) => feed.set_override(f).expect("valid"),
                    Act::Hold => feed.hold(),
                    Act::Resume => feed.resume(),
                    Act::Back(part) => feed.step_back(part * feed.position()).expect("valid"),
                    Act::Section(s, l, v) => {
                        let from = s * scenario.length;
                        feed.set_sections(&[LiveSection { from, to: from + l * scenario.length, feed: v }]).expect("valid");
                    }
                }
            }
            if cycle == u32::from(last) + 2000 {
                // Whatever was asked for, it can always be brought to the end.
                feed.set_override(1.0).expect("valid");
                feed.set_feed(0.3).expect("valid");
                feed.resume();
            }
            let step = feed.step();
            check(&curve, scenario.period, before, &step);
            before = step.state;
            if step.status == LiveStatus::Finished {
                finished = true;
                prop_assert_eq!((before.p, before.v, before.a), (curve.end(), 0.0, 0.0));
                break;
            }
        }
        prop_assert!(finished, "did not arrive: {:?}", before);
    }
}
