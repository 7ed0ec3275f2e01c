"""Leads the simulated controller with the program `cr7 send`, in real time: a look, refusals, the whole motion, Ctrl-C,
a scenario that is planned while the arm moves, with orders on stdin.

Usage: send_to_simulator.py SIMULATOR CR7 FOLDER
"""

import csv
import json
import math
import os
import signal
import subprocess
import sys
import time

SCENARIO = """
[path]
built_in = "six_point"
[feed]
feed_mm_s = 40.0
tangential_acceleration_mm_s2 = 500.0
tangential_jerk_mm_s3 = 10000.0
[run]
feed_mm_s = 20.0
[[event]]
at_mm = 10.0
do = "leave"
leave = "braking"
points = [{ deg = [10.0, -25.0, 85.0, 30.0, -90.0, 0.0] }]
[[event]]
wait_s = 0.3
do = "return"
"""
# A computer under load may be late: then the arm is stopped, and the motion is tried again.
TRIES = 6


def late(program):
    """True if a run ended because this computer was late."""
    return program.returncode == 1 and ("ms late" in program.stderr or "no new state" in program.stderr)


def main():
    simulator_program, cr7, folder = sys.argv[1:]
    run = lambda *arguments: subprocess.run([cr7, *arguments], capture_output=True, text=True, cwd=folder)
    move = ["plan", "--out", "motion", "--compile-rad", "1e-6"]
    done = run(*move)
    assert done.returncode == 0, done
    motion = json.load(open(os.path.join(folder, "motion/joint_trajectory.json")))
    start = [math.degrees(joint[0]) for joint in motion["coefficients_rad_per_s_k"][0]]

    def serve(version, joints, drives="on"):
        command = [simulator_program, version, "0", "0", "0", "25", *map(str, joints), drives]
        simulator = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        ports = simulator.stdout.readline().split()[1:]
        return simulator, ["send", "motion/joint_trajectory.json", "--address", "127.0.0.1", "--ports", *ports, "--dialect", version]

    def end(simulator):
        # The program says what came when its time is over: setpoints and stops are returned.
        text = simulator.communicate(timeout=60)[0].strip()
        print(text)
        assert "0 motions after a stop, excess None, at rest true" in text, text
        words = text.split()
        return int(words[0]), int(words[2])

    def whole(version):
        """Leads the arm along the whole motion; false if this computer was late."""
        simulator, send = serve(version, start)
        look = run(*send, "--out", "look")
        assert look.returncode == 0 and "no motion is ordered" in look.stdout, look
        sent = run(*send, "--really", "--out", "sent")
        print(sent.stdout, sent.stderr)
        assert sent.returncode == 0 or late(sent), sent
        assert "the arm rests" in sent.stderr, sent
        rows = list(csv.DictReader(open(os.path.join(folder, "sent/sent.csv"))))
        assert open(os.path.join(folder, "sent/sent.svg")).read().startswith("<svg")
        # Stops go on for a second after the arm came to rest.
        assert end(simulator)[1] >= 5
        last = rows[-1]
        return sent.returncode == 0 and all(abs(float(last[f"sent{k}_rad"]) - float(last[f"actual{k}_rad"])) < 1e-3 for k in range(1, 7))

    def live(version, orders):
        """Leads the arm along a scenario with orders on stdin: the program, its setpoints, those of the rehearsal, and the report."""
        dry = run("send", "--scenario", "live.toml", "--out", "dry", "--json")
        assert dry.returncode == 0, dry
        rows = list(csv.reader(open(os.path.join(folder, "dry/setpoints.csv"))))
        simulator, send = serve(version, [math.degrees(float(q)) for q in rows[1][1:]])
        send[1:2] = ["--scenario", "live.toml"]
        command = [cr7, *send, "--really", "--out", "live"]
        process = subprocess.Popen(command, cwd=folder, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        for pause, order in orders:
            time.sleep(pause)
            if process.poll() is None:
                process.stdin.write(order + b"\n")
                process.stdin.flush()
        process.stdout, process.stderr = (text.decode() for text in process.communicate(timeout=60))
        print(process.stdout, process.stderr)
        setpoints, stops = end(simulator)
        assert stops >= 5 and "the arm rests" in process.stderr, (stops, process.stderr)
        report = json.load(open(os.path.join(folder, "live/report.json")))
        return process, setpoints, len(rows) - 1, report

    def slower(version):
        """An override, and lines that are no order; false if this computer was late."""
        orders = [(0.5, b"override 20"), (0.2, b"faster"), (0.1, b"\xff\xfe"), (0.1, b"override 21")]
        process, setpoints, count, report = live(version, orders)
        assert process.returncode == 0 or late(process), (process.returncode, process.stderr)
        # With the order it takes longer than in the rehearsal.
        whole = process.returncode == 0 and setpoints > count + 20 and '"faster" is no order' in process.stderr
        return whole and any(event["what"] == "order: override 21 %" for event in report["events"])

    def halted(version):
        """A hold, a resume and a stop: the program says so, and has a code of its own; false if this computer was late."""
        orders = [(0.6, b"hold"), (1.5, b"resume"), (0.3, b"stop")]
        process, setpoints, count, report = live(version, orders)
        if late(process):
            return False
        assert process.returncode == 3 and "stopped by order" in process.stderr, (process.returncode, process.stderr)
        told = [event["what"] for event in report["events"] if event["what"].startswith("order")]
        assert told == ["order: hold", "order: resume", "order: stop"], told
        return True

    open(os.path.join(folder, "live.toml"), "w").write(SCENARIO)
    assert any(slower("v4") for _ in range(TRIES)), f"no whole scenario in {TRIES} tries"
    assert any(halted("v4") for _ in range(TRIES)), f"no stop by order in {TRIES} tries"
    for version in ["v3", "v4"]:
        assert any(whole(version) for _ in range(TRIES)), f"{version}: no whole motion in {TRIES} tries"

    away = start[:]
    away[2] += 4.0
    simulator, send = serve("v4", away, "off")
    refused = run(*send, "--really", "--out", "refused")
    assert refused.returncode == 1 and "--approach" in refused.stderr, refused
    refused = run(*send, "--really", "--approach", "--out", "refused")
    assert refused.returncode == 1 and "--enable" in refused.stderr, refused
    assert end(simulator) == (0, 0)

    def interrupted():
        """Interrupts a motion; false if this computer was late."""
        simulator, send = serve("v4", away, "off")
        command = [cr7, *send, "--really", "--approach", "--enable", "--out", "interrupted"]
        process = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        log = os.path.join(folder, "interrupted/sent.csv")
        time.sleep(3.0)
        process.send_signal(signal.SIGINT)
        _, process.stderr = process.communicate(timeout=20)
        print(process.stderr)
        setpoints, stops = end(simulator)
        if late(process):
            return False
        assert process.returncode == 130, process.returncode
        assert "interrupted" in process.stderr and "the arm rests" in process.stderr and os.path.exists(log), process.stderr
        assert setpoints > 0 and stops >= 5, (setpoints, stops)
        return True

    assert any(interrupted() for _ in range(TRIES)), f"no interruption in {TRIES} tries"


if __name__ == "__main__":
    main()
