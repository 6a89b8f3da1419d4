"""Puts the errors of `isomend study patches --json FILE` into the README's table: `scripts/readme_patches.py FILE`."""

import json
import math
import pathlib
import sys

README = pathlib.Path(__file__).parent.parent / "README.md"
BEGIN = "<!-- patches: scripts/readme_patches.py -->\n"
END = "<!-- end -->\n"


def row(table):
    columns = {name: i for i, name in enumerate(table["columns"])}
    rows = table["rows"]

    def entry(r, name):
        return r[columns[name]]

    cells = [table["title"].split(",")[0] if "not critical" in table["title"] else table["title"]]
    for r in rows:
        star = "" if entry(r, "steady") == "yes" else "*"
        cells.append(f"{entry(r, 'largest / D'):.1e}{star}")
    order = math.log2(entry(rows[1], "rms / D") / entry(rows[2], "rms / D")) if len(rows) > 2 else math.nan
    exact = entry(rows[-1], "largest / D") < 1e-12 or "not critical" in table["title"]
    cells.append("" if exact else f"{order:.1f}")
    cells.append(f"{entry(rows[-1], 'normal, degrees'):.2g}°" if not exact or "not" in table["title"] else "0°")
    return "| " + " | ".join(cells) + " |"


def main():
    study = json.loads(pathlib.Path(sys.argv[1]).read_text())
    tables = study["tables"]
    sizes = [r[0] for r in tables[0]["rows"]]
    head = ["surface", f"D/h = {sizes[0]}", *map(str, sizes[1:]), "order 32 → 64", f"normal at {sizes[-1]}"]
    lines = ["| " + " | ".join(head) + " |", "|---|" + "---:|" * (len(head) - 1)]
    lines += [row(t) for t in tables if "D / h" in t["columns"]]
    text = README.read_text()
    before, rest = text.split(BEGIN, 1)
    after = rest.split(END, 1)[1]
    README.write_text(before + BEGIN + "\n".join(lines) + "\n" + END + after)


if __name__ == "__main__":
    main()
