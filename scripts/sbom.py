"""Writes a bill of materials (SBOM) in CycloneDX 1.5: the crates that a build of the program or of the Python module contains.

    python3 scripts/sbom.py [--target TRIPLE] [--package isomend|isomend-python] OUT.json

It lists the crates of Cargo.lock for one system, without dependencies of builds and tests only. Each has its version, licence, package
URL, SHA-256 of the source, and dependencies. The same lock file gives the same bytes. It needs Python 3.11 and cargo."""

import argparse
import json
import subprocess
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def metadata(target):
    command = ["cargo", "metadata", "--locked", "--format-version", "1", "--filter-platform", target]
    return json.loads(subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout)


def host():
    """The target triple of this system."""
    words = subprocess.run(["rustc", "-vV"], check=True, capture_output=True, text=True).stdout
    return next(line.split()[1] for line in words.splitlines() if line.startswith("host: "))


def reached(nodes, root):
    """The packages that a package contains: for each package reached from `root` its normal dependencies."""
    found, todo = {}, [root]
    while todo:
        package = todo.pop()
        if package in found:
            continue
        normal = [d["pkg"] for d in nodes[package]["deps"] if any(kind["kind"] is None for kind in d["dep_kinds"])]
        found[package] = sorted(normal)
        todo += normal
    return found


def component(package, checksums):
    """A package as a CycloneDX component."""
    name, version = package["name"], package["version"]
    url = f"pkg:cargo/{name}@{version}"
    row = {"type": "library", "bom-ref": url, "name": name, "version": version, "purl": url}
    if package["license"]:
        row["licenses"] = [{"expression": package["license"].replace("/", " OR ")}]
    checksum = checksums.get((name, version))
    if checksum:
        row["hashes"] = [{"alg": "SHA-256", "content": checksum}]
    if package["repository"]:
        row["externalReferences"] = [{"type": "vcs", "url": package["repository"]}]
    return row


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--target", help="target triple of the build [default: this system]")
    parser.add_argument("--package", default="isomend", help="package that was built [default: isomend]")
    parser.add_argument("out", type=Path)
    arguments = parser.parse_args()
    target = arguments.target or host()
    found = metadata(target)
    packages = {package["id"]: package for package in found["packages"]}
    nodes = {node["id"]: node for node in found["resolve"]["nodes"]}
    root = next(package["id"] for package in found["packages"] if package["name"] == arguments.package and package["source"] is None)
    lock = tomllib.loads((ROOT / "Cargo.lock").read_text())["package"]
    checksums = {(row["name"], row["version"]): row["checksum"] for row in lock if "checksum" in row}
    contents = reached(nodes, root)
    rows = {name: component(packages[name], checksums) for name in contents}
    main_row = {**rows.pop(root), "type": "application" if arguments.package == "isomend" else "library"}
    document = {
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": {"component": main_row, "properties": [{"name": "target", "value": target}]},
        "components": sorted(rows.values(), key=lambda row: row["bom-ref"]),
        "dependencies": sorted(
            ({"ref": f"pkg:cargo/{packages[p]['name']}@{packages[p]['version']}",
              "dependsOn": sorted(f"pkg:cargo/{packages[d]['name']}@{packages[d]['version']}" for d in of)}
             for p, of in contents.items()),
            key=lambda row: row["ref"],
        ),
    }  # fmt: skip
    arguments.out.write_text(json.dumps(document, indent=1) + "\n")
    print(f"{arguments.out}: {len(rows)} crates")


if __name__ == "__main__":
    main()
