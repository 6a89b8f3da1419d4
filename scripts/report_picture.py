# /// script
# requires-python = ">=3.11"
# dependencies = ["pillow==13.0.0", "websocket-client==1.9.2"]
# ///
"""Draw data/report.png, the picture of a report in docs/options.md: the page of data/scan.ply in headless Chromium.

    cargo build --release && python3 scripts/report_picture.py [--isomend PROGRAM]"""

import argparse
import io
import shutil
import subprocess
import tempfile
from pathlib import Path

from PIL import Image

from browser_test import NAMES, ROOT, Browser


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--isomend", type=Path, default=ROOT / "target/release/isomend")
    arguments = parser.parse_args()
    target = ROOT / "data/report.png"
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        folder = Path(folder)
        page, picture = folder / "mended.html", folder / "page.png"
        command = [arguments.isomend.resolve(), "fill", "data/scan.ply", "-o", folder / "mended.ply", "--report", page, "-q"]
        subprocess.run(command, check=True, cwd=ROOT)
        (folder / "profile").mkdir()
        browser = Browser(next(filter(None, map(shutil.which, NAMES))), folder / "profile")
        try:
            browser.open(page, 1280, 735)
            browser.settled()
            browser.screenshot(picture)
        finally:
            browser.close()
        image = Image.open(io.BytesIO(picture.read_bytes())).convert("RGB")
    image.save(target, optimize=True)
    print(f"{target}: {target.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main()
