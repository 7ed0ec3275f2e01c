"""Targets that change, targets that move, way-points: limits by differences, exact ends, refusals that change nothing."""

import signal

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
    # Reached already: nothing is left to do.
    assert all(rows.shape == (0, 2) for rows in motion.run(7))


def test_run_ends_when_nothing_is_left_to_do():
    assert len(generator().run(100_000)[0]) == 0

    # A target that is left behind with a velocity is reached all the same.
    motion = generator()
    motion.set_target([[0.3, 0.1], [0.2, 0.0]])
    rows = len(motion.run(100_000)[0])
    assert 0 < rows < 5000 and motion.state[1].tolist() == [0.2, 0.0]
    assert len(motion.run(100)[0]) == 0

    motion.set_target([[2.0, 1.0]])
    motion.run(300)
    motion.hold()
    q, qd, qdd, _ = motion.run(100_000)
    assert 0 < len(q) < 2000 and motion.is_underway
    # It ends in the first cycle at rest.
    at_rest = (qd == 0).all(axis=1) & (qdd == 0).all(axis=1)
    assert at_rest[-1] and not at_rest[:-1].any()
    assert len(motion.run(100)[0]) == 0
    # A target set meanwhile waits, too; a stop ends.
    motion.set_target([[2.0, 1.5]])
    assert len(motion.run(100)[0]) == 0
    motion.stop_on_path()
    assert len(motion.run(100)[0]) == 1 and not motion.is_underway
    motion.resume()
    motion.set_target([[2.0, 1.0]])
    assert 300 < len(motion.run(100_000)[0]) < 10_000 and motion.state[0].tolist() == [2.0, 1.0]

    motion = generator()
    motion.set_target([[1.0, 0.5]])
    motion.run(300)
    motion.scale = 0.0
    assert 0 < len(motion.run(100_000)[0]) < 2000 and (motion.state[1:] == 0).all()
    motion.scale = 1.0
    assert len(motion.run(100_000)[0]) < 10_000 and motion.state[0].tolist() == [1.0, 0.5]


def test_run_goes_on_until_a_jog_or_a_stop_has_ended():
    motion = generator()
    motion.jog([0.4, -1.0], 0.5)
    q, qd, qdd, _ = motion.run(100_000)
    assert 500 < len(q) < 2000 and qd[-1].tolist() == [0.0, 0.0] and np.abs(qd).max(axis=0).tolist() == [0.4, 1.0]
    assert len(motion.run(100)[0]) == 0
    # At rest a jog of no velocity lasts as long as it was given, and not for ever.
    motion.jog([0.0, 0.0], 0.05)
    assert 50 <= len(motion.run(100_000)[0]) <= 52
    for stop in ("stop", "stop_on_path"):
        motion.set_target([motion.state[0] + [1.0, -0.5]])
        motion.run(300)
        getattr(motion, stop)()
        q, qd, qdd, _ = motion.run(100_000)
        assert 0 < len(q) < 2000 and (motion.state[1:] == 0).all()
        assert_smooth(q, qd, qdd)
        assert len(motion.run(100)[0]) == 0
    # A target takes the place of a jog.
    motion.jog([0.4, -1.0], 10.0)
    motion.run(100)
    motion.set_target([motion.state[0] + 0.2])
    assert 0 < len(motion.run(100_000)[0]) < 5000
    assert len(motion.run(100)[0]) == 0


def test_run_is_bounded():
    motion = generator()
    for cycles in (-1, 1_000_001):
        with pytest.raises(arcfeed.InputError, match="1000000"):
            motion.run(cycles)
    motion.set_target([[0.1, 0.1]])
    assert len(motion.run(1_000_000)[0]) < 5000
    assert len(generator().run(0)[0]) == 0


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="no timer that gives signals")
def test_a_signal_ends_a_run():
    class Interrupted(Exception):
        pass

    def interrupt(*_):
        raise Interrupted

    motion = generator()
    motion.jog([0.1, 0.1], 1e6)
    before = signal.signal(signal.SIGALRM, interrupt)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.02)
        with pytest.raises(Interrupted):
            motion.run(1_000_000)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    # All cycles would go to 100.
    assert 0 < motion.state[0, 0] < 99 and motion.state[1].tolist() == [0.1, 0.1]


def test_what_is_refused_changes_nothing():
    motion = generator(ranges=[(-1.0, 1.0), (-1.0, 1.0)])
    motion.set_target([[0.5, 0.5]])
    with pytest.raises(arcfeed.PlanError, match="axis 1"):
        motion.set_target([[1.5, 0.0]])
    with pytest.raises(arcfeed.PlanError):
        motion.set_target([[float("nan"), 0.0]])
    for axis in (-1, 2):
        with pytest.raises(arcfeed.InputError, match=f"axis is {axis}: .*0 to 1"):
            motion.set_axis_target(axis, 0.0)
        with pytest.raises(arcfeed.InputError, match=f"axis is {axis}: .*0 to 1"):
            motion.set_axis_limits(axis, 1.0, 1.0, 1.0)
    with pytest.raises(arcfeed.InputError, match="axis 1: .*-1"):
        motion.set_axis_limits(0, 1.0, -1.0, 1.0)
    with pytest.raises(arcfeed.InputError, match="axis 2: .*-1"):
        motion.set_axis_limits(1, -1.0, 1.0, 1.0)
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
    # Before the start it is there, and after the end it stays or goes on with the velocity of the target.
    q, qd, qdd = motion.sample([-1.0, motion.duration + 5.0])
    assert q[0].tolist() == [0.0, 0.0] and q[1] == pytest.approx([1.0, 1.0], abs=1e-9)
    assert np.abs(qd).max() < 1e-9 and (qdd[1] == 0).all()
    passing = arcfeed.way_points([[0.0, 0.0]], points, [[1.0, 1.0], [0.2, 0.0]], *LIMITS)
    q, qd, _ = passing.sample([passing.duration + 5.0])
    assert q[0] == pytest.approx([2.0, 1.0], abs=1e-9) and qd[0] == pytest.approx([0.2, 0.0], abs=1e-9)
    state_to_state = arcfeed.state_to_state([[0.0, 0.0]], [[1.0, 1.0]], *LIMITS)
    for time in (float("nan"), float("inf"), -float("inf")):
        for sampled in (motion, state_to_state):
            with pytest.raises(arcfeed.InputError, match=r"t\[1\] is "):
                sampled.sample([0.0, time])
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
