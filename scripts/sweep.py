#!/usr/bin/env python3
"""Sensitivity analysis: varies the thresholds (`tunable(…)` in the sources) one by one, and prints how results and errors change.

usage: sweep.py [--oracle] [--only REGEX] [--factors 0.7,1.4] [--binary PROGRAM] [--folder FOLDER [--score COMMAND]] [--cases REGEX] [--most-holes N] [--json FILE]

The program is built with `--cfg isomend_tuning` into target/tuning, unless --binary names one; it reads thresholds from ISOMEND_TUNING.

Without --folder the holes are made here: discs of faces are cut out of meshes in data/, and the error is the distance that
`isomend compare` measures between the filled and the whole mesh. With --folder the meshes are FOLDER/cases/NAME/input.ply; if
case.json beside one lists `holes` with `edges` and `perimeter`, only these holes are filled. Without COMMAND each result is compared with
truth.obj in the same folder. With COMMAND this command computes the errors: {cases} stands for FOLDER/cases, {outputs} for a folder with
NAME.ply for each filled case whose bytes changed; it prints a JSON object from names of holes to errors.

With --oracle no threshold is varied: each hole is closed by the level set and by the faired triangulation as well (`fill.always`), and
the errors are printed beside the error of the candidate that the program takes, and beside the smaller of both, the oracle.

Printed for each value: the number of files whose bytes change, the geometric mean of the ratios of errors to the errors with the
present value, and the largest ratio with its hole. Below 1 is better."""
import argparse
import hashlib
import json
import math
import os
import re
import resource
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
THRESHOLD = re.compile(r'tunable\(\s*"(\w+(?:\.\w+)+)",\s*([^,)]+),?\s*\)')
KIND = re.compile(r"Tunable<(\w+)>")


def thresholds():
    """The thresholds in the sources: names such as fill.bent, with type and value."""
    found = {}
    for path in sorted((ROOT / "crates").glob("*/src/**/*.rs")):
        source = path.read_text()
        for match in THRESHOLD.finditer(source):
            name, text = match.groups()
            kind = KIND.findall(source, 0, match.start())[-1]
            text = text.replace("_", "").replace("std::f64::consts::SQRT2", str(math.sqrt(2)))
            number = eval(text, {"__builtins__": {}})  # Numbers and products of numbers, from the repository's own sources.
            found[name] = (kind, number)
    return found


def varied(kind, value, factor):
    """The value times a factor; whole numbers change by at least one."""
    if kind == "f64":
        return value * factor
    new = round(value * factor)
    if new == value:
        new += 1 if factor > 1 else -1
    return max(new, 0)


def build():
    """Builds the program that reads thresholds from the environment."""
    target = ROOT / "target/tuning"
    env = dict(os.environ, CARGO_TARGET_DIR=str(target), RUSTFLAGS="--cfg isomend_tuning")
    subprocess.run(["cargo", "build", "--profile", "ci", "--bin", "isomend"], cwd=ROOT, env=env, check=True)
    return target / "ci/isomend"


def read_obj(path):
    """Positions and triangles of an OBJ file."""
    positions, faces = [], []
    for line in path.read_text().splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            positions.append(tuple(map(float, words[1:4])))
        elif words[:1] == ["f"]:
            faces.append(tuple(int(w.split("/")[0]) - 1 for w in words[1:4]))
    return positions, faces


def make_holes(program, folder):
    """Makes cases from meshes in data/, with three discs of faces cut out; truth.obj is the whole mesh, with its own holes filled."""
    for mesh in ("sphere.ply", "torus.ply", "scan.ply", "catenoid.ply"):
        case = folder / "cases" / mesh.split(".")[0]
        case.mkdir(parents=True)
        subprocess.run([program, "fill", ROOT / "data" / mesh, "-o", case / "truth.obj", "-q"], check=False)
        positions, faces = read_obj(case / "truth.obj")
        low, high = ([pick(p[k] for p in positions) for k in range(3)] for pick in (min, max))
        size = math.dist(low, high)
        centre = [tuple(sum(positions[v][k] for v in f) / 3 for k in range(3)) for f in faces]
        gone = set()
        for part, radius in ((0.2, 0.06), (0.5, 0.09), (0.8, 0.12)):
            seed = centre[int(part * len(faces))]
            gone.update(i for i, c in enumerate(centre) if math.dist(c, seed) < radius * size)
        kept = [f for i, f in enumerate(faces) if i not in gone]
        lines = ["v %r %r %r" % p for p in positions] + ["f %d %d %d" % tuple(v + 1 for v in f) for f in kept]
        (case / "holes.obj").write_text("\n".join(lines) + "\n")
        subprocess.run([program, "convert", case / "holes.obj", "-o", case / "input.ply", "-q"], check=True)


def compared(program, cases, outputs):
    """Errors of the outputs, measured by `isomend compare`."""
    errors = {}
    for output in sorted(outputs.glob("*.ply")):
        run = [program, "compare", output, cases / output.stem / "truth.obj", "--json", "-"]
        done = json.loads(subprocess.run(run, capture_output=True, text=True, check=True).stdout)
        both = [v for v in walk(done) if v[0].endswith("rms")]
        errors[output.stem] = max(v for _, v in both)
    return errors


def walk(document, path=""):
    """Yields the paths and values of all numbers in a JSON document."""
    for key, value in document.items():
        if isinstance(value, dict):
            yield from walk(value, f"{path}{key}.")
        elif isinstance(value, (int, float)) and not isinstance(value, bool):
            yield path + key, value


class Sweep:
    """The cases of a sweep, which are filled and scored with given thresholds."""

    def __init__(self, args, program, folder):
        self.args, self.program, self.cases = args, program, folder / "cases"
        names = sorted(p.parent.name for p in self.cases.glob("*/input.ply"))
        self.names = [n for n in names if re.search(args.cases, n)]
        self.holes = {name: self.hole_ids(self.cases / name) for name in self.names}
        self.hashes, self.errors = {}, {}
        self.hashes, self.errors = self.run({}, 600)

    def hole_ids(self, case):
        """Numbers of the holes that case.json lists; none for all holes."""
        listed = case / "case.json"
        holes = json.loads(listed.read_text()).get("holes", []) if listed.exists() else []
        if not holes:
            return None
        run = [self.program, "inspect", case / "input.ply", "--json", "-"]
        own = json.loads(subprocess.run(run, capture_output=True, text=True, check=True).stdout)["holes"]
        ids = []
        for hole in holes[: self.args.most_holes]:
            far = 1e-4 * hole["perimeter"]
            same = [h["id"] for h in own if h["edges"] == hole["edges"] and abs(h["length"] - hole["perimeter"]) < far]
            ids += same if len(same) == 1 else []
        return ",".join(map(str, ids))

    def run(self, values, limit):
        """Fills all cases; returns hashes of the outputs, and errors of outputs whose bytes differ from the present thresholds' outputs.
        `limit` is the time for each file, in seconds of one core."""
        hashes = {}
        with tempfile.TemporaryDirectory() as folder:
            outputs = Path(folder)
            env = dict(os.environ, ISOMEND_TUNING=json.dumps(values))
            for name in self.names:
                output = outputs / f"{name}.ply"
                run = [self.program, "fill", self.cases / name / "input.ply", "-o", output, "-q", "--threads", "1"]
                run += ["--holes", self.holes[name]] if self.holes[name] else []
                bound = lambda: resource.setrlimit(resource.RLIMIT_CPU, (limit, limit))  # noqa: E731
                done = subprocess.run(run, env=env, capture_output=True, check=False, preexec_fn=bound)
                if done.returncode < 0:
                    output.unlink(missing_ok=True)
                hashes[name] = hashlib.sha256(output.read_bytes()).hexdigest() if output.exists() else "none"
                if hashes[name] == self.hashes.get(name):
                    output.unlink()
            return hashes, self.score(outputs)

    def score(self, outputs):
        if not any(outputs.glob("*.ply")):
            return {}
        if not self.args.score:
            return compared(self.program, self.cases, outputs)
        command = self.args.score.format(cases=self.cases, outputs=outputs)
        done = subprocess.run(shlex.split(command), capture_output=True, text=True, check=True)
        return json.loads(done.stdout.splitlines()[-1])

    def vary(self, name, value):
        """Measures the changes with another value of one threshold."""
        hashes, errors = self.run({name: value}, 60)
        changed = [n for n in self.names if hashes[n] != self.hashes[n]]
        ratios = {}
        for hole, before in self.errors.items():
            if hole.split("/")[0] in changed:
                # A hole that is no longer closed counts as an error ten times as large.
                ratios[hole] = errors[hole] / before if errors.get(hole) and before else 10.0
        rest = len(self.errors) - len(ratios)
        mean = math.exp(sum(math.log(max(r, 1e-3)) for r in ratios.values()) / max(len(ratios) + rest, 1))
        worst = max(ratios, key=lambda h: abs(math.log(max(ratios[h], 1e-3))), default="")
        return dict(name=name, value=value, changed=len(changed), mean=mean, worst=ratios.get(worst, 1.0), hole=worst)

    def oracle(self):
        """Prints the errors of the candidates of each hole beside the error of the program's choice."""
        _, level = self.run({"fill.always": 1}, 600)
        _, faired = self.run({"fill.always": 2}, 600)
        ratios = {}
        print(f"{'hole':30s} {'chosen':>10s} {'level set':>10s} {'faired':>10s}   chosen / best")
        for hole, chosen in self.errors.items():
            # A candidate with the same bytes as the choice is not scored again.
            both = [errors.get(hole, chosen) for errors in (level, faired)]
            known = [e for e in (chosen, *both) if e]
            if not chosen or not known:
                continue
            ratios[hole] = chosen / min(known)
            print(f"{hole:30s} {chosen:10.4g} {both[0] or math.nan:10.4g} {both[1] or math.nan:10.4g}   {ratios[hole]:.2f}")
        mean = math.exp(sum(map(math.log, ratios.values())) / len(ratios))
        far = sum(r > 2 for r in ratios.values())
        worst = max(ratios, key=ratios.get)
        print(f"{len(ratios)} holes: chosen / best {mean:.3f}, above 2: {far}, largest {ratios[worst]:.2f} {worst}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default=".", help="regular expression of the names of thresholds")
    parser.add_argument("--oracle", action="store_true", help="compare the candidates of each hole instead")
    parser.add_argument("--factors", default="0.7,1.4")
    parser.add_argument("--binary", help="a program built with --cfg isomend_tuning")
    parser.add_argument("--folder", type=Path)
    parser.add_argument("--score", help="command that computes errors, with {cases} and {outputs}")
    parser.add_argument("--cases", default=".", help="regular expression of the names of cases")
    parser.add_argument("--most-holes", type=int, help="limit of the number of holes of each case")
    parser.add_argument("--json", type=Path, help="file for all rows, written after each row")
    args = parser.parse_args()
    program = Path(args.binary).resolve() if args.binary else build()
    with tempfile.TemporaryDirectory() as made:
        folder = args.folder or Path(made)
        if not args.folder:
            make_holes(program, folder)
        sweep = Sweep(args, program, folder)
        print(f"{len(sweep.names)} files, {len(sweep.errors)} errors", flush=True)
        if args.oracle:
            sweep.oracle()
            return 0
        rows = []
        for name, (kind, now) in thresholds().items():
            if not re.search(args.only, name):
                continue
            for factor in map(float, args.factors.split(",")):
                value = varied(kind, now, factor)
                row = dict(sweep.vary(name, value), now=now)
                rows.append(row)
                print(
                    f"{name:36s} {now:10.4g} -> {value:10.4g}  {row['changed']:3d} files  mean {row['mean']:.3f}  "
                    f"worst {row['worst']:.2f} {row['hole']}",
                    flush=True,
                )
                if args.json:
                    args.json.write_text(json.dumps(rows, indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
