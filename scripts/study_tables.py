"""Renews the tables of `isomend study` in docs/experiments.md from the reports in a folder: `scripts/study_tables.py DIR`.

`scripts/study.sh DIR` makes the reports and calls this script. Tables without a report in the folder are not changed.
"""

import json
import math
import pathlib
import re
import sys

from tables import renew

EXPERIMENTS = ["cap", "table1", "circle", "graph", "merge", "orthogonal", "surfaces"]


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|---|" + "---:|" * (len(head) - 1)]
    return lines + ["| " + " | ".join(cells) + " |" for cells in rows]


def columns(study_table):
    return {name: i for i, name in enumerate(study_table["columns"])}


def title(study_table):
    return study_table["title"].split(",")[0] if "not critical" in study_table["title"] else study_table["title"]


def errors(studies):
    """Errors of the fills of exact surfaces, by size."""
    tables = [t for t in studies["tables"] if "D / h" in t["columns"]]
    sizes = [r[0] for r in tables[0]["rows"]]
    head = ["surface", f"D/h = {sizes[0]}", *map(str, sizes[1:]), "order 32 → 64", f"normal at {sizes[-1]}"]
    lines = []
    for t in tables:
        at, rows = columns(t), t["rows"]
        cells = [title(t)]
        for r in rows:
            star = "" if r[at["converged"]] == "yes" else "\\*"
            cells.append(f"{r[at['largest / D']]:.1e}{star}")
        exact = rows[-1][at["largest / D"]] < 1e-12 or "not critical" in t["title"]
        order = math.log2(rows[1][at["rms / D"]] / rows[2][at["rms / D"]]) if len(rows) > 2 else math.nan
        cells.append("" if exact else f"{order:.1f}")
        cells.append(f"{rows[-1][at['normal, degrees']]:.2g}°")
        lines.append(cells)
    return table(head, lines)


def schemes(study):
    """The comparison of the schemes: the last table of `surfaces`."""
    found = study["tables"][-1]
    head = [c for c in found["columns"] if c != "s"]
    at = columns(found)

    def shown(value):
        return f"{value:.4g}" if isinstance(value, float) else str(value)

    return [f"{found['title'][0].upper()}{found['title'][1:]}:", ""] + table(
        head, [[shown(r[at[c]]) for c in head] for r in found["rows"]]
    )


def claims(studies):
    """The stated values of the experiments beside the measured ones."""
    rows, falling = [], []
    for study in studies:
        for claim in study["claims"]:
            held = "" if claim["holds"] else " (not met)"
            # That the energy falls is one row for all runs in which it does.
            if claim["holds"] and claim["stated"] == "falls in every step":
                falling.append(claim["got"])
            else:
                rows.append([f"`{study['name']}`", claim["what"], claim["stated"], claim["by"], claim["got"] + held])
    if falling:
        steps = sum(int(re.fullmatch(r"0 rises in (\d+) steps", got)[1]) for got in falling)
        rows.append(["all", f"energy of {len(falling)} runs", "falls in every step", "theory", f"0 rises in {steps} steps"])
    return ["| experiment | what | stated | by | got |", "|---|---|---|---|---|"] + [
        "| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in rows
    ]


def main():
    folder = pathlib.Path(sys.argv[1])
    paths = [folder / f"{name}.json" for name in EXPERIMENTS]
    if all(path.exists() for path in paths):
        studies = [json.loads(path.read_text()) for path in paths]
        renew("experiments", "study_tables.py", "\n".join(claims(studies)))
    for name, make in [
        ("patches", errors),
        ("patches-curvature-variation", errors),
        ("surfaces", schemes),
    ]:
        path = folder / f"{name}.json"
        if path.exists():
            renew(name, "study_tables.py", "\n".join(make(json.loads(path.read_text()))))


if __name__ == "__main__":
    main()
