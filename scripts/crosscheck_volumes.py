# /// script
# requires-python = ">=3.11"
# dependencies = ["numpy==2.4.6", "pyvista==0.49.1"]
# ///
"""Check with VTK, through pyvista, the volumes that isomend writes and reads.

    cargo build --release && python3 scripts/crosscheck_volumes.py [--isomend PROGRAM]

A VTI file of `isomend sdf` must have the right bounds, exact spacing and values, with 32 and 64 bits. `isomend surface` must
make the same surface from all files that VTK writes (text, base64, raw; zlib, LZ4, LZMA, none; legacy text and binary).
The exit code is 1 if a check fails."""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from left_out import left_out

try:
    import pyvista as pv
    import vtk
except ImportError as error:
    left_out("VTK's checks", f"pyvista cannot be loaded ({error})")
    sys.exit(0)

ROOT = Path(__file__).resolve().parent.parent


def run(program, *arguments):
    done = subprocess.run([program, *map(str, arguments), "-q"], capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"exit {done.returncode}: {done.stderr.strip()[-200:]}")


def check_written(program, folder, more):
    source, target = ROOT / "data/sphere.ply", folder / "ball.vti"
    run(program, "sdf", source, "-o", target, "--voxel", "0.0625", *more)
    grid, mesh = pv.read(target), pv.read(source)
    wrong = []
    if grid.spacing != (0.0625,) * 3:
        wrong.append(f"spacing {grid.spacing}")
    low, high = np.array(grid.bounds).reshape(3, 2).T
    mesh_low, mesh_high = np.array(mesh.bounds).reshape(3, 2).T
    if not (np.all(low < mesh_low - 0.18) and np.all(high > mesh_high + 0.18)):
        wrong.append(f"bounds {grid.bounds}")
    values = grid["distance"]
    if values.dtype != (np.float64 if "--f64" in more else np.float32):
        wrong.append(f"type {values.dtype}")
    exact = np.linalg.norm(grid.points, axis=1) - 1
    # The mesh has a hole of 60 degrees; far from it the distance equals the sphere's, up to the flatness of the faces.
    away = grid.points[:, 2] < 0
    if np.abs(values - exact)[away].max() > 0.01:
        wrong.append("values are not the distances of the sphere")
    cut = grid.contour([0.0], scalars="distance")
    if cut.n_points == 0 or cut.n_open_edges:
        wrong.append("VTK's own contour is not closed")
    return wrong


def made_volume():
    grid = pv.ImageData(dimensions=(20, 17, 13), spacing=(0.1, 0.11, 0.15), origin=(-1, 0.1, 50))
    x, y, z = (grid.points - grid.center).T
    grid["field"] = (np.sqrt(x**2 + y**2 + z**2) - 0.7).astype(np.float32)
    return grid


def writers(folder, grid):
    """Writes a volume with VTK in all its encodings; yields the files."""
    for mode in ("Ascii", "Binary", "Appended"):
        for pack in ("None", "ZLib", "LZ4", "LZMA"):
            for raw in (False, True):
                if (mode != "Appended" and raw) or (mode == "Ascii" and pack != "None"):
                    continue
                writer = vtk.vtkXMLImageDataWriter()
                path = folder / f"{mode}-{pack}-{raw}.vti"
                writer.SetFileName(str(path))
                writer.SetInputData(grid)
                getattr(writer, f"SetDataModeTo{mode}")()
                getattr(writer, f"SetCompressorTypeTo{pack}")()
                writer.SetEncodeAppendedData(not raw)
                writer.Write()
                yield path
    for mode in ("ASCII", "Binary"):
        writer = vtk.vtkStructuredPointsWriter()
        path = folder / f"legacy-{mode}.vtk"
        writer.SetFileName(str(path))
        writer.SetInputData(grid)
        getattr(writer, f"SetFileTypeTo{mode}")()
        writer.Write()
        yield path


def check_read(program, path, grid, folder):
    target = folder / "surface.ply"
    run(program, "surface", path, "-o", target, "--level", "0.05")
    mesh = pv.read(target)
    wrong = []
    if mesh.n_open_edges or not mesh.is_manifold:
        wrong.append("the surface is not closed")
    away = np.linalg.norm(mesh.points - grid.center, axis=1) - 0.75
    if np.abs(away).max() > 0.01:
        wrong.append(f"the surface is off by {np.abs(away).max():.3g}")
    return wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--isomend", default=ROOT / "target/release/isomend", help="the program")
    program = parser.parse_args().isomend
    failures = 0
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        jobs = [(f"sdf {more}", lambda more=more: check_written(program, folder, more.split())) for more in ("", "--f64")]
        grid = made_volume()
        for path in writers(folder, grid):
            jobs.append((path.name, lambda path=path: check_read(program, path, grid, folder)))
        for name, job in jobs:
            try:
                wrong = job()
            except RuntimeError as error:
                wrong = [str(error)]
            failures += bool(wrong)
            print(f"volume {name:28s} {'; '.join(wrong) or 'right'}", flush=True)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
