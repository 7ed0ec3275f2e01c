"""Mutants as cargo-mutants lists them, and a copy of the sources that holds many of them behind a switch."""

import functools
import hashlib
import json
import random
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent

# The files that hold limits, rows, planners, inverse solutions, dynamics and checks.
FILES = {
    "feedrate": [
        *(f"feedrate/src/{part}/**/*.rs" for part in ("jerk_limited", "constraint", "scan", "problem", "state_to_state")),
        *(f"feedrate/src/{part}/**/*.rs" for part in ("live", "online", "scurve")),
        "feedrate/src/{caps,limits,row,lp2,state}.rs",
        "feedrate/src/speed_law/{law,piece,cursor}.rs",
    ],
    "interp": [
        *(f"interp/src/{part}/**/*.rs" for part in ("limits", "problem", "planner", "verify", "compiled")),
        "interp/src/{planner,lowering,vibration,trajectory}.rs",
    ],
    "kinematics": [
        *(f"kinematics/src/{part}/**/*.rs" for part in ("analytic", "dynamics", "numeric")),
        "kinematics/src/{jacobian,differential,lu,joint,chain,description,arm,closed_form,singularity}.rs",
        "kinematics/src/{singular_pose,normalised,turns,branch,posture,any_arm}.rs",
    ],
    "sync": [
        "sync/src/generator/**/*.rs",
        "sync/src/way_points/{planner,excess,route,line_writer,lines,distinct,settle}.rs",
        "sync/src/{norm,state_to_state}.rs",
    ],
}
SEED = 18

SWITCH = """
/// Says whether a mutant runs: the one whose number is in the environment. A traced run writes down which ones it reaches.
pub(crate) mod mutant_switch {
    use std::io::Write;
    use std::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};

    const NONE: u32 = u32::MAX - 2;
    const TRACED: u32 = u32::MAX - 1;
    const UNREAD: u32 = u32::MAX;
    static CHOSEN: AtomicU32 = AtomicU32::new(UNREAD);
    static REACHED: [AtomicBool; COUNT] = [const { AtomicBool::new(false) }; COUNT];

    #[inline]
    pub(crate) fn mutant(number: u32) -> bool {
        let chosen = CHOSEN.load(Relaxed);
        chosen == number || (chosen >= TRACED && look(number))
    }

    #[cold]
    fn look(number: u32) -> bool {
        let trace = std::env::var_os("ARCFEED_MUTANTS_REACHED");
        if CHOSEN.load(Relaxed) == UNREAD {
            let chosen = std::env::var("ARCFEED_MUTANT").ok().and_then(|text| text.parse().ok());
            CHOSEN.store(if trace.is_some() { TRACED } else { chosen.unwrap_or(NONE) }, Relaxed);
        }
        if let Some(trace) = trace {
            if !REACHED[number as usize].swap(true, Relaxed) {
                let mut file = std::fs::File::options().append(true).create(true).open(trace).expect("a trace");
                file.write_all(format!("{number}\\n").as_bytes()).expect("a trace");
            }
        }
        CHOSEN.load(Relaxed) == number
    }
}
"""


@dataclass(frozen=True)
class Mutant:
    """A mutant: its number is its place among all that are asked for."""

    number: int
    crate: str
    name: str
    file: str
    function: str
    returns: str
    whole: tuple
    span: tuple
    replacement: str
    genre: str

    def cannot_be_switched(self, source: str) -> bool:
        """Whether the function is const, or returns an opaque type, which two bodies cannot share."""
        begin, _ = offsets(source, self.whole)
        head = source[begin : body_of(source, self.whole)[0]]
        return "impl " in self.returns or re.search(r"\bconst\s+fn\b", head) is not None


@functools.cache
def listed(crate: str) -> list:
    """What cargo-mutants lists for a crate, in the order of file, place and replacement; kept for sources that do not change."""
    patterns = [word for pattern in FILES[crate] for word in ("-f", pattern)]
    sources = b"".join(file.read_bytes() for file in sorted((ROOT / crate / "src").rglob("*.rs")))
    kept = ROOT / "target" / "mutants" / f"{crate}-{hashlib.sha256(repr(patterns).encode() + sources).hexdigest()[:16]}.json"
    if kept.is_file():
        return json.loads(kept.read_text(encoding="utf-8"))
    command = ["cargo", "mutants", "--list", "--json", "--no-config", *patterns]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"cargo mutants --list failed; `cargo install --locked cargo-mutants` installs it\n{done.stderr}")

    def place(one: dict) -> tuple:
        start = one["span"]["start"]
        return one["file"], start["line"], start["column"], one["replacement"]

    found = [{key: one[key] for key in one if key != "diff"} for one in json.loads(done.stdout) if one["function"]]
    found.sort(key=place)
    kept.write_text(json.dumps(found), encoding="utf-8")
    return found


def shuffled(crate: str) -> list:
    """The list of a crate in an order that is the same each time."""
    found = list(listed(crate))
    random.Random(SEED).shuffle(found)
    return found


def numbered(entries: list) -> list:
    """Mutants of entries `(crate, listed mutant)`, numbered."""

    def pair(span: dict) -> tuple:
        return tuple((span[end]["line"], span[end]["column"]) for end in ("start", "end"))

    mutants = []
    for crate, one in entries:
        function = one["function"]
        whole, span = pair(function["span"]), pair(one["span"])
        says = (one["name"], one["file"], function["function_name"], function["return_type"])
        mutants.append(Mutant(len(mutants), crate, *says, whole, span, one["replacement"], one["genre"]))
    return mutants


def offsets(source: str, span: tuple) -> tuple:
    """Where a span of lines and columns, both from 1, begins and ends in a text."""
    starts = [0]
    for line in source.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    return tuple(starts[line - 1] + column - 1 for line, column in span)


def body_of(source: str, whole: tuple) -> tuple:
    """Where the body of a function begins and ends, braces included: the first brace outside of brackets opens it."""
    at, end = offsets(source, whole)
    depth = 0
    while at < end:
        if source.startswith("//", at):
            at = source.index("\n", at)
        elif source[at] == '"':
            at = re.compile(r'"(?:\\.|[^"\\])*"', re.DOTALL).match(source, at).end() - 1
        elif source[at] in "([":
            depth += 1
        elif source[at] in ")]":
            depth -= 1
        elif source[at] == "{" and depth == 0:
            return at, end
        at += 1
    raise ValueError(f"no body in {whole}")


def switched(source: str, mutants: list) -> str:
    """A file with its mutants behind switches. Lines that say `mutant N begins` and `mutant N ends` are around each."""
    functions: dict = {}
    for mutant in mutants:
        functions.setdefault(body_of(source, mutant.whole), []).append(mutant)

    def region(begin: int, end: int) -> str:
        text, at = "", begin
        for inner in sorted(functions):
            if inner[0] >= at and inner[1] <= end:
                text += source[at : inner[0]] + both(inner)
                at = inner[1]
        return text + source[at:end]

    def both(body: tuple) -> str:
        text = "{ "
        for mutant in functions[body]:
            begin, end = offsets(source, mutant.span)
            new = mutant.replacement
            if begin == body[0]:
                new = f"{{ {new} }}"
            changed = source[body[0] : begin] + new + source[end : body[1]]
            text += f"if crate::mutant_switch::mutant({mutant.number})\n"
            text += f"// mutant {mutant.number} begins\n{changed}\n// mutant {mutant.number} ends\nelse "
        # The body itself, but for functions inside of it that have mutants of their own.
        return text + "{" + region(body[0] + 1, body[1]) + " }"

    return region(0, len(source))


def mutants_at(text: str) -> list:
    """The mutant that each line of a switched file belongs to, or None."""
    lines, inside = [None], None
    for line in text.splitlines():
        found = re.fullmatch(r"// mutant (\d+) (begins|ends)", line)
        if found:
            inside = int(found[1]) if found[2] == "begins" else None
        lines.append(inside)
    return lines


def write_if_new(file: Path, content: bytes) -> None:
    """Writes a file unless it is so already, so that cargo builds only what has changed."""
    if not file.is_file() or file.read_bytes() != content:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(content)


def write_sources(mutants: list, count: int, to: Path) -> None:
    """Copies the checkout as it stands, with the mutants behind switches; `count` is above all of their numbers."""
    command = ["git", "-C", str(ROOT), "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    names = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split("\0")
    names = [name for name in names if name and (ROOT / name).is_file()]
    by_file: dict = {}
    for mutant in mutants:
        by_file.setdefault(mutant.file, []).append(mutant)
    for name in names:
        content = (ROOT / name).read_bytes()
        if name in by_file:
            content = switched(content.decode(), by_file[name]).encode()
        elif name in [f"{crate}/src/lib.rs" for crate in FILES]:
            content += SWITCH.replace("COUNT", str(count)).encode()
        write_if_new(to / name, content)
        shutil.copymode(ROOT / name, to / name)
    kept = {to / name for name in names}
    for file in to.rglob("*"):
        if file.is_file() and file not in kept and file.name != "Cargo.lock":
            file.unlink()
