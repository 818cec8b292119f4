"""`python3 -m falsify_av.bridges NAME [OPTIONS]` serves another simulator as a world; `--missing NAME` says what is not installed.

The names are those of the entry points `falsify_av.worlds` of all installed packages.
"""

from __future__ import annotations

import sys

from ..answers import answers
from ..entries import WORLDS, entries, function, look
from . import BRIDGES, serve

USAGE = "usage: python3 -m falsify_av.bridges [--missing] NAME [OPTIONS]"


def main(words: list[str]) -> int:
    """Exit code 0 after the input has ended, 2 for a name that is not known, 3 if something is not installed."""
    only_look = words[:1] == ["--missing"]
    words = words[1:] if only_look else words
    known = entries(WORLDS, {name: f"{__package__}.{bridge.module}:world" for name, bridge in BRIDGES.items()})
    if not words or words[0] not in known:
        named = f"{words[0]!r} is not a bridge; " if words else ""
        print(f"{named}{USAGE}\nnames: {', '.join(known)}", file=sys.stderr)
        return 2
    missing = BRIDGES[words[0]].missing() if words[0] in BRIDGES else None
    if missing is not None:
        print(missing, file=sys.stderr)
        return 3
    # Some libraries print when they are imported.
    answers()
    if not only_look:
        serve(function(known[words[0]])(words[1:]))
    elif words[0] not in BRIDGES:
        look(known[words[0]])
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
