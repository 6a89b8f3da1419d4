# /// script
# requires-python = ">=3.11"
# dependencies = ["numpy==2.4.6"]
# ///
"""Measure how time and memory of `isomend fill` grow with D/h, triangles outside the hole, holes and threads, and the exponents.

    cargo build --release && python3 scripts/scaling.py [--json FILE] [--markdown FILE] [--docs] [--quick]
    python3 scripts/scaling.py --cut 50 IN.ply OUT.ply        # only cut holes into a large mesh, to time it
    python3 scripts/scaling.py --large 10000000 10 OUT.ply    # only make a mesh with this number of triangles and holes
    python3 scripts/scaling.py --memory 2000000 10000000 --docs    # only the memory of meshes of these sizes

The meshes are tori with round holes, made here. Every run is a separate process; its time and peak memory are measured from outside.
An exponent is the slope of log CPU time against log size, over all sizes and over the largest two; constant costs, such as the
start of the process, make the first one smaller. CPU time depends less on other load of the machine than wall time."""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))
from make_data import write_ply  # noqa: E402
from tables import renew  # noqa: E402

RING, TUBE = 3.0, 1.0


# --- meshes ---------------------------------------------------------------------------------------------------------


def read_ply(path):
    """Positions and triangles of a binary PLY whose vertices begin with x, y and z as 32-bit floats."""
    data = Path(path).read_bytes()
    header, body = data.split(b"end_header\n", 1)
    size = {"char": 1, "uchar": 1, "short": 2, "ushort": 2, "int": 4, "uint": 4, "float": 4, "double": 8}
    elements = []
    for line in header.decode("latin1").splitlines():
        words = line.split()
        if words[:1] == ["element"]:
            elements.append([words[1], int(words[2]), []])
        elif words[:1] == ["property"]:
            elements[-1][2].append(words[1:])
    (_, count, fields), (_, triangles, lists) = elements[:2]
    stride = sum(size[kind] for kind, _ in fields)
    vertices = np.frombuffer(body, np.uint8, count * stride).reshape(count, stride)[:, :12].copy().view("<f4")
    if b"binary_little_endian" not in header or len(lists) != 1 or lists[0][:2] != ["list", "uchar"]:
        raise ValueError(f"{path}: not a binary PLY file with triangles only")
    rows = np.frombuffer(body, np.dtype([("n", "u1"), ("v", "<i4", 3)]), triangles, count * stride)
    return vertices.astype(float), rows["v"].astype(np.int64)


def torus(triangles, ring=RING):
    """A torus with about `triangles` triangles, nearly equilateral halfway between its inner and outer equator."""
    across = max(8, 2 * round((triangles * TUBE / ring / 3**0.5) ** 0.5 / 2))
    around = max(8, round(triangles / 2 / across))
    i, j = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")
    u, w = 2 * np.pi * (i + 0.5 * (j % 2)) / around, 2 * np.pi * j / across
    reach = ring + TUBE * np.cos(w)
    vertices = np.stack([reach * np.cos(u), reach * np.sin(u), TUBE * np.sin(w)], axis=-1).reshape(-1, 3)

    def at(a, b):
        return (i + a) % around * across + (j + b) % across

    even = (j % 2 == 0)[..., None]
    one = np.where(even, np.stack([at(0, 0), at(1, 0), at(0, 1)], -1), np.stack([at(0, 0), at(1, 1), at(0, 1)], -1))
    two = np.where(even, np.stack([at(1, 0), at(1, 1), at(0, 1)], -1), np.stack([at(0, 0), at(1, 0), at(1, 1)], -1))
    return vertices, np.stack([one, two], axis=2).reshape(-1, 3)


def is_disc(faces):
    """Whether faces form a disc: connected, Euler characteristic 1."""
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    edges = np.unique(edges, axis=0)
    corners, number = np.unique(edges, return_inverse=True)
    number = number.reshape(-1, 2)
    label = np.arange(len(corners))
    while True:
        low = label[number].min(axis=1)
        new = label.copy()
        np.minimum.at(new, number[:, 0], low)
        np.minimum.at(new, number[:, 1], low)
        if np.array_equal(new, label):
            break
        label = new
    return not label.any() and len(corners) - len(edges) + len(faces) == 1


def cut_balls(vertices, faces, centres, radius, want=None, apart=3.0):
    """Removes the faces with centroids in the balls. With `want` only that number of balls is cut: the first with a disc of more than 50
    faces, and centres at least `apart` radii from each other. Returns the remaining vertices and faces."""
    middle = vertices[faces].mean(axis=1)
    order = np.argsort(middle[:, 0])
    along = middle[order, 0]
    gone, kept = np.zeros(len(faces), bool), []
    for centre in centres:
        if want is not None and (len(kept) == want or any(np.linalg.norm(centre - c) < apart * radius for c in kept)):
            continue
        near = order[slice(*np.searchsorted(along, [centre[0] - radius, centre[0] + radius]))]
        near = near[((middle[near] - centre) ** 2).sum(axis=1) < radius**2]
        if want is None or (len(near) > 50 and is_disc(faces[near])):
            gone[near] = True
            kept.append(centre)
    if want is not None and len(kept) < want:
        raise ValueError(f"only {len(kept)} of {want} holes have room")
    faces = faces[~gone]
    used = np.zeros(len(vertices), bool)
    used[faces] = True
    return vertices[used], (np.cumsum(used) - 1)[faces]


def places(count, ring=RING):
    """Points spread evenly on the torus, the centres of holes."""
    across = max(1, round((count * TUBE / ring) ** 0.5))
    k = np.arange(count)
    u, w = 2 * np.pi * (k // across) / -(-count // across), 2 * np.pi * (k % across + 0.5) / across
    w = w + 0.5 if count > 1 else 0 * w
    reach = ring + TUBE * np.cos(w)
    return np.stack([reach * np.cos(u), reach * np.sin(u), TUBE * np.sin(w)], axis=1)


def made(triangles, holes, edges_wide, ring=RING):
    """A torus with holes, each about `edges_wide` edges wide."""
    vertices, faces = torus(triangles, ring)
    edge = 2 * np.pi * TUBE * (ring / TUBE * 4 / 3**0.5 / triangles) ** 0.5
    return cut_balls(vertices, faces, places(holes, ring), edges_wide * edge / 2)


def cut_holes(source, holes, part):
    """A mesh file with holes cut into it: `holes` is their number, `part` their width over the diagonal of the bounding box."""
    vertices, faces = read_ply(source)
    radius = part * np.linalg.norm(np.ptp(vertices, axis=0)) / 2
    seeds = np.random.default_rng(50).choice(len(vertices), 40 * holes, replace=False)
    return cut_balls(vertices, faces, vertices[seeds], radius, holes)


# --- runs -----------------------------------------------------------------------------------------------------------


def run(program, source, folder, *options):
    """Runs one fill in a separate process; returns its figures (wall and CPU seconds, peak memory in MB) and its report."""
    report = Path(folder) / "report.json"
    command = [program, "fill", source, "-o", Path(folder) / "out.ply", "--json", report, "-q", *options]
    command = [sys.executable, "-S", ROOT / "scripts/timed.py", *command]
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    figures = json.loads(done.stderr.splitlines()[-1])
    if not figures["ok"]:
        raise RuntimeError(f"exit {figures['code']}: {done.stderr[-500:]}")
    return figures, json.loads(report.read_text())


def median_run(program, source, folder, times, *options):
    runs = []
    # Runs are not repeated once they have taken a minute of CPU time.
    while len(runs) < times and sum(figures["cpu"] for figures, _ in runs) < 60:
        runs.append(run(program, source, folder, *options))
    report = runs[0][1]
    outcomes = [hole["outcome"] for hole in report["holes"]]
    median = {key: float(np.median([figures[key] for figures, _ in runs])) for key in ("wall", "cpu", "mb")}
    return {
        "seconds": median["wall"],
        "cpu_seconds": median["cpu"],
        "mb": median["mb"],
        "library_seconds": float(np.median([own["seconds"] for _, own in runs])),
        "triangles": report["faces"],
        "holes": len(outcomes),
        "closed": outcomes.count("closed"),
    }, report


def slope(sizes, values):
    x, y = np.log(np.array(sizes, float)), np.log(np.array(values, float))
    return float(np.polyfit(x, y, 1)[0])


def exponents(name, rows, key):
    sizes = [row[key] for row in rows]
    result = {}
    for value in ("seconds", "cpu_seconds", "mb"):
        values = [row[value] for row in rows]
        result[value] = {"all": slope(sizes, values), "last": slope(sizes[-2:], values[-2:])}
    return {"study": name, "size": key, "rows": rows, "exponents": result}


def study_grid(program, folder, times, quick):
    source = folder / "grid.ply"
    write_ply(source, *made(20_000, 1, 24))
    diameter = run(program, source, folder)[1]["regions"][0]["diameter"]
    rows = []
    for cells in (16, 32, 64) if quick else (16, 32, 64, 128, 256):
        row, report = median_run(program, source, folder, times, "--voxel", diameter / cells)
        levels = report["regions"][0]["levels"]
        row |= {"size": cells, "unknowns": levels[-1]["flow"]["unknowns"]}
        rows.append(row)
    return exponents("voxels across the hole, D/h", rows, "size")


def study_triangles(program, folder, times, quick):
    rows = []
    for count in (10**4, 10**5) if quick else (10**4, 10**5, 10**6, 10**7):
        source = folder / "triangles.ply"
        # A longer tube, not a finer mesh, so that the hole and its surroundings stay the same.
        write_ply(source, *made(count, 1, 20, RING * count / 10**4))
        rows.append(median_run(program, source, folder, times)[0] | {"size": count})
    return exponents("triangles outside one hole", rows, "size")


def study_holes(program, folder, times, quick):
    rows, voxel = [], None
    for count in (1, 10) if quick else (1, 10, 100, 1000):
        source = folder / "holes.ply"
        write_ply(source, *made(1_000_000, count, 10))
        voxel = voxel or run(program, source, folder)[1]["regions"][0]["diameter"] / 16
        rows.append(median_run(program, source, folder, times, "--voxel", voxel)[0] | {"size": count})
    return exponents("holes in a mesh of 10⁶ triangles, D/h = 16", rows, "size")


def study_threads(program, folder, times, quick):
    source = folder / "threads.ply"
    write_ply(source, *made(100_000, 16, 24))
    one = folder / "one.ply"
    write_ply(one, *made(20_000, 1, 24))
    rows = []
    for name, path, options in (("16 holes", source, ()), ("1 hole, D/h = 96", one, ("--voxel", None))):
        if options:
            diameter = run(program, one, folder)[1]["regions"][0]["diameter"]
            options = ("--voxel", diameter / 96)
        # One and two threads run in turns, so that both have the same load of the machine.
        runs = {1: [], 2: []}
        for _ in range(times):
            for threads in runs:
                runs[threads].append(median_run(program, path, folder, 1, "--threads", threads, *options)[0])
        for threads, own in runs.items():
            row = own[0] | {key: float(np.median([r[key] for r in own])) for key in ("seconds", "cpu_seconds", "mb")}
            rows.append(row | {"case": name, "size": threads})
    return {"study": "threads", "size": "size", "rows": rows}


def memory_table(program, folder, sizes):
    """Peak memory of both commands on tori with ten holes, in bytes for each triangle."""
    lines = ["| triangles | inspect, MB | bytes a triangle | fill, MB | bytes a triangle | CPU seconds of the fill |", "|---:|---:|---:|---:|---:|---:|"]
    source, out = folder / "large.ply", folder / "out.ply"
    for size in sizes:
        made_by = [sys.executable, __file__, "--large", str(size), "10", str(source)]
        subprocess.run(made_by, check=True)
        row = [grouped(size)]
        for command in (["inspect", source], ["fill", source, "-o", out, "-q"]):
            timed = [sys.executable, "-S", ROOT / "scripts/timed.py", program, *command]
            done = subprocess.run([str(part) for part in timed], capture_output=True, text=True)
            figures = json.loads(done.stderr.splitlines()[-1])
            if not figures["ok"]:
                raise RuntimeError(f"exit {figures['code']}: {done.stderr[-500:]}")
            row += [f"{figures['mb']:.0f}", f"{figures['mb'] * 2**20 / size:.0f}"]
        lines.append(f"| {' | '.join(row)} | {figures['cpu']:.1f} |")
    return "\n".join(lines)


STUDIES = {"grid": study_grid, "triangles": study_triangles, "holes": study_holes, "threads": study_threads}


def grouped(number):
    """The number with narrow spaces between groups of three digits."""
    return f"{number:,}".replace(",", "\u202f")


def table(studies):
    lines = [
        "| against | size | seconds | CPU seconds | MB | exponent of CPU time: all, last two | of memory: all, last two |",
        "|---|---|---|---|---|---|---|",
    ]

    def several(values, form):
        return ", ".join(form.format(value) for value in values)

    for study in studies.values():
        rows = study["rows"]
        if "exponents" not in study:
            for case in dict.fromkeys(row["case"] for row in rows):
                own = [row for row in rows if row["case"] == case]
                faster = own[0]["seconds"] / own[-1]["seconds"]
                lines.append(
                    f"| threads, {case} | {several([r['size'] for r in own], '{}')} | {several([r['seconds'] for r in own], '{:.2f}')} "
                    f"| {several([r['cpu_seconds'] for r in own], '{:.2f}')} "
                    f"| {several([r['mb'] for r in own], '{:.0f}')} | {faster:.2f} times as fast | |"
                )
            continue
        slopes = study["exponents"]
        time_slopes, memory = slopes["cpu_seconds"], slopes["mb"]
        lines.append(
            f"| {study['study']} | {several([grouped(r['size']) for r in rows], '{}')} "
            f"| {several([r['seconds'] for r in rows], '{:.2f}')} | {several([r['cpu_seconds'] for r in rows], '{:.2f}')} | {several([r['mb'] for r in rows], '{:.0f}')} "
            f"| {time_slopes['all']:.2f}, {time_slopes['last']:.2f} | {memory['all']:.2f}, {memory['last']:.2f} |"
        )
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--isomend", default=ROOT / "target/release/isomend", help="the program")
    parser.add_argument("--json", help="file for the figures")
    parser.add_argument("--markdown", help="file for the table")
    parser.add_argument("--docs", action="store_true", help="write the table into docs/speed.md")
    parser.add_argument("--json-in", help="file of an earlier --json, from which studies that are not run are taken")
    parser.add_argument("--only", choices=STUDIES, nargs="+", default=list(STUDIES), help="studies to run [default: all]")
    parser.add_argument("--times", type=int, default=3, help="number of runs of each mesh, whose median counts")
    parser.add_argument("--quick", action="store_true", help="the small sizes only")
    parser.add_argument("--cut", nargs=3, metavar=("HOLES", "IN", "OUT"), help="cut holes into a mesh and stop")
    parser.add_argument("--part", type=float, default=0.02, help="with --cut, the width of the holes over the mesh's diagonal")
    parser.add_argument("--large", nargs=3, metavar=("TRIANGLES", "HOLES", "OUT"), help="make a mesh and stop")
    parser.add_argument("--memory", nargs="+", type=int, metavar="TRIANGLES", help="measure the memory of these sizes and stop")
    arguments = parser.parse_args()
    if arguments.cut:
        write_ply(arguments.cut[2], *cut_holes(arguments.cut[1], int(arguments.cut[0]), arguments.part))
        return
    if arguments.memory:
        with tempfile.TemporaryDirectory() as folder:
            text = memory_table(arguments.isomend, Path(folder), arguments.memory)
        print(text)
        if arguments.docs:
            renew("memory", "scaling.py", text)
        return
    if arguments.large:
        triangles, holes = int(arguments.large[0]), int(arguments.large[1])
        write_ply(arguments.large[2], *made(triangles, holes, 32))
        return
    studies = json.loads(Path(arguments.json_in).read_text()) if arguments.json_in else {}
    with tempfile.TemporaryDirectory() as folder:
        for name in arguments.only:
            studies[name] = STUDIES[name](arguments.isomend, Path(folder), arguments.times, arguments.quick)
            print(json.dumps(studies[name]), file=sys.stderr, flush=True)
    text = table(studies)
    print(text)
    if arguments.json:
        Path(arguments.json).write_text(json.dumps(studies, indent=1) + "\n")
    if arguments.markdown:
        Path(arguments.markdown).write_text(text + "\n")
    if arguments.docs:
        renew("scaling", "scaling.py", text)


if __name__ == "__main__":
    main()
