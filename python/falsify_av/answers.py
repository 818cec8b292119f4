"""The standard output of a program that answers messages: it is for answers alone, whatever a library prints there."""

from __future__ import annotations

import os
import sys
from functools import cache
from typing import BinaryIO


@cache
def answers() -> BinaryIO:
    """The stream for answers, which is the standard output at the first call. From then on what anything else prints there goes to the standard error."""
    sys.stdout.flush()
    kept = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    return kept
