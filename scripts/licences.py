"""Checks the dependencies in Cargo.lock by the rules of deny.toml, without cargo-deny: licences, sources, and banned packages.

    python3 scripts/licences.py [--list]

Advisories are not checked, since this needs cargo-deny and its database. --list prints each package with its licence. It needs Python
3.11 and cargo."""

import argparse
import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
CRATES_IO = "registry+https://github.com/rust-lang/crates.io-index"


def packages():
    """All packages of the lock file, for all systems and with all features."""
    command = ["cargo", "metadata", "--locked", "--all-features", "--format-version", "1"]
    return json.loads(subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout)["packages"]


def is_allowed(expression, allowed):
    """Whether allowed licences satisfy a licence expression. OR binds less than AND, as in SPDX; `/` is the old form of OR."""
    words = re.findall(r"\(|\)|[^\s()]+", expression.replace("/", " OR "))

    def either(at):
        value, at = both(at)
        while at < len(words) and words[at] == "OR":
            other, at = both(at + 1)
            value = value or other
        return value, at

    def both(at):
        value, at = one(at)
        while at < len(words) and words[at] == "AND":
            other, at = one(at + 1)
            value = value and other
        return value, at

    def one(at):
        if words[at] == "(":
            value, at = either(at + 1)
            return value, at + 1
        name, at = words[at], at + 1
        if at < len(words) and words[at] == "WITH":
            name, at = f"{name} WITH {words[at + 1]}", at + 2
        return name in allowed, at

    value, at = either(0)
    return value and at == len(words)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--list", action="store_true", help="print each package with its licence")
    arguments = parser.parse_args()
    rules = tomllib.loads((ROOT / "deny.toml").read_text())
    allowed, banned = set(rules["licenses"]["allow"]), {row["name"] for row in rules["bans"]["deny"]}
    found, wrong = packages(), []
    for package in found:
        name = f"{package['name']} {package['version']}"
        if arguments.list:
            print(f"{name}: {package['license']}")
        if not package["license"] or not is_allowed(package["license"], allowed):
            wrong.append(f"{name} has the licence {package['license']}")
        if package["source"] not in (None, CRATES_IO):
            wrong.append(f"{name} comes from {package['source']}")
        if package["name"] in banned:
            wrong.append(f"{name} is not to be there")
    if wrong:
        sys.exit("\n".join(wrong))
    print(f"{len(found)} packages have the licences and sources that deny.toml allows")


if __name__ == "__main__":
    main()
