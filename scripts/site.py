"""Makes the website from docs/ with mdBook: a page for each task, search, a gallery, and the documentation of the public API.

    python3 scripts/site.py DIR [--mdbook PROGRAM] [--api] [--try FOLDER]

mdBook is installed with `cargo install --locked mdbook`. The pages are the repository's, with their links changed to pages of the site; a
link without a target is a failure. --api adds cargo's documentation of the library, --try the page that
runs in the browser, from a folder that scripts/wasm.sh made. It needs only Python and mdBook."""

import argparse
import html.parser
import os
import re
import shutil
import subprocess
import sys
import tempfile
import urllib.parse
from pathlib import Path

from left_out import left_out

ROOT = Path(__file__).resolve().parent.parent
BOOK = """[book]
title = "isomend"
language = "en"
src = "src"

[output.html]
default-theme = "light"

[output.html.search]
limit-results = 20
"""
# Chapters: titles of chapters, with their pages and these pages' titles.
CHAPTERS = {
    "": {"index.md": "isomend", "gallery.md": "Gallery"},
    "Tasks": {
        "printing.md": "To print a scan",
        "generated.md": "To make a generated mesh solid",
        "restoration.md": "To restore damaged regions",
        "reverse.md": "To rebuild man-made parts",
        "photogrammetry.md": "To finish photogrammetry",
        "research.md": "To do research",
    },
    "Where it runs": {
        "options.md": "Commands and options",
        "view.md": "The page",
        "browser.md": "In the browser and Node.js",
        "blender.md": "Blender",
        "comfyui.md": "ComfyUI",
        "python.md": "Python",
        "library.md": "Rust library",
        "c.md": "C, C++ and C#",
        "fleets.md": "Fleets",
        "automation.md": "Agents, CI and hooks",
    },
    "What it does": {
        "check.md": "Checking",
        "repair.md": "Repair",
        "formats.md": "Formats and attributes",
        "json.md": "JSON reports",
        "method.md": "Method",
        "equations.md": "Equations",
    },
    "How well": {
        "accuracy.md": "Accuracy",
        "speed.md": "Speed",
        "benchmark.md": "The benchmark",
        "experiments.md": "Experiments of the paper",
    },
    "The project": {
        "CHANGELOG.md": "Changelog",
        "CONTRIBUTING.md": "Contributing",
        "ARCHITECTURE.md": "Architecture",
        "SECURITY.md": "Security",
        "fuzzing.md": "Fuzzing",
        "release.md": "Releases",
    },
}
# Pictures of the gallery, each drawn by a script of the repository.
GALLERY = {
    "mended.png": ("A scanned toy dinosaur, repaired, and the expected errors of its patches", "readme_picture.py"),
    "blender.png": ("In Blender: with holes, filled, and the expected error of the patches", "blender_picture.py"),
    "piece.png": ("A break, its hatched patch, and the missing piece", "restoration_pictures.py"),
    "counterpart.png": ("An ear made after the other one", "restoration_pictures.py"),
    "texels.png": ("Patches across seams of a texture", "restoration_pictures.py"),
    "edges.png": ("Holes cut out of solids with sharp edges: open, with smooth patches, and with the edges continued", "edges_picture.py"),
    "libigl.png": ("Patches of isomend and of libigl, coloured by their distance from the true surface", "compare_libigl.py"),
    "view_holes.png": ("Holes in the page of isomend view", "view_picture.py"),
    "view_paint.png": ("A painted region that is to be replaced", "view_picture.py"),
    "view_preview.png": ("One hole with two settings side by side", "view_picture.py"),
    "browser.png": ("The page as a static site, without a program", "wasm_test.py"),
    "report.png": ("A report", "report_picture.py"),
}


def places():
    """For each page of the repository its name in the site."""
    pages = {Path(f"docs/{path.name}"): path.name for path in (ROOT / "docs").glob("*.md")}
    pages |= {Path(name): name for name in ("CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md")}
    return pages | {Path("README.md"): "index.md"}


def relinked(page, text, names):
    """The text of a page with its links changed to pages of the site. Links to files that are not in the site become plain text."""

    def link(match):
        shown, target = match[1], match[2]
        if "://" in target or target.startswith("#"):
            return match[0]
        path, _, anchor = target.partition("#")
        aim = Path(os.path.normpath(page.parent / path))
        if aim in names:
            return f"{shown}({names[aim]}{'#' + anchor if anchor else ''})"
        if aim.parts[0] == "data" and aim.suffix == ".png":
            return f"{shown}({aim})"
        return re.sub(r"^!?\[(.*)\]$", r"\1", shown, flags=re.S)

    return re.sub(r"(!?\[[^\]]*\])\(([^)\s]+)\)", link, text)


def gallery():
    rows = [f"## {title}\n\n![{title}](data/{name})\n\n*Drawn by `scripts/{script}`.*\n" for name, (title, script) in GALLERY.items()]
    return "# Gallery\n\n" + "\n".join(rows)


def summary(names):
    """mdBook's list of chapters. The program ends with an error if a page is not listed exactly once."""
    listed = [page for pages in CHAPTERS.values() for page in pages]
    missing = set(names.values()) | {"gallery.md"}
    if sorted(listed) != sorted(missing):
        sys.exit(f"not listed exactly once in scripts/site.py: {sorted(missing ^ set(listed)) or 'a page that is listed twice'}")
    lines = ["# Summary", ""]
    for chapter, pages in CHAPTERS.items():
        lines += ["", f"# {chapter}", ""] if chapter else []
        lines += [f"{'- ' if chapter else ''}[{title}]({page})" for page, title in pages.items()]
    return "\n".join(lines) + "\n"


class Page(html.parser.HTMLParser):
    """The links of a page, and its anchors."""

    def __init__(self, text):
        super().__init__()
        self.links, self.ids = [], set()
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        given = dict(attributes)
        self.links += [given[name] for name in ("href", "src") if given.get(name)]
        self.ids |= {given[name] for name in ("id", "name") if given.get(name)}


def check(site):
    """Ends the program with an error if a link has no target. Links of print.html, 404.html and toc.html are not checked. Returns the
    number of pages."""
    read = {path: Page(path.read_text(encoding="utf-8")) for path in site.rglob("*.html") if not {"api", "try"} & set(path.relative_to(site).parts)}
    wrong = []
    for path, page in read.items():
        for link in page.links if path.name not in ("print.html", "404.html", "toc.html") else ():
            parts = urllib.parse.urlsplit(link)
            if parts.scheme or parts.netloc or parts.path.startswith("api/"):
                continue
            aim = (path.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else path
            if not aim.exists():
                wrong.append(f"{path.name}: {link}")
            elif parts.fragment and aim in read and urllib.parse.unquote(parts.fragment) not in read[aim].ids:
                wrong.append(f"{path.name}: there is no place {link}")
    if wrong:
        sys.exit("links without a target:\n" + "\n".join(sorted(set(wrong))))
    return len(read)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path, help="folder for the site, which is replaced")
    parser.add_argument("--mdbook", default="mdbook", help="the program mdbook")
    parser.add_argument("--api", action="store_true", help="add cargo's documentation, under api/isomend")
    parser.add_argument("--try", type=Path, dest="page", help="add the page that runs in the browser, under try: the folder `site` of scripts/wasm.sh")
    arguments = parser.parse_args()
    if arguments.out.exists() and any(arguments.out.iterdir()) and not (arguments.out / "index.html").exists():
        sys.exit(f"{arguments.out} has other files in it; name a new folder, or the folder of an earlier site")
    names = places()
    listed = summary(names)
    if not shutil.which(arguments.mdbook):
        left_out("The site", "mdbook is not installed (cargo install --locked mdbook)")
        return
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "src"
        shutil.copytree(ROOT / "data", source / "data", ignore=lambda _, files: [f for f in files if not f.endswith(".png")])
        for page, name in names.items():
            text = relinked(page, (ROOT / page).read_text(encoding="utf-8"), names)
            if arguments.page and name == "browser.md":
                text = text.replace("\n## The site\n", "\n**[Try it](try/index.html)**\n\n## The site\n", 1)
            (source / name).write_text(text, encoding="utf-8")
        (source / "gallery.md").write_text(gallery(), encoding="utf-8")
        (source / "SUMMARY.md").write_text(listed, encoding="utf-8")
        (Path(folder) / "book.toml").write_text(BOOK)
        subprocess.run([arguments.mdbook, "build", folder, "--dest-dir", str(Path(folder) / "out")], check=True)
        if arguments.api:
            target = Path(folder) / "target"
            subprocess.run(["cargo", "doc", "--no-deps", "--package", "isomend", "--target-dir", target], cwd=ROOT, check=True)
            shutil.copytree(target / "doc", Path(folder) / "out/api")
        if arguments.page:
            shutil.copytree(arguments.page, Path(folder) / "out/try")
        count = check(Path(folder).resolve() / "out")
        shutil.rmtree(arguments.out, ignore_errors=True)
        shutil.copytree(Path(folder) / "out", arguments.out)
    print(f"{arguments.out}: {count} pages, all links have targets")


if __name__ == "__main__":
    main()
