"""Reads what `cr7 plan --format ros2,mcap --out FOLDER` wrote, by readers of others, and holds it by trajectory.csv and report.json.

python ros2.py FOLDER; needs numpy, pyyaml, mcap-ros2-support, rosbags. Ends with exit code 1 at the first thing that is off.
"""

import csv
import json
import sys
from pathlib import Path

import numpy as np
import yaml
from mcap_ros2.reader import read_ros2_messages
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore

# Most that a value may exceed its limit through rounding, as everywhere in the project.
ROUNDING = 1e-6

folder = Path(sys.argv[1])
tolerance = float(sys.argv[2]) if len(sys.argv) > 2 else 1e-6


def check(what, value, limit):
    print(f"{what}: {value:.3e}, at most {limit:.3e}")
    if not value <= limit:
        sys.exit(f"{what} is off")


with open(folder / "trajectory.csv") as file:
    rows = list(csv.DictReader(file))
table = {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}
joints = sum(name.startswith("q") and name[1].isdigit() for name in table)
q = np.column_stack([next(table[n] for n in table if n.startswith(f"q{k + 1}_")) for k in range(joints)])
qd = np.column_stack([next(table[n] for n in table if n.startswith(f"qd{k + 1}_")) for k in range(joints)])
t = table["t_s"]
tool = np.column_stack([table[n] for n in ("x_m", "y_m", "z_m")])

# The message as YAML, and the same as JSON.
message = yaml.safe_load((folder / "ros2_trajectory.yaml").read_text())
as_json = json.loads((folder / "ros2_trajectory.json").read_text())
stamps = [p["time_from_start"]["sec"] * 10**9 + p["time_from_start"]["nanosec"] for p in message["points"]]
fields = ["positions", "velocities", "accelerations"]
points = [np.array([p[key] for p in message["points"]]) for key in fields]
assert all(isinstance(v, float) for p in message["points"] for key in fields for v in p[key])
assert as_json["joint_names"] == message["joint_names"] and len(message["joint_names"]) == joints
for ours, key in zip(points, fields):
    assert np.array_equal(ours, [p[key] for p in as_json["points"]])
assert stamps[0] == 0 and all(np.diff(stamps) > 0)

# What a controller makes of it: quintics by position, velocity and acceleration at both ends.
knots = np.array(stamps) * 1e-9
h = np.diff(knots)[:, None]
(p0, p1), (v0, v1), (a0, a1) = [(x[:-1], x[1:]) for x in points]
d = p1 - p0
c = np.array([
    p0,
    v0,
    a0 / 2,
    (20 * d - (8 * v1 + 12 * v0) * h - (3 * a0 - a1) * h**2) / (2 * h**3),
    (-30 * d + (14 * v1 + 16 * v0) * h + (3 * a0 - 2 * a1) * h**2) / (2 * h**4),
    (12 * d - 6 * (v1 + v0) * h + (a1 - a0) * h**2) / (2 * h**5),
])  # fmt: skip


def interpolated(times, order):
    i = np.clip(np.searchsorted(knots, times, side="right") - 1, 0, len(knots) - 2)
    tau = (times - knots[i])[:, None]
    value = 0
    for k in range(5, order - 1, -1):
        value = value * tau + c[k][i] * np.prod(np.arange(k, k - order, -1.0))
    return value


check("quintics from the plan, rad", np.abs(interpolated(t, 0) - q).max(), tolerance + 1e-9 + np.abs(qd).max() * (knots[-1] - t[-1] + 1e-9))
report = json.loads((folder / "report.json").read_text())
dense = np.unique(np.concatenate([np.linspace(knots[0], knots[-1], 200_001), knots[:-1] + 1e-12, knots[1:] - 1e-12]))
for order, name in [(1, "joint velocity"), (2, "joint acceleration"), (3, "joint jerk")]:
    limits = {line["joint"]: line["limit"] for line in report["limits"] if line["name"] == name}
    ratio = np.abs(interpolated(dense, order)).max(axis=0) / [limits[k + 1] for k in range(joints)]
    check(f"quintics: {name} over its limit", ratio.max(), 1 + ROUNDING)

# The recording, by two readers.
recording = folder / "motion.mcap"
states, frames, planned = [], [], []
for entry in read_ros2_messages(str(recording)):
    {"/joint_states": states, "/tf": frames, "/joint_trajectory": planned}[entry.channel.topic].append((entry.log_time_ns, entry.ros_msg))
assert len(planned) == 1 and list(planned[0][1].joint_names) == message["joint_names"]
check("trajectory of the recording", max(np.abs(np.array(p.positions) - x).max() for p, x in zip(planned[0][1].points, points[0])), 0)
assert [p.time_from_start.sec * 10**9 + p.time_from_start.nanosec for p in planned[0][1].points] == stamps
check("times of the states, ns", np.abs(np.array([ns for ns, _ in states]) - t * 1e9).max(), 0.501)
check("positions, rad", np.abs(np.array([list(m.position) for _, m in states]) - q).max(), 1e-12)
check("velocities, rad/s", np.abs(np.array([list(m.velocity) for _, m in states]) - qd).max(), 1e-12)
assert all(list(m.name) == message["joint_names"] for _, m in states)


def turned(rotation, vector):
    axis, w = np.array([rotation.x, rotation.y, rotation.z]), rotation.w
    return vector + 2 * np.cross(axis, np.cross(axis, vector) + w * vector)


worst = 0
for ns, m in frames:
    place = np.zeros(3)
    for transform in reversed(m.transforms):
        move = transform.transform.translation
        place = np.array([move.x, move.y, move.z]) + turned(transform.transform.rotation, place)
    links = [(x.header.frame_id, x.child_frame_id) for x in m.transforms]
    assert all(before[1] == after[0] for before, after in zip(links, links[1:])) and links[-1][1].startswith("tool")
    worst = max(worst, np.abs(place - tool[np.argmin(np.abs(t * 1e9 - ns))]).max())
check("tool by the frames, m", worst, 1e-12)

store = get_typestore(Stores.EMPTY)
with Reader(recording) as reader:
    for connection in reader.connections:
        from rosbags.typesys import get_types_from_msg

        store.register(get_types_from_msg(connection.msgdef.data, connection.msgtype))
    count = 0
    for connection, ns, data in reader.messages():
        m = store.deserialize_cdr(data, connection.msgtype)
        if connection.topic == "/joint_states":
            assert np.array_equal(m.position, states[count][1].position)
            count += 1
check("states that the second reader misses", len(states) - count, 0)
