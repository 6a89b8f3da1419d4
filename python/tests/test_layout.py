"""The structure of the package's source: no files import each other, directly or through others."""

import ast
import pathlib
import re

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[1]


def python_imports(folder):
    """The modules of the package that each module imports, including imports for type checking."""
    paths = [*sorted(folder.rglob("*.py")), *sorted(folder.rglob("*.pyi"))]
    names = {".".join(path.relative_to(folder).with_suffix("").parts): path for path in paths}
    imports = {}
    for name, path in names.items():
        found = set()
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ImportFrom) and node.module and node.module.split(".")[0] == "isomend":
                inner = node.module.split(".")[1:]
                found |= {".".join([*inner, alias.name]) for alias in node.names} | {".".join(inner)}
        imports[name] = {target for target in found if target in names and target != name}
    return imports


def rust_imports(folder):
    names = {path.stem: path for path in sorted(folder.glob("*.rs"))}
    return {name: set(re.findall(r"\bcrate::(\w+)", path.read_text())) & set(names) for name, path in names.items()}


def in_cycles(imports):
    """The files in cycles: files that import none of the rest, or are imported by none, are removed until nothing changes."""
    left = set(imports)
    while True:
        ends = {name for name in left if not imports[name] & left}
        begins = {name for name in left if not any(name in imports[other] for other in left)}
        if not ends | begins:
            return left
        left -= ends | begins


@pytest.mark.parametrize(
    ("read", "folder", "least"),
    [(python_imports, "isomend", 15), (rust_imports, "src", 15)],
    ids=["python", "rust"],
)
def test_no_files_import_each_other_in_a_cycle(read, folder, least):
    if not (ROOT / folder).is_dir():
        pytest.fail(f"{ROOT / folder} is not there")
    imports = read(ROOT / folder)
    assert sum(map(len, imports.values())) >= least
    assert in_cycles(imports) == set()
