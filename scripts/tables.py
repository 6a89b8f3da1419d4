"""Reads and writes the tables that scripts make for the documentation: the text between `<!-- NAME: SCRIPT -->` and `<!-- end -->`."""

import pathlib

ROOT = pathlib.Path(__file__).resolve().parent.parent
END = "<!-- end -->"
PAGES = {
    "summary": "README.md",
    "accuracy": "docs/accuracy.md",
    "libigl": "docs/accuracy.md",
    "real": "docs/accuracy.md",
    "sigma": "docs/accuracy.md",
    "edges": "docs/accuracy.md",
    "edges-measures": "docs/accuracy.md",
    "peers": "docs/speed.md",
    "scaling": "docs/speed.md",
    "memory": "docs/speed.md",
    "experiments": "docs/experiments.md",
    "surfaces": "docs/experiments.md",
    "patches": "docs/experiments.md",
    "patches-curvature-variation": "docs/experiments.md",
    "fleet": "docs/fleets.md",
    "repair": "docs/accuracy.md",
}


def split(name, script):
    """The page of a table, and its text before, in and after the table."""
    page = ROOT / PAGES[name]
    start = f"<!-- {name}: scripts/{script} -->\n"
    before, found, rest = page.read_text().partition(start)
    table, ended, behind = rest.partition(f"\n{END}")
    if not (found and ended):
        raise SystemExit(f"{PAGES[name]} has no line {start.strip()} with a line {END} after it")
    return page, before + start, table, f"\n{END}{behind}"


def renew(name, script, text):
    """Replaces a table in its page."""
    page, before, _, behind = split(name, script)
    page.write_text(before + text + behind)


def cells(name, script):
    """The rows of a table in its page, with the heading first. Several tables between the marks are joined."""
    table = split(name, script)[2]
    rows = [line.strip().strip("|") for line in table.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in row.split("|")] for row in rows if set(row) - set("|-: ")]
