"""Builds the units of this folder: `python3 build.py aeb FILE.fmu`. It needs gcc, and FMPy for the headers of FMI."""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

import fmpy
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave

HERE = Path(__file__).parent


def build(name: str, unit: Path) -> Path:
    """Write a unit; what FMI demands and the source lacks answers with an error."""
    source, description = (HERE / f"{name}.c").read_text(encoding="utf-8"), (HERE / f"{name}.xml").read_text(encoding="utf-8")
    form, prefix, system = (FMU2Slave, "fmi2", fmpy.platform) if 'fmiVersion="2' in description else (FMU3Slave, "fmi3", fmpy.platform_tuple)
    lacks = [each for each in dir(form) if each.startswith(prefix) and not re.search(rf"\b{each}\(", source)]
    with tempfile.TemporaryDirectory() as folder:
        stubs, library = Path(folder) / "stubs.c", Path(folder) / f"{name}{fmpy.sharedLibraryExtension}"
        stubs.write_text("\n".join(f"int {each}(void) {{ return 3; }}" for each in lacks), encoding="utf-8")
        headers = Path(fmpy.__file__).parent / "c-code"
        subprocess.run(["gcc", "-O1", "-shared", "-fPIC", f"-I{headers}", "-o", library, HERE / f"{name}.c", stubs, "-lm"], check=True)
        with zipfile.ZipFile(unit, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr("modelDescription.xml", description)
            archive.write(library, f"binaries/{system}/{library.name}")
            archive.writestr(f"sources/{name}.c", source)
    return unit


if __name__ == "__main__":
    if len(sys.argv) != 3:
        raise SystemExit(__doc__)
    print(build(sys.argv[1], Path(sys.argv[2])), "is written")
