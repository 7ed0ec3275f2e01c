//! Plans over segments, judged by dense sampling of their phases.
#![allow(clippy::unwrap_used)]
use crate::common;

use arcfeed_feedrate::{
    FeedError, MotionLaw, Segment, SpeedLaw, boundaries, boundary_speeds, plan_continuous, plan_per_segment,
    plan_windowed,
};
use arcfeed_testing::Random;
use common::{curve_like, judge, lower_bound};
use proptest::prelude::*;

fn hold(plan: &SpeedLaw, segments: &[Segment], v0: f64, v1: f64) {
    let w = judge(plan, segments, v0, v1);
    assert!(w.v <= 1.0 + 1e-9 && w.a <= 1.0 + 1e-9 && w.j <= 1.0 + 1e-9 && w.gap <= 1e-9, "{w:?}");
    let end = plan.at(plan.duration());
    let length: f64 = segments.iter().map(Segment::length).sum();
    assert!((end.p - length).abs() <= 1e-12 * length && end.v == v1 && end.a == 0.0, "{end:?}");
}

#[test]
fn joined_plans_keep_the_limits_and_beat_one_profile_per_segment() {
    let mut worst = 0.0_f64;
    let mut mean = 0.0;
    for seed in 0..40 {
        let n = if seed % 4 == 0 { 3000 } else { 300 };
        let segments = curve_like(n, 1000 + seed);
        let joined = plan_continuous(&segments, 0.0, 0.0).unwrap();
        let single = plan_per_segment(&segments, 0.0, 0.0).unwrap();
        hold(&joined, &segments, 0.0, 0.0);
        hold(&single, &segments, 0.0, 0.0);
        let bound = lower_bound(&segments, 0.0, 0.0);
        let (joined, single) = (joined.duration() / bound, single.duration() / bound);
        assert!(joined >= 1.0 - 1e-12 && single >= 1.0 - 1e-12, "seed {seed}: faster than without a jerk limit");
        worst = worst.max(joined / single);
        mean += joined / 40.0;
        println!("seed {seed} n {n}: joined {joined:.4}, per segment {single:.4} of the bound without jerk");
    }
    println!("mean {mean:.4}, worst against per segment {worst:.4}");
    assert!(mean < 1.06, "mean {mean}");
    assert!(worst <= 1.0 + 1e-12, "worst {worst}");
}

fn any_segments(max: usize) -> impl Strategy<Value = Vec<Segment>> {
    let one = (-5.0..-3.0_f64, -3.0..0.0_f64, -1.0..1.0_f64, 0.0..3.0_f64)
        .prop_map(|(l, v, a, j)| Segment::new(10f64.powf(l), 10f64.powf(v), 10f64.powf(a), 10f64.powf(j)).unwrap());
    prop::collection::vec(one, 1..max)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    #[test]
    fn wild_segments_keep_the_limits(segments in any_segments(40)) {
        hold(&plan_per_segment(&segments, 0.0, 0.0).unwrap(), &segments, 0.0, 0.0);
        hold(&plan_continuous(&segments, 0.0, 0.0).unwrap(), &segments, 0.0, 0.0);
        for window in [1, 2, 5] {
            hold(&plan_windowed(&segments, 0.0, window).unwrap(), &segments, 0.0, 0.0);
        }
    }

    #[test]
    fn starts_at_speed_keep_the_limits_or_say_why_not(segments in any_segments(20), share in 0.0..1.3_f64) {
        let top = match plan_per_segment(&segments, segments[0].v_max(), 0.0) {
            Ok(_) => segments[0].v_max(),
            Err(FeedError::StartTooFast { highest_start, allowed, lowest, segment, .. }) => {
                prop_assert!(lowest > allowed && segment <= segments.len() || segment == 0);
                highest_start
            }
            Err(other) => return Err(TestCaseError::fail(other.to_string())),
        };
        let v0 = share * top;
        let plan = plan_per_segment(&segments, v0, 0.0);
        if share <= 1.0 {
            hold(&plan.unwrap(), &segments, v0, 0.0);
            hold(&plan_continuous(&segments, v0, 0.0).unwrap(), &segments, v0, 0.0);
        } else {
            let refused = matches!(plan, Err(FeedError::StartTooFast { .. }));
            prop_assert!(refused);
        }
    }

    #[test]
    fn scale_of_length_and_time_does_not_matter(segments in any_segments(12), p in -9..9_i32, q in -4..4_i32) {
        let (l, t) = (2f64.powi(3 * p), 2f64.powi(3 * q));
        let scaled: Vec<Segment> = segments.iter()
            .map(|s| Segment::new(s.length() * l, s.v_max() * l / t, s.a_max() * l / t / t, s.j_max() * l / t / t / t).unwrap())
            .collect();
        let (one, other) = (plan_per_segment(&segments, 0.0, 0.0).unwrap(), plan_per_segment(&scaled, 0.0, 0.0).unwrap());
        prop_assert!((other.duration() / t / one.duration() - 1.0).abs() < 1e-9);
        let (one, other) = (plan_continuous(&segments, 0.0, 0.0).unwrap(), plan_continuous(&scaled, 0.0, 0.0).unwrap());
        prop_assert!((other.duration() / t / one.duration() - 1.0).abs() < 1e-6);
    }
}

#[test]
fn window_as_long_as_the_path_is_the_full_scan() {
    for seed in 0..10 {
        let segments = curve_like(120, seed);
        let full = plan_per_segment(&segments, 0.0, 0.0).unwrap();
        for window in [120, 121, 5000] {
            assert_eq!(plan_windowed(&segments, 0.0, window).unwrap(), full);
        }
        let mut last = f64::INFINITY;
        for window in [1, 3, 10, 30, 60] {
            let plan = plan_windowed(&segments, 0.0, window).unwrap();
            hold(&plan, &segments, 0.0, 0.0);
            assert!(plan.duration() >= full.duration() * (1.0 - 1e-12));
            assert!(plan.duration() <= last * (1.0 + 1e-12), "a longer window is not slower");
            last = plan.duration();
        }
    }
}

#[test]
fn a_window_can_start_at_speed() {
    let segments = vec![Segment::new(1e-3, 0.1, 1.0, 50.0).unwrap(); 50];
    let plan = plan_windowed(&segments, 0.03, 20).unwrap();
    hold(&plan, &segments, 0.03, 0.0);
    assert!(matches!(plan_windowed(&segments, 0.1, 2), Err(FeedError::StartTooFast { .. })));
}

#[test]
fn ends_at_speed() {
    let segments = vec![Segment::new(2e-3, 0.1, 1.0, 50.0).unwrap(); 20];
    for v_end in [0.0, 0.01, 0.05, 0.1] {
        hold(&plan_per_segment(&segments, 0.0, v_end).unwrap(), &segments, 0.0, v_end);
        hold(&plan_continuous(&segments, 0.02, v_end).unwrap(), &segments, 0.02, v_end);
    }
    let short = &segments[..1];
    let Err(FeedError::EndTooFast { highest, .. }) = plan_per_segment(short, 0.0, 0.1) else { panic!("reached") };
    hold(&plan_per_segment(short, 0.0, highest).unwrap(), short, 0.0, highest);
}

#[test]
fn impossible_start_is_reported_with_the_segment() {
    let mut segments = vec![Segment::new(1e-3, 0.1, 1.0, 50.0).unwrap(); 10];
    segments[4] = Segment::new(1e-3, 0.005, 1.0, 50.0).unwrap();
    let Err(FeedError::StartTooFast { segment, allowed, lowest, highest_start, .. }) =
        plan_per_segment(&segments, 0.1, 0.0)
    else {
        panic!("accepted")
    };
    assert_eq!((segment, allowed), (4, 0.005));
    assert!(lowest > allowed && highest_start < 0.1);
    hold(&plan_per_segment(&segments, highest_start, 0.0).unwrap(), &segments, highest_start, 0.0);
}

#[test]
fn alternating_equal_and_tiny_segments() {
    let mut rng = Random::new(7);
    let make = |f: &mut dyn FnMut(usize) -> (f64, f64)| -> Vec<Segment> {
        (0..200)
            .map(|i| {
                let (l, v) = f(i);
                Segment::new(l, v, 1.0, 50.0).unwrap()
            })
            .collect()
    };
    let sets = [
        make(&mut |i| (1e-4, if i % 2 == 0 { 0.1 } else { 0.01 })),
        make(&mut |_| (1e-4, 0.05)),
        make(&mut |i| (if i % 3 == 0 { 1e-12 } else { 1e-4 }, 0.05 + 0.04 * (i as f64 / 20.0).sin())),
        make(&mut |_| (1e-7, 0.05 * rng.unit() + 0.001)),
        make(&mut |i| (1e-3, 0.1 / (1.0 + i as f64 % 50.0))),
    ];
    for segments in &sets {
        let joined = plan_continuous(segments, 0.0, 0.0).unwrap();
        hold(&joined, segments, 0.0, 0.0);
        let single = plan_per_segment(segments, 0.0, 0.0).unwrap();
        hold(&single, segments, 0.0, 0.0);
    }
}

#[test]
fn one_segment_is_one_s_profile() {
    let segments = [Segment::new(0.02, 0.1, 1.0, 50.0).unwrap()];
    let limits = arcfeed_feedrate::AxisLimits::symmetric(0.1, 1.0, 50.0).unwrap();
    let profile = arcfeed_feedrate::SProfile::new(0.02, 0.0, 0.0, &limits).unwrap();
    for plan in [plan_per_segment(&segments, 0.0, 0.0).unwrap(), plan_continuous(&segments, 0.0, 0.0).unwrap()] {
        assert!(
            (plan.duration() / profile.duration() - 1.0).abs() < 1e-6,
            "{} {}",
            plan.duration(),
            profile.duration()
        );
    }
}

#[test]
fn speed_by_position_agrees_with_sampling_in_time() {
    let segments = curve_like(300, 5);
    let plan = plan_continuous(&segments, 0.0, 0.0).unwrap();
    for k in 0..1000 {
        let state = plan.at(plan.duration() * f64::from(k) / 999.0);
        let by_s = plan.v_at_s(state.p);
        assert!((by_s - state.v).abs() < 1e-7, "{by_s} {}", state.v);
    }
    assert_eq!(plan.v_at_s(f64::NAN), 0.0);
    let s = boundaries(&segments);
    let speeds = boundary_speeds(&segments, 0.0, 0.0).unwrap();
    let single = plan_per_segment(&segments, 0.0, 0.0).unwrap();
    for (s, v) in s.iter().zip(&speeds) {
        assert!((single.v_at_s(*s) - v).abs() < 1e-9);
    }
}

#[test]
fn invalid_input_is_named() {
    for bad in [f64::NAN, 0.0, -1.0, f64::INFINITY] {
        for field in 0..4 {
            let mut x = [1.0; 4];
            x[field] = bad;
            let message = Segment::new(x[0], x[1], x[2], x[3]).unwrap_err().to_string();
            assert!(message.starts_with(["length", "v_max", "a_max", "j_max"][field]), "{message}");
        }
    }
    let segments = [Segment::new(1.0, 1.0, 1.0, 1.0).unwrap()];
    for bad in [f64::NAN, -1.0, f64::INFINITY] {
        assert!(plan_continuous(&segments, bad, 0.0).is_err() && plan_continuous(&segments, 0.0, bad).is_err());
        assert!(plan_per_segment(&segments, bad, 0.0).is_err() && plan_per_segment(&segments, 0.0, bad).is_err());
    }
    assert_eq!(plan_continuous(&[], 0.0, 0.0), Err(FeedError::Empty { what: "segments" }));
    assert!(plan_windowed(&segments, 0.0, 0).is_err());
    assert!(matches!(plan_continuous(&segments, 2.0, 0.0), Err(FeedError::StartTooFast { segment: 0, .. })));
    assert!(matches!(plan_continuous(&segments, 0.0, 2.0), Err(FeedError::EndTooFast { .. })));
}
