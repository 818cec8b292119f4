"""Progress of long calls: a bar in a terminal or a notebook, or a function of your own. It needs no package."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

#: Is called with what is done and with what there is to do.
Progress = Callable[[int, int], None]

#: Cells of the bar, and the least time between two drawings (s).
_WIDTH, _EVERY = 30, 0.1


class Bar:
    """Draws a bar on the error stream, which notebooks show, too. Each drawing replaces the last one."""

    def __init__(self, unit: str) -> None:
        self.unit = unit
        self._begun = time.monotonic()
        self._drawn = 0.0

    def __call__(self, done: int, total: int) -> None:
        """Draw it, if it is over or has not been drawn for a tenth of a second."""
        now, over = time.monotonic(), done >= total
        if not over and now - self._drawn < _EVERY:
            return
        self._drawn = now
        share = done / total if total else 1.0
        filled = int(share * _WIDTH)
        left = "" if over or not done else f", {(now - self._begun) / done * (total - done):.0f} s left"
        end = "\n" if over else ""
        sys.stderr.write(f"\r{'█' * filled}{'░' * (_WIDTH - filled)} {done} of {total} {self.unit}{left}\x1b[K{end}")
        sys.stderr.flush()


def shown(progress: bool | Progress, unit: str) -> Progress:
    """The function to call: a bar for ``True``, nothing for ``False``, and a function as it is."""
    if callable(progress):
        return progress
    return Bar(unit) if progress else lambda done, total: None
