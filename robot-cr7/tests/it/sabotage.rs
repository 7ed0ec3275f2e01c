//! Results that are spoiled on purpose: each must turn a named row of the reproduction to broken.

use robot_cr7::SamplePath;
use robot_cr7::reproduce::Reproduction;
use robot_cr7::reproduce::checker::{SampledAxis, SampledMotion};
use robot_cr7::reproduce::hs::projection::{Table5Run, Table7Run};
use robot_cr7::reproduce::hs::table_1::Section2Run;
use robot_cr7::reproduce::hs::table_3::Table3Run;
use robot_cr7::reproduce::hs::table_4::Table4Run;
use robot_cr7::reproduce::hs::table_6::Table6Run;
use robot_cr7::reproduce::hs::table_8::EventRun;
use robot_cr7::reproduce::pn::competitors::Table2Run;
use robot_cr7::reproduce::pn::counts::CountRun;
use robot_cr7::reproduce::pn::curves::curve_of;
use robot_cr7::reproduce::pn::motion::MotionRun;
use robot_cr7::reproduce::qb::QbRun;

/// A mutation by name, what it does, and the row that it must break.
type Mutation<T> = (&'static str, fn(&mut T), &'static str);

/// Judges `run` as it is, then with each mutation. Every row that counts is broken by some mutation.
fn sabotage<T: Clone>(run: &T, judge: impl Fn(&T, &mut Reproduction), mutations: &[Mutation<T>]) {
    let judged = |run: &T| {
        let mut r = Reproduction::new("spoiled");
        judge(run, &mut r);
        r
    };
    let sound = judged(run);
    assert_eq!(sound.broken().count(), 0, "{sound}");
    let counts = sound.claims.iter().filter(|c| c.holds.is_some());
    let mut never: Vec<&str> = counts.map(|c| c.what.as_str()).collect();
    for (name, mutate, row) in mutations {
        let mut spoiled = run.clone();
        mutate(&mut spoiled);
        let r = judged(&spoiled);
        let broken: Vec<&str> = r.broken().map(|c| c.what.as_str()).collect();
        never.retain(|what| !broken.contains(what));
        assert!(broken.iter().any(|what| what.contains(row)), "{name} should break \"{row}\", breaks {broken:?}");
    }
    assert!(never.is_empty(), "no mutation breaks {never:?}");
}

/// Samples of `values` as they were one cycle before.
fn stale(values: &mut Vec<f64>) {
    values.insert(0, values[0]);
    values.pop();
}

fn halved(axis: &mut SampledAxis) {
    axis.p.iter_mut().for_each(|p| *p *= 0.5);
}

/// Index of the sample with the largest value.
fn peak(values: &[f64]) -> usize {
    (0..values.len()).max_by(|&i, &j| values[i].total_cmp(&values[j])).unwrap_or(0)
}

/// All positions from sample `from` on are moved, so that the mean velocity of one cycle is 2 %
/// above the limit while every sampled velocity stays.
fn over_between_samples(motion: &mut SampledMotion, axis: usize, from: usize, limit: f64) {
    let step = 0.02 * limit * (motion.t[from + 1] - motion.t[from]);
    motion.axes[axis].p[from + 1..].iter_mut().for_each(|p| *p += step);
}

/// Breaks every rule of the checker at once; table 3 breaks them one by one.
fn wreck(motion: &mut SampledMotion) {
    let (last, middle) = (motion.t.len() - 1, motion.t.len() / 2);
    motion.t[1] = motion.t[0];
    motion.t[last] += 0.01;
    motion.arrived = motion.arrived.map(|_| false);
    for axis in &mut motion.axes {
        axis.p[0] += 1.0;
        axis.p[last] += 1.0;
        axis.v[middle] += 1e3;
        axis.a[middle] += 1e6;
    }
}

#[test]
fn table_3_of_hs() {
    let run = Table3Run::measure().expect("the numbers of the table");
    let mutations: [Mutation<Table3Run>; 12] = [
        ("positions halved", |r| halved(&mut r.motion.axes[0]), "position from velocity"),
        ("positions halved", |r| halved(&mut r.motion.axes[0]), "error at the end"),
        (
            "a jump in the last cycle",
            |r| *r.motion.axes[0].p.last_mut().expect("a sample") += 1e-6,
            "position from velocity",
        ),
        ("stale velocity", |r| stale(&mut r.motion.axes[0].v), "velocity from acceleration"),
        ("stale acceleration", |r| stale(&mut r.motion.axes[0].a), "velocity from acceleration"),
        ("a moment twice", |r| r.motion.t[100] = r.motion.t[99], "shortest step of time"),
        ("no arrival", |r| r.motion.arrived = Some(false), "arrives"),
        (
            "2 % over the velocity limit between samples",
            |r| {
                let at = peak(&r.motion.axes[0].v);
                over_between_samples(&mut r.motion, 0, at, 30.0);
            },
            "velocity / limit",
        ),
        (
            "2 % over the acceleration limit",
            |r| {
                let at = peak(&r.motion.axes[0].a);
                r.motion.axes[0].a[at] *= 1.02;
            },
            "acceleration / limit",
        ),
        ("jerk above its limit in one cycle", |r| r.motion.axes[0].a[200] += 0.05, "jerk / limit"),
        (
            "wrong sign of the end velocity",
            |r| *r.motion.axes[0].v.last_mut().expect("a sample") *= -1.0,
            "error at the end",
        ),
        ("another start", |r| r.motion.axes[0].p[0] += 1e-6, "error at the start"),
    ];
    sabotage(&run, Table3Run::judge, &mutations);
}

#[test]
fn table_4_of_hs() {
    let run = Table4Run::measure().expect("the numbers of the table");
    let mutations: [Mutation<Table4Run>; 8] = [
        (
            "motion scaled by 0.5",
            |r| {
                r.together.axes.iter_mut().for_each(|a| {
                    for x in a.p.iter_mut().chain(&mut a.v).chain(&mut a.a) {
                        *x *= 0.5;
                    }
                })
            },
            "all joints together: error at the end",
        ),
        (
            "one joint late",
            |r| {
                let axis = &mut r.together.axes[2];
                [&mut axis.p, &mut axis.v, &mut axis.a].into_iter().for_each(stale);
            },
            "all joints together: error at the end",
        ),
        ("0.1 % slower", |r| r.alone[4].t.iter_mut().for_each(|t| *t *= 1.001), "joint 5 alone: duration"),
        (
            "sections swapped",
            |r| {
                let first = r.together.axes[0].p.clone();
                r.together.axes[0].p = std::mem::replace(&mut r.together.axes[1].p, first);
            },
            "all joints together: error at the start",
        ),
        (
            "wrong sign of the acceleration",
            |r| r.alone[1].axes[0].a.iter_mut().for_each(|a| *a = -*a),
            "joint 2 alone: velocity from acceleration",
        ),
        ("a value that is no number", |r| r.alone[5].axes[0].v[7] = f64::NAN, "joint 6 alone: velocity / limit"),
        ("every rule broken, together", |r| wreck(&mut r.together), "all joints together: velocity / limit"),
        ("every rule broken, alone", |r| r.alone.iter_mut().for_each(wreck), "joint 3 alone: jerk / limit"),
    ];
    sabotage(&run, Table4Run::judge, &mutations);
}

#[test]
fn tables_5_and_7_of_hs() {
    let run = Table5Run::measure().expect("the numbers of the table");
    let mutations: [Mutation<Table5Run>; 8] = [
        (
            "a bend beside the line",
            |r| {
                let (t, axis) = (&r.joints.motion.t, &mut r.joints.motion.axes[1]);
                axis.p.iter_mut().zip(t).for_each(|(p, t)| *p += 1e-7 * t.sin());
            },
            "joints: off the straight line",
        ),
        ("positions halved", |r| r.joints.motion.axes.iter_mut().for_each(halved), "joints: position from velocity"),
        ("tool beside its line", |r| r.points[300][2] += 1e-9, "tool: off the straight line"),
        ("tool tilted", |r| r.orientations[300][1] += 1e-6, "tool: off the plane of its rotation"),
        (
            "wrong branch of the rotation",
            |r| r.tool.axes[1].p.iter_mut().for_each(|p| *p = std::f64::consts::TAU - *p),
            "tool, way and angle: error at the start",
        ),
        ("stale angular velocity", |r| stale(&mut r.tool.axes[1].v), "tool, way and angle: velocity from acceleration"),
        ("every rule broken, joints", |r| wreck(&mut r.joints.motion), "joints: velocity / limit"),
        ("every rule broken, tool", |r| wreck(&mut r.tool), "tool, way and angle: jerk / limit"),
    ];
    sabotage(&run, Table5Run::judge, &mutations);
    let run = Table7Run::measure().expect("the numbers of the table");
    let mutations: [Mutation<Table7Run>; 4] = [
        (
            "one joint late",
            |r| {
                let axis = &mut r.joints.motion.axes[3];
                [&mut axis.p, &mut axis.v].into_iter().for_each(stale);
            },
            "joints: velocity from acceleration",
        ),
        (
            "acceleration of joint 2 out of its limit for longer",
            |r| r.joints.motion.axes[1].a[14] = -12.2,
            "joints: acceleration / limit",
        ),
        (
            "last target missed",
            |r| r.joints.motion.axes[5].p.iter_mut().for_each(|p| *p -= 1.0),
            "joints: error at the end",
        ),
        ("every rule broken", |r| wreck(&mut r.joints.motion), "joints: velocity / limit"),
    ];
    sabotage(&run, Table7Run::judge, &mutations);
}

#[test]
fn table_6_of_hs() {
    let run = Table6Run::measure().expect("an embedded scenario");
    let mutations: [Mutation<Table6Run>; 8] = [
        (
            "sections swapped",
            |r| {
                let (a, b) = (r.sections[0].clone(), r.sections[1].clone());
                (r.sections[0].from, r.sections[0].to) = (b.from, b.to);
                (r.sections[1].from, r.sections[1].to) = (a.from, a.to);
            },
            "highest feed, segments 20-45",
        ),
        ("tool beside the curve", |r| r.cycles[9000].tool[1] += 1e-9, "tool off the curve"),
        (
            "2 % over the feed in one cycle",
            |r| {
                let inside = |s: f64| (r.sections[1].from..r.sections[1].to).contains(&s);
                let at = (0..r.cycles.len()).rev().find(|&i| inside(r.cycles[i].s)).expect("a cycle") - 1000;
                let (a, b) = (r.cycles[at].tool, r.cycles[at + 1].tool);
                r.cycles[at + 1].tool = std::array::from_fn(|k| b[k] + 0.02 * (b[k] - a[k]));
            },
            "highest feed, segments 50-60",
        ),
        (
            "every second break dropped",
            |r| r.breaks = r.breaks.iter().copied().step_by(2).collect(),
            "largest chord error of a segment",
        ),
        ("positions halved", |r| halved(&mut r.motion.axes[0]), "path: position from velocity"),
        ("every rule broken", |r| wreck(&mut r.motion), "path: velocity / limit"),
        ("a tenth faster", |r| r.motion.t.iter_mut().for_each(|t| *t *= 0.9), "highest feed elsewhere"),
        (
            "one cycle of 400",
            |r| {
                r.cycles = r.cycles.iter().copied().step_by(400).collect();
                r.motion.t = r.motion.t.iter().copied().step_by(400).collect();
            },
            "chord error of a cycle",
        ),
    ];
    sabotage(&run, Table6Run::judge, &mutations);
}

#[test]
fn table_8_of_hs() {
    let mut runs = EventRun::measure().expect("embedded scenarios");
    let (middle, run) = (runs.remove(1), runs.remove(0));
    let passing: [Mutation<EventRun>; 3] = [
        ("point 3 missed", |r| r.joints.axes[2].p.iter_mut().for_each(|p| *p += 0.3), "passes point 3"),
        (
            "a stop near point 3",
            |r| r.joints.axes.iter_mut().for_each(|axis| axis.v.iter_mut().for_each(|v| *v *= 0.01)),
            "passes point 3",
        ),
        ("1 mm beside point 2", |r| r.tool.iter_mut().for_each(|p| p[0] += 1e-3), "stops at point 2"),
    ];
    let stopping: [Mutation<EventRun>; 1] =
        [("point 3 missed", |r| r.joints.axes[2].p.iter_mut().for_each(|p| *p += 1e-6), "reaches point 3")];
    let both: [Mutation<EventRun>; 6] = [
        (
            "wrong branch of joint 6",
            |r| r.joints.axes[5].p.iter_mut().for_each(|p| *p += std::f64::consts::TAU),
            "joints: error at the start",
        ),
        (
            "the way in the wrong order",
            |r| {
                let out = r.states.iter().position(|&s| s == "returning").expect("it comes back");
                for axis in &mut r.joints.axes {
                    axis.p[..out].reverse();
                }
            },
            "point 3, then point 4",
        ),
        ("tool beside its line", |r| r.tool[500][2] += 1e-6, "tool off the line"),
        (
            "a jump in the last cycle",
            |r| *r.joints.axes[0].p.last_mut().expect("a sample") += 1e-4,
            "joints: position from velocity",
        ),
        ("every rule broken", |r| wreck(&mut r.joints), "joints: velocity / limit"),
        ("point 4 missed", |r| r.joints.axes[3].p.iter_mut().for_each(|p| *p += 1e-6), "reaches point 4"),
    ];
    sabotage(&run, EventRun::judge, &[&passing[..], &both].concat());
    sabotage(&middle, EventRun::judge, &[&stopping[..], &both].concat());
}

#[test]
fn counts_of_pn_and_control_points() {
    let method = arcfeed_geometry::SegmentationMethod::CType;
    let run = CountRun::measure("butterfly", SamplePath::Butterfly, method, 1e-6).expect("an embedded curve");
    let mutations: [Mutation<CountRun>; 4] = [
        (
            "tolerance / 100",
            |r| {
                let curve = curve_of(SamplePath::Butterfly).expect("an embedded curve");
                r.breaks = curve.segment(r.method, 0.01 * r.tolerance).expect("can be cut").breaks().to_vec();
            },
            "count",
        ),
        (
            "one break in a hundred too much",
            |r| {
                let more = r.breaks.windows(2).step_by(100).map(|w| 0.5 * (w[0] + w[1])).collect::<Vec<_>>();
                r.breaks.extend(more);
                r.breaks.sort_by(f64::total_cmp);
            },
            "count",
        ),
        ("every second break dropped", |r| r.breaks = r.breaks.iter().copied().step_by(2).collect(), "chord error"),
        ("last piece missing", |r| _ = r.breaks.pop(), "chord error"),
    ];
    sabotage(&run, |run, r| run.judge(r, "counts", "1579"), &mutations);
    let run = Section2Run::measure().expect("an embedded curve");
    let mutations: [Mutation<Section2Run>; 7] = [
        ("a control point moved", |r| r.table.points[1][2][0] += 1e-3, "Bezier 2, point 3"),
        ("pieces swapped", |r| r.table.points.swap(0, 1), "control points beside the polar form"),
        ("a control point moved by 1e-6 mm", |r| r.table.points[3][1][1] += 1e-6, "pieces by de Casteljau"),
        (
            "all control points moved",
            |r| {
                for p in r.table.points.iter_mut().flatten() {
                    *p = p.map(|x| x + 1.0);
                }
            },
            "Bezier 4, point 4",
        ),
        (
            "not cut at all",
            |r| r.hull.breaks = vec![r.hull.breaks[0], r.hull.breaks[r.hull.breaks.len() - 1]],
            "below X.D. in chord error",
        ),
        ("W.L. cut as finely as ours", |r| r.others[2] = r.hull.breaks.clone(), "below W.L. in chord error"),
        ("ours cut as M.L.", |r| r.hull.breaks = r.others[0].clone(), "below M.L. in chord error"),
    ];
    sabotage(&run, Section2Run::judge, &mutations);
}

#[test]
fn table_2_and_the_motion_of_pn() {
    let (motion, table) = MotionRun::measure().expect("an embedded curve");
    let mutations: [Mutation<Table2Run>; 5] = [
        (
            "the end of the curve missed",
            |r| *r.methods[5].parameters.last_mut().expect("a cycle") -= 0.003,
            "ours ends on the end",
        ),
        (
            "one cycle late",
            |r| {
                let last = r.methods[5].parameters.len() - 1;
                r.methods[5].parameters.copy_within(..last, 1);
            },
            "error of arc length on the way",
        ),
        ("wrong way in one cycle", |r| r.methods[5].parameters[4000] += 1e-9, "error of the way of one cycle"),
        ("open loop", |r| r.methods[5].breaks = r.methods[1].breaks.clone(), "ours keeps the chord tolerance"),
        ("arc length missing", |r| *r.methods[5].asked.last_mut().expect("a cycle") += 1e-9, "truncation error"),
    ];
    sabotage(&table, Table2Run::judge, &mutations);
    let mutations: [Mutation<MotionRun>; 6] = [
        ("positions halved", |r| halved(&mut r.path.axes[0]), "path: position from velocity"),
        ("one joint late", |r| stale(&mut r.joints.axes[2].p), "joints: position from velocity"),
        ("tool beside the curve", |r| r.tool[3000][0] += 1e-9, "tool off the curve"),
        ("every second break dropped", |r| r.breaks = r.breaks.iter().copied().step_by(2).collect(), "chord error"),
        ("every rule broken, path", |r| wreck(&mut r.path), "path: velocity / limit"),
        ("every rule broken, joints", |r| wreck(&mut r.joints), "joints: jerk / limit"),
    ];
    sabotage(&motion, MotionRun::judge, &mutations);
}

#[test]
fn motions_of_qb() {
    let run = QbRun::measure().expect("the embedded data");
    let mutations: [Mutation<QbRun>; 17] = [
        ("2 % faster", |r| r.pure.period *= 0.98, "without torque: velocity by differences"),
        ("a jump of 1e-6 rad", |r| r.pure.q[40][4] += 1e-6, "without torque: acceleration by differences"),
        ("2 % faster under torque limits", |r| r.composite.period *= 0.98, "composite: torque by Lagrange"),
        ("jerk in one sample", |r| r.jerk.q[700][1] += 1e-7, "composite with jerk: jerk by differences"),
        (
            "wrong sign of a joint",
            |r| r.composite.q.iter_mut().for_each(|q| q[0] = -q[0]),
            "composite: tool off the printed start",
        ),
        ("ends early", |r| r.composite.q.truncate(4000), "composite: tool off the printed goal"),
        (
            "wrong branch of joint 4",
            |r| r.pure.q.iter_mut().for_each(|q| q[3] += std::f64::consts::PI),
            "without torque: tool off the printed start",
        ),
        ("the way back", |r| r.pure.s.reverse(), "without torque: cycles that go back"),
        (
            "half angles for whole ones",
            |r| r.pure.s.iter_mut().for_each(|s| *s *= 0.5),
            "velocity of joint 5 binds from",
        ),
        ("scan 1 % too slow", |r| r.speeds[1].iter_mut().for_each(|v| *v *= 0.99), "Appendix A by a second program"),
        (
            "a tenth faster",
            |r| {
                for run in [&mut r.pure, &mut r.pure_torque, &mut r.composite, &mut r.jerk] {
                    run.period *= 0.9;
                }
            },
            "composite with jerk: acceleration by differences",
        ),
        (
            "the way back, in another place",
            |r| {
                for run in [&mut r.pure, &mut r.pure_torque, &mut r.composite, &mut r.jerk] {
                    run.s.reverse();
                    run.q.iter_mut().for_each(|q| q[0] += 0.1);
                }
            },
            "with torque: tool off its line",
        ),
        (
            "integration 1 % too slow",
            |r| r.integration.iter_mut().flat_map(|run| &mut run.x).for_each(|x| *x *= 0.98),
            "duration by numerical integration",
        ),
        ("load lowered at half the speed", |r| r.completeness.by_hand.period *= 2.0, "a motion by hand: force"),
        ("the same by reachability", |r| r.completeness.reachability.period *= 2.0, "reachability: force"),
        ("a scan that is complete", |r| r.completeness.refused_at = None, "the scan of the paper finds"),
        (
            "both scans 1 % too slow",
            |r| r.speeds.iter_mut().flatten().for_each(|v| *v *= 0.99),
            "Appendix A by a second program",
        ),
    ];
    sabotage(&run, QbRun::judge, &mutations);
}
