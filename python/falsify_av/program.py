"""The program ``falsify`` from Python: it runs campaigns, repeats episodes and writes reports; here are its calls and its tables.

The wheel of environments has no table library and no command line. These functions start the program, which
``cargo install --locked --path .`` in a clone installs; ``FALSIFY_BIN`` may name it. Ctrl-C ends it as in a terminal, and finished work is kept.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

if TYPE_CHECKING:
    import pyarrow


class ProgramError(RuntimeError):
    """The program ended with an error. ``code`` is its exit code, the text what it printed on its error stream."""

    def __init__(self, code: int, text: str) -> None:
        super().__init__(text.strip() or f"the program ended with exit code {code}")
        self.code = code


def find() -> str:
    """The path of the program.

    Raises:
        FileNotFoundError: It is not installed.
    """
    named = os.environ.get("FALSIFY_BIN")
    beside = Path(sysconfig.get_path("scripts")) / ("falsify.exe" if os.name == "nt" else "falsify")
    found = named or (str(beside) if beside.is_file() else None) or shutil.which("falsify")
    if found is None:
        raise FileNotFoundError("the program `falsify` is not installed: `cargo install --locked --path .` in a clone installs it, or name it in FALSIFY_BIN")
    return found


def call(*arguments: str | os.PathLike[str], show: bool = False) -> str:
    """Call the program with these arguments and return what it prints. With ``show`` its messages go to the terminal as it runs.

    Raises:
        ProgramError: It ended with an error.
    """
    command = [find(), *map(os.fspath, arguments)]
    stderr = sys.__stderr__ if show else subprocess.PIPE
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=stderr, text=True, encoding="utf-8") as process:
        try:
            out, text = process.communicate()
        except KeyboardInterrupt:
            # The terminal has sent the signal to the program, too: it ends after the work in hand.
            process.wait()
            raise
    if process.returncode:
        raise ProgramError(process.returncode, text or "")
    return out


@dataclass(frozen=True)
class Report:
    """The folder of a report of one campaign."""

    folder: Path

    @property
    def manifest(self) -> dict[str, Any]:
        """What was run: files, seed, version, towns."""
        return tomllib.loads((self.folder / "manifest.toml").read_text(encoding="utf-8"))

    @property
    def tables(self) -> list[str]:
        """The names of its tables."""
        return sorted({path.stem for kind in ("parquet", "csv") for path in self.folder.glob(f"*.{kind}")})

    def table(self, name: str) -> pyarrow.Table:
        """A table as Arrow, from Parquet if the report has it, else from CSV. ``polars.from_arrow`` takes it without a copy.

        It needs ``pip install falsify-av[tables]``.
        """
        from pyarrow import csv, parquet

        if (path := self.folder / f"{name}.parquet").is_file():
            return parquet.read_table(path)
        if (path := self.folder / f"{name}.csv").is_file():
            return csv.read_csv(path)
        raise KeyError(f"the report has no table `{name}`; it has {', '.join(self.tables) or 'none'}")


def run(
    files: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    *,
    out: str | os.PathLike[str] = "reports",
    seed: int = 1,
    settings: Mapping[str, Any] | None = None,
    allow_external: bool = False,
    arguments: Sequence[str] = (),
    show: bool = False,
) -> dict[str, Report]:
    """Run the campaigns of scenario files and return their reports by the names of their folders.

    Args:
        files: A file, or several.
        out: The folder for the reports.
        seed: The seed of all random numbers.
        settings: Values of parameters and keys, by name.
        allow_external: Whether the files may start programs as drivers.
        arguments: Further arguments of ``falsify run``.
        show: Whether messages go to the terminal as it runs.
    """
    named = [files] if isinstance(files, (str, os.PathLike)) else list(files)
    command = ["run", *map(os.fspath, named), "--out", os.fspath(out), "--seed", str(seed)]
    for name, value in (settings or {}).items():
        command += ["--set", f"{name}={value}"]
    if allow_external:
        command.append("--allow-external")
    call(*command, *arguments, show=show)
    return reports(out)


def reports(out: str | os.PathLike[str] = "reports") -> dict[str, Report]:
    """The reports in a folder, by the names of their folders."""
    found = sorted(Path(out).glob("*/manifest.toml"))
    return {path.parent.name: Report(path.parent) for path in found}


def replay(name: str, *, out: str | os.PathLike[str] = "reports", arguments: Sequence[str] = ()) -> dict[str, Any]:
    """Repeat an episode ``RUN:EPISODE`` of a report and compare it with the report."""
    return json.loads(call("replay", name, "--report", os.fspath(out), "--json", *arguments))
