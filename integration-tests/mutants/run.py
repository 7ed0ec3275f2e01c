#!/usr/bin/env python3
"""Plays random mutants of the libraries, and shows those that no test catches.

A mutant is the code with one small mistake, as cargo-mutants lists it (`cargo install --locked cargo-mutants`).

    run.py feedrate:0:40                  # the first 40 of the shuffled list of a crate
    run.py feedrate:40:40 sync:0:30       # of several crates, in one build
    run.py --name 'live/follow.rs.*is_safe' # those whose name matches
    run.py ... --again                    # those that were missed once more, after tests were added
    run.py ... --table                    # what was found so far, without playing anything

The lists are shuffled with the same seed each time. A copy of the checkout, in target/mutants/sources, holds all mutants that are
asked for, each behind a switch: a function becomes `if mutant(N) { changed body } else { body }`, and an environment variable says
which N runs. One build serves them all. First every test runs on the code as it is, each in a process of its own, which gives the
time it takes and the mutants whose function it runs. A mutant then meets the tests that run its function, the quick ones first,
and ends at the first that fails: those of its own crate, and, when all mutants have met theirs, those of the crates above. A test
may take four times the processor time of the code as it is, and two seconds more.

A result is a line of target/mutants/results.jsonl, so that a run which was stopped goes on where it was. Tests that count
allocations, measure the stack or read the sources are left out: a switch changes all three. The exit code is 1 if a mutant was missed.
"""

import argparse
import collections
import concurrent.futures
import json
import math
import os
import re
import resource
import signal
import subprocess
import sys
import tempfile
import threading
import tomllib
from dataclasses import dataclass
from pathlib import Path

import switch

WORK = switch.ROOT / "target" / "mutants"
SOURCES = WORK / "sources"
RESULTS = WORK / "results.jsonl"
CLEAN = WORK / "clean.json"

# Each crate and those above it whose tests a mutant meets.
TESTED_BY = {
    "feedrate": ["feedrate", "sync", "interp", "integration-tests", "robot-cr7"],
    "sync": ["sync", "interp", "integration-tests", "robot-cr7"],
    "kinematics": ["kinematics", "interp", "integration-tests", "robot-cr7"],
    "interp": ["interp", "integration-tests", "robot-cr7"],
}
# Features without which some of their tests are left out.
FEATURES = {"feedrate": ["clarabel"], "kinematics": ["json", "urdf"], "interp": ["json"]}
LEFT_OUT = r"allocat|stack|hybrid::random_scenarios_keep|security::nothing_that_a_robot_file_names"
UNPLAYED = ("no switch", "does not compile")
# Of a mutant that has met the tests of its own crate alone so far.
HALF = "missed by its crate"


@dataclass(frozen=True)
class Test:
    """A test: the folder of its package, its program, its name, its processor time and the mutants whose function it runs."""

    package: str
    program: str
    name: str
    seconds: float
    reaches: frozenset

    def title(self) -> str:
        """The test as a person looks for it."""
        return f"{self.package} {self.name}"


def surroundings(**more: str) -> dict:
    """The environment of cargo and of tests."""
    config = tomllib.loads((switch.ROOT / ".cargo" / "config.toml").read_text(encoding="utf-8"))
    quiet = {"CARGO_INCREMENTAL": "0", "CARGO_PROFILE_RELEASE_DEBUG": "0", "CARGO_TARGET_DIR": str(WORK / "build")}
    return {**config.get("env", {}), **os.environ, **quiet, **more}


def build(packages: list, jobs: int) -> tuple:
    """Builds the tests. Gives programs as `[package, path]` and the messages of errors."""
    command = ["cargo", "test", "--release", "--no-run", "--no-fail-fast", "--message-format=json", "--jobs", str(jobs)]
    command += ["--lib", "--bins", "--test", "it"]
    for package in packages:
        command += ["-p", f"arcfeed-{package}" if package in switch.FILES else package]
        command += [f"--features=arcfeed-{package}/{feature}" for feature in FEATURES.get(package, [])]
    done = subprocess.run(command, cwd=SOURCES, env=surroundings(), stdout=subprocess.PIPE, text=True, check=False)
    programs, errors = [], []
    for message in map(json.loads, done.stdout.splitlines()):
        if message["reason"] == "compiler-artifact" and message["profile"]["test"] and message["executable"]:
            package = Path(message["manifest_path"]).parent.relative_to(SOURCES)
            programs.append([str(package), message["executable"]])
        elif message["reason"] == "compiler-message" and message["message"]["level"].startswith("error"):
            errors.append(message["message"])
    if done.returncode != 0 and not errors:
        sys.exit("cargo failed without an error of the compiler")
    return programs, errors


def at_fault(errors: list) -> set:
    """The mutants that errors of the compiler are about."""
    found = set()
    for error in errors:
        spans = sorted(error["spans"], key=lambda span: not span["is_primary"])
        # What a macro wrote is where it was called.
        for span in spans:
            if span["expansion"]:
                spans.append(span["expansion"]["span"])
        for span in spans:
            file = SOURCES / span["file_name"]
            number = switch.mutants_at(file.read_text(encoding="utf-8"))[span["line_start"]] if file.is_file() else None
            if number is not None:
                found.add(number)
                break
    if not found:
        sys.exit("the sources with mutants do not compile:\n" + "\n".join(error["rendered"] for error in errors))
    return found


def tested_by(crate: str, libraries: bool) -> list:
    """The packages whose tests a mutant of a crate meets."""
    return [package for package in TESTED_BY[crate] if package in switch.FILES or not libraries]


def build_all(mutants: list, results: dict, libraries: bool, jobs: int) -> list:
    """Writes and builds the sources, without the mutants that do not compile. Gives the programs."""
    for mutant in mutants:
        source = (switch.ROOT / mutant.file).read_text(encoding="utf-8")
        if mutant.name not in results and mutant.cannot_be_switched(source):
            settle(results, mutant, outcome="no switch")
    packages = sorted({package for mutant in mutants for package in tested_by(mutant.crate, libraries)})
    while True:
        rest = [mutant for mutant in mutants if results.get(mutant.name, {}).get("outcome") not in UNPLAYED]
        switch.write_sources(rest, len(mutants), SOURCES)
        print(f"builds {len(rest)} mutants", file=sys.stderr, flush=True)
        programs, errors = build(packages, jobs)
        if not errors:
            return programs
        for number in at_fault(errors):
            settle(results, mutants[number], outcome="does not compile")


def run_test(package: str, program: str, name: str, limit: float, more: dict) -> tuple:
    """Runs one test in a process of its own. Gives `passes`, `fails` or `no end`, the processor time, and what it printed."""

    def bound() -> None:
        seconds = int(limit) + 1
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 5))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))

    with tempfile.TemporaryFile() as output:
        command = [program, "--exact", name]
        folder = SOURCES / package
        environment = surroundings(CARGO_MANIFEST_DIR=str(folder), **more)
        streams = {"stdin": subprocess.DEVNULL, "stdout": output, "stderr": output}
        child = subprocess.Popen(command, cwd=folder, env=environment, preexec_fn=bound, start_new_session=True, **streams)
        # A mutant may also wait for ever, which takes no processor time.
        timer = threading.Timer(60.0 + 20.0 * limit, os.killpg, (child.pid, signal.SIGKILL))
        timer.start()
        _, status, usage = os.wait4(child.pid, 0)
        timer.cancel()
        child.returncode = os.waitstatus_to_exitcode(status)
        spent = usage.ru_utime + usage.ru_stime
        output.seek(0)
        text = output.read().decode(errors="replace")
    if child.returncode == 0:
        return "passes", spent, text
    return ("no end" if child.returncode in (-signal.SIGXCPU, -signal.SIGKILL) or spent > limit else "fails"), spent, text


def names_of(package: str, program: str) -> list:
    """The tests of a program, without those that are ignored."""

    def ask(*words: str) -> list:
        command = [program, "--list", "--format", "terse", *words]
        done = subprocess.run(command, cwd=SOURCES / package, env=surroundings(), capture_output=True, text=True, check=True)
        return [line.removesuffix(": test") for line in done.stdout.splitlines() if line.endswith(": test")]

    ignored = set(ask("--ignored"))
    return [name for name in ask() if name not in ignored]


def clean_run(package: str, program: str, name: str) -> dict:
    """Runs a test on the code as it is."""
    with tempfile.TemporaryDirectory(prefix="arcfeed_mutants_") as folder:
        trace = Path(folder) / "reached"
        result, seconds, text = run_test(package, program, name, 3600.0, {"ARCFEED_MUTANTS_REACHED": str(trace)})
        reached = sorted(set(map(int, trace.read_text().split()))) if trace.is_file() else []
    return {"name": name, "passes": result == "passes", "seconds": seconds, "reaches": reached, "text": text[-3000:]}


def tests_of(programs: list, left_out: str, jobs: int) -> list:
    """Runs every test on the code as it is, but for programs of which that is known already."""
    known = json.loads(CLEAN.read_text(encoding="utf-8")) if CLEAN.is_file() else {}
    tests, failed = [], []
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        for package, program in programs:
            names = [name for name in names_of(package, program) if not re.search(left_out, name)]
            found = known.setdefault(f"{program} {os.stat(program).st_mtime_ns}", {})
            new = [name for name in names if name not in found]
            if new:
                print(f"{len(new)} tests of {package}, {Path(program).name}", file=sys.stderr, flush=True)
            for name, run in zip(new, pool.map(lambda name: clean_run(package, program, name), new)):
                found[name] = run
            if new and all(test["passes"] for test in found.values()):
                CLEAN.write_text(json.dumps(known), encoding="utf-8")
            for test in map(found.get, names):
                tests.append(Test(package, program, test["name"], test["seconds"], frozenset(test["reaches"])))
                if not test["passes"]:
                    failed.append(f"{package} {test['name']}\n{test['text']}")
    if failed:
        sys.exit("tests fail without any mutant:\n" + "\n".join(failed))
    return tests


def play(mutant: switch.Mutant, tests: list, above: bool) -> dict:
    """Plays a mutant against the tests of its own crate that run its function, or against those of the crates above."""
    packages = TESTED_BY[mutant.crate][1:] if above else [mutant.crate]
    met = [test for test in tests if test.package in packages and mutant.number in test.reaches]
    met.sort(key=lambda test: test.seconds)
    spent = 0.0
    for count, test in enumerate(met):
        limit = 4.0 * test.seconds + 2.0
        result, seconds, _ = run_test(test.package, test.program, test.name, limit, {"ARCFEED_MUTANT": str(mutant.number)})
        spent += seconds
        if result != "passes":
            outcome = result if result == "no end" else ("caught above" if above else "caught")
            return {"outcome": outcome, "by": test.title(), "tests": count + 1, "seconds": round(spent, 1)}
    return {"outcome": "missed" if above else HALF, "tests": len(met), "seconds": round(spent, 1)}


def play_all(mutants: list, results: dict, tests: list, above: bool, jobs: int) -> None:
    """Plays mutants, and notes what became of each as soon as it is known."""
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        plays = {pool.submit(play, mutant, tests, above): mutant for mutant in mutants}
        for count, done in enumerate(concurrent.futures.as_completed(plays), 1):
            mutant, line = plays[done], done.result()
            before = results.get(mutant.name, {}) if above else {}
            for sum_of in ("tests", "seconds"):
                line[sum_of] = round(line[sum_of] + before.get(sum_of, 0), 1)
            settle(results, mutant, **line)
            by = line.get("by", f"{line['tests']} tests passed")
            print(f"{count}/{len(mutants)} {line['outcome']} ({by}): {mutant.name}", file=sys.stderr, flush=True)


def settle(results: dict, mutant: switch.Mutant, **found: object) -> None:
    """Notes what became of a mutant."""
    results[mutant.name] = {"mutant": mutant.name, "crate": mutant.crate, **found}
    with RESULTS.open("a", encoding="utf-8") as file:
        file.write(json.dumps(results[mutant.name]) + "\n")


def share(caught: int, played: int) -> str:
    """The part that was caught, and Wilson's interval in which that of all mutants is with a probability of 95 %."""
    if played == 0:
        return ""
    z, part = 1.96, caught / played
    middle = (part + z * z / (2 * played)) / (1 + z * z / played)
    half = z / (1 + z * z / played) * math.sqrt(part * (1 - part) / played + z * z / (4 * played * played))
    return f"{part:.0%}, {middle - half:.0%} to {middle + half:.0%}"


def table(mutants: list, results: dict) -> bool:
    """Prints what became of the mutants. Says whether one was missed."""
    kinds = ["caught", "caught above", "no end", "missed", HALF, *UNPLAYED]
    print(f"| crate | {' | '.join(kinds)} | not played yet | caught of those played |\n|---|{'---|' * (len(kinds) + 2)}")
    for crate in dict.fromkeys(mutant.crate for mutant in mutants):
        outcomes = [results.get(mutant.name, {}).get("outcome", "") for mutant in mutants if mutant.crate == crate]
        counts = collections.Counter(outcomes)
        caught = counts["caught"] + counts["caught above"]
        part = share(caught, caught + counts["no end"] + counts["missed"] + counts[HALF])
        print(f"| {crate} | {' | '.join(str(counts[kind]) for kind in [*kinds, ''])} | {part} |")
    for kind in ("no end", "missed", HALF):
        for mutant in mutants:
            result = results.get(mutant.name, {})
            if result.get("outcome") == kind:
                by = f" by {result['by']}" if "by" in result else f", {result['tests']} tests"
                print(f"\n{kind}{by}: {mutant.name}\n    in {mutant.function} {mutant.returns}")
    return any(results.get(mutant.name, {}).get("outcome") in ("missed", HALF) for mutant in mutants)


def asked_for(arguments: argparse.Namespace) -> list:
    """The mutants that the command line names, each once."""
    entries = []
    for sample in arguments.samples:
        found = re.fullmatch(r"(\w+):(\d+):(\d+)", sample)
        if not found or found[1] not in switch.FILES:
            sys.exit(f"{sample}: not CRATE:FROM:COUNT with one of {', '.join(switch.FILES)}")
        begin = int(found[2])
        entries += [(found[1], one) for one in switch.shuffled(found[1])[begin : begin + int(found[3])]]
    for pattern in arguments.name:
        for crate in switch.FILES:
            entries += [(crate, one) for one in switch.listed(crate) if re.search(pattern, one["name"])]
    unique = {one["name"]: (crate, one) for crate, one in entries}
    return switch.numbered(list(unique.values()))


def main() -> int:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("samples", nargs="*", metavar="CRATE:FROM:COUNT", help=f"of {', '.join(switch.FILES)}")
    parser.add_argument("--name", action="append", default=[], metavar="REGEX", help="mutants whose name matches")
    parser.add_argument("--libraries", action="store_true", help="leave out integration-tests and robot-cr7: less to build")
    parser.add_argument("--again", action="store_true", help="play those that were missed once more")
    parser.add_argument("--table", action="store_true", help="print what was found so far and play nothing")
    parser.add_argument("--list", action="store_true", help="name the mutants and play nothing")
    parser.add_argument("--leave-out", default="", metavar="REGEX", help="tests to leave out as well")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="how much runs at a time")
    arguments = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    mutants = asked_for(arguments)
    if not mutants:
        parser.error("no mutant is asked for")
    lines = RESULTS.read_text(encoding="utf-8").splitlines() if RESULTS.is_file() else []
    results = {result["mutant"]: result for result in map(json.loads, lines)}
    if arguments.list:
        print("\n".join(mutant.name for mutant in mutants))
        return 0
    if not arguments.table:
        programs = build_all(mutants, results, arguments.libraries, arguments.jobs)
        left_out = "|".join(filter(None, [LEFT_OUT, arguments.leave_out]))
        tests = tests_of(programs, left_out, arguments.jobs)
        again = ["missed"] if arguments.again else []
        for above, due in ((False, ["", *again]), (True, [HALF])):
            rest = [mutant for mutant in mutants if results.get(mutant.name, {}).get("outcome", "") in due]
            play_all(rest, results, tests, above, arguments.jobs)
    return 1 if table(mutants, results) else 0


if __name__ == "__main__":
    sys.exit(main())
