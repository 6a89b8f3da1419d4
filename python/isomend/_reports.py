"""Reports of results: JSON documents as dictionaries, HTML pages, PNG pictures."""

from __future__ import annotations

import base64
import dataclasses
import html
import json
from typing import Any

from isomend._errors import IsomendError


class Report(dict[str, Any]):
    """A report: a dictionary that prints its outcome and its keys instead of all that it holds, which may be long.

    >>> Report(command="fill", complete=True, outcomes={"closed": 2, "left": 0})
    <isomend report of fill: complete, 2 closed; keys: command, complete, outcomes>
    """

    def __repr__(self) -> str:
        facts = [name if self[name] else f"not {name}" for name in ("complete", "sound") if name in self]
        outcomes = self.get("outcomes")
        if isinstance(outcomes, dict):
            facts += [f"{outcomes[name]} {name}" for name in ("closed", "left", "open") if outcomes.get(name)]
        summary = f": {', '.join(facts)}" if facts else ""
        return f"<isomend report of {self.get('command')}{summary}; keys: {', '.join(self)}>"


def report_of(document: str) -> Report:
    """The JSON document of a command as a dictionary, without path and format for meshes that are not from files."""
    report = Report(json.loads(document))
    for name in ("input", "output", "first", "second"):
        place = report.get(name)
        if isinstance(place, dict) and place["path"] == "-":
            del place["path"], place["format"]
    return report


def shortened(record: Any, arrays: dict[str, str]) -> str:
    """The fields of a dataclass in a line. Of each array only its length is shown, in the noun that ``arrays`` has for its name."""
    names = [field.name for field in dataclasses.fields(record)]

    def shown(name: str) -> str:
        value = getattr(record, name)
        return f"<{len(value)} {arrays[name]}>" if name in arrays else repr(value)

    return f"{type(record).__name__}({', '.join(f'{name}={shown(name)}' for name in names)})"


class Drawn:
    """Base class of results that can be drawn as a page and a picture."""

    _core: Any

    def page(self) -> str:
        """The page of the command line's ``--report``: one self-contained HTML file with a 3D view, plots and tables.

        Raises:
            MeshError: The mesh is not valid.
        """
        page: str = self._core.page()
        return page

    def picture(self) -> bytes:
        """The picture of the command line's ``--picture``: the bytes of a PNG file, 1448 pixels wide.

        Raises:
            MeshError: The mesh is not valid.
        """
        picture: bytes = self._core.picture()
        return picture

    def _repr_html_(self) -> str:
        """What a notebook shows: the picture with a caption; the caption alone if the mesh cannot be drawn."""
        line = html.escape(repr(self).strip("<>"))
        try:
            image = base64.b64encode(self.picture()).decode()
        except IsomendError:
            return f"<p>{line}</p>"
        source = f'src="data:image/png;base64,{image}"'
        return f'<figure><img {source} alt="{line}" style="width: 100%; max-width: 724px"><figcaption>{line}</figcaption></figure>'
