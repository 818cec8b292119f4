"""Scenario files: reading, checking, and the scenarios that they hold."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypedDict, Union

from . import _core
from .suggestion import suggested

if TYPE_CHECKING:
    from typing_extensions import Unpack

#: A file, or several.
Files = Union[str, "os.PathLike[str]", Sequence[Union[str, "os.PathLike[str]"]]]

#: The scenario of environments that are made without a file: the paper's pedestrian.
PAPER = Path(__file__).with_name("pedestrian.scn")


class Reading(TypedDict, total=False):
    """How scenario files are read."""

    #: Values of parameters and keys, as ``["far=20 m"]``.
    settings: Sequence[str]
    #: OpenDRIVE files that replace the roads of towns, by the names of the towns.
    maps: Mapping[str, str | os.PathLike[str]] | None
    #: Whether the files may name programs.
    allow_external: bool


class Selection(Reading, total=False):
    """Names that choose one scenario of files, besides that of its campaign."""

    town: str | None
    driver: str | None
    reward: str | None
    #: ``train``, ``evaluate`` or ``search``.
    task: str | None
    block: int | None


#: The names of the options of :func:`choose`.
_OPTIONS = ("campaign", *Selection.__annotations__)


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


def _paths(files: Files | None) -> list[Path]:
    if files is None:
        return [PAPER]
    if isinstance(files, (str, os.PathLike)):
        return [Path(files)]
    if isinstance(files, bytes) or not isinstance(files, Iterable):
        worlds = f"; the number of worlds is num_envs={files}" if isinstance(files, int) else ""
        raise TypeError(f"the scenario is {files!r}; give a file or a list of files{worlds}")
    paths = [Path(file) for file in files]
    if not paths:
        raise ValueError("no scenario file is given")
    return paths


def _load(
    files: Files | None, settings: Sequence[str] = (), maps: Mapping[str, Any] | None = None, allow_external: bool = False
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


def load(files: Files | None, reading: Mapping[str, Any]) -> _core.Scenarios:
    """Compile scenario files.

    Raises:
        ScenarioError: They have errors.
        FileNotFoundError: There is no such file.
        OSError: One cannot be read.
    """
    loaded, text, found = _load(files, **reading)
    if loaded is None:
        raise ScenarioError(text, found)
    return loaded


def choose(files: Files | None, options: Mapping[str, Any]) -> _core.Choice:
    """The scenario of the files that the options choose; the other options are those of :func:`load`.

    Raises:
        TypeError: There is no such option.
        ValueError: No scenario has these names, or several have.
    """
    for name in options:
        if name not in _OPTIONS:
            raise TypeError(f"there is no option {name}; {suggested(name, _OPTIONS)}")
    names = dict(options)
    loaded = load(files, {name: names.pop(name) for name in Reading.__annotations__ if name in names})
    return loaded.choose(**names)


def check(files: Files, **reading: Unpack[Reading]) -> list[Diagnostic]:
    """Check scenario files and return all errors and warnings; an empty list when there is none.

    Args:
        files: A file, or several.
        reading: ``settings``, ``maps`` and ``allow_external``, as :class:`Reading` has them.
    """
    return _load(files, **reading)[2]


def scenarios(files: Files | None = None, **reading: Unpack[Reading]) -> list[dict[str, Any]]:
    """List the scenarios of the files: the names that :func:`falsify_av.make` chooses one by."""
    keys = ("campaign", "task", "block", "town", "driver", "reward")
    return [dict(zip(keys, names)) for names in load(files, reading).choices()]
