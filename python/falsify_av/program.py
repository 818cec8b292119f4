"""The program ``falsify`` from Python: it runs campaigns, repeats episodes and writes reports; here are its calls and its tables.

The wheel of environments has no table library and no command line. These functions start the program, which the wheel ``falsify-av-program`` installs
(the extra ``falsify-av[program]``); ``FALSIFY_BIN`` may name another one. ``python -m falsify_av`` is the program, too.
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from .progress import Progress, shown

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
        raise FileNotFoundError("the program `falsify` is not installed: install the wheel falsify-av-program, or name it in FALSIFY_BIN")
    return found


def call(*arguments: str | os.PathLike[str], show: bool = False, each_line: Callable[[str], None] | None = None) -> str:
    """Call the program with these arguments and return what it prints.

    Ctrl-C ends the program after the work in hand, which is kept, and a second one at once; then ``KeyboardInterrupt`` is raised.

    Args:
        arguments: Those of the command line.
        show: Whether its messages go to the terminal as it runs.
        each_line: Is called with each line of its output as it comes.

    Raises:
        ProgramError: It ended with an error.
    """
    command = [find(), *(os.fspath(each) for each in arguments)]
    with tempfile.TemporaryFile("w+", encoding="utf-8") as messages:
        stderr = sys.__stderr__ if show else messages
        # A session of its own: a Ctrl-C on the terminal reaches Python alone, which passes on one.
        with subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=stderr, text=True, encoding="utf-8", start_new_session=os.name == "posix"
        ) as process:
            try:
                out = ""
                for line in process.stdout or ():
                    out += line
                    if each_line is not None:
                        each_line(line)
                process.wait()
            except BaseException:
                _interrupt(process)
                raise
        messages.seek(0)
        text = messages.read()
    if process.returncode:
        raise ProgramError(process.returncode, text)
    return out


def _interrupt(process: subprocess.Popen[str]) -> None:
    """End the program, as Ctrl-C in a terminal does."""
    for _ in range(2):
        try:
            if os.name == "posix":
                process.send_signal(signal.SIGINT)
            else:
                process.terminate()
            process.wait()
        except KeyboardInterrupt:
            continue
        return
    process.kill()


class _Tasks:
    """Counts the tasks of a run by the events that `--format json` prints, for a progress bar."""

    def __init__(self, tell: Progress) -> None:
        self._tell = tell
        self._done = self._total = 0

    def __call__(self, line: str) -> None:
        event = json.loads(line)
        if event["event"] == "campaign_begun":
            self._total += sum(count for count in event.values() if isinstance(count, int))
        elif event["event"] == "task_finished":
            self._done += 1
            self._tell(self._done, self._total)


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
        """A table as Arrow, from Parquet if the report has it, else from CSV.

        It has Arrow's C interface of streams. ``polars.from_arrow(table)`` shares the memory of numbers and truth values with it,
        and ``table.to_pandas(types_mapper=pandas.ArrowDtype)`` that of all columns.

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
    progress: bool | Progress = False,
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
        progress: ``True`` for a bar, or a function that is called with the finished tasks and all tasks of the campaigns begun.
    """
    named = [files] if isinstance(files, (str, os.PathLike)) else list(files)
    command = ["run", *(os.fspath(each) for each in named), "--out", os.fspath(out), "--seed", str(seed)]
    for name, value in (settings or {}).items():
        command += ["--set", f"{name}={value}"]
    if allow_external:
        command.append("--allow-external")
    if progress:
        call(*command, "--format", "json", *arguments, show=show, each_line=_Tasks(shown(progress, "tasks")))
    else:
        call(*command, *arguments, show=show)
    return reports(out)


def reports(out: str | os.PathLike[str] = "reports") -> dict[str, Report]:
    """The reports in a folder, by the names of their folders."""
    found = sorted(Path(out).glob("*/manifest.toml"))
    return {path.parent.name: Report(path.parent) for path in found}


def failures(report: str | os.PathLike[str] = "reports", *, arguments: Sequence[str] = ()) -> list[dict[str, Any]]:
    """The failures of a report or of a folder of reports, those that count most against a driver first.

    ``arguments`` are further ones of ``falsify failures``, such as ``["--verdict", "fault", "--top", "5"]``.
    """
    return [json.loads(line) for line in call("failures", os.fspath(report), "--format", "json", *arguments).splitlines()]


def compare(
    before: str | os.PathLike[str],
    after: str | os.PathLike[str] | None = None,
    *,
    drivers: tuple[str, str] | None = None,
    page: str | os.PathLike[str] | None = None,
    arguments: Sequence[str] = (),
) -> dict[str, Any]:
    """Compare two reports start by start, or two drivers of one report: rates with paired intervals, failures that are new, worse, fixed, better or the same.

    Args:
        before, after: Two reports, or one and ``drivers``.
        drivers: The driver before and the one after.
        page: A file for a page with both episodes of the worst changes side by side.
        arguments: Further arguments of ``falsify compare``.
    """
    command = ["compare", os.fspath(before)]
    if after is not None:
        command.append(os.fspath(after))
    if drivers is not None:
        command += ["--drivers", *drivers]
    if page is not None:
        command += ["--page", os.fspath(page)]
    found: dict[str, Any] = json.loads(call(*command, "--format", "json", *arguments))
    return found


def export(
    name: str,
    form: str,
    *,
    report: str | os.PathLike[str] = "reports",
    to: str | os.PathLike[str] = ".",
    ego: Literal["recorded", "user"] = "recorded",
    arguments: Sequence[str] = (),
) -> list[Path]:
    """Write an episode ``RUN:EPISODE`` for another program and return the new and the changed files.

    Args:
        name: The episode.
        form: A format of ``falsify export --formats``, such as ``"xosc-1.3"``.
        report: A report, or a folder of reports.
        to: The folder for the files.
        ego: ``"recorded"``: the ego follows its recorded track; ``"user"``: it starts as recorded, and your driver drives it.
        arguments: Further arguments of ``falsify export``.
    """
    folder = Path(to)
    folder.mkdir(parents=True, exist_ok=True)
    before = {path: path.stat().st_mtime_ns for path in folder.iterdir()}
    driven = [] if ego == "recorded" else ["--ego", ego]
    call("export", name, "--as", form, "--report", os.fspath(report), "--out", os.fspath(folder), *driven, *arguments)
    return sorted(path for path in folder.iterdir() if before.get(path) != path.stat().st_mtime_ns)


def replay(name: str, *, report: str | os.PathLike[str] = "reports", arguments: Sequence[str] = ()) -> dict[str, Any]:
    """Repeat an episode ``RUN:EPISODE`` of a report and compare it with the report."""
    found: dict[str, Any] = json.loads(call("replay", name, "--report", os.fspath(report), "--json", *arguments))
    return found
