"""Plans: shapes, limits by differences of the arrays alone, reports, errors with their place."""

import threading

import numpy as np
import pytest

import arcfeed

LINE = arcfeed.Path.nurbs(1, [[0, 0], [0.1, 0]], [0, 0, 1, 1], name="line")


@pytest.fixture(scope="module")
def butterfly():
    return arcfeed.plan(arcfeed.Path.butterfly(), "cr7", compile_rad=1e-6, bound=True)


def test_arrays_belong_together(butterfly):
    n = len(butterfly.t)
    assert butterfly.q.shape == butterfly.qd.shape == butterfly.qdd.shape == butterfly.jerk.shape == (n, 6)
    assert butterfly.position.shape == (n, 3) and butterfly.quaternion.shape == (n, 4)
    assert butterfly.t[0] == 0 and butterfly.t[-1] == butterfly.duration
    assert np.allclose(np.diff(butterfly.t)[:-1], butterfly.period, rtol=0, atol=1e-12)
    assert np.allclose(np.linalg.norm(butterfly.quaternion, axis=1), 1)
    assert len(butterfly.joint_names) == 6


def test_the_tool_is_where_forward_kinematics_puts_it(butterfly):
    poses = arcfeed.Robot("cr7").forward_all(butterfly.q)
    # The job's tool stands on the flange: its place in the flange frame is the same all the way.
    flange_to_tip = np.einsum("nji,nj->ni", poses[:, :3, :3], butterfly.position - poses[:, :3, 3])
    assert np.ptp(flange_to_tip, axis=0).max() < 1e-12


def test_limits_hold_by_differences(butterfly):
    q, dt = butterfly.q, butterfly.period
    velocity = np.diff(q[:-1], axis=0) / dt
    acceleration = np.diff(q[:-1], 2, axis=0) / dt**2
    limits = {(line["name"], line["joint"]): line for line in butterfly.report["limits"]}
    for k in range(6):
        assert np.abs(velocity[:, k]).max() <= limits["joint velocity", k + 1]["limit"] * (1 + 1e-9)
        assert np.abs(acceleration[:, k]).max() <= limits["joint acceleration", k + 1]["limit"] * (1 + 1e-6)
    assert all(line["ratio"] <= 1 + 1e-6 for line in butterfly.report["limits"])
    assert butterfly.report["bound"] is not None


def test_the_law_is_the_motion(butterfly):
    law = butterfly.law
    assert law.shape[1] == 4 and law[0, 0] == 0 and law[-1, 0] == pytest.approx(butterfly.duration, rel=1e-14)
    feed = np.interp(law[:, 0], butterfly.t, butterfly.feed)
    assert np.abs(feed - law[:, 2]).max() < 1e-3


def test_a_compiled_motion_is_the_plan(butterfly):
    compiled = butterfly.compiled
    q, qd, _, _ = compiled.sample(butterfly.t)
    assert np.abs(q - butterfly.q).max() <= compiled.deviation_bound <= 1e-6
    assert np.abs(qd - butterfly.qd).max() < 1e-2
    again = arcfeed.JointTrajectory.from_json(compiled.to_json())
    assert np.array_equal(again.sample(butterfly.t)[0], q) and again.joint_names == butterfly.joint_names
    back = compiled.reversed().sample([0.0, compiled.duration])[0]
    with pytest.raises(arcfeed.InputError, match=r"t\[1\] is NaN"):
        compiled.sample([0.0, float("nan")])
    assert np.abs(back - q[[-1, 0]]).max() < 1e-12
    assert len(compiled.times(0.004)) == int(compiled.duration / 0.004) + 2


def test_paths_from_arrays_are_the_same_as_from_a_file(tmp_path):
    points, knots, weights = [[0, 0], [0.04, 0.06], [0.08, 0]], [0, 0, 0, 1, 1, 1], [1, 2, 1]
    ours = arcfeed.plan(arcfeed.Path.nurbs(2, points, knots, weights))
    file = tmp_path / "arch.json"
    text = '{"units": "m", "degree": 2, "control_points": [[0,0],[0.04,0.06],[0.08,0]], "weights": [1,2,1], "knots": [0,0,0,1,1,1]}'
    file.write_text(text)
    theirs = arcfeed.plan(arcfeed.Path.load(file))
    assert np.array_equal(ours.q, theirs.q)


def test_a_program_of_g_code(tmp_path):
    file = tmp_path / "part.ngc"
    file.write_text("G21 G90 F3000\nG0 X0 Y0\nG1 X40\nG1 Y30\nG4 P0.5\nG1 X0 Y0\n")
    job = arcfeed.Job(path={"blend_mm": 0.2}, feed={"rapid": "joints"})
    motion = arcfeed.plan(arcfeed.Path.load(file, job=job), job=job)
    resting = (motion.qd == 0).all(axis=1)
    assert resting.sum() * motion.period >= 0.5 and motion.report["parts"]


def test_limits_of_a_job_count():
    slow = arcfeed.plan(job=arcfeed.Job(feed={"feed_mm_s": 10}))
    assert slow.feed.max() <= 0.01 * (1 + 1e-9) and slow.duration > 38


def test_every_kind_of_arm():
    for name in ["ur5e", "kr6_r700", "panda"]:
        motion = arcfeed.plan(arcfeed.Path.through([[0, 0], [0.03, 0.02], [0.06, 0]]), name)
        assert motion.q.shape[1] == len(motion.joint_names), name


def test_numbers_of_numpy_are_numbers():
    jerk = np.full(6, 4000.0)
    ours = arcfeed.Job(joints={"jerk_deg_s3": jerk, "velocity_deg_s": None}, feed={"feed_mm_s": np.float32(50)})
    theirs = arcfeed.Job(joints={"jerk_deg_s3": [4000.0] * 6}, feed={"feed_mm_s": 50.0})
    assert arcfeed.plan(LINE, job=ours).duration == arcfeed.plan(LINE, job=theirs).duration
    for value, part in [(float("nan"), "feed.feed_mm_s is nan"), (object(), "feed.feed_mm_s is <object")]:
        with pytest.raises(arcfeed.InputError, match=part):
            arcfeed.Job(feed={"feed_mm_s": value})


def test_errors_have_fields():
    with pytest.raises(arcfeed.InputError, match="feed_mm_sec"):
        arcfeed.Job(feed={"feed_mm_sec": 1})
    with pytest.raises(arcfeed.InputError, match="feed_mm_s"):
        arcfeed.Job(feed={"feed_mm_s": -1})
    with pytest.raises(arcfeed.InputError, match="nosuch"):
        arcfeed.plan(robot="nosuch")
    with pytest.raises(arcfeed.PlanError) as caught:
        arcfeed.plan(arcfeed.Path.through([[0, 0], [0.5, 0.1], [1.5, 0]]))
    assert caught.value.kind == "path" and caught.value.s > 0 and len(caught.value.tool) == 3
    assert isinstance(caught.value, ValueError)
    with pytest.raises(arcfeed.InputError, match="compile_rad"):
        arcfeed.plan(compile_rad=-1.0)
    with pytest.raises(arcfeed.InputError, match="columns"):
        arcfeed.Path.through([[1.0], [2.0]])


def test_planning_frees_the_interpreter():
    job = arcfeed.Job(tolerance={"chord_mm": 0.0001})
    thread = threading.Thread(target=arcfeed.plan, kwargs={"job": job})
    thread.start()
    ticks = 0
    while thread.is_alive():
        thread.join(1e-4)
        ticks += 1
    # With the interpreter held this thread would not run before the plan is done.
    assert ticks > 2


def test_comparison():
    result = arcfeed.compare(arcfeed.Path.through([[0, 0], [0.03, 0.02], [0.06, 0]]))
    assert (result["command"], result["robot"]) == ("compare", "cr7")
    planners = {entry["planner"]: entry for entry in result["entries"]}
    assert planners["jerk-limited"]["duration_s"] > planners["reachability"]["duration_s"]


def test_pictures(butterfly, tmp_path):
    matplotlib = pytest.importorskip("matplotlib")
    pytest.importorskip("matplotlib.pyplot")
    matplotlib.use("pdf")
    file = tmp_path / "motion.png"
    butterfly.plot(file)
    # The caller's backend and figures stay what they were.
    assert matplotlib.get_backend() == "pdf"
    assert not matplotlib.pyplot.get_fignums()
    assert file.stat().st_size > 10_000
