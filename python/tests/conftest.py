"""A short scenario for all tests, and the program if it is built."""

import os
import subprocess
from pathlib import Path

import pytest

SCENARIO = Path(__file__).with_name("short.scn")


@pytest.fixture
def scenario() -> Path:
    return SCENARIO


@pytest.fixture
def program() -> str:
    """The path of the program `falsify`, which `FALSIFY_BIN` names."""
    path = os.environ.get("FALSIFY_BIN")
    if not path:
        pytest.skip("FALSIFY_BIN does not name the program")
    assert subprocess.run([path, "--version"], capture_output=True, check=True).stdout
    return path
