"""Remarks on results, beside the library's own: why they are not complete, and what could not be continued on patches."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

# What to do about a boundary chain that does not close, by its reason.
CHAINS = {
    "non_manifold": "isomend.repair separates the surfaces there, then fills; its debris=0.01 removes loose faces",
    "one_sided": "it bounds no hole and cannot be filled",
}


def incomplete(mended: Any) -> list[str]:
    """Why a result is not complete, beside holes that could not be closed: reasons why a repaired mesh is not sound; boundary chains that
    do not close."""
    after = mended.report.get("after")
    if after:
        return [f"the result is not sound: {'; '.join(after['reasons'])}"]
    chains = mended.report.get("open_chains", [])
    lines = [line for line in mended._core.lines() if line.startswith("a boundary chain of ")]
    more = [f"{len(chains) - len(lines)} more boundary chains do not close"] if len(chains) > len(lines) else []
    # A reason of a newer library has no advice yet.
    return ["; ".join(filter(None, (line, CHAINS.get(chain["reason"])))) for chain, line in zip(chains, lines)] + more


def not_continued(mended: Any, messages: Sequence[tuple[bool, str]]) -> list[str]:
    """Remarks on the caller's values that could not be continued on patches. For values of files, :meth:`isomend.Mended.write` returns them."""
    return beside_patches(mended, messages) if any(mended._given) else []


def beside_patches(mended: Any, messages: Sequence[tuple[bool, str]]) -> list[str]:
    """The notes on a result without its messages, which are on patches and holes."""
    texts = [text for _, text in messages]
    return [note for note in mended.notes if note not in texts]
