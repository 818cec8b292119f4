"""Scenario files: reading, checking, and the scenarios that they hold."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from . import _core

Files = "str | os.PathLike[str] | Sequence[str | os.PathLike[str]]"

#: The scenario of environments that are made without a file: the paper's pedestrian.
PAPER = Path(__file__).with_name("pedestrian.scn")


@dataclass(frozen=True)
class Diagnostic:
    """One finding in a scenario file."""

    #: ``error`` or ``warning``.
    severity: str
    #: A word that names the kind of finding.
    code: str
    #: What is wrong, in one line.
    message: str
    #: The file.
    file: str
    #: Line, from 1.
    line: int
    #: Column, from 1, in characters.
    column: int
    #: Advice.
    help: tuple[str, ...]


class ScenarioError(ValueError):
    """Scenario files have errors. The text shows each under its line; ``diagnostics`` has them one by one."""

    def __init__(self, text: str, diagnostics: Sequence[Diagnostic]) -> None:
        super().__init__(text)
        self.diagnostics = list(diagnostics)


def _paths(files: Any) -> list[Path]:
    if files is None:
        return [PAPER]
    if isinstance(files, (str, os.PathLike)):
        return [Path(files)]
    paths = [Path(file) for file in files]
    if not paths:
        raise ValueError("no scenario file is given")
    return paths


def _load(
    files: Any, settings: Sequence[str], maps: Mapping[str, Any] | None, allow_external: bool
) -> tuple[_core.Scenarios | None, str, list[Diagnostic]]:
    if isinstance(settings, str):
        raise TypeError('settings is a list of texts such as ["far=20 m"], not one text')
    pairs = [(str(town), Path(path)) for town, path in (maps or {}).items()]
    loaded, text, records = _core.load(_paths(files), list(settings), pairs, bool(allow_external))
    found = [
        Diagnostic(each["severity"], each["code"], each["message"], each["file"], each["line"], each["column"], tuple(each["help"]))
        for each in json.loads(records)
    ]
    return loaded, text, found


def load(
    files: Any, settings: Sequence[str] = (), maps: Mapping[str, Any] | None = None, allow_external: bool = False
) -> _core.Scenarios:
    """Compile scenario files.

    Raises:
        ScenarioError: They have errors.
        OSError: One cannot be read.
    """
    loaded, text, found = _load(files, settings, maps, allow_external)
    if loaded is None:
        raise ScenarioError(text, found)
    return loaded


def choose(files: Any, options: Mapping[str, Any]) -> _core.Choice:
    """The scenario of the files that the options choose; the other options are those of :func:`load`.

    Raises:
        TypeError: There is no such option.
        ValueError: No scenario has these names, or several have.
    """
    options = dict(options)
    loaded = load(files, options.pop("settings", ()), options.pop("maps", None), options.pop("allow_external", False))
    unknown = set(options) - {"campaign", "town", "policy", "reward", "task", "block"}
    if unknown:
        raise TypeError(f"there is no option {', '.join(sorted(unknown))}")
    return loaded.choose(**options)


def check(
    files: Any, *, settings: Sequence[str] = (), maps: Mapping[str, Any] | None = None, allow_external: bool = False
) -> list[Diagnostic]:
    """Check scenario files and return all errors and warnings; an empty list when there is none.

    Args:
        files: A file, or several.
        settings: Values of parameters and keys, as ``"far=20 m"``.
        maps: OpenDRIVE files that replace the roads of towns, by the names of the towns.
        allow_external: Whether the files may name programs.
    """
    return _load(files, settings, maps, allow_external)[2]


def scenarios(
    files: Any = None, *, settings: Sequence[str] = (), maps: Mapping[str, Any] | None = None, allow_external: bool = False
) -> list[dict[str, Any]]:
    """List the scenarios of the files: the names that :func:`falsify_av.make` chooses one by."""
    keys = ("campaign", "task", "block", "town", "policy", "reward")
    return [dict(zip(keys, names)) for names in load(files, settings, maps, allow_external).choices()]
