"""The steps of `tests/installed/run`, by the Python of the environment, in an empty folder. What they read lies one folder above."""

import os
import re
import subprocess
import sys
from importlib.metadata import distribution
from pathlib import Path

HERE = Path.cwd()
TEXTS = HERE.parent


def falsify(*arguments: str, code: int = 0) -> str:
    """What the program prints; it must end with this exit code."""
    done = subprocess.run(["falsify", *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert done.returncode == code, (arguments, done.returncode, done.stdout[-2000:], done.stderr[-2000:])
    return done.stdout


def blocks(page: str, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", (TEXTS / page).read_text(), re.DOTALL | re.MULTILINE)


def own_folder(name: str) -> None:
    (HERE / name).mkdir()
    os.chdir(HERE / name)


def metadata() -> None:
    """Both wheels have one version, an author, a page, and the licences of what is in them; `python -m falsify_av` is the program."""
    import falsify_av

    for name in ("falsify-av", "falsify-av-program"):
        found = distribution(name)
        assert found.version == falsify_av.__version__, (name, found.version)
        assert found.metadata["Author"] and found.metadata.get_all("Project-URL"), found.metadata.as_string()
        texts = {path.name: path.locate() for path in found.files or () if "licenses" in path.parts}
        assert {"LICENSE-MIT", "LICENSE-APACHE", "LICENSE-DEPENDENCIES.txt", "LICENSE-RUST-LIBRARY.html"} <= set(texts), texts
        assert "serde 1." in Path(texts["LICENSE-DEPENDENCIES.txt"]).read_text()
    as_module = subprocess.run([sys.executable, "-m", "falsify_av", "--version"], check=True, stdout=subprocess.PIPE, text=True).stdout
    assert as_module == falsify("--version") == f"falsify {falsify_av.__version__}\n"


def demo() -> None:
    own_folder("demo")
    said = falsify("demo")
    assert "campaign demo" in said and Path("falsify-demo/demo/report.html").stat().st_size > 10_000, said


def scenario() -> None:
    """README's scenario, a little of it."""
    own_folder("scenario")
    Path("my.scn").write_text(blocks("README.md", "scn")[0])
    assert "campaign mine" in falsify("run", "--smoke", "my.scn")
    assert falsify("failures", "--names", "reports/mine-smoke")


def page() -> None:
    """All blocks of the page about Python, one after another."""
    own_folder("page")
    Path("my.scn").write_text(blocks("scenario.md", "scn")[0])
    names: dict[str, object] = {}
    found = blocks("python.md", "python")
    assert len(found) >= 5, found
    for number, block in enumerate(found):
        exec(compile(block, f"python.md, block {number}", "exec"), names)
    assert names["files"] and names["changes"] and names["worst"], names


def notebook() -> None:
    import nbclient
    import nbformat

    own_folder("notebook")
    read = nbformat.read(TEXTS / "first_failure.ipynb", as_version=4)
    nbclient.NotebookClient(read, timeout=300, kernel_name="python3").execute()
    cells = [cell for cell in read.cells if cell.cell_type == "code"]
    assert cells and all(cell.outputs for cell in cells if not cell.source.startswith("#")), [cell.source for cell in cells if not cell.outputs]


def gate() -> None:
    """A driver of one's own meets the jobs that the page about gates begins with; each ends as its condition says."""
    import yaml

    wheel = next(Path(os.environ["WHEELS"]).glob("falsify_av_program-*.whl"))
    github, gitlab = (yaml.safe_load(block) for block in blocks("gate.md", "yaml")[:2])
    (steps,) = (job["steps"] for job in github["jobs"].values())
    (job,) = gitlab.values()
    scripts = [[step["run"] for step in steps if "run" in step], job["script"]]
    assert scripts[0] == scripts[1], scripts
    own_folder("gate")
    falsify("new", "my.scn", "--template", "own-driver")
    text = Path("my.scn").read_text()
    # A tenth of the work, by the search that takes a new start for each episode: a gate on a share of starts wants ten of them.
    changes = {"budget: 60_000": "budget: 12_000", "runs: 2": "runs: 1", "methods: [meet, faults]": "methods: [meet]"}
    for before, after in changes.items():
        assert before in text, before
        text = text.replace(before, after)
    Path("my.scn").write_text(text)
    install, run = scripts[0]
    for limit, code in ((">= 0", 7), ("> 0.99", 0)):
        line = run.replace("> 0.1", limit)
        assert line != run, run
        done = subprocess.run(["/bin/sh", "-ec", f"{install} -q\n{line}"], env={**os.environ, "FALSIFY": str(wheel)}, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        assert done.returncode == code, (line, done.returncode, done.stdout[-3000:])
        for file in ("falsify.xml", "reports/own_driver/report.html"):
            assert Path(file).stat().st_size > 500, file
            Path(file).unlink()


{each.__name__: each for each in (metadata, demo, scenario, page, notebook, gate)}[sys.argv[1]]()
