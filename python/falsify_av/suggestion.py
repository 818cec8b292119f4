"""Suggestions for names that are not known."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches


def suggested(name: object, known: Iterable[str]) -> str:
    """The end of a sentence about an unknown name: the known one that is like it, or all."""
    written = {each.lower(): each for each in known}
    near = get_close_matches(str(name).lower(), written, 1)
    return f"did you mean `{written[near[0]]}`?" if near else f"there is {', '.join(written.values())}"
