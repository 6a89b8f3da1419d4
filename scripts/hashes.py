"""Hashes of isomend's output for the meshes in data/, to compare systems. They agree if the C libraries round exp, ln and sin alike.

    cargo build --release && python3 scripts/hashes.py [--isomend PROGRAM] [--runner WINE] [--out FILE] [--against FILE]

The outputs are fills, restorations, a fairing, a repair, a volume and all formats, one with a file name that is not ASCII. --out writes the
hashes as JSON. --against compares them with a file that --out wrote; the exit code is 1 if one differs. --runner is a program that runs
isomend, such as wine. It needs only Python."""

import argparse
import hashlib
import json
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
MARK = ["--colour", "ff0000", "--grow", "0.2"]
RUNS = {
    **{f"fill {name}": (["fill", f"{name}.ply"], "ply") for name in ("catenoid", "island", "scan", "slab", "sphere", "torus")},
    **{f"fill scan as {kind}": (["fill", "scan.ply", "--max-diameter", "40"], kind) for kind in ("obj", "stl", "glb", "gltf", "vtk", "vtp")},
    "fill with curvature variation": (["fill", "torus.ply", "--energy", "curvature-variation"], "ply"),
    "fill without a finish": (["fill", "sphere.ply", "--finish", "none"], "ply"),
    "restore": (["restore", "painted.ply", *MARK], "ply"),
    "restore, shape kept": (["restore", "painted.ply", *MARK, "--keep-shape", "0.8"], "ply"),
    "fair": (["fair", "painted.ply", "--ball", "0,0,-1,0.6"], "ply"),
    "repair with borders": (["repair", "scan.ply", "--close-borders"], "ply"),
    "a wall of a sheet": (["repair", "sheet.obj", "--close-borders"], "ply"),
    "distances": (["sdf", "torus.ply", "--voxel", "0.1"], "vti"),
}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--isomend", type=Path, default=ROOT / "target/release/isomend", help="the program")
    parser.add_argument("--runner", default="", help="program that runs isomend, with its arguments")
    parser.add_argument("--out", type=Path, help="file for the hashes")
    parser.add_argument("--against", type=Path, help="hashes to compare with")
    arguments = parser.parse_args()
    hashes = {}
    with tempfile.TemporaryDirectory() as folder:
        for number, (name, (words, kind)) in enumerate(RUNS.items()):
            out = Path(folder) / f"geflickt-ü-{number}.{kind}"
            words = [words[0], str(ROOT / "data" / words[1]), *words[2:], "-o", str(out), "-q"]
            done = subprocess.run([*arguments.runner.split(), str(arguments.isomend.resolve()), *words], capture_output=True, text=True)
            # Exit code 3 (some hole is left open) is expected here.
            if done.returncode not in (0, 3) or not out.exists():
                hashes[name] = f"ended with {done.returncode}: {done.stderr.strip()[-300:]}"
            else:
                hashes[name] = hashlib.sha256(out.read_bytes()).hexdigest()
            print(f"{hashes[name][:64]}  {name}", flush=True)
    if arguments.out:
        arguments.out.write_text(json.dumps(hashes, indent=1) + "\n")
    failed = [name for name, value in hashes.items() if value.startswith("ended")]
    other = json.loads(arguments.against.read_text()) if arguments.against else hashes
    differ = [name for name in {**hashes, **other} if hashes.get(name) != other.get(name)]
    if failed or differ:
        sys.exit(f"failed: {', '.join(failed) or 'none'}; other bytes: {', '.join(differ) or 'none'}")
    print(f"{len(hashes)} files{' have the same bytes' if arguments.against else ''}")


if __name__ == "__main__":
    main()
