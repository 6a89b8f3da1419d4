"""Checks the meshes of a folder and writes a table of them: the work of the action in action.yml.

    FILES='**/*.stl' python3 scripts/action/check.py --isomend PROGRAM

FILES and EXCLUDE are patterns, one a line, OPTIONS further options of `isomend check`. The table goes to the file that GITHUB_STEP_SUMMARY
names, or to standard output, the number of unsound meshes to GITHUB_OUTPUT. It ends with 0 if all meshes are sound, with 1 if not, with 2 if
there is none or an option is wrong. It needs only Python."""

import argparse
import glob
import json
import os
import shlex
import subprocess
import sys

# Most meshes for one run of the program: its command line has a largest length.
MOST = 100
# Most rows of the table; a summary may have 1 MiB.
MOST_ROWS = 500


def listed(name):
    """The files of the patterns in a variable of the environment, in order of their names."""
    patterns = [line.strip() for line in os.environ.get(name, "").splitlines() if line.strip()]
    return sorted({path for pattern in patterns for path in glob.glob(pattern, recursive=True) if os.path.isfile(path)})


def checked(program, files, options):
    """The documents of files: what the program writes with --json, and its exit code."""
    # Behind `--`, no name is taken for an option.
    command = [program, "check", "-q", "--json", "-", *options, "--", *files]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True)
    if done.returncode not in (0, 1, 3):
        sys.exit(2)
    if not done.stdout.strip():
        # A single file that cannot be read has no document; the program has printed why.
        return [{"input": {"path": path}, "error": "it cannot be read; see the log"} for path in files]
    documents = json.loads(done.stdout)
    return documents if isinstance(documents, list) else [documents]


def cell(text):
    """A text in a table of Markdown."""
    return " ".join(str(text).split()).replace("\\", "\\\\").replace("|", "\\|").replace("<", "&lt;")


def escaped(text, more=""):
    """A text in a workflow command, with further characters to escape."""
    return "".join(f"%{ord(c):02X}" if c in "%\r\n" + more else c for c in text)


def row(document):
    """A row of the table: name, faces, components, verdict."""
    name = f"`{cell(document['input']['path'])}`"
    if "error" in document:
        return f"| {name} | | | ❌ {cell(document['error'])} |"
    verdict = "✅" if document["sound"] else f"❌ {cell(', '.join(document['reasons']))}"
    return f"| {name} | {document['input']['faces']} | {document['components']} | {verdict} |"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--isomend", default="isomend", help="the program")
    program = parser.parse_args().isomend
    excluded = set(listed("EXCLUDE"))
    files = [path for path in listed("FILES") if path not in excluded]
    if not files:
        print("no mesh matches the patterns of FILES", file=sys.stderr)
        return 2
    options = shlex.split(os.environ.get("OPTIONS", ""))
    documents = []
    for start in range(0, len(files), MOST):
        documents += checked(program, files[start : start + MOST], options)
    unsound = [d for d in documents if not d.get("sound")]
    # Unsound ones first, since a long table is cut.
    rows = [row(d) for d in sorted(documents, key=lambda d: bool(d.get("sound")))]
    more = [f"| … and {len(rows) - MOST_ROWS} more | | | |"] if len(rows) > MOST_ROWS else []
    head = [f"### {len(unsound)} of {len(documents)} meshes are not sound" if unsound else f"### All {len(documents)} meshes are sound", ""]
    table = "\n".join([*head, "| mesh | faces | components | watertight and printable |", "|---|---|---|---|", *rows[:MOST_ROWS], *more]) + "\n"
    for name, text in (("GITHUB_STEP_SUMMARY", table), ("GITHUB_OUTPUT", f"unsound={len(unsound)}\n")):
        if os.environ.get(name):
            with open(os.environ[name], "a", encoding="utf-8") as file:
                file.write(text)
    if not os.environ.get("GITHUB_STEP_SUMMARY"):
        print(table, end="")
    for document in unsound:
        what = document.get("error") or ", ".join(document["reasons"])
        print(f"::error file={escaped(document['input']['path'], ':,')}::{escaped(' '.join(what.split()))}")
    return 1 if unsound else 0


if __name__ == "__main__":
    sys.exit(main())
