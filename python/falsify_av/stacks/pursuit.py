"""What the planners in the JSON form share: the speed that the road ahead allows, steering to a point, and what they do where the route ends."""

from __future__ import annotations

import math
from typing import Any

APART = 2.0  # m: between two points of the route
END = -3.0  # m/s^2: brakes softly to standstill where the route ends
COMFORT, LATERAL = 2.0, 2.0  # m/s^2: before a lower limit, in bends


def limit(world: dict[str, Any], route: Any) -> float:
    """The greatest speed from which comfortable braking keeps every limit and takes every bend ahead (m/s). It needs revision 2."""
    turns = [math.remainder(after - before, math.tau) for before, after in zip(route[:-1, 2], route[1:, 2])]
    bends = [math.sqrt(LATERAL * APART / max(abs(turn), 1e-3)) for turn in turns] + [math.inf]
    allowed = (min(lane["speed_limit"], bend) for lane, bend in zip(world["lanes"], bends))
    return min(math.sqrt(speed**2 + 2 * COMFORT * APART * place) for place, speed in enumerate(allowed))


def pursue(x: float, y: float, yaw: float, vehicle: dict[str, float]) -> float:
    """Steering of pure pursuit to a point that is `x`, `y` (m) from the car in the world's frame; -1 to 1, positive to the left."""
    angle = math.remainder(math.atan2(y, x) - yaw, math.tau)
    wheel = math.atan2(2.0 * vehicle["wheelbase"] * math.sin(angle), math.hypot(x, y))
    return max(-1.0, min(1.0, wheel / vehicle["greatest_wheel_angle"]))
