"""Type checkers see wrong calls, and have no complaint about the package itself."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

CALLS = Path(__file__).with_name("typed.py")


def test_mypy_rejects_wrong_calls_and_no_others(tmp_path):
    pytest.importorskip("mypy", reason="mypy is not installed")
    command = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", tmp_path, "--no-error-summary", CALLS]
    said = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path).stdout
    found = {int(line) for line in re.findall(r"typed\.py:(\d+): error", said)}
    wanted = {number for number, line in enumerate(CALLS.read_text().splitlines(), 1) if line.endswith("# error")}
    assert found == wanted, said


def test_mypy_has_no_complaint_about_the_package(tmp_path):
    pytest.importorskip("mypy", reason="mypy is not installed")
    command = [sys.executable, "-m", "mypy", "--cache-dir", tmp_path, "--config-file", "pyproject.toml"]
    checked = subprocess.run(command, capture_output=True, text=True, cwd=Path(__file__).parents[1])
    assert checked.returncode == 0, checked.stdout + checked.stderr
