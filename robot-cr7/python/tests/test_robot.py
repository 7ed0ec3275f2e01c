"""Arms: kinematics and dynamics against each other and against differences."""

import numpy as np
import pytest

import arcfeed


@pytest.mark.parametrize("name", arcfeed.robots())
def test_kinematics_agree(name):
    arm = arcfeed.Robot(name)
    n = len(arm.joint_names)
    random = np.random.default_rng(20260101)
    for _ in range(5):
        q = random.uniform(-1, 1, n) + np.clip(arm.range, -1.5, 1.5).mean(axis=0)
        pose = arm.forward(q)
        jacobian = arm.jacobian(q)
        h = 1e-6
        for k in range(n):
            step = np.eye(n)[k] * h
            ahead, behind = arm.forward(q + step), arm.forward(q - step)
            linear = (ahead[:3, 3] - behind[:3, 3]) / (2 * h)
            skew = (ahead[:3, :3] - behind[:3, :3]) @ pose[:3, :3].T / (2 * h)
            angular = np.array([skew[2, 1], skew[0, 2], skew[1, 0]])
            assert np.abs(jacobian[:, k] - np.concatenate([linear, angular])).max() < 1e-7
        if n >= 6:
            again = arm.inverse(pose, q + 0.01)
            assert np.abs(arm.forward(again) - pose).max() < 1e-9


def test_all_solutions_have_the_pose():
    arm = arcfeed.Robot("ur5e")
    pose = arm.forward([0.3, -1.2, 1.4, -0.8, -1.5, 0.2])
    solutions, complete = arm.inverse_all(pose)
    assert complete and len(solutions) == 8
    assert max(np.abs(arm.forward(q) - pose).max() for q in solutions) < 1e-10


def test_urdf_and_tool(tmp_path):
    built_in = arcfeed.Robot("kr6_r700")
    file = tmp_path / "arm.urdf"
    file.write_text(built_in.to_urdf())
    arm = arcfeed.Robot(str(file))
    q = [0.1, -1.0, 1.2, 0.4, 0.5, -0.3]
    assert np.abs(arm.forward(q) - built_in.forward(q)).max() < 1e-12
    tool = np.eye(4)
    tool[2, 3] = 0.1
    assert np.allclose(arm.with_tool(tool).forward(q), arm.forward(q) @ tool, atol=1e-12)


def test_torque_is_linear_in_the_acceleration():
    arm = arcfeed.Robot("panda")
    q = [0.1, -0.5, 0.2, -1.8, 0.1, 1.5, 0.4]
    still = np.zeros(7)
    hold = arm.torque(q, still, still)
    columns = np.column_stack([arm.torque(q, still, e) - hold for e in np.eye(7)])
    assert np.abs(columns - columns.T).max() < 1e-9 and np.linalg.eigvalsh(columns).min() > 0


def test_what_is_wrong_is_told():
    with pytest.raises(arcfeed.InputError, match="6"):
        arcfeed.Robot("cr7").forward([0.0, 0.0])
    with pytest.raises(arcfeed.InputError, match="rotation"):
        arcfeed.Robot("cr7").inverse_all(2 * np.eye(4))
    with pytest.raises(arcfeed.InputError):
        arcfeed.Robot("cr7").forward([float("nan")] * 6)
