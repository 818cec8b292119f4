"""Drivers and worlds that packages bring, by the entry points of their metadata.

A package of yours adds one in its ``pyproject.toml``: ``[project.entry-points."falsify_av.drivers"]`` with ``mine = "my_package.driver:main"``. The function
gets the options after the name and serves a driver; one of ``falsify_av.worlds`` returns a world (:class:`falsify_av.bridges.World`). A function ``look`` of
the same module may end the program with a sentence that says what is not installed.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from typing import Any

DRIVERS, WORLDS = "falsify_av.drivers", "falsify_av.worlds"


def entries(group: str, own: Mapping[str, str]) -> dict[str, EntryPoint]:
    """The entry points of a group by name; those of this package, as ``own`` gives them, come first and are there without its metadata, too."""
    found = {name: EntryPoint(name, value, group) for name, value in own.items()}
    for each in sorted(entry_points(group=group), key=lambda each: (each.name, each.value)):
        found.setdefault(each.name, each)
    return found


def function(entry: EntryPoint) -> Callable[[list[str]], Any]:
    """What an entry point names.

    Raises:
        SystemExit: A sentence that says why there is no function, and what to do.
    """
    brings = f"{entry.name} ({entry.value}" + (f" of {entry.dist.name} {entry.dist.version})" if entry.dist else ")")
    try:
        import_module(entry.module)
    except ModuleNotFoundError as error:
        raise SystemExit(f"{brings} needs the Python package {error.name}, which is not installed; install it for {sys.executable}") from error
    try:
        named = entry.load()
    except AttributeError as error:
        raise SystemExit(f"{brings} is not there: {error}; correct the entry point") from error
    if not callable(named):
        raise SystemExit(f"{brings} is {type(named).__name__} and no function; let the entry point name one")
    function: Callable[[list[str]], Any] = named
    return function


def look(entry: EntryPoint) -> None:
    """See whether all that an entry point needs is there; end the program with a sentence if not."""
    function(entry)
    getattr(import_module(entry.module), "look", lambda: None)()
