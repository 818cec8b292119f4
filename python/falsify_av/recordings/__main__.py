"""`python3 -m falsify_av.recordings FORMAT FILE OUT.osi` writes a recording of others as a trace for `falsify judge`."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path

from . import Unreadable, write

FORMATS = {"ind": "ind", "round": "ind", "rosbag": "rosbag", "py123d": "driven", "sumo": "sumo"}
USAGE = f"usage: python3 -m falsify_av.recordings FORMAT FILE OUT.osi\nformats: {', '.join(FORMATS)}"


def main(words: list[str]) -> int:
    """Exit code 0 after the trace was written, 2 for a wrong call or a file that cannot be read, 6 if the trace cannot be written."""
    if len(words) != 3 or words[0] not in FORMATS or not words[2].endswith(".osi"):
        print(USAGE, file=sys.stderr)
        return 2
    path, out = Path(words[1]), Path(words[2])
    try:
        if not path.exists():
            raise Unreadable("there is no such file")
        instants = import_module(f"{__package__}.{FORMATS[words[0]]}").read(path)
    except (Unreadable, OSError, UnicodeDecodeError) as error:
        print(f"error: cannot read `{path}`: {error}", file=sys.stderr)
        return 2
    try:
        count = write(out, instants)
    except Unreadable as error:
        print(f"error: cannot read `{path}`: {error}", file=sys.stderr)
        return 2
    except OSError as error:
        print(f"error: cannot write `{out}`: {error}", file=sys.stderr)
        return 6
    print(f"{out}: {count} instants; falsify judge {out}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
