"""`python -m falsify_av` is the program `falsify`."""

import os
import subprocess
import sys

from .program import find

try:
    program = find()
except FileNotFoundError as error:
    sys.exit(f"error: {error}")
if os.name == "posix":
    os.execv(program, ["falsify", *sys.argv[1:]])
sys.exit(subprocess.call([program, *sys.argv[1:]]))
