"""Renews what stands in the README between `<!-- NAME: SCRIPT -->` and the next `<!-- end -->`."""

import pathlib

README = pathlib.Path(__file__).parent.parent / "README.md"
END = "<!-- end -->"


def renew(name, script, text):
    start = f"<!-- {name}: scripts/{script} -->"
    before, rest = README.read_text().split(start, 1)
    README.write_text(f"{before}{start}\n{text}\n{END}{rest.split(END, 1)[1]}")
