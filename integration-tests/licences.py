#!/usr/bin/env python3
"""Licences and sources of the dependencies, by deny.toml, where cargo-deny is not installed.

    pip install license-expression
    licences.py MANIFEST...

A dependency passes if its licence permits what deny.toml allows, for all or for this one, and if it comes from crates.io or stands in
this repository. cargo-deny also looks at the text of licences, at banned versions and at known defects.
"""

import json
import subprocess
import sys
import tomllib
from pathlib import Path

from license_expression import Licensing

ROOT = Path(__file__).resolve().parent.parent
CRATES_IO = "registry+https://github.com/rust-lang/crates.io-index"
LICENSING = Licensing()


def permits(expression: str, allowed: set) -> bool:
    """Whether one of the choices that an SPDX expression leaves asks for allowed licences alone."""
    # Older manifests write a choice with a slash.
    parsed = LICENSING.parse(expression.replace("/", " OR "))
    symbols = LICENSING.license_symbols(parsed, decompose=False)
    decided = {symbol: LICENSING.TRUE if symbol.render() in allowed else LICENSING.FALSE for symbol in symbols}
    return parsed.subs(decided, simplify=True) == LICENSING.TRUE


def faults(package: dict, rules: dict) -> list:
    """What is wrong with a package of `cargo metadata`."""
    if package["source"] is None and Path(package["manifest_path"]).is_relative_to(ROOT):
        return []
    found = []
    if package["source"] != CRATES_IO:
        found.append(f"comes from {package['source']}; only crates.io is permitted")
    allowed = set(rules["allow"])
    for exception in rules["exceptions"]:
        if exception["crate"] == package["name"]:
            allowed |= set(exception["allow"])
    if package["license"] is None:
        found.append("states no licence as an SPDX expression")
    elif not permits(package["license"], allowed):
        found.append(f"has the licence {package['license']}, which deny.toml does not list")
    return found


def main() -> int:
    """The command line."""
    rules = tomllib.loads((ROOT / "deny.toml").read_text(encoding="utf-8"))["licenses"]
    failed = False
    for manifest in sys.argv[1:]:
        command = ["cargo", "metadata", "-q", "--locked", "--all-features", "--format-version", "1", "--manifest-path", manifest]
        done = subprocess.run(command, stdout=subprocess.PIPE, check=True)
        packages = json.loads(done.stdout)["packages"]
        for package in packages:
            for fault in faults(package, rules):
                print(f"{manifest}: {package['name']} {package['version']} {fault}")
                failed = True
        print(f"-- {manifest}: {len(packages)} packages")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
