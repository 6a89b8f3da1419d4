# /// script
# requires-python = ">=3.11"
# dependencies = ["numpy==2.4.6"]
# ///
"""Compare the CPU time and peak memory of two revisions on the same holes.

    uv run scripts/bench_guard.py BASE [--head REVISION] [--rounds 5] [--limit 1.25] [--folder DIR] [--json FILE]

(or in any virtual environment with numpy). BASE and REVISION are anything that git can check out; without --head the working tree is
measured. Both are built with the same profile (--profile, by default ci), in target/guard. Then both programs fill each mesh in turns, on
one thread. The ratio of a round is the CPU time of the head over the CPU time of the base, so that a change of the machine's speed between
rounds affects both. The script prints the median ratio of each mesh with the smallest and the largest, the geometric mean over the meshes,
and the ratio of peak memory.

Exit code 1: the geometric mean of the time or of the memory is above --limit.

Without --folder the meshes are made here: wavy closed surfaces with noise and many ragged holes of 6 to 90 edges, like scans; one with many
tiny holes; a large one with few holes; and data/scan.ply. --folder measures the meshes of a folder instead, --command another command
than fill (repair, check)."""

import argparse
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))
import make_data as data  # noqa: E402
from benchmark import surfaces  # noqa: E402

KINDS = {".ply", ".obj", ".stl", ".vtk", ".vtp", ".off", ".glb", ".3mf"}
# Name, subdivisions of the icosphere, noise in mean edges, and the holes: their number and the range of their radius in mean edges.
MADE = [
    ("ragged", 7, 0.15, 60, (1.5, 12.0)),
    ("smooth", 7, 0.0, 30, (2.0, 14.0)),
    ("tiny", 7, 0.1, 600, (0.8, 2.2)),
    ("large", 8, 0.05, 12, (3.0, 20.0)),
]


def icosphere(subdivisions):
    """Unit sphere: an octahedron with its faces split into four, `subdivisions` times."""
    v = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float)
    f = np.array([[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])
    for _ in range(subdivisions):
        edges = np.sort(f[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        pairs, number = np.unique(edges, axis=0, return_inverse=True)
        middle = len(v) + number.reshape(-1, 3)
        v = np.vstack([v, v[pairs].mean(axis=1)])
        v /= np.linalg.norm(v, axis=1, keepdims=True)
        a, b, c = f.T
        ab, bc, ca = middle.T
        f = np.stack([a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca], axis=1).reshape(-1, 3)
    return v, f


def wavy(subdivisions, noise, seed):
    """Vertices and faces of a closed surface whose radius varies in waves, with noise."""
    random = np.random.default_rng(seed)
    v, f = icosphere(subdivisions)
    directions = random.normal(size=(12, 3)) * 2.5
    phases, heights = random.uniform(0, 2 * np.pi, 12), random.normal(size=12) * 0.04
    radius = 1 + (np.sin(v @ directions.T + phases) * heights).sum(axis=1)
    edge = np.linalg.norm(v[f[:, 0]] - v[f[:, 1]], axis=1).mean()
    return v * (radius + random.normal(size=len(v)) * noise * edge)[:, None], f, edge


def with_holes(v, f, edge, count, radii, seed):
    """Cuts out ragged balls around vertices far from each other; returns the largest component."""
    random = np.random.default_rng(seed)
    middles = v[f].mean(axis=1)
    nearest = np.full(len(v), np.inf)
    stays = np.ones(len(f), bool)
    at = 0
    for _ in range(count):
        radius = random.uniform(*radii) * edge
        distance = np.linalg.norm(middles - v[at], axis=1)
        near = distance < 2 * radius
        wave = np.sin((middles[near] - v[at]) @ random.normal(size=(3, 2)) * 3 / radius).sum(axis=1)
        stays[near] &= distance[near] > radius * (1 + 0.2 * wave)
        nearest = np.minimum(nearest, np.linalg.norm(v - v[at], axis=1))
        at = int(nearest.argmax())
    v, f = surfaces.cut(v, f, ~stays)
    component = surfaces.components(f)
    return surfaces.cut(v, f, component != np.bincount(component).argmax())


def meshes(folder, given):
    """The mesh files to fill: the files of a given folder, else meshes made here and data/scan.ply."""
    if given:
        return sorted(path for path in Path(given).iterdir() if path.suffix.lower() in KINDS)
    made = []
    for seed, (name, subdivisions, noise, count, radii) in enumerate(MADE):
        path = Path(folder) / f"{name}.ply"
        data.write_ply(path, *with_holes(*wavy(subdivisions, noise, seed), count, radii, seed))
        made.append(path)
    return [*made, ROOT / "data/scan.ply"]


def built(revision, name, profile):
    """Builds and returns the program of a revision, or of the working tree if none is given."""
    source = ROOT
    target = ROOT / "target/guard" / name
    if revision:
        source = target / "source"
        subprocess.run(["git", "worktree", "prune"], cwd=ROOT, check=True)
        if source.exists():
            subprocess.run(["git", "checkout", "--quiet", "--detach", revision], cwd=source, check=True)
        else:
            subprocess.run(["git", "worktree", "add", "--quiet", "--detach", source, revision], cwd=ROOT, check=True)
    environment = os.environ | {"CARGO_TARGET_DIR": str(target)}
    command = ["cargo", "build", "--quiet", "--locked", "--profile", profile, "--bin", "isomend"]
    subprocess.run(command, cwd=source, env=environment, check=True)
    return target / profile / "isomend"


def measured(program, command, source, target):
    """CPU seconds and peak memory, in MB, of one run."""
    line = [sys.executable, "-S", ROOT / "scripts/timed.py", program, command, source, *target, "--threads", "1", "-q"]
    done = subprocess.run(line, capture_output=True, text=True)
    figures = json.loads(done.stderr.splitlines()[-1])
    if not figures["ok"]:
        sys.exit(f"{program} {command} {source} ended with {figures['code']}: {done.stderr.strip()}")
    return figures["cpu"], figures["mb"]


def geometric_mean(values):
    return math.exp(statistics.fmean(math.log(value) for value in values))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("base", help="revision to compare with")
    parser.add_argument("--head", help="revision to measure [default: the working tree]")
    parser.add_argument("--profile", default="ci", help="profile of the builds [default: ci]")
    parser.add_argument("--programs", nargs=2, type=Path, help="programs of base and head, instead of building them")
    parser.add_argument("--program", type=Path, help="program of the head, instead of building it")
    parser.add_argument("--command", default="fill", choices=("fill", "repair", "check"))
    parser.add_argument("--folder", help="folder of meshes to measure")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--limit", type=float, default=1.25)
    parser.add_argument("--json", type=Path, help="file for all figures")
    arguments = parser.parse_args()
    programs = arguments.programs or [
        built(arguments.base, "base", arguments.profile),
        arguments.program or built(arguments.head, "head", arguments.profile),
    ]
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        target = [] if arguments.command == "check" else ["-o", f"{folder}/out.ply"]
        for path in meshes(folder, arguments.folder):
            rounds = []
            for number in range(arguments.rounds):
                # The order alternates, so that neither program always runs on the warmer cache.
                order = (0, 1) if number % 2 == 0 else (1, 0)
                figures = {which: measured(programs[which], arguments.command, path, target) for which in order}
                rounds.append((figures[0], figures[1]))
            ratios = [head[0] / base[0] for base, head in rounds]
            memory = statistics.median(head[1] / base[1] for base, head in rounds)
            seconds = [statistics.median(r[which][0] for r in rounds) for which in (0, 1)]
            rows.append({"mesh": path.stem, "seconds": seconds, "ratios": ratios, "memory": memory})
            spread = f"{min(ratios):.3f} to {max(ratios):.3f}"
            print(f"{path.stem:20} {seconds[0]:8.2f} s -> {seconds[1]:8.2f} s   {statistics.median(ratios):.3f} ({spread})   memory {memory:.3f}")
    time = geometric_mean([statistics.median(row["ratios"]) for row in rows])
    memory = geometric_mean([row["memory"] for row in rows])
    print(f"{'all':20} time {time:.3f}, memory {memory:.3f}; limit {arguments.limit}")
    if arguments.json:
        arguments.json.write_text(json.dumps({"time": time, "memory": memory, "meshes": rows}, indent=1))
    if max(time, memory) > arguments.limit:
        sys.exit(f"slower or larger than {arguments.base} by more than the limit")


if __name__ == "__main__":
    main()
