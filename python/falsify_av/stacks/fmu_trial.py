"""What an FMU does in front of people and vehicles, in words, and a scenario with its variables to fill in."""

from __future__ import annotations

import math
import os
import signal
from collections.abc import Callable, Iterator
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np

from ..answers import answers
from .batch import PEDESTRIAN, VEHICLE, Frame
from .fmu import Fmu
from .fmu_file import File
from .fmu_links import USERS, items, spelled, unit_of, wanted

TICK, PATIENCE, POINTS = 0.05, 10.0, 40  # s, s
CAR = {"length": 4.79, "width": 2.16, "wheelbase": 3.0, "greatest_wheel_angle": 0.86}
STRONGEST, PULL = 9.0, 3.0  # m/s^2: of the car
LIMIT, SPEEDS, GAPS = 14.0, (3.0, 8.0, 14.0), (60.0, 30.0, 15.0, 8.0, 4.0, 2.0, 1.0)  # m/s, m/s, m
KINDS = {"person": (PEDESTRIAN, 0.5, 0.5), "vehicle": (VEHICLE, 4.5, 1.8)}


class Road:
    """A straight road with at most one road user, which stands: its kind, and the place of its near side (m)."""

    def __init__(self, fmu: Fmu) -> None:
        self.fmu = fmu
        #: The least and the greatest value of each output.
        self.seen: dict[str, tuple[float, float]] = {}

    def tick(self, front: float, speed: float, limit: float, starts: bool, user: tuple[str, float] | None) -> float:
        """The acceleration (m/s^2) of a car whose front is at a place (m)."""
        numbers = np.zeros((1, 14 + 8 + 3 * POINTS))
        middle = front - CAR["length"] / 2
        numbers[0, 2], numbers[0, 3], numbers[0, 6:8], numbers[0, 13] = 1.0 if starts else -1.0, middle, (speed, limit), POINTS
        numbers[0, 22::3] = middle + 2.0 * np.arange(POINTS)
        if user is not None:
            kind, length, width = KINDS[user[0]]
            numbers[0, 12], numbers[0, 14:22] = 1.0, (kind, user[1] + length / 2, 0.0, 0.0, 0.0, 0.0, length, width)
        *pushes, steer = (float(each[0]) for each in self.fmu.decide(Frame(numbers, 1, POINTS)))
        if not math.isfinite(steer):
            raise RuntimeError(self.fmu.failure)
        for name, value in self.fmu.last.items():
            least, most = self.seen.get(name, (value, value))
            self.seen[name] = min(least, value), max(most, value)
        push = pushes[0] if len(pushes) == 1 else PULL * pushes[0] - STRONGEST * pushes[1]
        return min(max(push, -STRONGEST), PULL)

    def holds(self, speed: float, user: tuple[str, float] | None) -> float:
        """Its acceleration after a second in which neither speed nor gap changes."""
        return [self.tick(0.0, speed, LIMIT, tick == 0, user) for tick in range(20)][-1]

    def drives(self, speed: float, limit: float, user: tuple[str, float] | None, seconds: float) -> tuple[float, float]:
        """Place and speed after a time, or where it touches."""
        front = 0.0
        for tick in range(round(seconds / TICK)):
            speed = max(speed + TICK * self.tick(front, speed, limit, tick == 0, user), 0.0)
            front += TICK * speed
            if user is not None and front >= user[1]:
                break
        return front, speed


def findings(fmu: Fmu) -> Iterator[tuple[str, str]]:
    """What it does, in words: `ok`, `note`, `FAIL` or a line of a table; `now` says what comes next."""
    road, ignored = Road(fmu), 0
    yield "now", "on an empty road"
    _, speed = road.drives(0.0, LIMIT, None, 30.0)
    slow = ": it stands, or nearly; see units, factors and what switches the FMU on" if speed < 2.0 else ""
    yield "FAIL" if slow else "ok", f"drives {speed:.1f} m/s after 30 s on an empty road{slow}"
    free = [road.holds(each, None) for each in SPEEDS]
    for kind in KINDS:
        yield "", f"{f'm/s² while a {kind} stands ahead by':>36}" + "".join(f"{gap:5.0f} m" for gap in GAPS) + "  nobody"
        blind: list[str] = []
        same: list[str] = []
        for each, alone in zip(SPEEDS, free):
            yield "now", f"at {each:g} m/s while a {kind} stands ahead"
            pushes = [road.holds(each, (kind, gap)) for gap in GAPS]
            yield "", f"{f'at {each:g} m/s':>36}" + "".join(f"{push:+7.1f}" for push in [*pushes, alone])
            if max(pushes) - min(pushes) < 1e-6:
                (blind if abs(pushes[0] - alone) < 1e-6 else same).append(f"{each:g}")
        if blind:
            yield "note", f"reacts to no {kind} at {', '.join(blind)} m/s"
        if same:
            yield "FAIL", f"answers the same at all distances of a {kind} at {', '.join(same)} m/s"
        ignored += len(blind) == len(SPEEDS)
    if ignored == len(KINDS):
        yield "FAIL", "reacts to nothing at these speeds: see units, factors and what switches the FMU on"
    for each in SPEEDS:
        yield "now", f"while a person stands in its way at {each:g} m/s"
        front, speed = road.drives(each, each, ("person", 80.0), 60.0)
        what = f"touches at {speed:.1f} m/s" if front >= 80.0 else f"stops {80.0 - front:.1f} m before" if speed < 0.1 else "drives for a minute without reaching"
        yield "note", f"from {each:g} m/s it {what} a person who stands in its way 80 m ahead"
    for name, (least, most) in road.seen.items():
        if least == most:
            yield "FAIL", f"its output `{name}` is {least:g} in all manoeuvres"


def tried(make: Callable[[dict[str, Any]], Fmu]) -> int:
    """Say what an FMU does, which runs in a process of its own; returns 5 if that cannot be tested."""
    out, code = answers(), 0
    for mark, what in _heard(make):
        out.write(f"  {mark:5} {what}\n".encode())
        out.flush()
        code = 5 if mark == "FAIL" else code
    return code


def _heard(make: Callable[[dict[str, Any]], Fmu]) -> Iterator[tuple[str, str]]:
    """The findings of another process, and how that ended if it did not end well."""
    context = get_context("fork")
    ours, theirs = context.Pipe()
    process = context.Process(target=_run, args=(theirs, make), daemon=True)
    process.start()
    theirs.close()
    now = "at its start"
    while ours.poll(PATIENCE):
        try:
            mark, what = ours.recv()
        except EOFError:
            process.join()
            code = process.exitcode or 0
            yield "FAIL", f"ends its process {now}, with {signal.Signals(-code).name if code < 0 else f'exit code {code}'}"
            return
        if mark == "end":
            return
        if mark == "now":
            now = what
        else:
            yield mark, what
    process.kill()
    yield "FAIL", f"gives no answer for {PATIENCE:g} s {now}"


def _run(pipe: Connection, make: Callable[[dict[str, Any]], Fmu]) -> None:
    try:
        for finding in findings(make({"vehicle": CAR, "tick_s": TICK, "worlds": 1})):
            pipe.send(finding)
    except (Exception, SystemExit) as error:
        pipe.send(("FAIL", str(error)))
    pipe.send(("end", ""))


SCENARIO = """\
// A functional mock-up unit as a driver. docs/src/how-to/stacks/fmu.md says what the quantities are. Fill in each `?` of the command, then:
//
//     {command} --try
//     falsify run --allow-external {scenario}
//
// {variables}
edition 1
import "std/pedestrians.scn"
import "std/rewards.scn"
import "std/drivers.scn"
import "std/towns.scn"

driver mine = external(command: "{command}", files: ["{fmu}"], route_points: 40)

spawn near {{ bearing: -60 deg .. 60 deg  distance: 7 m .. 40 m }}
episode short {{ ticks: 240  hold: 10  end_when: ahead < -6 m }}
method meet = intercept()
method faults = archive(reward: fault)

campaign fmu {{
  vehicle: model3  body: plausible  spawn: near  episode: short
  search {{ towns: [harbour]  drivers: [mine, blind]  methods: [meet, faults]  budget: 20_000  runs: 1 }}
}}
"""


def write(file: File, scenario: Path) -> None:
    """Write a scenario with the variables of an FMU to fill in. One that exists is not replaced."""
    model = file.model
    asked = [each for each in model.modelVariables if each.causality in ("input", "output") and not each.shape and each.alias is None]
    lines = [f"{_described(each)}: {wanted(each, model)}" for each in asked]
    lines.append(f"USER is {', '.join(USERS[:-1])} or {USERS[-1]}. `parameters: [\"NAME=NUMBER\"]` of the driver sets")
    lines += [f"{spelled(each.name)}={each.start}, {_described(each)}" for each in model.modelVariables if each.causality == "parameter"]
    fmu = os.path.relpath(file.path, scenario.parent)
    words = [f"'{each}'" if any(map(str.isspace, each)) else each for each in [fmu, *(f"{each.name}=?" for each in asked)]]
    command = " ".join(["python3 -m falsify_av.stacks fmu", *words])
    text = SCENARIO.format(variables="\n// ".join(" ".join(line.split()) for line in lines), command=command, fmu=fmu, scenario=scenario)
    try:
        with scenario.open("x", encoding="utf-8") as place:
            place.write(text)
    except FileExistsError:
        raise SystemExit(f"{scenario} exists and is not replaced: give another name") from None
    except OSError as error:
        raise SystemExit(f"{scenario} cannot be written: {error.strerror}") from None
    answers().write(f"{scenario} is written: fill in its command\n".encode())
    answers().flush()


def _described(variable: Any) -> str:
    unit, names = unit_of(variable), ", ".join(items(variable))
    parts = (variable.name + (f" [{unit}]" if unit is not None else ""), variable.description, names and f"one of {names}")
    return ", ".join(each for each in parts if each)
