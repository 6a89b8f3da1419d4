# /// script
# requires-python = ">=3.11"
# dependencies = [
#   "fcpw==1.2.0", "libigl==2.6.3", "matplotlib==3.11.2", "meshlib==3.1.4.297", "numpy==2.4.6", "open3d==0.20.0",
#   "pillow==13.0.0", "pymeshlab==2025.7.post1", "pyvista==0.49.1", "warp-lang==1.19.0",
# ]
# ///
"""Compare the time of isomend with CGAL, libigl, MeshLib and MeshLab on the same holes, and of its distances with the fastest libraries.

    cargo build --release && uv run scripts/bench_peers.py [--json FILE] [--docs]

(or in any virtual environment with the packages of the first lines). Every fill is a separate process. The tools run in turns, in
another order each round, and the tables have medians. 'fill' is the time of the library's own call, 'process' the time of the whole
process with its start, reading and writing, MB its peak memory. The holes and their true surfaces are the same as in
scripts/compare_libigl.py, and one with a ragged rim. A result with another topology than the true surface is 'open'.

CGAL's triangulate_refine_and_fair_hole is compiled from scripts/cgal_fill.cpp; on Debian, apt install g++ libcgal-dev
libeigen3-dev. libigl's fairing starts from MeshLib's triangulation, k = 3, one solve or eleven. Tools that are not installed
are left out, with a message (Open3D needs libusb-1.0-0). PMP is in neither registry, so it is not compared.

Distances: CPU seconds per node of the query alone, at the nodes within four voxels of the surface, in a lattice of 256 voxels
along the longest side. The libraries are queried at these nodes only; building their trees is not counted. isomend has two rows.
'Distances alone' is the time that `isomend sdf --band --json` reports for them, on one thread, times the share of the CPU that its
process got; it includes finding the nodes that are farther away, and no building of the tree. The whole command is the CPU time of
`isomend sdf --band` for the whole lattice, less the CPU time of `isomend inspect`: an upper bound, as it includes building the
tree, the signs, all nodes farther away and the compressed output. Both are divided by the same number of nodes. The JSON file
also has the seconds of building the trees."""

import argparse
import json
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))
from benchmark import cases as benchmark  # noqa: E402
from summary import renew_summary  # noqa: E402
from tables import renew  # noqa: E402

CASES = ["sphere 60°", "sphere 60°, fine", "sphere 60°, ragged", "sphere 60°, noise 3 %", "torus, outer, fine", "bunny, back"]
TOOLS = {
    "isomend": "isomend",
    "cgal1": "CGAL, fairing continuity 1",
    "cgal2": "CGAL, fairing continuity 2",
    "meshlib": "MeshLib, fillHoleNicely",
    "igl3": "MeshLib + libigl k = 3",
    "igl3x10": "MeshLib + libigl k = 3 × 10",
    "meshlab": "MeshLab, close holes, refined",
}


# --- files ----------------------------------------------------------------------------------------------------------


def write_off(path, v, f):
    lines = [f"OFF\n{len(v)} {len(f)} 0"] + ["{!r} {!r} {!r}".format(*p) for p in v.tolist()]
    Path(path).write_text("\n".join(lines + ["3 {} {} {}".format(*t) for t in f.tolist()]) + "\n")


def read_off(path):
    lines = [line for line in Path(path).read_text().split("\n") if line and line[0] != "#"]
    n, m = map(int, lines[1].split()[:2])
    v = np.array([line.split()[:3] for line in lines[2 : 2 + n]], float)
    return v, np.array([line.split()[1:4] for line in lines[2 + n : 2 + n + m]], int)


def read_obj(path):
    rows = {"v": [], "f": []}
    for line in Path(path).read_text().splitlines():
        words = line.split()
        if words and words[0] in rows:
            rows[words[0]].append([word.split("/")[0] for word in words[1:4]])
    return np.array(rows["v"], float), np.array(rows["f"], int) - 1


# --- the process of a Python library --------------------------------------------------------------------------------


class Input:
    """A case with the fields that the functions of scripts/compare_libigl.py need."""

    bridge = False

    def __init__(self, v, f):
        self.v, self.f = v, f


def worker(tool, source, target):
    """The process of a Python library: reads, fills and writes a mesh; prints the seconds of the filling."""
    given = np.load(source)
    v, f, longest = given["v"], given["f"].astype(np.int64), float(given["longest"])
    if tool == "meshlab":
        import pymeshlab

        meshes = pymeshlab.MeshSet()
        meshes.add_mesh(pymeshlab.Mesh(v, f))
        start = time.perf_counter()
        meshes.meshing_close_holes(
            maxholesize=100_000, selfintersection=False, refinehole=True, refineholeedgelen=pymeshlab.PureValue(longest)
        )
        seconds = time.perf_counter() - start
        v, f = meshes.current_mesh().vertex_matrix(), meshes.current_mesh().face_matrix()
    else:
        import compare_libigl

        case = Input(v, f)
        v, f, _, seconds = compare_libigl.triangulate(case, longest, tool == "meshlib")
        if tool != "meshlib":
            moved, more = compare_libigl.fair(case, v, f, 3, 11 if tool == "igl3x10" else 1)
            v, seconds = v if moved is None else moved, seconds + more
    np.savez(target, v=v, f=f)
    print(json.dumps({"seconds": seconds}))


# --- fills ----------------------------------------------------------------------------------------------------------


def process(command):
    """Wall and CPU seconds, peak memory in MB and standard output of a process."""
    done = subprocess.run([sys.executable, "-S", ROOT / "scripts/timed.py", *map(str, command)], capture_output=True, text=True)
    figures = json.loads(done.stderr.splitlines()[-1])
    figures["output"] = done.stdout
    if not figures["ok"]:
        print(f"{Path(command[0]).name} failed: {' '.join(done.stderr.splitlines()[-2:-1])}", file=sys.stderr)
    return figures


def run_tool(tool, program, cgal, folder):
    """Runs one fill of the input in the folder; returns seconds of the fill, figures of the process, and the mesh."""
    if tool == "isomend":
        done = process([program, "fill", folder / "in.ply", "-o", folder / "out.obj", "--json", "-", "-q"])
        return (json.loads(done["output"])["seconds"], done, read_obj(folder / "out.obj")) if done["ok"] else None
    if tool.startswith("cgal"):
        done = process([cgal, folder / "in.off", folder / "out.off", tool[-1]])
        return (float(done["output"]), done, read_off(folder / "out.off")) if done["ok"] else None
    done = process([sys.executable, __file__, "--worker", tool, folder / "in.npz", folder / "out.npz"])
    if not done["ok"]:
        return None
    mesh = np.load(folder / "out.npz")
    return json.loads(done["output"].splitlines()[-1])["seconds"], done, (mesh["v"], mesh["f"].astype(int))


def compile_cgal(folder):
    if not shutil.which("g++"):
        print("CGAL is LEFT OUT: there is no g++", file=sys.stderr)
        return None
    target = Path(folder) / "cgal_fill"
    options = ["-O3", "-DNDEBUG", "-march=native", "-std=c++17", "-DCGAL_EIGEN3_ENABLED", "-I/usr/include/eigen3"]
    done = subprocess.run(
        ["g++", *options, ROOT / "scripts/cgal_fill.cpp", "-o", target, "-lgmp", "-lmpfr"], capture_output=True, text=True
    )
    if done.returncode:
        print(f"CGAL is LEFT OUT: {done.stderr.splitlines()[:1]}; apt install libcgal-dev libeigen3-dev", file=sys.stderr)
        return None
    return target


def marked(case, v, f):
    """Which faces are new, by the positions of their corners, and whether the mesh is closed with the topology of the true surface."""
    both = np.vstack([case.v, v]).astype(np.float32)
    _, number = np.unique(both, axis=0, return_inverse=True)
    number = number.reshape(-1)
    own, f = np.sort(number[: len(case.v)][case.f], axis=1), number[len(case.v) :][f]
    both = np.vstack([own, np.sort(f, axis=1)])
    _, face = np.unique(both, axis=0, return_inverse=True)
    face = face.reshape(-1)
    patch = ~np.isin(face[len(own) :], face[: len(own)])
    edges = np.sort(np.concatenate([f[:, [0, 1]], f[:, [1, 2]], f[:, [2, 0]]]), axis=1)
    edges, count = np.unique(edges, axis=0, return_counts=True)
    euler = len(np.unique(f)) - len(edges) + len(f)
    truth = case.whole[1]
    expected = len(np.unique(truth)) - 3 * len(truth) // 2 + len(truth)
    return patch, bool((count == 2).all() and euler == expected)


def bench_case(case, tools, program, cgal, folder, rounds):
    import compare_libigl

    compare_libigl.data.write_ply(folder / "in.ply", case.v, case.f)
    write_off(folder / "in.off", case.v, case.f)
    # Tools that have a parameter for it make edges as long as isomend's.
    v, f = run_tool("isomend", program, cgal, folder)[2]
    longest = compare_libigl.mean_edge(v, f[len(case.f) :]) / 0.75
    np.savez(folder / "in.npz", v=case.v, f=case.f, longest=longest)
    runs = {tool: [] for tool in tools}
    last = {}
    for number in range(rounds):
        order = tools[number % len(tools) :] + tools[: number % len(tools)]
        for tool in order if number % 2 == 0 else order[::-1]:
            done = run_tool(tool, program, cgal, folder)
            if done:
                runs[tool].append((done[0], done[1]["wall"], done[1]["cpu"], done[1]["mb"]))
                last[tool] = done[2]
    rows = {}
    for tool in tools:
        if not runs[tool]:
            rows[tool] = {"failed": True}
            continue
        seconds, wall, cpu, mb = np.median(np.array(runs[tool]), axis=0)
        patch, closed = marked(case, *last[tool])
        rows[tool] = {"fill": seconds, "process": wall, "cpu": cpu, "mb": mb, "closed": closed}
        if patch.any():
            rows[tool] |= compare_libigl.score(case, *last[tool], patch)
    return {"case": case.name, "input_faces": len(case.f), "tools": rows}


def fill_table(rows):
    lines = [
        "| tool | " + " | ".join(row["case"] for row in rows) + " | process, s | MB |",
        "|---|" + "---|" * len(rows) + "---:|---:|",
    ]
    for tool, title in TOOLS.items():
        cells, own = [], []
        for row in rows:
            r = row["tools"].get(tool)
            if r is None or "failed" in r:
                cells.append("failed" if r else "–")
                continue
            own.append(r)
            error = f"{r['rms']:.2f} ‰" if r["closed"] and "rms" in r else "open"
            cells.append(f"{r['fill']:.2f} s, {error}")
        whole = [f"{np.median([r['process'] for r in own]):.2f}", f"{max(r['mb'] for r in own):.0f}"] if own else ["–", "–"]
        lines.append(f"| {title} | {' | '.join(cells + whole)} |")
    return "\n".join(lines)


# --- distances ------------------------------------------------------------------------------------------------------


def with_warp(v, f, points):
    import warp as wp

    wp.config.quiet = True
    wp.init()

    @wp.kernel
    def nearest(mesh: wp.uint64, at: wp.array(dtype=wp.vec3), most: float, out: wp.array(dtype=float)):
        i = wp.tid()
        query = wp.mesh_query_point_no_sign(mesh, at[i], most)
        if query.result:
            out[i] = wp.length(wp.mesh_eval_position(mesh, query.face, query.u, query.v) - at[i])

    start = time.process_time()
    mesh = wp.Mesh(wp.array(v.astype(np.float32), dtype=wp.vec3, device="cpu"), wp.array(f.ravel(), dtype=wp.int32, device="cpu"))
    built = time.process_time() - start
    at = wp.array(points.astype(np.float32), dtype=wp.vec3, device="cpu")
    out = wp.zeros(len(points), dtype=float, device="cpu")
    few = wp.zeros(8, dtype=float, device="cpu")
    wp.launch(nearest, 8, [mesh.id, at, 1e10, few], device="cpu")
    start = time.process_time()
    wp.launch(nearest, len(points), [mesh.id, at, 1e10, out], device="cpu")
    return built, time.process_time() - start, out.numpy()


def with_fcpw(v, f, points):
    import fcpw

    start = time.process_time()
    scene = fcpw.scene_3D()
    scene.set_object_count(1)
    scene.set_object_vertices(np.asfortranarray(v, np.float32), 0)
    scene.set_object_triangles(np.asfortranarray(f, np.int32), 0)
    scene.build(fcpw.aggregate_type.bvh_surface_area, True)
    built = time.process_time() - start
    found = fcpw.interaction_3D_list()
    at, reach = np.asfortranarray(points, np.float32), np.full(len(points), np.inf, np.float32)
    start = time.process_time()
    scene.find_closest_points(at, reach, found)
    taken = time.process_time() - start
    return built, taken, np.array([interaction.d for interaction in found])


def with_open3d(v, f, points):
    import open3d as o3d

    start = time.process_time()
    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(o3d.core.Tensor(v.astype(np.float32)), o3d.core.Tensor(f.astype(np.uint32)))
    at = o3d.core.Tensor(points.astype(np.float32))
    scene.compute_distance(at[:8])
    built = time.process_time() - start
    start = time.process_time()
    out = scene.compute_distance(at)
    return built, time.process_time() - start, out.numpy()


def with_libigl(v, f, points):
    import igl

    start = time.process_time()
    igl.point_mesh_squared_distance(points[:8], v, f)
    built = time.process_time() - start
    start = time.process_time()
    squares = igl.point_mesh_squared_distance(points, v, f)[0]
    return built, time.process_time() - start - built, np.sqrt(squares)


ALONE, WHOLE = "isomend, distances of `isomend sdf --band`", "isomend, all of `isomend sdf --band`"
LIBRARIES = {"warp-lang": with_warp, "fcpw": with_fcpw, "Open3D (Embree)": with_open3d, "libigl": with_libigl}


def distance_worker(library, source, target):
    given = np.load(source)
    built, taken, distance = LIBRARIES[library](given["v"], given["f"], given["points"])
    np.save(target, distance)
    print(json.dumps({"build": built, "query": taken}))


def bench_distances(program, folder, rounds):
    import compare_libigl
    import pyvista as pv
    import scaling

    rows = []
    for name, (v, f) in (("bunny", benchmark.bunny()), ("torus", scaling.torus(1_000_000))):
        v = v.astype(np.float32).astype(float)
        voxel = np.ptp(v, axis=0).max() / 250
        source, target = folder / "in.ply", folder / "out.vti"
        compare_libigl.data.write_ply(source, v, f)
        command = [program, "sdf", source, "-o", target, "--voxel", voxel, "--band", 4 * voxel, "-q"]
        process(command)
        grid = pv.read(target)
        values = np.array(grid["distance"], float)
        near = np.flatnonzero(np.abs(values) < 3.999 * voxel)
        places = np.stack(np.unravel_index(near, grid.dimensions[::-1])[::-1], axis=1)
        points = np.array(grid.origin) + places * np.array(grid.spacing)
        np.savez(folder / "in.npz", v=v, f=f.astype(np.int64), points=points)
        taken = {library: [] for library in (ALONE, WHOLE, *LIBRARIES)}
        wrong = {}
        for number in range(rounds):
            for library in list(taken)[:: 1 if number % 2 == 0 else -1]:
                if library == ALONE:
                    done = process([*command, "--threads", 1, "--json", "-"])
                    if done["ok"]:
                        seconds, share = json.loads(done["output"])["seconds"], min(done["cpu"] / done["wall"], 1.0)
                        taken[library].append((share * seconds["tree"], share * seconds["distances"]))
                    continue
                if library == WHOLE:
                    whole, before = process(command), process([program, "inspect", source, "--json", folder / "i.json", "-q"])
                    taken[library].append((0.0, whole["cpu"] - before["cpu"]))
                    continue
                done = process([sys.executable, __file__, "--distances", library, folder / "in.npz", folder / "d.npy"])
                if done["ok"]:
                    figures = json.loads(done["output"].splitlines()[-1])
                    taken[library].append((figures["build"], figures["query"]))
                    wrong[library] = float(np.abs(np.load(folder / "d.npy") - np.abs(values[near])).max() / voxel)
        row = {"mesh": name, "triangles": len(f), "band_nodes": len(near), "all_nodes": len(values), "libraries": {}}
        for library, runs in taken.items():
            if runs:
                build, query = np.median(np.array(runs), axis=0)
                row["libraries"][library] = {
                    "build": build, "query": query, "microseconds": 1e6 * query / len(near), "apart": wrong.get(library, 0.0)
                }
        rows.append(row)
    return rows


def distance_table(rows):
    lines = [
        "| library | " + " | ".join(f"{r['mesh']}, {r['triangles']:,} triangles, {r['band_nodes']:,} nodes" for r in rows) + " |",
        "|---|" + "---:|" * len(rows),
    ]
    for library in dict.fromkeys(name for row in rows for name in row["libraries"]):
        cells = []
        for row in rows:
            figures = row["libraries"].get(library)
            cells.append(f"{figures['microseconds']:.2f} µs" if figures else "failed")
        lines.append(f"| {library} | {' | '.join(cells)} |")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--isomend", default=ROOT / "target/release/isomend", help="the program")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--cases", nargs="+", default=CASES, help="cases to run [default: all]")
    parser.add_argument("--only", choices=("fills", "distances"))
    parser.add_argument("--json", help="file for all figures")
    parser.add_argument("--docs", action="store_true", help="write the tables into docs/speed.md, and a summary into the README")
    parser.add_argument("--worker", nargs=3, help=argparse.SUPPRESS)
    parser.add_argument("--distances", nargs=3, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    arguments.isomend = Path(arguments.isomend).resolve()
    if arguments.worker:
        return worker(*arguments.worker)
    if arguments.distances:
        return distance_worker(*arguments.distances)
    import compare_libigl

    result, parts = {}, []
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        if arguments.only != "distances":
            cgal = compile_cgal(folder)
            tools = [tool for tool in TOOLS if cgal or not tool.startswith("cgal")]
            made = [case for case in compare_libigl.cases() if case.name in arguments.cases]
            if "sphere 60°, ragged" in arguments.cases:
                made.append(benchmark.ragged())
            made.sort(key=lambda case: arguments.cases.index(case.name))
            rows = []
            for case in made:
                rows.append(bench_case(case, tools, arguments.isomend, cgal, folder, arguments.rounds))
                print(json.dumps(rows[-1]), file=sys.stderr, flush=True)
            result["fills"] = rows
            parts.append(fill_table(rows))
        if arguments.only != "fills":
            result["distances"] = bench_distances(arguments.isomend, folder, arguments.rounds)
            parts.append(distance_table(result["distances"]))
    text = "\n\n".join(parts)
    print(text)
    if arguments.json:
        Path(arguments.json).write_text(json.dumps(result, indent=1) + "\n")
    if arguments.docs:
        renew("peers", "bench_peers.py", text)
        if "fills" in result:
            renew_summary()


if __name__ == "__main__":
    main()
