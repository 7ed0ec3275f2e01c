"""G-code programs of LinuxCNC's trajectory planner tests, planned and verified on the CR7.

The programs are at https://github.com/LinuxCNC/linuxcnc, tests/trajectory-planner/circular-arcs/nc_files
(GPL-2.0-or-later). They are run from a folder of their own; none is part of this project.

    python integration-tests/foreign/linuxcnc.py FOLDER [--cr7 PROGRAM] [--report FILE]

Each program is read as it is. Lines that only the machine can follow (`MACHINE`) are left out where they
are refused, one by one, and counted. The frame of the workpiece is the first of those found so far in which
the whole program is in reach, else the one that `cr7 place --turn` finds. Only a message that the arm cannot
stand somewhere, or not go on from there (`OUT_OF_REACH`), leads to the next frame; any other is the verdict.
A planned motion is verified by the program itself, and judged here by differences of its joint positions
alone. Exit code 1: a program failed.
"""

import argparse
import collections
import csv
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile
import time

# Returns to positions of the machine, its offsets, and its tools.
MACHINE = ("G10", "G28", "G28.1", "G30", "G30.1", "G43", "G53", "G92")
# What rounding of positions adds to a third difference over 1 ms, as a share of the jerk limit.
ROUNDING = 1e-4
# A frame in front of the arm, in which most programs are in reach.
FIRST = """[workpiece]
position_mm = [382.0, -395.0, 400.0]
rotation_rpy_deg = [0.0, 0.0, -45.0]
[start]
configuration = "front down flip"
"""
# What the command says where the place of the workpiece is at fault: a distance, a joint's range, a singular pose.
OUT_OF_REACH = re.compile(
    r"out of reach|outside its range|inverse solutions break a joint limit|no solution at the start stands"
    r"|changes its branch|singular"
)
EXTENSIONS = (".ngc", ".nc", ".gcode")


class Refused(Exception):
    """The program is not read, and the message says why."""


class Unplanned(Exception):
    """The program is read, and there is no plan in this frame."""


def run(arguments):
    """Standard output of the command `cr7`."""
    done = subprocess.run(arguments, capture_output=True, text=True)
    if done.returncode == 0:
        return done.stdout
    lines = [line for line in done.stderr.splitlines() if line and "so far" not in line]
    message = " ".join(lines).removeprefix("cr7: ")
    raise {1: Unplanned, 2: Refused}.get(done.returncode, RuntimeError)(message)


def readable(cr7, source, folder):
    """A copy of the program without the lines that only its machine can follow, and how many these are."""
    lines = source.read_text(errors="replace").splitlines()
    copy, without = folder / source.name, 0
    while True:
        copy.write_text("\n".join([*lines, ""]))
        try:
            run([cr7, "inspect", copy, "--out", folder / "inspect"])
            return copy, without
        except Refused as error:
            place = re.match(r".*?:(\d+):\d+: ([GM][\d.]+):", str(error))
            if not place or place[2] not in MACHINE:
                raise Refused(str(error).removeprefix(f"{folder}/")) from error
            lines[int(place[1]) - 1] = ""
            without += 1


def frame(cr7, program):
    """The workpiece and the start of a job in which the whole program is in reach."""
    found = json.loads(run([cr7, "place", program, "--turn", "--count", "1", "--json"]))["frames"]
    if not found:
        raise Unplanned("no frame in which the whole program is in reach")
    position = [1e3 * x for x in found[0]["position_m"]]
    turn = [math.degrees(x) for x in found[0]["rotation_rpy_rad"]]
    return (
        f"[workpiece]\nposition_mm = {position}\nrotation_rpy_deg = {turn}\n"
        f"[start]\nconfiguration = {json.dumps(found[0]['configuration'])}\n"
    )


def planned(cr7, program, frames, folder):
    """The report of the plan in the first frame that fits; a new frame is added to `frames`."""
    job, out = folder / "job.toml", folder / "out"

    def plan(text):
        job.write_text(text)
        return json.loads(run([cr7, "plan", program, "--job", job, "--out", out, "--json"]))

    for text in frames:
        try:
            return plan(text)
        except Unplanned as error:
            if not OUT_OF_REACH.search(str(error)):
                raise
    frames.append(frame(cr7, program))
    return plan(frames[-1])


def by_differences(report, file):
    """The largest ratios of velocity, acceleration and jerk of a joint to their limits, from positions alone.

    A mean over one period, and the changes of two and three of them, are within the limits where these hold
    at all times.
    """
    limits = [{}, {}, {}]
    for row in report["limits"]:
        for order, name in enumerate(["joint velocity", "joint acceleration", "joint jerk"]):
            if row["name"] == name and row["joint"]:
                limits[order][row["joint"] - 1] = row["limit"]
    period = report["period_s"]
    with open(file) as lines:
        rows = list(csv.reader(lines))[1:]
    # The last step may be shorter than a period.
    even = [row for i, row in enumerate(rows) if abs(float(row[0]) - i * period) < 1e-9 * max(1.0, i)]
    worst = [0.0, 0.0, 0.0]
    for joint in range(len(report["joint_names"])):
        values = [float(row[1 + joint]) for row in even]
        for order in range(3):
            values = [(b - a) / period for a, b in zip(values, values[1:])]
            worst[order] = max(worst[order], max(map(abs, values), default=0.0) / limits[order][joint])
    return worst


def reason(message):
    """The message without its place."""
    return re.sub(r"^\S+?:(\d+:\d+: )?", "", message).strip()


def judge(cr7, source, frames, folder):
    """Verdict, duration and remark for one program."""
    try:
        program, without = readable(cr7, source, folder)
    except Refused as error:
        return "refused", "", reason(str(error))
    try:
        report = planned(cr7, program, frames, folder)
    except Unplanned as error:
        return "not planned", "", reason(str(error))
    except (Refused, RuntimeError) as error:
        return "failed", "", str(error)
    ratios = by_differences(report, folder / "out" / "trajectory.csv")
    stated = max(row["ratio"] for row in report["limits"])
    remark = "by differences " + ", ".join(f"{ratio:.4f}" for ratio in ratios) + f"; verified {stated:.6f}"
    if max(ratios) > 1.0 + ROUNDING:
        return "failed", report["duration_s"], remark
    verdict = f"planned without {without} lines" if without else "planned"
    return verdict, report["duration_s"], remark


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--cr7", default="target/release/cr7")
    parser.add_argument("--report", type=pathlib.Path)
    arguments = parser.parse_args()
    found = (file for file in arguments.folder.rglob("*") if file.suffix in EXTENSIONS)
    sources = sorted(found, key=lambda file: (file.stat().st_size, file.name))
    if not sources:
        print(f"no program below {arguments.folder}")
        return 2
    frames, rows, tally = [FIRST], [], collections.Counter()
    for source in sources:
        with tempfile.TemporaryDirectory() as folder:
            begin = time.monotonic()
            verdict, duration, remark = judge(arguments.cr7, source, frames, pathlib.Path(folder))
            spent = time.monotonic() - begin
        tally["planned without lines of the machine" if "without" in verdict else verdict] += 1
        rows.append([source.name, verdict, duration and f"{duration:.3f} s", remark])
        print(*rows[-1], f"{spent:.1f} s", sep=" | ", flush=True)
    summary = f"{len(rows)} programs: " + ", ".join(f"{count} {verdict}" for verdict, count in tally.items())
    print(summary)
    if arguments.report:
        table = [["program", "verdict", "duration", "remark"], ["---"] * 4, *rows]
        lines = [f"| {' | '.join(map(str, row))} |" for row in table]
        arguments.report.write_text("\n".join([*lines, "", summary, ""]))
    return int(tally["failed"] + tally["not planned"] > 0)


if __name__ == "__main__":
    sys.exit(main())
