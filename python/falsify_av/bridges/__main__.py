"""`python3 -m falsify_av.bridges NAME [OPTIONS]` serves another simulator as a world; `--missing NAME` says what is not installed."""

from __future__ import annotations

import sys
from importlib import import_module

from ..answers import answers
from . import BRIDGES, serve

USAGE = "usage: python3 -m falsify_av.bridges [--missing] NAME [OPTIONS]"


def main(words: list[str]) -> int:
    """Exit code 0 after the input has ended, 2 for a name that is not known, 3 if something is not installed."""
    only_look = words[:1] == ["--missing"]
    words = words[1:] if only_look else words
    if not words or words[0] not in BRIDGES:
        named = f"{words[0]!r} is not a bridge; " if words else ""
        print(f"{named}{USAGE}\nnames: {', '.join(BRIDGES)}", file=sys.stderr)
        return 2
    missing = BRIDGES[words[0]].missing()
    if missing is not None:
        print(missing, file=sys.stderr)
        return 3
    if not only_look:
        # Some libraries print when they are imported.
        answers()
        serve(import_module(f".{words[0]}", __package__).world(words[1:]))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
