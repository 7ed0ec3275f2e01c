"""Leads the simulated controller with the program `cr7 send`, in real time: a look, a refusal, the whole motion, Ctrl-C.

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
        # The program says what came when its time is over.
        text = simulator.communicate(timeout=60)[0].strip()
        print(text)
        assert "0 motions after a stop, excess None, at rest true" in text, text
        return text

    for version in ["v3", "v4"]:
        simulator, send = serve(version, start)
        look = run(*send, "--out", "look")
        assert look.returncode == 0 and "no motion is ordered" in look.stdout, look
        sent = run(*send, "--really", "--out", "sent")
        # A computer under load may be late: then the arm is stopped.
        late = sent.returncode == 1 and ("late" in sent.stderr or "no new state" in sent.stderr)
        assert sent.returncode == 0 or late, sent
        rows = list(csv.DictReader(open(os.path.join(folder, "sent/sent.csv"))))
        last = rows[-1]
        assert late or all(abs(float(last[f"sent{k}_rad"]) - float(last[f"actual{k}_rad"])) < 1e-3 for k in range(1, 7)), last
        assert open(os.path.join(folder, "sent/sent.svg")).read().startswith("<svg")
        print(sent.stdout)
        assert " 0 stops" not in end(simulator)

    away = start[:]
    away[2] += 4.0
    simulator, send = serve("v4", away, "off")
    refused = run(*send, "--really", "--out", "refused")
    assert refused.returncode == 1 and "--approach" in refused.stderr, refused
    refused = run(*send, "--really", "--approach", "--out", "refused")
    assert refused.returncode == 1 and "--enable" in refused.stderr, refused
    command = [cr7, *send, "--really", "--approach", "--enable", "--out", "interrupted"]
    process = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    time.sleep(3.0)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=20)
    assert process.returncode == 130 or "late" in err, (process.returncode, out, err)
    print(out, err)
    assert not end(simulator).startswith("0 setpoints")


if __name__ == "__main__":
    main()
