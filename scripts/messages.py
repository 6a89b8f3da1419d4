"""Collect every message that the tests provoke into one file, to read them through.

    python3 scripts/messages.py [-o messages.txt]

It builds the tests, then runs the test programs that start isomend with a wrapper in its place, which copies standard error. Each
different line is written once, numbers replaced by `#` and paths by `PATH`, with how often it occurred, under the command that printed it. The results of
the tests do not matter here: those that stop the program by signals may fail under the wrapper."""

import argparse
import collections
import json
import os
import re
import subprocess
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TESTS = ("engine", "program", "page")
COMMANDS = ("fill", "restore", "fair", "inspect", "check", "repair", "compare", "convert", "study", "sdf", "surface", "view", "completions", "man")
WRAPPER = """#!/bin/bash
messages=$(mktemp "{folder}/XXXXXX.messages")
echo "$1" > "$messages"
exec "{program}" "$@" 2> >(tee -a "$messages" >&2)
"""


def built():
    """The program and the test programs."""
    command = ["cargo", "test", "--profile", "ci", "--package", "isomend", "--no-run", "--message-format", "json"]
    command += [word for name in TESTS for word in ("--test", name)]
    done = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True)
    program, tests = None, []
    for line in done.stdout.splitlines():
        artefact = json.loads(line)
        if not artefact.get("executable"):
            continue
        if artefact["target"]["kind"] == ["bin"]:
            program = artefact["executable"]
        elif artefact["target"]["name"] in TESTS:
            tests.append(artefact["executable"])
    return program, tests


def pattern(line):
    line = re.sub(r"(/[\w.+-]+)+/?", "PATH", line)
    return re.sub(r"-?\d+(\.\d+)?(e[+-]?\d+)?", "#", line).strip()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, default=Path("messages.txt"))
    arguments = parser.parse_args()
    program, tests = built()
    with tempfile.TemporaryDirectory() as folder:
        wrapper = Path(folder) / "isomend"
        wrapper.write_text(WRAPPER.format(folder=folder, program=program))
        wrapper.chmod(0o755)
        for test in tests:
            environment = os.environ | {"CARGO_BIN_EXE_isomend": str(wrapper)}
            subprocess.run([test, "--quiet"], cwd=ROOT, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        seen = collections.defaultdict(collections.Counter)
        for path in Path(folder).glob("*.messages"):
            command, *lines = path.read_text(errors="replace").splitlines()
            seen[command if command in COMMANDS else "other"].update(filter(None, map(pattern, lines)))
    with arguments.output.open("w") as out:
        for command in sorted(seen):
            out.write(f"\n== {command}\n")
            out.writelines(f"{count:5} {line}\n" for line, count in seen[command].most_common())
    print(f"{sum(map(len, seen.values()))} different lines in {arguments.output}")


if __name__ == "__main__":
    main()
