#!/usr/bin/env python3
"""Breaks each guarantee of docs/guarantees.md on purpose, and looks whether its test fails.

A break is a patch `NAME.patch` beside this file, against the checkout. Text before its first `diff` says what it is about:

    guarantee: the first words of a row of docs/guarantees.md
    test: one command that runs the test of this row
    expects: words of the failure, which its output has to contain
    break: what the mistake is

    run.py                      # play all patches, one after another: some hours
    run.py NAME...              # these
    run.py --list               # name them
    run.py --check              # only look whether all of them apply and every guarantee has one: a second

A patch is played on a fresh worktree of the last commit, in a temporary folder; what is built is kept in target/broken. The
exit code is 1 if a patch does not apply or does not compile, or if its test passes all the same.
"""

import argparse
import os
import re
import shlex
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
PAGE = ROOT / "docs" / "guarantees.md"
KEYS = ("guarantee", "test", "expects", "break")

# Guarantees without a patch, by the first words of their rows: their tests are breaks themselves, or they cannot be broken so.
EXCEPTIONS = {
    "a planner that breaks a limit is caught": "the test plays 24 broken planners itself",
    "the check itself catches jumps": "the test plays the spoilt motions itself",
    "joint motions and motions that are changed while they run": "the tests play 19 spoilt motions themselves",
    "a spoilt result of a paper's motion breaks a named row": "the test plays 86 spoilt results itself",
    "C: NULL, NaN, wrong counts": "the test needs gcc, g++ and valgrind: robot-cr7/c/run_examples.sh",
    "online generation, motions and arms link neither": "what breaks it does not link: the build fails before any test",
}

@dataclass
class Patch:
    """A break: its name, its file, and what the text before its first `diff` says."""

    name: str
    file: Path
    says: dict
    touched: list

    @staticmethod
    def read(file: Path) -> "Patch":
        text = file.read_text(encoding="utf-8")
        head, _, diff = text.partition("\ndiff --git ")
        says = dict(line.split(": ", 1) for line in head.splitlines() if ": " in line)
        if tuple(says) != KEYS or not diff:
            sys.exit(f"{file}: it has to begin with {', '.join(KEYS)}, one line each, and go on with a diff")
        return Patch(file.stem, file, says, re.findall(r"^\+\+\+ b/(.*)$", text, re.MULTILINE))

    def names_test(self) -> str:
        """The last argument of the command: the path of the test, or the module of some tests."""
        return shlex.split(self.says["test"])[-1]


def guarantees() -> list:
    """The first cell of each row of the table of docs/guarantees.md."""
    table = PAGE.read_text(encoding="utf-8").split("\n## ", 1)[0]
    rows = [line.split("|")[1].strip() for line in table.splitlines() if line.startswith("|")]
    return rows[2:]


def git(*arguments: str, at: Path = ROOT) -> subprocess.CompletedProcess:
    """Runs git, quietly, without a look at its success."""
    return subprocess.run(["git", "-C", str(at), *arguments], capture_output=True, text=True, check=False)


def check(patches: list) -> list:
    """What is wrong with the patches as they stand, without building anything."""
    rows, wrong, broken = guarantees(), [], set()
    sources = "\n".join(file.read_text(encoding="utf-8") for file in sorted(ROOT.glob("*/tests/it/**/*.rs")))
    sources += "\n".join(file.read_text(encoding="utf-8") for file in sorted(ROOT.glob("*/src/**/*.rs")))
    for patch in patches:
        tried = git("apply", "--check", str(patch.file))
        if tried.returncode != 0:
            wrong.append(f"{patch.name}: does not apply: {tried.stderr.strip()}")
        if any("/tests/" in file for file in patch.touched):
            wrong.append(f"{patch.name}: changes a test: break the code")
        test = patch.names_test().rsplit("::", 1)[-1]
        if not re.search(rf"\b(fn|mod) {test}\b", sources) and not any(ROOT.glob(f"*/src/**/{test}.rs")):
            wrong.append(f"{patch.name}: no test is named {test}")
        found = [row for row in rows if row.startswith(patch.says["guarantee"])]
        if len(found) != 1:
            wrong.append(f"{patch.name}: {len(found)} rows of docs/guarantees.md begin with \"{patch.says['guarantee']}\"")
        broken.update(found)
    for words in EXCEPTIONS:
        if sum(row.startswith(words) for row in rows) != 1:
            wrong.append(f"exception \"{words}\": not exactly one row of docs/guarantees.md begins so")
        if any(row.startswith(words) for row in broken):
            wrong.append(f"exception \"{words}\": a patch breaks it: take the exception out")
    for row in rows:
        if row not in broken and not row.startswith(tuple(EXCEPTIONS)):
            wrong.append(f"no patch breaks \"{row}\": add one, or an exception with its reason")
    count = f"{len(patches)} patches"
    if count not in PAGE.read_text(encoding="utf-8"):
        wrong.append(f"docs/guarantees.md does not say that there are {count}")
    return wrong


def verdict(patch: Patch, done: subprocess.CompletedProcess, output: str) -> str:
    """`red`, or why the run of a broken test does not count."""
    if "could not compile" in output or "error[E" in output:
        return "DOES NOT COMPILE"
    if done.returncode == 0:
        return "NO TEST RAN" if not re.search(r"test result: ok\. [1-9]", output) else "THE TEST PASSES"
    # A test that is killed by a signal, as a stack that overflows is, has no result.
    if "test result: FAILED" not in output and "(signal:" not in output:
        return "DOES NOT RUN"
    return "red" if patch.says["expects"] in output else f"FAILS WITHOUT \"{patch.says['expects']}\""


def run(patch: Patch, worktree: Path, jobs: str, log: Path) -> str:
    """Plays one patch on the worktree and takes it back."""
    applied = git("apply", str(patch.file), at=worktree)
    if applied.returncode != 0:
        return "DOES NOT APPLY"
    try:
        environment = {**os.environ, "CARGO_TARGET_DIR": str(ROOT / "target" / "broken"), "CARGO_BUILD_JOBS": jobs}
        command = shlex.split(patch.says["test"])
        done = subprocess.run(command, cwd=worktree, env=environment, capture_output=True, text=True, check=False)
        output = done.stdout + done.stderr
        log.write_text(output, encoding="utf-8")
        return verdict(patch, done, output)
    finally:
        git("checkout", "--quiet", "--", ".", at=worktree)


def play(patches: list, jobs: str) -> bool:
    """Plays the patches on a worktree of the last commit and prints a table."""
    logs = ROOT / "target" / "broken" / "logs"
    logs.mkdir(parents=True, exist_ok=True)
    right = True
    with tempfile.TemporaryDirectory(prefix="arcfeed_broken_") as folder:
        worktree = Path(folder) / "checkout"
        made = git("worktree", "add", "--quiet", "--detach", str(worktree), "HEAD")
        if made.returncode != 0:
            sys.exit(made.stderr)
        try:
            print("| guarantee | patch | test | result | s |\n|---|---|---|---|---|", flush=True)
            for patch in patches:
                begin = time.monotonic()
                result = run(patch, worktree, jobs, logs / f"{patch.name}.log")
                right &= result == "red"
                cells = [patch.says["guarantee"], patch.name, patch.names_test(), result, f"{time.monotonic() - begin:.0f}"]
                print(f"| {' | '.join(cells)} |", flush=True)
        finally:
            git("worktree", "remove", "--force", str(worktree))
    if not right:
        print(f"what was printed is in {logs}", file=sys.stderr)
    return right


def main() -> int:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help="patches to play, without .patch: all by default")
    parser.add_argument("--list", action="store_true", help="name the patches with guarantee and test")
    parser.add_argument("--check", action="store_true", help="only check that all apply and no guarantee is left out")
    parser.add_argument("--jobs", default="1", help="jobs of cargo at a time")
    arguments = parser.parse_args()
    patches = [Patch.read(file) for file in sorted(HERE.glob("*.patch"))]
    if arguments.check:
        wrong = check(patches)
        print("\n".join(wrong) or f"{len(patches)} patches apply; each guarantee is broken by one or has a reason for none")
        return 1 if wrong else 0
    unknown = set(arguments.names) - {patch.name for patch in patches}
    if unknown:
        sys.exit(f"no patch is named {', '.join(sorted(unknown))}: run.py --list names them")
    chosen = [patch for patch in patches if not arguments.names or patch.name in arguments.names]
    if arguments.list:
        for patch in chosen:
            print(f"{patch.name}: {patch.says['break']}\n    {patch.says['guarantee']}\n    {patch.says['test']}")
        return 0
    return 0 if play(chosen, arguments.jobs) else 1


if __name__ == "__main__":
    sys.exit(main())
