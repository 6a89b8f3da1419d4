"""The tables that scripts write into the pages: what stands between `<!-- NAME: SCRIPT -->` and the next `<!-- end -->`."""

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
    "experiments": "docs/experiments.md",
    "surfaces": "docs/experiments.md",
    "patches": "docs/experiments.md",
    "patches-curvature-variation": "docs/experiments.md",
    "fleet": "docs/fleets.md",
    "repair": "docs/repair.md",
}


def split(name, script):
    """The page of a table, and its text before, in and behind the table."""
    page = ROOT / PAGES[name]
    start = f"<!-- {name}: scripts/{script} -->\n"
    before, found, rest = page.read_text().partition(start)
    table, ended, behind = rest.partition(f"\n{END}")
    if not (found and ended):
        raise SystemExit(f"{PAGES[name]} has no line {start.strip()} with a line {END} behind it")
    return page, before + start, table, f"\n{END}{behind}"


def renew(name, script, text):
    """Puts a table into its page."""
    page, before, _, behind = split(name, script)
    page.write_text(before + text + behind)


def cells(name, script):
    """The rows of a table in its page, the heading first, those of several tables one after the other."""
    table = split(name, script)[2]
    rows = [line.strip().strip("|") for line in table.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in row.split("|")] for row in rows if set(row) - set("|-: ")]
