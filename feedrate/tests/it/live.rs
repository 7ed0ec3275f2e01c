//! Random operators on random limit curves: whatever is asked for, and whenever, the motion keeps its bounds.

use std::f64::consts::TAU;

use arcfeed_feedrate::{FeedOverride, LiveSection, LiveStatus, LiveStep, MotionState, VelocityLimitCurve};
use arcfeed_testing::Random;
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
    fn caps(&self) -> Vec<f64> {
        let cap = |i: usize| {
            let x = (i as f64 + 0.5) / POINTS as f64;
            let sum: f64 = self.waves.iter().map(|&(size, n, phase)| size * (TAU * n * x + phase).sin()).sum();
            0.15 * (1.0 + sum).max(0.05)
        };
        (0..POINTS).map(cap).collect()
    }

    /// The cap at `p`, without the curve's help.
    fn cap_at(&self, caps: &[f64], p: f64) -> f64 {
        let i = (p / self.length * POINTS as f64).floor();
        // A place on a border to within rounding may be in either interval.
        let near = |i: f64| caps[(i.max(0.0) as usize).min(POINTS - 1)];
        let border = (p / self.length * POINTS as f64).round();
        if (p / self.length * POINTS as f64 - border).abs() < 1e-9 {
            near(border - 1.0).max(near(border))
        } else {
            near(i)
        }
    }

    fn curve(&self) -> VelocityLimitCurve {
        let grid: Vec<f64> = (0..=POINTS).map(|i| self.length * i as f64 / POINTS as f64).collect();
        let caps = self.caps();
        VelocityLimitCurve::new(&grid, &caps, &self.stops, self.acceleration, self.acceleration / self.build_up)
            .expect("a curve")
    }
}

/// Holds a cycle against the bounds.
fn check(curve: &VelocityLimitCurve, cap_at: impl Fn(f64) -> f64, period: f64, before: MotionState, step: &LiveStep) {
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
        let cap = cap_at(p);
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
        let (curve, caps) = (scenario.curve(), scenario.caps());
        let mut feed = FeedOverride::new(&curve, scenario.period, 0.1).expect("valid");
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
            check(&curve, |p| scenario.cap_at(&caps, p), scenario.period, before, &step);
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

/// A straight path of 0.5 m at 0.1 m/s, 1 m/s^2 and 20 m/s^3.
fn straight() -> VelocityLimitCurve {
    let grid: Vec<f64> = (0..=100).map(|i| 0.005 * f64::from(i)).collect();
    VelocityLimitCurve::new(&grid, &[0.1; 100], &[], 1.0, 20.0).expect("a curve")
}

#[test]
fn a_hold_brakes_in_the_time_that_the_limits_take() {
    let curve = straight();
    let mut feed = FeedOverride::new(&curve, 1e-3, 0.08).expect("valid");
    for _ in 0..1500 {
        feed.step();
    }
    assert!((feed.step().state.v - 0.08).abs() < 1e-12);
    feed.hold();
    let cycles = (1..1000).find(|_| feed.step().state.v == 0.0).expect("it stops");
    // From constant speed: v / a + a / j.
    let wanted = 0.08 / 1.0 + 1.0 / 20.0;
    assert!((f64::from(cycles) * 1e-3 - wanted).abs() <= 1e-3, "{cycles} cycles, {wanted} s");
}

#[test]
fn a_section_asked_for_in_time_is_entered_at_its_feed() {
    let curve = straight();
    for override_factor in [0.5, 1.0, 1.2] {
        let mut feed = FeedOverride::new(&curve, 1e-3, 0.08).expect("valid");
        feed.set_override(override_factor).expect("valid");
        feed.set_sections(&[LiveSection { from: 0.2, to: 0.3, feed: 0.02 }]).expect("valid");
        let (mut inside, mut fastest, mut top) = (0, 0.0_f64, 0.0_f64);
        loop {
            let step = feed.step();
            if (0.2..0.3).contains(&step.state.p) {
                inside += 1;
                fastest = fastest.max(step.state.v);
            }
            top = top.max(step.state.v);
            if step.status == LiveStatus::Finished {
                break;
            }
        }
        let (within, elsewhere) = (0.02 * override_factor, 0.08 * override_factor);
        assert!(
            inside > 100 && (fastest / within - 1.0).abs() <= 1e-6,
            "{fastest} at an override of {override_factor}"
        );
        assert!(
            top <= elsewhere * (1.0 + 1e-9) && top >= 0.99 * elsewhere,
            "{top} at an override of {override_factor}"
        );
    }
}

#[test]
fn at_full_feed_the_way_takes_as_long_as_the_fastest_law() {
    let curve = straight();
    let mut feed = FeedOverride::new(&curve, 1e-3, 1.0).expect("valid");
    let cycles = (1..100_000).find(|_| feed.step().status == LiveStatus::Finished).expect("it arrives");
    // The law itself: rest to rest over 0.5 m at 0.997 of the cap, L / v + v / a + a / j with 0.99 of a and j.
    let closed_form = 0.5 / 0.0997 + 0.0997 / 0.99 + 1.0 / 20.0;
    assert!((curve.duration() / closed_form - 1.0).abs() < 1e-3, "{} s, {closed_form} s", curve.duration());
    assert!((f64::from(cycles) * 1e-3 / closed_form - 1.0).abs() < 0.01, "{cycles} cycles, {closed_form} s");
}

/// A narrow place between the samples of two cycles. Where one jerk acts over the whole cycle its speed is known at all times, and it is
/// under the curve at the quarters, at which the motion looks for such places.
#[test]
fn a_cycle_does_not_jump_over_a_narrow_place() {
    let mut rng = Random::new(121);
    let mut near = 0;
    for case in 0..60 {
        let waves = [0; 3].map(|_| (rng.unit(), rng.between(0.5, 40.0), rng.between(0.0, TAU)));
        let scenario = Scenario {
            length: rng.log(0.02, 0.3),
            waves: waves[..1 + rng.below(3)].to_vec(),
            stops: Vec::new(),
            acceleration: rng.log(0.5, 8.0),
            build_up: rng.log(0.005, 0.05),
            period: rng.log(2e-3, 2e-2),
            acts: Vec::new(),
        };
        let (curve, caps, period) = (scenario.curve(), scenario.caps(), scenario.period);
        let mut feed = FeedOverride::new(&curve, period, 1.0).expect("valid");
        let mut before = MotionState::default();
        for cycle in 0..20_000 {
            if cycle % 17 == 0 {
                feed.set_override(if rng.chance(0.5) { 1.0 } else { rng.between(0.05, 1.2) }).expect("valid");
            }
            let LiveStep { state: now, status, .. } = feed.step();
            let jerk = (now.a - before.a) / period;
            let v = |t: f64| before.v + t * (before.a + 0.5 * t * jerk);
            let p = |t: f64| before.p + t * (before.v + t * (0.5 * before.a + t * jerk / 6.0));
            if (v(period) - now.v).abs() < 1e-12 && (p(period) - now.p).abs() < 1e-12 {
                for t in [0.25, 0.5, 0.75, 1.0].map(|part| part * period) {
                    let cap = scenario.cap_at(&caps, p(t));
                    assert!(v(t) <= cap, "case {case}: speed {} over the curve {cap} at {}", v(t), p(t));
                    near += usize::from(v(t) > 0.99 * cap);
                }
            }
            before = now;
            if status == LiveStatus::Finished {
                break;
            }
        }
    }
    assert!(near > 1000, "{near}");
}
