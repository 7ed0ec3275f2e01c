"""Targets that change, targets that move, way-points: limits by differences, exact ends, refusals that change nothing."""

import numpy as np
import pytest

import arcfeed

LIMITS = [1.0, 2.0], [5.0, 8.0], [50.0, 100.0]
CYCLE = 1e-3


def generator(**keywords):
    return arcfeed.OnlineGenerator([[0.0, 0.0]], *LIMITS, CYCLE, **keywords)


def assert_smooth(q, qd, qdd, limits=LIMITS, cycle=CYCLE):
    """Mean rates of the cycles keep the limits, and every value follows from those before."""
    velocity, acceleration, jerk = (np.array(values) * (1 + 1e-9) + 1e-9 for values in limits)
    assert (np.abs(np.diff(q, axis=0)) <= velocity * cycle).all()
    assert (np.abs(np.diff(qd, axis=0)) <= acceleration * cycle).all()
    assert (np.abs(np.diff(qdd, axis=0)) <= jerk * cycle).all()
    assert (np.abs(q[1:] - q[:-1] - qd[:-1] * cycle) <= acceleration * cycle**2 / 2).all()


def test_a_target_that_changes_on_the_way_is_reached_exactly():
    motion = generator()
    motion.set_target([[0.5, -0.2]])
    rows = [motion.step() for _ in range(300)]
    assert rows[0].replanned and motion.is_underway and motion.time_left > 0
    motion.set_axis_target(1, 0.1, velocity=0.05)
    motion.set_axis_limits(0, 0.5, 5.0, 50.0)
    while not rows[-1].reached:
        rows.append(motion.step())
        assert len(rows) < 5000
    q, qd, qdd = (np.array([getattr(row, name) for row in rows]) for name in ("q", "qd", "qdd"))
    assert_smooth(q, qd, qdd)
    assert q[-1].tolist() == [0.5, 0.1] and qd[-1].tolist() == [0.0, 0.05] and qdd[-1].tolist() == [0.0, 0.0]
    assert rows[-1].arrived == [True, True] and motion.target.tolist() == [[0.5, 0.1], [0.0, 0.05], [0.0, 0.0]]
    assert np.array_equal(motion.state, [q[-1], qd[-1], qdd[-1]])


def test_it_takes_as_long_as_the_motion_between_the_states():
    shortest = arcfeed.state_to_state([[0.0, 0.0]], [[0.7, -0.4]], *LIMITS).duration
    motion = generator()
    motion.set_target([[0.7, -0.4]])
    q, qd, qdd, jerk = motion.run(100_000)
    assert shortest <= len(q) * CYCLE <= shortest + CYCLE * (1 + 1e-9)
    assert q.shape == qd.shape == qdd.shape == jerk.shape and q[-1].tolist() == [0.7, -0.4]
    assert_smooth(q, qd, qdd)
    # Reached already: one cycle at rest does not last for ever.
    assert len(motion.run(7)[0]) <= 7


def test_what_is_refused_changes_nothing():
    motion = generator(ranges=[(-1.0, 1.0), (-1.0, 1.0)])
    motion.set_target([[0.5, 0.5]])
    with pytest.raises(arcfeed.PlanError, match="axis 1"):
        motion.set_target([[1.5, 0.0]])
    with pytest.raises(arcfeed.PlanError):
        motion.set_target([[float("nan"), 0.0]])
    with pytest.raises(arcfeed.PlanError, match="axis 3"):
        motion.set_axis_target(2, 0.0)
    with pytest.raises(arcfeed.InputError, match="2"):
        motion.set_target([[0.0, 0.0, 0.0]])
    with pytest.raises(arcfeed.InputError):
        motion.set_limits([1.0], [1.0], [1.0])
    with pytest.raises(arcfeed.InputError):
        arcfeed.OnlineGenerator([[0.0]], [1.0], [1.0], [-1.0], CYCLE)
    with pytest.raises(arcfeed.InputError):
        arcfeed.OnlineGenerator([[0.0]], [1.0], [1.0], [1.0], 0.0)
    with pytest.raises(arcfeed.InputError, match="1 to 10"):
        arcfeed.OnlineGenerator([[0.0] * 11], *[[1.0] * 11] * 3, CYCLE)
    with pytest.raises(arcfeed.PlanError):
        motion.scale = 2.0
    assert motion.run(100_000)[0][-1].tolist() == [0.5, 0.5]


def test_jog_hold_scale_and_stop():
    motion = generator()
    for _ in range(500):
        motion.jog([0.4, -1.0], 0.05)
        step = motion.step()
    assert step.qd.tolist() == [0.4, -1.0]
    # No call any more: it stops by itself.
    q, qd, qdd, _ = motion.run(5000)
    assert_smooth(q, qd, qdd)
    assert (motion.state[1:] == 0).all()

    motion.set_target([[3.0, 3.0]])
    motion.scale = 0.5
    q, qd, _, _ = motion.run(800)
    assert motion.scale == 0.5 and np.abs(qd).max() <= 1.0 + 1e-9
    motion.hold()
    motion.run(1000)
    assert motion.is_held and motion.scale == 0 and (motion.state[1:] == 0).all()
    motion.resume()
    motion.run(100)
    motion.stop()
    q, qd, qdd, _ = motion.run(5000)
    assert_smooth(q, qd, qdd)
    assert np.array_equal(motion.state, motion.target) and motion.state[0, 0] < 3.0


def test_a_place_on_a_conveyor_is_followed_exactly():
    tracking = arcfeed.TrackingGenerator([[0.0, 0.0]], *LIMITS, CYCLE)
    rows = []
    for i in range(1, 1000):
        target = [[0.1 + 0.5e-3 * i, 0.2], [0.5, 0.0]]
        rows.append(tracking.step(target))
        if rows[-1].following:
            break
    assert rows[0].status == ["approaching", "approaching"] and rows[-1].status == ["following", "following"]
    assert rows[-1].q.tolist() == target[0] and rows[-1].qd.tolist() == target[1]
    assert_smooth(*(np.array([getattr(row, name) for row in rows]) for name in ("q", "qd", "qdd")))
    assert np.array_equal(tracking.state[0], rows[-1].q)
    with pytest.raises(arcfeed.PlanError, match="axis 2"):
        tracking.step([[0.0, float("inf")]])
    assert np.array_equal(tracking.state[0], rows[-1].q)


def test_way_points_are_passed_in_time_and_without_a_stop():
    points = np.array([[0.4, 0.1], [0.8, 0.5], [0.9, 0.2]])
    motion = arcfeed.way_points([[0.0, 0.0]], points, [[1.0, 1.0]], *LIMITS)
    q, qd, _ = motion.sample(motion.times)
    assert np.abs(q - points).max() < 1e-9 and np.abs(qd).min(axis=0).max() > 0.1
    t = np.append(np.arange(0, motion.duration, CYCLE), motion.duration)
    q, qd, qdd = motion.sample(t)
    assert_smooth(q[:-1], qd[:-1], qdd[:-1])
    assert q[-1] == pytest.approx([1.0, 1.0], abs=1e-9) and qd[-1] == pytest.approx([0, 0], abs=1e-9)
    # With a stop in every point it takes longer.
    corners = [[0.0, 0.0], *points.tolist(), [1.0, 1.0]]
    stops = sum(arcfeed.state_to_state([a], [b], *LIMITS).duration for a, b in zip(corners, corners[1:]))
    assert motion.duration < 0.8 * stops

    free = float("nan")
    slow = arcfeed.way_points(
        [[0.0, 0.0]], points, [[1.0, 1.0]], *LIMITS, passing=[[0.1, free], [free, free], [free, -0.2]]
    )
    _, qd, _ = slow.sample(slow.times)
    assert qd[0, 0] == pytest.approx(0.1, abs=1e-9) and qd[2, 1] == pytest.approx(-0.2, abs=1e-9)
    assert slow.duration > motion.duration
    with pytest.raises(arcfeed.PlanError, match="way-point 2, axis 1"):
        arcfeed.way_points([[0.0, 0.0]], [[0.1, 0.1], [float("inf"), 0.0]], [[1.0, 1.0]], *LIMITS)
    with pytest.raises(arcfeed.InputError, match="columns"):
        arcfeed.way_points([[0.0, 0.0]], [[0.1, 0.1, 0.1]], [[1.0, 1.0]], *LIMITS)
