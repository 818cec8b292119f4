"""`python3 -m falsify_av.stacks NAME [OPTIONS]` serves a driver, or a pedestrian, of others; `--missing NAME` says what is not installed.

The names are those of the entry points `falsify_av.drivers` of all installed packages.
"""

from __future__ import annotations

import sys

from ..answers import answers
from ..entries import DRIVERS, entries, function, look
from . import STACKS

USAGE = "usage: python3 -m falsify_av.stacks [--missing] NAME [OPTIONS]"


def main(words: list[str]) -> int:
    """Exit code 0 after the input has ended, 2 for a name that is not known, 3 if something is not installed."""
    only_look = words[:1] == ["--missing"]
    words = words[1:] if only_look else words
    known = entries(DRIVERS, {name: f"{__package__}.{stack.module}:main" for name, stack in STACKS.items()})
    if not words or words[0] not in known:
        named = f"{words[0]!r} is no driver of others; " if words else ""
        print(f"{named}{USAGE}\nnames: {', '.join(known)}", file=sys.stderr)
        return 2
    missing = STACKS[words[0]].missing() if words[0] in STACKS else None
    if missing is not None:
        print(missing, file=sys.stderr)
        return 3
    # Some libraries print when they are imported.
    answers()
    if only_look:
        look(known[words[0]])
    else:
        function(known[words[0]])(words[1:])
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
