//! Excursions that pass their points without a stop, and on straight lines of the joint space.

use crate::common;

use arcfeed_interp::{
    Command, Excursion, HybridError, HybridMotion, HybridState, JointMoveBy, LeaveBy, LivePath, Setpoint,
};
use arcfeed_kinematics::Joints;

/// Setpoints with the state after them, and whether the tool is on the path.
type Record = Vec<(Setpoint, HybridState, bool)>;

/// Leaves the path in cycle 500, returns from the goal, and ends the path; the points start from the start of the path. The whole motion is
/// held against every limit.
fn played(points: &[Joints<6>], shape: impl Fn(Excursion) -> Excursion) -> (Record, Vec<Joints<6>>) {
    common::live_on_the_knotted_path(|live, motion| along(live, motion, points, shape))
}

fn along(
    live: &LivePath<'_>,
    mut motion: HybridMotion<'_>,
    points: &[Joints<6>],
    shape: impl Fn(Excursion) -> Excursion,
) -> (Record, Vec<Joints<6>>) {
    let start = motion.setpoint().q;
    let points: Vec<Joints<6>> = points.iter().map(|by| start + by).collect();
    let excursion = shape(Excursion::new(&points, LeaveBy::Braking).expect("points"));
    let first = *motion.setpoint();
    let mut record: Record = Vec::new();
    for cycle in 0..60_000 {
        let command = match motion.state() {
            _ if cycle == 500 => Command::Leave(excursion),
            HybridState::Waiting => Command::Return,
            _ => Command::None,
        };
        let step = motion.step(&command);
        assert!(step.refused.is_none(), "{:?} in cycle {cycle}", step.refused);
        record.push((step.setpoint, step.state, step.on_path));
        if step.state == HybridState::Done {
            let check = live.verify(&first, record.iter().map(|(p, _, on_path)| (p, *on_path)));
            assert!(check.holds(1e-6), "{:?}", check.worst());
            return (record, points);
        }
    }
    panic!("not done: {:?}", motion.state());
}

/// The three points of the tests: a way round a corner.
fn corner() -> [Joints<6>; 3] {
    [
        Joints::from([0.3, 0.0, 0.1, 0.0, 0.1, 0.0]),
        Joints::from([0.3, -0.3, 0.1, 0.2, 0.1, 0.3]),
        Joints::from([-0.1, -0.3, 0.2, 0.2, 0.0, 0.3]),
    ]
}

fn apart(q: &Joints<6>, point: &Joints<6>) -> f64 {
    (q - point).amax()
}

#[test]
fn points_before_the_goal_are_passed_without_a_stop_and_as_near_as_asked() {
    let within = 0.05;
    let (stopping, _) = played(&corner(), |e| e);
    let (passing, points) = played(&corner(), |e| e.with_passing(within).expect("a distance"));
    assert!(passing.len() + 100 < stopping.len(), "{} cycles instead of {}", passing.len(), stopping.len());
    for off in [HybridState::JointMove(0), HybridState::Returning] {
        let begin = passing.iter().position(|(_, state, _)| *state == off).expect("it leaves");
        let rest = |(p, _, on_path): &(Setpoint, HybridState, bool)| *on_path || p.qd.amax() == 0.0;
        let end = begin + 1 + passing[begin + 1..].iter().position(rest).expect("it arrives");
        // From rest to rest without a stop between, past both points.
        for point in &points[..2] {
            let least = passing[begin..end].iter().map(|(p, ..)| apart(&p.q, point)).fold(f64::INFINITY, f64::min);
            assert!(least <= within && least > 1e-6, "{least} rad from a point");
        }
        let goal = if off == HybridState::Returning { &passing[begin - 1].0.q } else { &points[2] };
        assert!(passing[begin..=end].iter().any(|(p, ..)| apart(&p.q, goal) < 1e-3));
    }
    assert!(passing.iter().any(|(p, ..)| p.q == points[2]), "the goal itself is reached exactly");
    // Without a distance every point is one where the arm stands.
    for point in &points {
        assert!(stopping.iter().any(|(p, ..)| p.q == *point && p.qd.amax() == 0.0));
    }
}

/// A hold that comes while the path is left, or between points that are passed, is kept until it is ended.
#[test]
fn a_hold_is_kept_whatever_was_ordered_before() {
    common::live_on_the_knotted_path(|live, _| {
        for (at, leave) in (500..4000).step_by(125).zip([LeaveBy::Braking, LeaveBy::AtOnce].into_iter().cycle()) {
            let mut motion = HybridMotion::new(live, 0.05).expect("a feed");
            let first = *motion.setpoint();
            let points = corner().map(|by| first.q + by);
            let excursion = Excursion::new(&points, leave).and_then(|e| e.with_passing(0.1)).expect("points");
            let (mut record, mut held) = (Vec::new(), None);
            for cycle in 0..60_000 {
                let command = match motion.state() {
                    _ if cycle == 490 => Command::Leave(excursion),
                    _ if cycle == at => Command::Hold,
                    _ if cycle == at + 3000 => Command::Resume,
                    HybridState::Waiting if cycle > at + 3000 => Command::Return,
                    _ => Command::None,
                };
                let step = motion.step(&command);
                assert!(matches!(step.refused, None | Some(HybridError::BrakesFirst { .. })), "{:?}", step.refused);
                if (at + 2000..at + 3000).contains(&cycle) {
                    let place = held.get_or_insert(step.setpoint.q);
                    assert!(
                        step.holding && apart(&step.setpoint.q, place) < 1e-12,
                        "{at}: {cycle} {:?} {:?}",
                        step.state,
                        step.setpoint
                    );
                }
                record.push((step.setpoint, step.on_path));
                if step.state == HybridState::Done {
                    break;
                }
            }
            assert_eq!(motion.state(), HybridState::Done, "{at}");
            let check = live.verify(&first, record.iter().map(|(p, on_path)| (p, *on_path)));
            assert!(check.holds(1e-6), "{at}: {:?}", check.worst());
        }
    });
}

#[test]
fn projection_moves_the_joints_on_straight_lines() {
    let off_lines = |by: JointMoveBy| {
        let (record, points) = played(&corner(), |e| e.with_joint_moves(by));
        // The cycle in which it comes to rest on the path.
        let left = record.iter().find(|(_, state, _)| *state == HybridState::JointMove(0)).expect("it leaves");
        let mut from = left.0.q;
        let mut worst = 0.0f64;
        for (number, to) in points.iter().enumerate() {
            let along = (to - from).normalize();
            for (p, ..) in record.iter().filter(|(_, state, _)| *state == HybridState::JointMove(number)) {
                let off = p.q - from;
                // The sample that reaches a point belongs to the next one already.
                worst = worst.max((off - along * off.dot(&along)).amax().min(apart(&p.q, to)));
            }
            from = *to;
        }
        worst
    };
    let [straight, curved] = [JointMoveBy::Projection, JointMoveBy::LeastTime].map(off_lines);
    assert!(straight < 1e-12, "{straight} rad off");
    assert!(curved > 1e-3, "joints of equal duration each on its own profile: {curved}");
}

#[test]
fn passing_by_projection_keeps_every_limit() {
    let (passing, _) =
        played(&corner(), |e| e.with_passing(0.1).expect("a distance").with_joint_moves(JointMoveBy::Projection));
    let (stopping, _) = played(&corner(), |e| e.with_joint_moves(JointMoveBy::Projection));
    assert!(passing.len() < stopping.len(), "{} cycles instead of {}", passing.len(), stopping.len());
}

#[test]
fn a_distance_that_is_none_is_refused() {
    let excursion = Excursion::new(&[Joints::<6>::zeros()], LeaveBy::Braking).expect("a point");
    for value in [-0.1, f64::NAN, f64::INFINITY] {
        let refused = excursion.with_passing(value);
        assert!(matches!(refused, Err(HybridError::Within { .. })), "{refused:?}");
    }
}
