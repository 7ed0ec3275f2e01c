"""Rows, speed laws of one's own, motions between states."""

import numpy as np
import pytest

import arcfeed

LINE = arcfeed.Path.nurbs(1, [[0, 0], [0.1, 0]], [0, 0, 1, 1], name="line")


def test_the_planned_law_passes_and_a_faster_one_fails():
    motion = arcfeed.plan(LINE)
    problem = arcfeed.problem(LINE)
    s, v = motion.s, motion.feed
    assert problem.verify(s, v)["duration"] == pytest.approx(motion.duration, rel=1e-3)
    assert problem.verify(s, 0.9 * v)["holds"]
    fast = problem.verify(s, 1.3 * v)
    assert not fast["holds"]
    worst = max(fast["limits"], key=lambda line: line["ratio"])
    assert worst["ratio"] > 1.2


@pytest.mark.parametrize("jerk, holds", [(0.1, True), (2.0, False)])
def test_phases(jerk, holds):
    problem = arcfeed.problem(LINE)
    # Up and down in four equal phases over 0.1 m: 2 j T^3 = 0.1 m, and the greatest speed is j T^2.
    duration = (0.1 / (2 * jerk)) ** (1 / 3)
    check = problem.verify_phases([(jerk, duration), (-jerk, 2 * duration), (jerk, duration)])
    assert check["duration"] == pytest.approx(4 * duration) and check["holds"] == holds
    feed = next(line for line in check["limits"] if line["name"] == "feed")
    assert feed["ratio"] == pytest.approx(jerk * duration**2 / 0.1, rel=1e-4)
    with pytest.raises(arcfeed.ArcfeedError):
        problem.verify([0, 0.05], [0, 0.01])


def test_the_planned_law_keeps_the_rows():
    path = arcfeed.Path.butterfly()
    motion, problem = arcfeed.plan(path), arcfeed.problem(path)
    rows = problem.rows
    assert len(rows["a"]) == len(rows["source"]) == len(rows["at"])
    s = problem.s[rows["at"]]
    inside = (s > 1e-3) & (s < s.max() - 1e-3)
    law = motion.law
    v = np.interp(s, law[:, 1], law[:, 2])
    u = np.interp(s, law[:, 1], law[:, 3])
    value = rows["a"] * u + rows["b"] * v**2 + rows["c"] * v + rows["d"]
    scale = np.abs(rows["hi"])
    excess = np.maximum(value - rows["hi"], rows["lo"] - value) / scale
    assert excess[inside].max() < 0.02
    assert (v**2 <= problem.cap[rows["at"]] * 1.02 + 1e-9).all()


def test_state_to_state_takes_the_closed_form():
    # Rest to rest over 1 m, jerk 8: four phases of T with 2 j T^3 = 1.
    motion = arcfeed.state_to_state([[0.0]], [[1.0]], [10.0], [100.0], [8.0])
    assert motion.duration == pytest.approx(4 * (1 / 16) ** (1 / 3), rel=1e-14)
    q, qd, qdd = motion.sample(np.array([0.0, motion.duration / 2, motion.duration]))
    assert q[:, 0] == pytest.approx([0.0, 0.5, 1.0]) and qd[[0, 2], 0] == pytest.approx([0, 0], abs=1e-12)
    assert qdd[1, 0] == pytest.approx(0, abs=1e-9)


def test_axes_arrive_together_within_their_limits():
    v, a, j = [1.0, 0.5, 2.0], [5.0, 2.0, 8.0], [50.0, 20.0, 80.0]
    motion = arcfeed.state_to_state([[0, 0, 0], [0.3, -0.2, 0.1]], [[1, -0.5, 0.1]], v, a, j)
    t = np.linspace(0, motion.duration, 20001)
    q, qd, qdd = motion.sample(t)
    assert np.abs(q[-1] - [1, -0.5, 0.1]).max() < 1e-12
    assert (np.abs(qd).max(axis=0) <= np.array(v) * (1 + 1e-12)).all()
    assert (np.abs(qdd).max(axis=0) <= np.array(a) * (1 + 1e-12)).all()
    assert (np.abs(np.diff(qdd, axis=0)).max(axis=0) / t[1] <= np.array(j) * (1 + 1e-6)).all()
    with pytest.raises(arcfeed.InputError, match="jerk"):
        arcfeed.state_to_state([[0.0]], [[1.0]], [1.0], [1.0], [1.0, 2.0])
