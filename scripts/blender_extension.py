"""Packs the Blender extension: a zip file for Blender with the files of blender/, the licences, and wheels of isomend.

    python3 scripts/blender_extension.py --out DIR WHEEL...

The wheels and their platforms are added to the manifest. With one wheel the zip is named after its platform. The same files give the same
bytes. It needs only Python."""

import argparse
import re
import sys
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
# Blender's names of platforms, by the ends of the wheels' platform tags.
PLATFORMS = {
    "x86_64": {"linux": "linux-x64", "macosx": "macos-x64"},
    "arm64": {"macosx": "macos-arm64"},
    "amd64": {"win": "windows-x64"},
}


def platform(wheel):
    """Blender's name of the platform that a wheel is for."""
    tag = wheel.stem.split("-")[-1].split(".")[0]
    for end, systems in PLATFORMS.items():
        for system, name in systems.items():
            if tag.endswith(end) and tag.removeprefix("many").startswith(system):
                return name
    sys.exit(f"Blender has no platform for {wheel.name}")


def manifest(wheels):
    """The text of the manifest with the wheels and their platforms added."""
    text = (ROOT / "blender/blender_manifest.toml").read_text()
    text = re.sub(r"^# scripts/.*\n(# .*\n)*", "", text, flags=re.M).rstrip("\n")
    version = re.search(r'^version = "(.*)"', text, re.M)[1]
    wanted = re.search(r'^version = "(.*)"', (ROOT / "Cargo.toml").read_text(), re.M)[1]
    if version != wanted:
        sys.exit(f"blender/blender_manifest.toml has version {version}, Cargo.toml {wanted}")
    names = ", ".join(f'"{name}"' for name in sorted({platform(wheel) for wheel in wheels}))
    paths = "".join(f'  "./wheels/{wheel.name}",\n' for wheel in wheels)
    return version, f"{text}\n\nplatforms = [{names}]\nwheels = [\n{paths}]\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True, help="folder of the zip")
    parser.add_argument("wheels", type=Path, nargs="+", help="wheels of isomend, one for each platform")
    arguments = parser.parse_args()
    wheels = sorted(arguments.wheels, key=lambda wheel: wheel.name)
    version, text = manifest(wheels)
    files = {path.name: path.read_bytes() for path in (ROOT / "blender").glob("*.py")}
    files |= {name: (ROOT / name).read_bytes() for name in ("LICENSE-APACHE", "LICENSE-MIT")}
    files |= {f"wheels/{wheel.name}": wheel.read_bytes() for wheel in wheels}
    files["blender_manifest.toml"] = text.encode()
    ending = f"-{platform(wheels[0])}" if len(wheels) == 1 else ""
    out = arguments.out / f"isomend-blender-{version}{ending}.zip"
    out.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as packed:
        for name in sorted(files):
            entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
            entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
            packed.writestr(entry, files[name])
    print(out)


if __name__ == "__main__":
    main()
