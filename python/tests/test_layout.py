"""How the source of the package is laid out: no two files use each other, directly or through others."""

import ast
import pathlib
import re

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[1]


def python_arrows(folder):
    """Which modules each module of the package imports, for type checking as well."""
    paths = [*sorted(folder.rglob("*.py")), *sorted(folder.rglob("*.pyi"))]
    names = {".".join(path.relative_to(folder).with_suffix("").parts): path for path in paths}
    arrows = {}
    for name, path in names.items():
        found = set()
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ImportFrom) and node.module and node.module.split(".")[0] == "isomend":
                inner = node.module.split(".")[1:]
                found |= {".".join([*inner, alias.name]) for alias in node.names} | {".".join(inner)}
        arrows[name] = {target for target in found if target in names and target != name}
    return arrows


def rust_arrows(folder):
    names = {path.stem: path for path in sorted(folder.glob("*.rs"))}
    return {name: set(re.findall(r"\bcrate::(\w+)", path.read_text())) & set(names) for name, path in names.items()}


def in_circles(arrows):
    """What stays when files that use no other are taken away, again and again, and then those that none uses."""
    left = set(arrows)
    while True:
        ends = {name for name in left if not arrows[name] & left}
        begins = {name for name in left if not any(name in arrows[other] for other in left)}
        if not ends | begins:
            return left
        left -= ends | begins


@pytest.mark.parametrize(
    ("read", "folder", "least"),
    [(python_arrows, "isomend", 15), (rust_arrows, "src", 15)],
    ids=["python", "rust"],
)
def test_no_files_use_each_other_in_a_circle(read, folder, least):
    if not (ROOT / folder).is_dir():
        pytest.fail(f"{ROOT / folder} is not there")
    arrows = read(ROOT / folder)
    assert sum(map(len, arrows.values())) >= least
    assert in_circles(arrows) == set()
