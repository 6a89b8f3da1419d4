# /// script
# requires-python = ">=3.11"
# dependencies = ["numpy==2.4.6"]
# ///
"""Count the instructions of fills, repairs and checks, and compare them with the counts in instructions.json.

    cargo build --profile ci --bin isomend && uv run scripts/instructions.py [--isomend PROGRAM] [--limit 1.05] [--renew]

(or in any virtual environment with numpy). Valgrind counts; it takes about fifty times as long as the program, and does not need a quiet
machine: counts of one program differ by less than 1e-4 from run to run, on one thread. They depend on the compiler, its options and the
C library, which the limit leaves room for. The meshes are some of data/ and a wavy closed surface with twenty holes, made here.

Exit code 1: a count is more than --limit times the stored one. After a change that is meant to take more, or takes clearly fewer, --renew
stores the counts; only these tell how much slower the program became over many changes that each took little."""

import argparse
import json
import platform
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))
import make_data as data  # noqa: E402
from bench_guard import wavy, with_holes  # noqa: E402
from left_out import left_out  # noqa: E402

STORED = ROOT / "scripts/instructions.json"
COMMANDS = [
    ("fill", "scan.ply"),
    ("fill", "island.ply"),
    ("fill", "part.ply"),
    ("fill", "many.ply"),
    ("repair", "part.ply"),
    ("check", "many.ply"),
]


def count(program, command, mesh, folder):
    """The instructions of one run."""
    target = [] if command == "check" else ["-o", f"{folder}/out.ply"]
    counter = ["valgrind", "--tool=cachegrind", "--cache-sim=no", "--cachegrind-out-file=/dev/null"]
    line = [*counter, program, command, mesh, *target, "--threads", "1", "-q"]
    done = subprocess.run(line, capture_output=True, text=True)
    found = re.search(r"I +refs: +([\d,]+)", done.stderr)
    if done.returncode not in (0, 3) or not found:
        sys.exit(f"{program} {command} {mesh} ended with {done.returncode}: {done.stderr.strip()}")
    return int(found[1].replace(",", ""))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--isomend", default=ROOT / "target/ci/isomend", type=Path)
    parser.add_argument("--limit", type=float, default=1.05)
    parser.add_argument("--renew", action="store_true", help="store the counts")
    arguments = parser.parse_args()
    if platform.machine() not in ("x86_64", "AMD64"):
        left_out("counts of instructions", "the stored ones are of x86-64")
        return
    if not shutil.which("valgrind"):
        left_out("counts of instructions", "valgrind is not installed")
        return
    keys = [f"{command} {name}" for command, name in COMMANDS]
    stored = {} if arguments.renew else json.loads(STORED.read_text())
    if not arguments.renew and list(stored) != keys:
        sys.exit(f"{STORED.name} has the counts of other runs than this script's: --renew stores them")
    counts, slower = {}, []
    with tempfile.TemporaryDirectory() as folder:
        data.write_ply(Path(folder) / "many.ply", *with_holes(*wavy(6, 0.05, 1), 20, (1.5, 5.0), 1))
        for key, (command, name) in zip(keys, COMMANDS):
            mesh = Path(folder) / name if name == "many.ply" else ROOT / "data" / name
            counts[key] = count(arguments.isomend, command, mesh, folder)
            ratio = counts[key] / stored.get(key, counts[key])
            print(f"{key:20} {counts[key] / 1e9:8.3f} billion instructions, {ratio:.3f} of the stored count", flush=True)
            slower += [key] if ratio > arguments.limit else []
    if arguments.renew:
        STORED.write_text(json.dumps(counts, indent=1) + "\n")
    elif slower:
        sys.exit(f"more than {arguments.limit} times the stored counts: {', '.join(slower)}; see the first lines of scripts/instructions.py")


if __name__ == "__main__":
    main()
