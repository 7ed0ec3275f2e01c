"""Robots of others, from their files: is each read, and do forward kinematics and Jacobian agree with Pinocchio?

    pip install robot-cr7/python pin example-robot-data rtb-data xacro
    python integration-tests/robots/survey.py FOLDER ... [--count 1000] [--seed 1] [--report survey.md]

Reads every .urdf below the folders, and every .xacro that expands to a robot. For each that is read: `count` joint values within
the range by seed, the pose and the Jacobian of both; the inverse from starts 0.2 rad away; and, of six or seven joints, a plan of a
circle of 20 mm in the middle of the range, which is verified before it is handed out. Exit code 1 if a number differs by more than
1e-9 or cannot be compared, 2 if there is no file.
"""

import argparse
import collections
import pathlib
import re
import subprocess
import sys
import tempfile

import arcfeed
import numpy as np
import pinocchio

AGREE = 1e-9


def files(folders):
    """Each robot once: (name, file), xacro files expanded."""
    seen = set()
    for folder in map(pathlib.Path, folders):
        for file in sorted(folder.rglob("*.urdf")) + sorted(folder.rglob("*.xacro")):
            text = file.read_text(errors="replace")
            name = str(file.relative_to(folder))
            if file.suffix == ".xacro":
                run = subprocess.run([sys.executable, "-m", "xacro", str(file)], capture_output=True, text=True, check=False)
                text = run.stdout
                # Macros for other files, and files that need packages which are not there.
                if run.returncode != 0 or "<link" not in text:
                    continue
            key = re.sub(r"\s+", " ", re.sub(r"<!--.*?-->", "", text, flags=re.S))
            if key not in seen:
                seen.add(key)
                yield name, text


def read(file):
    """The arm, or the reason why not; with the first of the tips that are offered, where one is asked for."""
    try:
        return arcfeed.Robot(file), "as it is"
    except arcfeed.InputError as error:
        reason = str(error).removeprefix(file).removeprefix(": ")
        offered = re.search(r"the tip link must be named, one of these \(found: '([^']*)'", reason)
        if offered is None:
            return None, reason
        for tip in offered[1].split(" and ")[0].split(", "):
            try:
                return arcfeed.Robot(file, tip=tip), f"tip named, of {len(offered[1].split(', '))}"
            except arcfeed.InputError:
                continue
        return None, reason


def reference(file, robot):
    """The model of Pinocchio, the frames of base and tip, and where each joint's value stands in its vector."""
    model = pinocchio.buildModelFromUrdf(file)
    base, tip = re.search(r"link '(.*)' to link '(.*)'", robot.source).groups()
    places = [model.joints[model.getJointId(name)] for name in robot.joint_names]
    return model, model.getFrameId(base), model.getFrameId(tip), places


def compare(file, robot, generator, count):
    """The largest differences of pose and Jacobian."""
    model, base, tip, places = reference(file, robot)
    data = model.createData()
    lower, upper = np.clip(robot.range, -np.pi, np.pi)
    worst = np.zeros(2)
    for q in generator.uniform(lower, upper, (count, len(lower))):
        full = pinocchio.neutral(model)
        for place, value in zip(places, q):
            # A joint without limits is a point of the unit circle there.
            full[place.idx_q : place.idx_q + place.nq] = [value] if place.nq == 1 else [np.cos(value), np.sin(value)]
        pinocchio.computeJointJacobians(model, data, full)
        pinocchio.updateFramePlacements(model, data)
        of_base = data.oMf[base]
        pose = (of_base.inverse() * data.oMf[tip]).homogeneous
        columns = [place.idx_v for place in places]
        jacobian = pinocchio.getFrameJacobian(model, data, tip, pinocchio.LOCAL_WORLD_ALIGNED)
        # Of one joint it is a vector.
        jacobian = jacobian.reshape(6, model.nv)[:, columns]
        turn = np.kron(np.eye(2), of_base.rotation.T)
        worst = np.maximum(
            worst, [np.abs(robot.forward(q) - pose).max(), np.abs(robot.jacobian(q) - turn @ jacobian).max()]
        )
    return worst


def inverse(robot, generator, count):
    """The share of poses whose joint values are found again, from a start 0.2 rad (m) away."""
    lower, upper = np.clip(robot.range, -np.pi, np.pi)
    found = 0
    for q in generator.uniform(lower, upper, (count, len(lower))):
        pose = robot.forward(q)
        seed = np.clip(q + generator.uniform(-0.2, 0.2, len(q)), lower, upper)
        try:
            answer = robot.inverse(pose, seed)
        except arcfeed.ArcfeedError:
            continue
        found += np.abs(robot.forward(answer) - pose).max() < 1e-6
    return found / count


def plan(robot, generator, tries=20):
    """The duration of a circle of 20 mm somewhere in the middle of the range, or the reason why there is none."""
    lower, upper = np.clip(robot.range, -np.pi, np.pi)
    reason = "no try"
    turn = np.linspace(0.0, 2.0 * np.pi, 33)
    for _ in range(tries):
        q = lower + (upper - lower) * generator.uniform(0.3, 0.7, len(lower))
        pose = robot.forward(q)
        ring = np.stack([np.cos(turn) - 1.0, np.sin(turn), 0.0 * turn], axis=1) * 0.01
        points = pose[:3, 3] + ring @ pose[:3, :3].T
        job = arcfeed.Job(
            feed={"feed_mm_s": 50.0},
            workpiece={"position_mm": [0.0, 0.0, 0.0]},
            orientation={"rpy_deg": rpy_deg(pose[:3, :3])},
            **({"start": {"near_deg": np.degrees(q).tolist()}} if len(q) == 6 else {}),
        )
        try:
            return f"{arcfeed.plan(arcfeed.Path.through(points), robot, job).duration:.3f} s"
        except arcfeed.ArcfeedError as error:
            reason = str(error)
    return reason


def rpy_deg(turn):
    """Roll, pitch, yaw of a rotation, deg."""
    yaw, pitch = np.arctan2(turn[1, 0], turn[0, 0]), np.arcsin(np.clip(-turn[2, 0], -1.0, 1.0))
    return np.degrees([np.arctan2(turn[2, 1], turn[2, 2]), pitch, yaw]).tolist()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="+")
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--report")
    arguments = parser.parse_args()
    generator = np.random.default_rng(arguments.seed)
    rows, tally, wrong = [], collections.Counter(), 0
    with tempfile.TemporaryDirectory() as folder:
        for number, (name, text) in enumerate(files(arguments.folders)):
            file = f"{folder}/{number}.urdf"
            pathlib.Path(file).write_text(text)
            robot, how = read(file)
            tally[how.split(",")[0] if robot else "not read"] += 1
            if robot is None:
                rows.append([name, "", how[:160], "", "", "", ""])
                continue
            joints = len(robot.joint_names)
            try:
                worst = compare(file, robot, generator, arguments.count)
                wrong += not (worst <= AGREE).all()
                figures = [f"{worst[0]:.0e}", f"{worst[1]:.0e}"]
            except Exception as error:  # Whatever Pinocchio's own reader raises.
                wrong += 1
                figures = ["-", f"not compared: {error}"[:80]]
            share = inverse(robot, generator, min(arguments.count, 200))
            motion = plan(robot, generator)[:80] if joints in (6, 7) else "-"
            rows.append([name, joints, how, *figures, f"{100 * share:.1f} %", motion])
            if how == "as it is":
                rows[-1][2] = re.sub(r".*to (link '.*')", r"as it is, to \1", robot.source)
            print(*rows[-1], sep=" | ", flush=True)
    head = ["file", "joints", "read", "pose", "Jacobian", "inverse", "circle of 20 mm"]
    lines = [f"| {' | '.join(map(str, row))} |" for row in [head, ["---"] * len(head), *rows]]
    if not rows:
        print("no robot below these folders")
        return 2
    summary = f"{sum(tally.values())} robots: " + ", ".join(f"{count} {how}" for how, count in tally.most_common())
    print(summary, f"{wrong} differ from Pinocchio", sep="\n")
    if arguments.report:
        pathlib.Path(arguments.report).write_text("\n".join([*lines, "", summary, ""]))
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
