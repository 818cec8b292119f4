"""acados as `comma-deps-acados` installs it: a problem becomes C, is compiled once, and is kept for the next start.

Its generator prints, and needs two environment variables and a search path of its own; all of that is here.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import sys
import tempfile
from collections.abc import Callable, Iterator
from importlib.metadata import version
from pathlib import Path
from typing import Any

Solver = Any


def cache() -> Path:
    """The folder of compiled problems."""
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "falsify_av"


def compiled(problem: Callable[[], Any], source: bytes) -> Solver:
    """A solver of a problem, which ``source`` is the text of. It is compiled if no earlier process has."""
    import acados

    os.environ["ACADOS_SOURCE_DIR"] = str(_tree(acados))
    os.environ["TERA_PATH"] = acados.TERA_PATH
    from acados.acados_template import AcadosOcpSolver

    # What is compiled names the libraries of the environment that it was compiled in.
    key = hashlib.sha256(source + version("comma-deps-acados").encode() + acados.DIR.encode()).hexdigest()[:16]
    folder = cache() / f"acados-{key}"
    with _quiet():
        if not folder.is_dir():
            # Another process may compile the same; the first that is done wins.
            folder.parent.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryDirectory(dir=folder.parent) as place:
                _make(AcadosOcpSolver, problem(), Path(place))
                description = Path(place) / "problem.json"
                description.write_text(description.read_text(encoding="utf-8").replace(place, str(folder)), encoding="utf-8")
                with contextlib.suppress(OSError):
                    Path(place).rename(folder)
                Path(place).mkdir(exist_ok=True)
        ocp = problem()
        ocp.code_export_directory = str(folder / "code")
        _libraries(acados.LIB_DIR)
        return AcadosOcpSolver(ocp, json_file=str(folder / "problem.json"), build=False, generate=False)


def _tree(acados: Any) -> Path:
    """A folder that is laid out as the sources of acados are, where its generator looks for templates and libraries."""
    folder = cache() / f"acados-tree-{hashlib.sha256(acados.DIR.encode()).hexdigest()[:16]}"
    inner = folder / "interfaces" / "acados_template"
    inner.mkdir(parents=True, exist_ok=True)
    links = {inner / "acados_template": acados.TEMPLATE_DIR, folder / "include": acados.INCLUDE_DIR, folder / "lib": acados.LIB_DIR, folder / "bin": acados.BIN_DIR}
    for link, target in links.items():
        with contextlib.suppress(FileExistsError):
            link.symlink_to(target)
    return folder


def _make(solver: Any, ocp: Any, folder: Path) -> None:
    ocp.code_export_directory = str(folder / "code")
    solver.generate(ocp, json_file=str(folder / "problem.json"))
    solver.build(str(folder / "code"), with_cython=False)


def _libraries(folder: str) -> None:
    """The libraries of acados lie beside no loader's search path, so they are loaded before what needs them."""
    import ctypes

    for name in ("libblasfeo", "libhpipm", "libqpOASES_e", "libacados"):
        ending = ".dylib" if sys.platform == "darwin" else ".so"
        ctypes.CDLL(str(Path(folder) / f"{name}{ending}"), mode=ctypes.RTLD_GLOBAL)


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """The generator and the compiler print pages; what goes wrong is on the standard error."""
    kept = os.dup(1)
    nothing = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nothing, 1)
    os.close(nothing)
    try:
        yield
    finally:
        sys.stdout.flush()
        os.dup2(kept, 1)
        os.close(kept)
