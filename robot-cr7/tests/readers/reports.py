"""Runs every command that has a report, and validates each report by the schema that `cr7 schema` prints.

python reports.py CR7; needs jsonschema. What is spoilt must be refused, so that a schema which lets everything pass is found out.
Ends with exit code 1 at the first thing that is off.
"""

import copy
import json
import subprocess
import sys
import tempfile
from pathlib import Path

from jsonschema import Draft202012Validator

program = Path(sys.argv[1]).resolve()
REPOSITORY = Path(__file__).resolve().parents[2]
# Keys that are there where there is something to say: of reports, of limits, of parts.
SOMETIMES = {"vibration", "thermal", "bound", "fit", "program", "parts", "stream", "lines"}
SOMETIMES |= {"leaves_lines_m", "leaves_lines_at", "lift_m", "passes_ends_m", "reconfigured"}


def run(*words, folder=None):
    done = subprocess.run([program, *map(str, words)], cwd=folder, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"cr7 {' '.join(map(str, words))} ended with {done.returncode}: {done.stderr}")
    return done.stdout


def jobs(folder):
    """Names, and words of commands."""
    (folder / "calm.toml").write_text(
        "[torque]\nlimit_nm = 500\nrated_nm = 300\n[[vibration]]\njoint = 1\nfrequency_hz = 12.0\ndamping = 0.02\n"
    )
    (folder / "joints.toml").write_text('[feed]\nrapid = "joints"\n')
    (folder / "pick.toml").write_text(run("schedule", "--print-example"))
    (folder / "way.toml").write_text(run("schedule", "--print-example=waypoints"))
    (folder / "tool.toml").write_text(run("online", "--print-tool-example"))
    (folder / "butterfly.toml").write_text(run("run", "--print-example", "butterfly_live"))
    move = ["--from-deg", 0, -30, 90, 30, -90, 0, "--to-deg", 60, 0, 60, 30, -90, 45]
    plate = REPOSITORY / "data/gcode/plate.ngc"
    yield "plan"
    yield "plan", "--compile-rad", 1e-6, "--bound"
    yield "plan", "--stream", 20, "--stream-gap-ms", 12
    yield "plan", "--robot", "ur5e", "--job", "calm.toml"
    yield "plan", "--robot", "panda"
    yield "plan", plate
    yield "plan", plate, "--job", "joints.toml", "--compile-rad", 1e-5
    yield "schedule", "pick.toml", "--robot", "kr6_r700"
    yield "schedule", "way.toml"
    yield "move", *move
    yield "move", *move, "--mode", "none"
    yield ("online",)
    yield "online", "tool.toml"
    yield ("run",)
    yield "run", "butterfly.toml"
    yield ("compare",)
    yield "advise", "--robot", "ur5e", "calm.toml"
    yield "place", plate, "--z-mm", 0, "--turn", "--count", 2
    if "send" in run("--help"):
        yield ("send",)


def first_of_lists(report):
    """The first entry of each list of objects."""
    return {key: value[0] for key, value in report.items() if isinstance(value, list) and value and isinstance(value[0], dict)}


def spoilt(report):
    """The report with one thing that is wrong."""
    for key in report:
        less = copy.deepcopy(report)
        del less[key]
        if key not in SOMETIMES:
            yield f"without {key}", less
    yield "with a key that is not known", {**report, "surprise": 1}
    for key, first in first_of_lists(report).items():
        yield f"with a key that is not known in {key}", {**report, key: [{**first, "surprise": 1}]}
        for inner in first:
            if inner not in SOMETIMES:
                yield f"without {inner} in {key}", {**report, key: [{k: v for k, v in first.items() if k != inner}]}
        if "unit" in first:
            yield f"with a unit that is not known in {key}", {**report, key: [{**first, "unit": "mm"}]}
    for key, value in report.items():
        if isinstance(value, float):
            yield f"with a text for the number {key}", {**report, key: str(value)}
    yield "of another command", {**report, "command": "run" if report["command"] != "run" else "plan"}


def main():
    schema = json.loads(run("schema"))
    Draft202012Validator.check_schema(schema)
    validator = Draft202012Validator(schema)
    used = set()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for words in jobs(folder):
            words = (words,) if isinstance(words, str) else words
            printed = json.loads(run(*words, "--json", folder=folder))
            reports = [printed]
            if words[0] not in ("compare", "advise", "place"):
                assert printed == json.loads((folder / "out/report.json").read_text()), words
            if words == ("plan",):
                reports.append(json.loads(run("verify", "out/trajectory.csv", "--json", folder=folder)))
            for report in reports:
                for error in validator.iter_errors(report):
                    sys.exit(f"cr7 {' '.join(map(str, words))}: {error.json_path}: {error.message[:300]}")
                for what, wrong in spoilt(report):
                    if validator.is_valid(wrong):
                        sys.exit(f"cr7 {' '.join(map(str, words))}: a report {what} passes")
                used.update(report)
                print(f"{report['command']}: {len(report)} keys, {report['name']}", flush=True)
    known = set(schema["properties"]).union(*(of.get("properties", {}) for of in schema["$defs"].values()))
    kinds = [k["$ref"].split("/")[-1] for k in schema["oneOf"]]
    top = set(schema["properties"]).union(*(schema["$defs"][kind]["properties"] for kind in [*kinds, "motion"]))
    assert used <= known
    # A key that no report has shows a schema that is older than the reports.
    left = top - used - {"fit"}
    if left:
        sys.exit(f"no report has {', '.join(sorted(left))}")


if __name__ == "__main__":
    main()
