"""Make the README's short table of errors and times from the table that scripts/bench_peers.py wrote into docs/speed.md.

    python3 scripts/summary.py"""

from tables import cells, renew

TOOLS = {
    "isomend": "isomend",
    "CGAL, fairing continuity 2": "CGAL, continuity 2",
    "MeshLib, fillHoleNicely": "MeshLib",
    "MeshLib + libigl k = 3 × 10": "MeshLib + libigl",
    "MeshLab, close holes, refined": "MeshLab",
}


def summary():
    """The table: error and seconds for each hole, with the smallest error bold, and seconds of the whole process."""
    head, *rows = cells("peers", "bench_peers.py")
    figures = {row[0]: dict(zip(head, row)) for row in rows if row[0] in TOOLS}
    tools = [tool for tool in TOOLS if tool in figures]
    lines = ["| hole | " + " | ".join(TOOLS[tool] for tool in tools) + " |", "|---|" + "---|" * len(tools)]
    for hole in head[1:-2]:
        made = [figures[tool][hole].partition(" s, ")[::2] for tool in tools]
        errors = [float(error.split()[0]) if error.endswith("‰") else float("inf") for _, error in made]
        shown = []
        for (seconds, error), value in zip(made, errors):
            bold = "**" if value == min(errors) else ""
            shown.append(f"{bold}{error}{bold}, {seconds} s" if error else seconds)
        lines.append(f"| {hole} | " + " | ".join(shown) + " |")
    seconds, megabytes = head[-2:]
    whole = (f"{figures[tool][seconds]} s, {figures[tool][megabytes]} MB" for tool in tools)
    lines.append("| the whole process | " + " | ".join(whole) + " |")
    return "\n".join(lines)


def renew_summary():
    """Writes the table into the README."""
    renew("summary", "summary.py", summary())


if __name__ == "__main__":
    renew_summary()
