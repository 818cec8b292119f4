"""The file of an FMU, a functional mock-up unit: what it describes, its library unpacked, and instances of it, by FMPy.

An FMU is a library of somebody else. None of it runs before :func:`opened` has looked at its archive, which is unpacked into a folder of the cache.
"""

from __future__ import annotations

import contextlib
import hashlib
import stat
import tempfile
import zipfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import fmpy
from fmpy.simulation import apply_start_values, settable_in_initialization_mode, settable_in_instantiated

from .acados import cache

MOST_BYTES, MOST_FILES, LONGEST_DESCRIPTION = 512 << 20, 10_000, 64 << 20
DESCRIPTION = "modelDescription.xml"

Model = Any
Variable = Any


@dataclass(frozen=True)
class File:
    """An FMU that can be used here, and where it is unpacked."""

    path: Path
    model: Model
    folder: Path

    def step(self, tick: float) -> float:
        """The length of its own steps (s), or a tick if it takes any."""
        form, experiment = self.model.coSimulation, self.model.defaultExperiment
        own = form.fixedInternalStepSize
        if own is None and not form.canHandleVariableCommunicationStepSize and experiment is not None:
            own = experiment.stepSize
        return float(own) if own is not None and float(own) > 0.0 else tick


def opened(path: Path) -> File:
    """Look at an FMU, and unpack it.

    Raises:
        SystemExit: It cannot be used, with the reason and what helps.
    """
    if not path.is_file():
        raise SystemExit(f"there is no file {path}: give the path of an .fmu file, from the folder of the scenario")
    try:
        with path.open("rb") as source:
            entries = zipfile.ZipFile(source).infolist()
            _check(path, entries)
            model = fmpy.read_model_description(source, validate=False)
    except Exception as error:
        raise SystemExit(f"{path} cannot be read as an FMU: {error}; `fmpy validate {path}` says more") from None
    _check_kind(path, model, {entry.filename for entry in entries})
    return File(path, model, _unpacked(path))


def _check(path: Path, entries: list[zipfile.ZipInfo]) -> None:
    """Refuse archives that would write elsewhere or fill the disk."""
    for entry in entries:
        name = entry.filename
        if name.startswith("/") or "\\" in name or ":" in name or ".." in name.split("/") or stat.S_ISLNK(entry.external_attr >> 16):
            raise SystemExit(f"{path} is not unpacked, since its entry {name!r} leads out of its folder: export it again")
    sizes = {entry.filename: entry.file_size for entry in entries}
    total = sum(entry.file_size for entry in entries)
    if total > MOST_BYTES or len(entries) > MOST_FILES or sizes.get(DESCRIPTION, 0) > LONGEST_DESCRIPTION:
        most = f"at most {MOST_BYTES >> 20} MiB in {MOST_FILES} files are"
        raise SystemExit(f"{path} is not unpacked: it has {total >> 20} MiB in {len(entries)} files, and {most}; export it without what it does not need")
    if DESCRIPTION not in sizes:
        raise SystemExit(f"{path} is no FMU, since it has no {DESCRIPTION}: give one of FMI 2.0 or 3.0")


def _check_kind(path: Path, model: Model, names: set[str]) -> None:
    """Refuse FMUs of another kind or for another system."""
    version = str(model.fmiVersion)
    if version.startswith("1"):
        raise SystemExit(f"{path} is of FMI {version}: export it as FMI 2.0 or 3.0 for co-simulation")
    if model.coSimulation is None:
        kind = "model exchange" if model.modelExchange is not None else "scheduled execution"
        raise SystemExit(f"{path} is for {kind} alone, without a solver of its own: export it for co-simulation")
    system = fmpy.platform if version.startswith("2") else fmpy.platform_tuple
    if f"binaries/{system}/{model.coSimulation.modelIdentifier}{fmpy.sharedLibraryExtension}" not in names:
        others = sorted({name.split("/")[1] for name in names if name.startswith("binaries/") and name.count("/") > 1})
        source = f", or build it from its sources by `fmpy compile {path}`" if any(name.startswith("sources/") for name in names) else ""
        raise SystemExit(f"{path} has no library for {system}, only for {', '.join(others) or 'nothing'}: export it for {system}{source}")


def _unpacked(path: Path) -> Path:
    """The folder of its contents, which an earlier start may have made."""
    folder = cache() / f"fmu-{hashlib.sha256(path.read_bytes()).hexdigest()[:24]}"
    if not folder.is_dir():
        # Another process may unpack the same; the first that is done wins.
        folder.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder.parent) as place:
            whole = Path(place) / "fmu"
            fmpy.extract(str(path), str(whole))
            with contextlib.suppress(OSError):
                whole.rename(folder)
    return folder


class Instance:
    """An instance, made anew for each episode."""

    def __init__(self, file: File, inputs: Sequence[Variable], outputs: Sequence[Variable], constants: dict[str, Any], step: float) -> None:
        self._file, self._model, self._constants, self._step = file, file.model, constants, step
        self._inputs, self._outputs = inputs, outputs
        self._is_new, self._steps = True, 0
        self._open()

    def _open(self) -> None:
        path = self._file.path
        try:
            self._fmu = fmpy.instantiate_fmu(str(self._file.folder), self._model, "CoSimulation")
        except Exception as error:
            raise SystemExit(f"{path} cannot be instantiated: {error}; `fmpy simulate {path}` does the same without falsify") from None
        self._setters, self._getters = self._calls("set", self._inputs), self._calls("get", self._outputs)

    def _calls(self, verb: str, variables: Sequence[Variable]) -> list[tuple[Callable[..., Any], list[int], list[int], Callable[[float], Any]]]:
        """One call for each type: the function, the references, their places among the variables, and what makes a value of a number."""
        integer = "Integer" if str(self._model.fmiVersion).startswith("2") else "Int64"
        types = [integer if each.type == "Enumeration" else each.type for each in variables]
        calls = []
        for kind in sorted(set(types)):
            places = [place for place, each in enumerate(types) if each == kind]
            made: Callable[[float], Any] = float if kind in ("Real", "Float32", "Float64") else bool if kind == "Boolean" else round
            calls.append((getattr(self._fmu, verb + kind), [variables[place].valueReference for place in places], places, made))
        return calls

    def step(self, inputs: Sequence[float], until: float, starts: bool) -> list[float]:
        """Initialise it at the time 0 if an episode starts; step until it has reached a time (s), or is beyond it by a part of its step; return its outputs."""
        if starts:
            self._start(inputs)
        self._set(inputs)
        while self._steps * self._step < until - 1e-9:
            state = self._fmu.doStep(self._steps * self._step, self._step)
            self._steps += 1
            if state and state[1]:
                raise RuntimeError("it ends its simulation")
        outputs = [0.0] * len(self._outputs)
        for get, references, places, _ in self._getters:
            for place, value in zip(places, get(references)):
                outputs[place] = float(value)
        return outputs

    def _start(self, inputs: Sequence[float]) -> None:
        if not self._is_new:
            # The reset of some leaves their state as it is.
            self._fmu.terminate()
            self._fmu.freeInstance()
            self._open()
        self._is_new, self._steps = False, 0
        fmu, model = self._fmu, self._model
        if str(model.fmiVersion).startswith("2"):
            fmu.setupExperiment(startTime=0.0)
        left = apply_start_values(fmu, model, self._constants, settable_in_instantiated)
        fmu.enterInitializationMode()
        left = apply_start_values(fmu, model, left, settable_in_initialization_mode)
        self._set(inputs)
        fmu.exitInitializationMode()
        if left:
            raise RuntimeError(f"{', '.join(left)} cannot be set")

    def _set(self, inputs: Sequence[float]) -> None:
        for put, references, places, made in self._setters:
            put(references, [made(inputs[place]) for place in places])


class Apart:
    """An instance in a process of its own."""

    def __init__(self, make: Callable[[], Instance]) -> None:
        context = get_context("fork")
        self._pipe, theirs = context.Pipe()
        context.Process(target=_answer, args=(theirs, make), daemon=True).start()
        theirs.close()

    def step(self, inputs: Sequence[float], until: float, starts: bool) -> list[float]:
        """As :meth:`Instance.step`."""
        try:
            self._pipe.send((inputs, until, starts))
            found = self._pipe.recv()
        except (EOFError, OSError):
            raise RuntimeError("its process has ended") from None
        if isinstance(found, str):
            raise RuntimeError(found)
        return list(found)


def _answer(pipe: Connection, make: Callable[[], Instance]) -> None:
    """Answer the calls until there are no more."""
    instance: Instance | None = None
    while True:
        values = pipe.recv()
        try:
            instance = instance or make()
            pipe.send(instance.step(*values))
        except (Exception, SystemExit) as error:
            pipe.send(str(error))
