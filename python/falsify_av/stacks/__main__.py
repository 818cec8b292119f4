"""`python3 -m falsify_av.stacks NAME [OPTIONS]` serves a driver, or a pedestrian, of others; `--missing NAME` says what is not installed."""

from __future__ import annotations

import sys
from importlib import import_module

from ..answers import answers
from . import STACKS

USAGE = "usage: python3 -m falsify_av.stacks [--missing] NAME [OPTIONS]"


def main(words: list[str]) -> int:
    """Exit code 0 after the input has ended, 2 for a name that is not known, 3 if something is not installed."""
    only_look = words[:1] == ["--missing"]
    words = words[1:] if only_look else words
    if not words or words[0] not in STACKS:
        named = f"{words[0]!r} is no driver of others; " if words else ""
        print(f"{named}{USAGE}\nnames: {', '.join(STACKS)}", file=sys.stderr)
        return 2
    stack = STACKS[words[0]]
    missing = stack.missing()
    if missing is not None:
        print(missing, file=sys.stderr)
        return 3
    # Some libraries print when they are imported.
    answers()
    module = import_module(f".{stack.module}", __package__)
    if only_look:
        getattr(module, "look", lambda: None)()
    else:
        module.main(words[1:])
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
