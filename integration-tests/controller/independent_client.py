"""Holds the simulated controller against a client of others: DobotTCP (PyPI, MIT), which speaks version 4.

Usage: independent_client.py SIMULATOR, the example `controller_simulator`. It reads mode, joints and feedback, moves the joints by
MovJ and by ServoJ, stops, and compares what both ports say with what was asked. DobotTCP leaves out the two reserved bytes 1023 and 1024 of
the maker's table, so that of its fields those up to byte 1022 are compared, and those behind are read here by the table.
"""

import struct
import subprocess
import sys
import time

from DobotTCP import Dobot, Feedback


def numbers(response):
    """The numbers of a reply as DobotTCP hands them out."""
    text = str(response)
    for mark in "{}[]()'\"":
        text = text.replace(mark, " ")
    return [float(part) for part in text.replace(",", " ").split()]


def near(name, found, expected, tolerance):
    """Fails with a message where two lists differ."""
    assert len(found) >= len(expected), (name, found)
    for a, b in zip(found, expected):
        assert abs(a - b) <= tolerance, f"{name}: {found}, not {expected}"
    print(f"{name}: {[round(value, 4) for value in found[:len(expected)]]}")


def accepted(name, reply):
    """Fails unless DobotTCP reads the reply as that of code 0."""
    assert reply[0] == Dobot.error_codes[0], (name, reply)


def main():
    start = [10.0, -20.0, 30.0, 0.0, 45.0, -5.0]
    command = [sys.argv[1], "v4", "0", "0", "0", "14", *map(str, start), "off"]
    simulator = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    dashboard, _, feedback_port = map(int, simulator.stdout.readline().split()[1:])

    robot = Dobot(ip="127.0.0.1", port=dashboard)
    robot.SetDebugLevel(0)
    robot.Connect()
    feedback = Feedback(robot, port=feedback_port)
    feedback.Connect()

    def get():
        feedback.Get()
        return feedback.data

    data = get()
    assert data["MessageSize"] == 1440 and data["TestValue"] == 0x0123456789ABCDEF, data
    assert data["RobotMode"] == 4, data["RobotMode"]
    near("actual joints, off", data["QActual"], start, 1e-9)
    near("mode, off", numbers(robot.RobotMode()[1]), [4], 0)
    near("GetAngle", numbers(robot.GetAngle()[1]), start, 1e-5)

    accepted("EnableRobot", robot.EnableRobot())
    time.sleep(0.6)
    near("mode, on", numbers(robot.RobotMode()[1]), [5], 0)

    goal = [12.0, -25.0, 30.0, 3.0, 45.0, -5.0]
    accepted("MovJ", robot.SendCommand("MovJ(joint={%s})" % ",".join(map(str, goal))))
    time.sleep(0.3)
    data = get()
    assert data["RobotMode"] == 7 and any(abs(v) > 1 for v in data["QDActual"]), data["QDActual"]
    time.sleep(1.2)
    data = get()
    near("joints after MovJ", data["QActual"], goal, 0.01)
    assert data["RobotMode"] == 5, data["RobotMode"]

    # Joint 1 by 3 deg in 60 setpoints of a smooth step.
    for i in range(61):
        x = i / 60
        q = goal[:]
        q[0] += 3.0 * x**3 * (10 - 15 * x + 6 * x * x)
        accepted("ServoJ", robot.ServoJ(*q, t=0.03))
        time.sleep(0.03)
    time.sleep(0.3)
    goal[0] += 3.0
    data = get()
    near("joints after ServoJ", data["QActual"], goal, 0.01)
    near("target after ServoJ", data["QTarget"], goal, 0.001)
    near("velocity after ServoJ", data["QDActual"], [0.0] * 6, 0.05)

    # The bytes behind the reserved ones, by the maker's table.
    raw = b""
    while len(raw) < 4 * 1440:
        raw += feedback.client.recv(1440)
    head = struct.pack("<H", 1440)
    at = next(i for i in range(1440) if raw[i:i + 2] == head and raw[i + 48:i + 56] == struct.pack("<Q", 0x0123456789ABCDEF))
    packet = raw[at:at + 1440]
    assert (packet[1026], packet[1029], packet[1031]) == (1, 0, 7), packet[1023:1040]
    later = raw[at + 1440:at + 2880]
    assert struct.unpack_from("<Q", later, 32)[0] - struct.unpack_from("<Q", packet, 32)[0] == 8

    accepted("Stop", robot.Stop())
    unknown = robot.SendCommand("Mov(1,2,3)")
    assert unknown[0] == Dobot.error_codes[-10000], unknown
    end = simulator.communicate(timeout=30)[0]
    print(end.strip())
    assert "1 stops, 0 motions after a stop, excess None, at rest true" in end, end
    print("the simulator says what the client expects")


if __name__ == "__main__":
    main()
