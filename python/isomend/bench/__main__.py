"""Fills holes whose true surface is known, with isomend and all other installed programs, and scores the patches.

    python -m isomend.bench [--set exact|real|solids]... [--cases REGEX] [--only TOOL]... [--out DIR]

exact: spheres, tori, catenoids, ellipsoids, with noise and with a ragged rim; and holes of the bunny. real: holes all over meshes in the
package pymeshlab. solids: holes over edges and corners. Distances are root mean squares in 1/1000 of the hole's diameter, the larger of
patch to truth and truth to mesh. The smallest distance is bold; a dash is a failure, an open hole or a wrong topology, by the same test for
all programs. Expected errors: the share of new vertices that are nearer to the truth than `isomend_sigma`, and than twice this value. --out
writes the tables to bench.md, and the figures to bench.json after each hole."""

import argparse
import importlib.util
import json
import re
import sys
from pathlib import Path

import numpy as np

import isomend

from . import cases as known
from .peers import TOOLS, mean_edge
from .score import Reference, marked, marked_at_rim, score, to_truth

LEAST = 1e-4  # lower bound of distances in geometric means, in 1/1000 of the diameter
NO_ERRORS = [[], []]  # for a case that isomend did not close: no comparison of expected errors
SETS = {"exact": "exact surfaces, and the bunny", "real": "real meshes", "solids": "solids with sharp edges"}


def cases_of(name, pattern):
    """The cases of a set whose names match a regular expression."""
    if name == "exact":
        yield from known.cases(pattern, Reference, with_bunny=installed(["pymeshlab"]))
        if re.search(pattern, "sphere 60°, ragged"):
            yield known.ragged()
    elif name == "real":
        yield from (case for case in known.real_cases(Reference) if re.search(pattern, case.name))
    else:
        yield from (case for case in known.solid_cases(Reference) if re.search(pattern, case.name))


def installed(packages):
    return all(importlib.util.find_spec(name) for name in packages)


def filled(case):
    """isomend's result. In a mesh with other holes only the hole that was cut is filled."""
    found = isomend.Model(case.v, case.f).inspect()
    holes = None
    if hasattr(case, "centre"):
        wanted = min(found.holes, key=lambda h: (h.edges != case.rim, np.linalg.norm(np.array(h.centre) - case.centre)))
        holes = [wanted.id]
    return found.fill(holes=holes)


def scored(case, vertices, faces, seconds):
    """The score of a program's mesh; none if the hole is open or the topology is wrong. The test is the same for all programs."""
    vertices, faces = np.ascontiguousarray(vertices, float), np.ascontiguousarray(faces, np.int64)
    # Some programs close every hole of a real mesh; only the hole that was cut is scored.
    patch, closed = marked_at_rim(case, vertices, faces) if hasattr(case, "centre") else marked(case, vertices, faces)
    return {**score(case, vertices, faces, patch), "seconds": seconds} if closed and patch.any() else None


def by_isomend(case, mended):
    """isomend's score, and for each new vertex with an expected error whether it is nearer to the truth than once and twice this error."""
    found = scored(case, mended.vertices, mended.faces, mended.report["seconds"])
    if found is None:
        return None, NO_ERRORS
    new = np.arange(len(case.v), len(mended.vertices))
    expected, distance = mended.sigma[new], to_truth(case, mended.vertices[new])
    has_one = np.isfinite(expected) & (expected > 0)
    return found, [(distance[has_one] < times * expected[has_one]).tolist() for times in (1, 2)]


def measured(case, tools):
    """The scores of all programs for a case, without programs that failed; and how isomend's expected errors compare with its distances."""
    scores, below = {}, NO_ERRORS
    v, f, gone = case.whole
    aim = float(mean_edge(v, f[gone]))
    try:
        mended = filled(case)
        if mended.is_patch.any():
            aim = float(mean_edge(mended.vertices, mended.faces[mended.is_patch]))
        scores["isomend"], below = by_isomend(case, mended)
    except Exception as error:  # The remaining cases still run; the table has a dash for this one.
        print(f"{case.name}: isomend failed: {error}", file=sys.stderr)
    for tool in tools:
        try:
            vertices, faces, _, seconds = TOOLS[tool][2](case, aim)
            scores[tool] = scored(case, vertices, faces, seconds)
        except Exception as error:  # Other programs can raise anything; the table has a dash for them.
            print(f"{case.name}: {TOOLS[tool][0]} failed: {error}", file=sys.stderr)
    scores = {tool: found for tool, found in scores.items() if found}
    return {"case": case.name, "diameter": float(case.diameter), "scores": scores, "below": below}


def mean(values):
    """Geometric mean."""
    return float(np.exp(np.mean(np.log(np.maximum(values, LEAST)))))


def titles(tools):
    return {"isomend": "isomend", **{tool: TOOLS[tool][0] for tool in tools}}


def table(rows, tools):
    """Distances and seconds of each case, and geometric means over the cases that all programs closed."""
    names = titles(tools)
    lines = ["| hole | " + " | ".join(names.values()) + " |", "|---|" + "---:|" * len(names)]
    for row in rows:
        best = min((s["rms"] for s in row["scores"].values()), default=None)
        cells = []
        for tool in names:
            s = row["scores"].get(tool)
            text = "–" if s is None else f"{s['rms']:.2f} ‰"
            bold = "**" if s is not None and s["rms"] == best else ""
            cells.append(text if s is None else f"{bold}{text}{bold}, {s['seconds']:.2f} s")
        lines.append(f"| {row['case']} | " + " | ".join(cells) + " |")
    common = [row for row in rows if all(tool in row["scores"] for tool in names)]
    if common:
        means = (f"{mean([row['scores'][tool]['rms'] for row in common]):.1f} ‰" for tool in names)
        lines.append(f"| geometric mean of {len(common)} | " + " | ".join(means) + " |")
    return "\n".join(lines)


def calibration(rows):
    """The table of the shares of new vertices within once and twice their expected error."""
    one, two = (np.concatenate([np.array(row["below"][k], bool) for row in rows]) for k in (0, 1))
    shares = f"{100 * one.mean():.0f} % | {100 * two.mean():.0f} %" if len(one) else "– | –"
    return f"| new vertices | nearer than σ | nearer than 2 σ |\n|---:|---:|---:|\n| {len(one)} | {shares} |"


def needs_pymeshlab(name, pattern):
    """The title of the cases of a set that need the package pymeshlab; none if the pattern matches none of them."""
    if name == "real":
        return SETS[name]
    return "bunny" if name == "exact" and any(re.search(pattern, f"bunny, {place}") for place in known.BUNNY) else None


def write_json(folder, results):
    """Writes bench.json. It is called after each case, so that an interrupted run keeps its results."""
    if folder is None:
        return
    folder.mkdir(parents=True, exist_ok=True)
    part = folder / "bench.json.part"
    part.write_text(json.dumps(results) + "\n", encoding="utf-8")
    part.replace(folder / "bench.json")


def main(words=None):
    parser = argparse.ArgumentParser(prog="python -m isomend.bench", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--set", action="append", choices=SETS, dest="sets", help="set of holes [default: all]")
    parser.add_argument("--cases", default="", help="regular expression on names of holes")
    parser.add_argument("--only", action="append", choices=TOOLS, help="other program to run [default: all that are installed]")
    parser.add_argument("--alone", action="store_true", help="run isomend only")
    parser.add_argument("--out", type=Path, help="folder for bench.md and bench.json")
    arguments = parser.parse_args(words)
    tools = [] if arguments.alone else [tool for tool in arguments.only or TOOLS if installed(TOOLS[tool][1])]
    for tool in () if arguments.alone else arguments.only or TOOLS:
        if tool not in tools:
            print(f"{TOOLS[tool][0]} is LEFT OUT: it needs {' and '.join(TOOLS[tool][1])}", file=sys.stderr)
    results, pages = {}, []
    for name in arguments.sets or SETS:
        if not installed(["pymeshlab"]) and (what := needs_pymeshlab(name, arguments.cases)):
            print(f"{what}: LEFT OUT, the meshes come from the package pymeshlab, which is not installed", file=sys.stderr)
            if name == "real":
                continue
        rows = []
        for case in cases_of(name, arguments.cases):
            rows.append(measured(case, tools))
            own = rows[-1]["scores"].get("isomend")
            print(f"{case.name}:", f"{own['rms']:.2f} ‰" if own else "–", file=sys.stderr)
            results[name] = rows
            write_json(arguments.out, results)
        if rows:
            pages.append(f"## {SETS[name].capitalize()}\n\n{table(rows, tools)}\n\n{calibration(rows)}\n")
    page = f"# isomend {isomend.__version__}\n\n" + "\n".join(pages)
    print(page)
    if arguments.out and results:
        (arguments.out / "bench.md").write_text(page, encoding="utf-8")
    return 0 if results else 1


if __name__ == "__main__":
    sys.exit(main())
