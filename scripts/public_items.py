"""Counts the library's public items, without methods and fields, and fails if there are more than MOST.

    cargo doc --no-deps && python3 scripts/public_items.py [--list]

Counted are the entries of rustdoc's page of all items, each once even if it has several paths, and public items that are hidden from
the documentation.
"""

import argparse
import re
import sys
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).parent.parent
# Limit of the number of public items: users of the library have to read through all of them.
MOST = 250


def documented():
    page = ROOT / "target/doc/isomend/all.html"
    if not page.exists():
        sys.exit(f"{page} does not exist; make it with: cargo doc --no-deps")
    return re.findall(r'<li><a href="([^"]+)\.html">', page.read_text())


def hidden():
    """Public names with `#[doc(hidden)]`, without names that only WebAssembly makes public."""
    names = []
    pattern = re.compile(r"((?:^ *#\[.*\]\n)*^ *#\[doc\(hidden\)\]\n(?:^ *#\[.*\]\n)*)^ *pub (?:use|mod|fn|struct) ([^;{]+)", re.M)
    for file in sorted((ROOT / "src").rglob("*.rs")):
        for attributes, name in pattern.findall(file.read_text()):
            if not re.search('target_family = "wasm"', attributes):
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
        sys.exit(f"more than {MOST}: make some private (pub(crate)), or hide them from the documentation")


if __name__ == "__main__":
    main()
