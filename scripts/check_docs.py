"""Check the documentation: its commands run, its links have targets, its tables come from the scripts, the README is short.

    cargo build --release && python3 scripts/check_docs.py [--isomend PROGRAM] [PAGE...]

The commands of a page run in its order, in a separate folder. Commands of `isomend study`, which take minutes, and of `isomend view`,
which runs until Ctrl-C, are only parsed. What follows a `|` is left out if that program is not installed. Output that a page shows after
`$ COMMAND` must be the command's output. It needs only Python."""

import argparse
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from summary import summary
from tables import PAGES, ROOT, cells, split

MOST_BYTES = 8000
HELPERS = ("jq", "man")
COMMANDS = ("fill", "restore", "fair", "inspect", "check", "repair", "compare", "convert", "study", "sdf", "surface", "view", "mcp", "completions", "man")
# Commands that are run with --help only.
PARSED = ("isomend study", "isomend view")


def blocks(text, language):
    return re.findall(rf"^```{language}\n(.*?)^```$", text, re.M | re.S)


def anchors(page):
    """The anchors of a page's headings, by the rules of GitHub."""
    headings = re.findall(r"^#+ (.*)$", re.sub(r"^```.*?^```$", "", page.read_text(), flags=re.M | re.S), re.M)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def check_links(page):
    wrong = []
    for link in re.findall(r"\]\(([^)\s]+)\)", page.read_text()):
        if "://" in link:
            continue
        path, _, anchor = link.partition("#")
        target = (page.parent / path) if path else page
        if not target.exists() or (anchor and anchor not in anchors(target)):
            wrong.append(f"the link {link} has no target")
    return wrong


def commands(text):
    """The commands of a page, each with the output that the page shows, or none if it shows none."""
    found = []
    for match in re.finditer(r"^```(sh|console)\n(.*?)^```$", text, re.M | re.S):
        if match[1] == "console":
            line, _, output = match[2].partition("\n")
            found.append((line.removeprefix("$ "), output))
        else:
            found += [(line.split("  #")[0].strip(), None) for line in match[2].splitlines()]
    return [(line, output) for line, output in found if line.split(" ")[0] in ("isomend", "mkdir")]


def run(line, folder, environment):
    return subprocess.run(["bash", "-o", "pipefail", "-c", line], cwd=folder, env=environment, capture_output=True, text=True)


def check_commands(text, program):
    wrong = []
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        (folder / "bin").mkdir()
        (folder / "bin/isomend").symlink_to(program)
        desk = folder / "desk"
        desk.mkdir()
        (desk / "data").symlink_to(ROOT / "data")
        environment = os.environ | {"PATH": f"{folder / 'bin'}:{os.environ['PATH']}", "HOME": str(folder)}
        todo = commands(text)
        for number, options in enumerate(blocks(text, "toml")):
            if "[fill]" in options:
                (desk / f"{number}.toml").write_text(options)
                todo.append((f"isomend fill data/scan.ply --dry-run --config {number}.toml", None))
        for line, output in todo:
            for name in HELPERS:
                if not shutil.which(name):
                    line = line.split(f" | {name} ")[0]
            done = run(f"{line} --help" if line.startswith(PARSED) else line, desk, environment)
            # `isomend check` ends with 3 if the mesh is not sound.
            if done.returncode != 0 and not (line.startswith("isomend check") and done.returncode == 3):
                wrong.append(f"'{line}' ended with {done.returncode}: {done.stderr.strip()}")
            elif output is not None and done.stdout != output:
                wrong.append(f"'{line}' prints something else now:\n{done.stdout}")
    return wrong


def check_fills(text, program):
    """Checks that each table of holes on a page is printed by a fill of data/scan.ply on that page, save for run times."""
    shown = [block.splitlines() for block in blocks(text, "text") if "hole  diameter" in block]
    fills = [line.split("#")[0] for block in blocks(text, "sh") for line in block.splitlines() if line.startswith("isomend fill data/scan.ply")]

    def timeless(lines):
        return {re.sub(r"; [0-9.]+ s$", "", line) for line in lines} - {"..."}

    printed = []
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "data").symlink_to(ROOT / "data")
        for fill in fills if shown else []:
            done = subprocess.run([program, *shlex.split(fill)[1:]], cwd=folder, capture_output=True, text=True)
            printed.append(timeless(done.stderr.splitlines()))
    return [f"no fill of the page prints the table with {lines[1].split()}" for lines in shown if not any(timeless(lines) <= p for p in printed)]


def check_options(text, program):
    """Checks that the text describes every option of every command, and no other options."""
    there = set()
    for command in COMMANDS:
        text_of = subprocess.run([program, command, "--help"], capture_output=True, text=True, check=True).stdout
        there |= set(re.findall(r"^ +(?:-\w, )?(--[a-z][a-z0-9-]*)", text_of, re.M))
    text = re.sub(r"\]\([^)]*\)", "", text)
    described = set(re.findall(r"--[a-z][a-z0-9-]*", text)) | {"--finest", "--csv", "--plot", "--series"}
    return [f"the option {o} is not described" for o in sorted(there - described - {"--quiet", "--verbose"})] + [
        f"there is no option {o}" for o in sorted(described - there - {"--version"})
    ]


def check_tables():
    wrong = []
    for name, page in PAGES.items():
        script = re.search(rf"<!-- {name}: scripts/(\S+) -->", (ROOT / page).read_text())
        if not script or not (ROOT / "scripts" / script[1]).exists():
            wrong.append(f"{page} has no table {name} of a script")
        elif not cells(name, script[1]):
            wrong.append(f"the table {name} in {page} is empty")
    if split("summary", "summary.py")[2] != summary():
        wrong.append("the table of README.md differs from docs/speed.md: run scripts/summary.py")
    return wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--isomend", type=Path, default=ROOT / "target/release/isomend", help="the program")
    parser.add_argument("pages", nargs="*", type=Path, help="pages whose commands to run [default: all]")
    arguments = parser.parse_args()
    program = arguments.isomend.resolve()
    pages = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "SECURITY.md", *sorted((ROOT / "docs").glob("*.md"))]
    wrong = check_tables()
    size = (ROOT / "README.md").stat().st_size
    if size > MOST_BYTES:
        wrong.append(f"README.md has {size} bytes, more than {MOST_BYTES}")
    wrong += check_options((ROOT / "docs/options.md").read_text(), program)

    def check(page):
        found = check_links(page)
        if not arguments.pages or page in [p.resolve() for p in arguments.pages]:
            found += check_commands(page.read_text(), program) + check_fills(page.read_text(), program)
        return [f"{page.relative_to(ROOT)}: {what}" for what in found]

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for found in pool.map(check, pages):
            wrong += found
    if wrong:
        sys.exit("\n".join(wrong))
    print(f"{len(pages)} pages are right")


if __name__ == "__main__":
    main()
