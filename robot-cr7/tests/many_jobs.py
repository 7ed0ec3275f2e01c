"""Many jobs by `cr7 batch`, while the program is killed again and again: every job has one result, and kills change none of them.

    python robot-cr7/tests/many_jobs.py target/release/cr7 [JOBS, else 2000] [KILLS, else 3] [FOLDER, else a temporary one]

Needs no package. FOLDER must not be there yet. One of ten jobs is out of reach. Says the jobs a second of the clock, and a second of
processor time, which does not depend on what else the machine does.
"""

import json
import pathlib
import random
import resource
import signal
import subprocess
import sys
import tempfile
import time

PATHS = 100
JOBS_A_KILL = 20  # fewer, and the program may be at its end before it is killed
ROBOTS = ["cr7", "ur5e", "kr6_r700"]


def write_jobs(folder, count):
    """Straight lines of 2 to 10 mm anywhere before the arm, at 20 to 200 mm/s."""
    random_numbers = random.Random(1)
    uniform = random_numbers.uniform
    for i in range(PATHS):
        end = [uniform(2, 8), uniform(-5, 5), uniform(-2, 2)]
        line = {"units": "mm", "degree": 1, "control_points": [[0, 0, 0], end], "knots": [0, 0, 1, 1]}
        (folder / f"line_{i}.json").write_text(json.dumps(line))
    with open(folder / "jobs.jsonl", "w") as file:
        for i in range(count):
            at = [uniform(350, 450), uniform(-150, 150), uniform(150, 250)]
            job = {
                "id": f"{i:06}",
                "robot": random_numbers.choice(ROBOTS),
                "path": {"file": f"line_{random_numbers.randrange(PATHS)}.json"},
                "feed": {"feed_mm_s": uniform(20, 200)},
                "workpiece": {"position_mm": [4000.0, 0.0, 0.0] if i % 10 == 0 else at},
                "sampling": {"period_ms": 4.0},
                "plan": {"planner": "continuous-acceleration"},
            }
            file.write(json.dumps(job) + "\n")


def processor_seconds():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def run(command, file=None, kills=()):
    """Runs to the end; the seconds of the clock and of the processor, and how often it was killed: when its file has so many bytes, each in turn."""
    begin, used, killed = time.monotonic(), processor_seconds(), 0
    random_numbers = random.Random(2)
    while True:
        program = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        while killed < len(kills) and program.poll() is None:
            time.sleep(random_numbers.uniform(0.001, 0.01))  # anywhere in a job
            if file.exists() and file.stat().st_size >= kills[killed]:
                program.kill()
                break
        code = program.wait()
        if code == -signal.SIGKILL:
            killed += 1
            continue
        assert code in (0, 1), f"{command} ended with {code}"
        return time.monotonic() - begin, processor_seconds() - used, killed


def results(folder):
    lines = (folder / "results.jsonl").read_text().splitlines()
    return [json.loads(line) for line in lines]


def check(found, count):
    """Every job has one result, and it is the right one of the two."""
    ids = sorted(result["id"] for result in found)
    assert ids == [f"{i:06}" for i in range(count)], f"{len(ids)} results, {len(set(ids))} names, {count} jobs"
    for result in found:
        if int(result["id"]) % 10 == 0:
            assert "out of reach" in result["error"], result
        else:
            assert result["error"] is None and result["worst_ratio"] <= 1 + 1e-6, result


def main():
    program = sys.argv[1]
    count, kills = (int(sys.argv[i]) if len(sys.argv) > i else default for i, default in [(2, 2000), (3, 3)])
    if kills * JOBS_A_KILL > count:
        sys.exit(f"{kills} kills of {count} jobs: give at least {JOBS_A_KILL} jobs a kill")
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(sys.argv[4]) if len(sys.argv) > 4 else pathlib.Path(temporary) / "jobs"
        if folder.exists():
            sys.exit(f"{folder} is there: name a new folder, since a batch takes up the results that it finds")
        folder.mkdir()
        write_jobs(folder, min(count, 2000))
        batch = lambda out, threads: [program, "batch", str(folder / "jobs.jsonl"), "-j", threads, "--out", str(folder / out)]
        few = min(count, 2000)
        seconds, used, _ = run(batch("one", "1"))
        check(results(folder / "one"), few)
        print(f"one at a time: {few} jobs, {few / seconds:.1f} a second, {few / used:.1f} a second of processor time", flush=True)
        expected = {result["id"]: result["duration_s"] for result in results(folder / "one")}

        write_jobs(folder, count)
        # One kill in each part of the results but the last.
        size = (folder / "one" / "results.jsonl").stat().st_size * count / few
        random_numbers = random.Random(3)
        at = [size * (i + random_numbers.random()) / (kills + 1) for i in range(kills)]
        seconds, used, killed = run(batch("two", "2"), folder / "two" / "results.jsonl", at)
        assert killed == kills, f"killed {killed} times instead of {kills}"
        found = results(folder / "two")
        check(found, count)
        for result in found:
            assert expected.get(result["id"], result["duration_s"]) == result["duration_s"], result
        failed = sum(result["error"] is not None for result in found)
        print(
            f"two at a time: {count} jobs, {count / seconds:.1f} a second, {count / used:.1f} a second of processor time; "
            f"killed {killed} times; {count - failed} motions, {failed} failures with their reason, none lost, none twice"
        )


if __name__ == "__main__":
    main()
