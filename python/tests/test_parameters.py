"""The keywords of functions against the library's parameter tables."""

import inspect
import json
import re

import numpy as np
import pytest

import isomend
from isomend import _isomend, _options

TABLES = json.loads(_isomend.parameters())
# Keywords that are in no table: the mesh and its data, how a call is run, and the refusal of unknown ones.
OTHERS = {"vertices", "faces", "mark", "a", "b", "threads", "progress", "strict", "point_data", "cell_data", "options", "unknown"}
KEYWORDS = {"fill": _options.FillOptions, "repair": _options.RepairOptions, "restore": _options.RestoreOptions, "fair": _options.FairOptions}


def words(text):
    """A text without line ends and backquotes."""
    return re.sub(r"\s+", " ", text.replace("`", ""))


def default(row):
    """The default of a keyword from its row in the table."""
    if row["kind"] == "flag":
        return False
    if row["kind"] in ("holes", "groups", "pairs", "words"):
        return None if row["default"] else ()
    if row["default"] is None or row["kind"] in ("voxel", "band", "choice"):
        return row["default"]
    return json.loads(row["default"])


@pytest.mark.parametrize("command", TABLES)
def test_keywords_and_their_defaults_equal_the_tables(command):
    rows = {row["name"]: row for row in TABLES[command]}
    keywords = inspect.signature(getattr(isomend, command)).parameters
    named = {name: keyword.default for name, keyword in keywords.items() if name not in OTHERS}
    if "options" in keywords:
        assert set(KEYWORDS[command].__annotations__) == set(rows) | {"threads", "progress", "strict"}
        assert not named
    else:
        assert named == {name: default(row) for name, row in rows.items()}


@pytest.mark.parametrize("command", TABLES)
def test_documentation_has_the_sentences_of_the_tables(command):
    documented = words(getattr(isomend, command).__doc__)
    for row in TABLES[command]:
        # Parameters that work as in a fill are listed by name only.
        as_fill = row["path"][:1] == ["fill"] and row["name"] != "max_diameter"
        if as_fill or command in ("restore", "fair"):
            assert row["name"] in documented or "further options as for :func:fill" in documented, row["name"]
        else:
            assert words(f"{row['name']}: {row['sentence']}") in documented, row["name"]
    for row in TABLES["fill"]:
        if row["default"] is None and row["kind"] in ("number", "whole") and row["usual"]:
            assert words(f"By default {row['usual']}") in words(isomend.fill.__doc__), row["name"]


@pytest.mark.parametrize(("command", "row"), [(command, row) for command in TABLES for row in TABLES[command]])
def test_values_out_of_bounds_are_refused(sphere, command, row):
    run = getattr(isomend.Model(*sphere), command, None) or (lambda **options: isomend.compare(sphere, sphere, **options))
    arguments = ([0],) if command in ("restore", "fair") else ()
    wrong = {"choice": ["none of them"], "flag": [1], "holes": [1], "groups": [[[0.5]]], "pairs": [[[0.5, 1]], [[1]], [[2, 2]]], "like": [1, ""], "words": [1, ["none of them"]]}.get(row["kind"], ["a word"])
    for value in wrong:
        with pytest.raises(isomend.ParameterError, match=row["name"]):
            run(*arguments, **{row["name"]: value})
    instead = {"voxel": " or 'auto'", "band": " or 'full'"}.get(row["kind"], "")
    bounds = [row["low"] - 1] if row["low"] is not None else []
    bounds += [row["high"] + 1] if row["high"] is not None else []
    for bound in bounds:
        value = int(bound) if row["kind"] == "whole" else bound
        with pytest.raises(isomend.ParameterError, match=f"^{row['name']} must be {row['allowed']}{instead}, but is "):
            run(*arguments, **{row["name"]: value})
    if row["kind"] in ("number", "voxel", "band"):
        for value in (np.inf, -np.inf, np.nan):
            with pytest.raises(isomend.ParameterError, match=f"^{row['name']} must be .*, but is {value}"):
                run(*arguments, **{row["name"]: value})
