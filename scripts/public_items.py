"""Counts the library's public items, without methods and fields, and fails where there are more than MOST.

    cargo doc --no-deps && python3 scripts/public_items.py [--list]

Counted are the entries of rustdoc's page of all items, each once however it can be reached, and what is public but hidden from the
documentation.
"""

import argparse
import re
import sys
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).parent.parent
# Anyone who learns the library has to look through them.
MOST = 250


def documented():
    page = ROOT / "target/doc/isomend/all.html"
    if not page.exists():
        sys.exit(f"{page} is not there: cargo doc --no-deps makes it")
    return re.findall(r'<li><a href="([^"]+)\.html">', page.read_text())


def hidden():
    """Public names under `#[doc(hidden)]`, but for what the feature `internals` opens."""
    names = []
    pattern = re.compile(r"((?:^ *#\[.*\]\n)*^ *#\[doc\(hidden\)\]\n(?:^ *#\[.*\]\n)*)^ *pub (?:use|mod|fn|struct) ([^;{]+)", re.M)
    for file in sorted((ROOT / "src").rglob("*.rs")):
        for attributes, name in pattern.findall(file.read_text()):
            if 'feature = "internals"' not in attributes:
                names.append(f"hidden/{name.strip()}")
    return names


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--list", action="store_true", help="print the items too")
    arguments = parser.parse_args()
    items = documented() + hidden()
    if arguments.list:
        print("\n".join(items))
    rooms = Counter(item.split("/")[0] if "/" in item else "(root)" for item in items)
    print(f"{len(items)} public items: " + ", ".join(f"{room} {count}" for room, count in rooms.most_common()))
    if len(items) > MOST:
        sys.exit(f"more than {MOST}: make some private (pub(crate)), or part of src/internals.rs")


if __name__ == "__main__":
    main()
