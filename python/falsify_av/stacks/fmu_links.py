"""The variables of an FMU beside quantities of the world: `v_ego=ego.speed[km/h]`, `mode=2`, `object=front.kind[None,Person,Car]`."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from ..suggestion import suggested
from .fmu_file import Model, Variable

FAR, LATER = 200.0, 100.0  # m, s: the gap to nobody, the greatest time to collision

#: What an FMU can be told of the car and the road, with its unit.
WORLD = {"ego.speed": "m/s", "ego.acceleration": "m/s2", "ego.yaw_rate": "rad/s", "road.limit": "m/s", "road.speed": "m/s"}
#: Which road users it can be told of, and what of each, with the value for nobody: for `speed` it is that of the car.
USERS = ("front", "course", "person", "vehicle")
USER = {
    "gap": ("m", FAR), "left": ("m", 0.0), "speed": ("m/s", math.nan), "lateral": ("m/s", 0.0), "closing": ("m/s", 0.0), "ttc": ("s", LATER),
    "present": ("choice", 0.0), "kind": ("choice", 0.0),
}
COLUMNS = list(USER)
#: What it can answer.
CAR = {
    "car.acceleration": "m/s2", "car.deceleration": "m/s2", "car.speed": "m/s", "car.throttle": "1", "car.brake": "1", "car.stop": "choice", "car.steer": "1",
    "car.wheel": "rad",
}
TOLD = {**WORLD, **{f"{user}.{name}": unit for user in USERS for name, (unit, _) in USER.items()}}
#: What the values of a choice are, from 0 on.
CHOICES = {"present": ("nobody", "somebody"), "kind": ("nobody", "a pedestrian", "a vehicle")}

_NAMES = {
    "m": {"m": 1.0, "km": 1e3, "cm": 1e-2, "mm": 1e-3, "ft": 0.3048},
    "m/s": {"m/s": 1.0, "m.s-1": 1.0, "km/h": 1 / 3.6, "kph": 1 / 3.6, "kmh": 1 / 3.6, "mph": 0.44704, "cm/s": 1e-2},
    "m/s2": {"m/s2": 1.0, "m/s^2": 1.0, "m/s²": 1.0, "m.s-2": 1.0, "g": 9.80665},
    "s": {"s": 1.0, "ms": 1e-3},
    "rad": {"rad": 1.0, "deg": math.pi / 180, "°": math.pi / 180},
    "rad/s": {"rad/s": 1.0, "deg/s": math.pi / 180, "°/s": math.pi / 180},
    "1": {"1": 1.0, "-": 1.0, "": 1.0, "%": 1e-2},
}
UNITS = {name: (kind, factor) for kind, names in _NAMES.items() for name, factor in names.items()}
#: Exponents of m, s and rad.
_BASES = {(1, 0, 0): "m", (1, -1, 0): "m/s", (1, -2, 0): "m/s2", (0, 1, 0): "s", (0, 0, 1): "rad", (0, -1, 1): "rad/s", (0, 0, 0): "1"}
_QUANTITY = re.compile(r"([a-z]+)([1-9]?)(\.[a-z_]+)(?:\[([^\]]*)\])?(?:\*([^,]+))?(?:,(.+))?")


@dataclass
class Link:
    """A variable of the FMU, and the quantity that it stands for."""

    variable: Variable
    quantity: str
    #: Which of the road users, counted from 0.
    place: int = 0
    #: What the world's number is multiplied with to be the FMU's, or the FMU's answer to be the world's.
    factor: float = 1.0
    #: The FMU's own number for nobody.
    nobody: float | None = None
    #: The FMU's own numbers for the values of a choice; for `car.stop` those that brake.
    choices: list[float] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.head, _, tail = self.quantity.partition(".")
        self.column = COLUMNS.index(tail) if self.head in USERS else -1

    def told(self, own: Mapping[str, float], near: Mapping[str, list[list[float]]]) -> float:
        """The FMU's number in a world: of its own quantities, and the road users that are near, as numbers of `USER`."""
        if self.head not in near:
            return own[self.quantity] * self.factor
        users = near[self.head]
        if len(users) > self.place:
            value = users[self.place][self.column]
        elif self.nobody is not None:
            return self.nobody
        else:
            value = USER[COLUMNS[self.column]][1]
            value = own["ego.speed"] if math.isnan(value) else value
        return self.choices[int(value)] if self.choices else value * self.factor

    def answered(self, value: float) -> float:
        """The world's number for an answer of the FMU."""
        return float(value in self.choices) if self.choices else value * self.factor


@dataclass
class Links:
    """What an FMU is told, what it answers, and what stays the same."""

    inputs: list[Link]
    outputs: list[Link]
    constants: dict[str, Any]

    @property
    def is_pedals(self) -> bool:
        """Whether it answers with pedals."""
        return any(each.quantity in ("car.throttle", "car.brake") for each in self.outputs)

    @property
    def is_angle(self) -> bool:
        """Whether it answers with the angle of the front wheels."""
        return any(each.quantity == "car.wheel" for each in self.outputs)


def linked(words: Iterable[str], model: Model) -> Links:
    """Read `NAME=QUANTITY` and `NAME=VALUE`.

    Raises:
        SystemExit: One cannot be read, or an input has none.
    """
    known = {each.name: each for each in model.modelVariables}
    links = Links([], [], {})
    for word in words:
        name, is_pair, value = word.partition("=")
        if not is_pair:
            raise SystemExit(f"`{word}` is no pair: write NAME=QUANTITY or NAME=VALUE, as v_ego=ego.speed")
        if name not in known:
            named = [each.name for each in known.values() if each.causality in ("input", "output", "parameter")]
            raise SystemExit(f"the FMU has no variable `{name}`: {suggested(name, named)}")
        variable, found = known[name], _QUANTITY.fullmatch(value)
        if variable.shape or variable.type in ("Binary", "Clock"):
            raise SystemExit(f"`{name}` is {'an array' if variable.shape else variable.type}: only single numbers, choices and texts can be given")
        if value == "?":
            raise SystemExit(f"`{word}` is to be filled in: {wanted(variable, model)}")
        if variable.causality not in ("input", "parameter"):
            links.outputs.append(_link(word, variable, found, CAR, model))
        elif variable.causality == "input" and variable.type != "String" and found is not None:
            links.inputs.append(_link(word, variable, found, TOLD, model))
        else:
            links.constants[name] = value if variable.type == "String" else _number(variable, value)
    given = {*links.constants, *(each.variable.name for each in links.inputs)}
    for each in known.values():
        if each.causality == "input" and each.name not in given and each.alias is None:
            raise SystemExit(f"the input `{each.name}` has no value: {wanted(each, model)}")
    _check_outputs(links, model)
    return links


def parameters(given: Mapping[str, float], model: Model) -> dict[str, Any]:
    """The numbers of a scenario by the names of the FMU's variables."""
    known = {spelled(each.name): each for each in model.modelVariables if each.causality in ("parameter", "input")}
    for name in given:
        if name not in known:
            raise SystemExit(f"the FMU has no parameter `{name}`: {suggested(name, known)}")
    return {known[name].name: value for name, value in given.items()}


def spelled(name: str) -> str:
    """The name of a parameter in a scenario, which has only letters, digits and `_`."""
    return re.sub(r"\W", "_", name)


def wanted(variable: Variable, model: Model) -> str:
    """What to give for a variable. `USER` stands for any of :data:`USERS`."""
    name, unit = variable.name, unit_of(variable)
    kind = None if unit is None else (_measure(unit, model) or ("none", 0.0))[0]
    kinds = {kind} if kind is not None else {"choice"} if variable.type in ("Boolean", "Enumeration") else {*_NAMES, "choice"}
    if variable.causality != "input":
        fit = " ".join(each for each, unit in CAR.items() if unit in kinds)
        return f"write {name}={fit or 'QUANTITY, of which none has its unit'}, or leave it out"
    users = {f"USER.{each}": unit for each, (unit, _) in USER.items()}
    fit = " ".join(each for each, unit in {**WORLD, **users}.items() if unit in kinds)
    start = f"; it starts with {variable.start}" if variable.start is not None else ""
    return f"write {name}={fit or 'QUANTITY, of which none has its unit'}, or a value, {', '.join(items(variable)) or 'a number'}{start}"


def unit_of(variable: Variable) -> str | None:
    """The unit that a description states."""
    declared = variable.declaredType
    unit = variable.unit or (declared.unit if declared is not None else None)
    return None if unit is None else str(unit)


def items(variable: Variable) -> dict[str, float]:
    """The names of the values of a choice with their numbers."""
    declared = variable.declaredType
    named = {each.name: float(each.value) for each in declared.items} if declared is not None else {}
    return {"false": 0.0, "true": 1.0} if variable.type == "Boolean" else named


def _check_outputs(links: Links, model: Model) -> None:
    """Refuse answers that exclude each other, and none."""
    answered = [each.quantity for each in links.outputs]
    if not answered:
        names = [each.name for each in model.modelVariables if each.causality == "output"]
        raise SystemExit(f"no output of the FMU drives the car: write NAME=QUANTITY, NAME being one of {', '.join(names)}, and QUANTITY one of {', '.join(CAR)}")
    forces = [name for name in answered if name in ("car.acceleration", "car.deceleration", "car.speed")]
    if len(set(answered)) < len(answered) or (links.is_pedals and forces) or (links.is_angle and "car.steer" in answered):
        raise SystemExit(f"the outputs stand for {', '.join(answered)}: give each once, pedals or accelerations, and one of car.steer and car.wheel")


def _link(word: str, variable: Variable, found: re.Match[str] | None, known: Mapping[str, str], model: Model) -> Link:
    head, place, tail, bracket, factor, nobody = found.groups() if found is not None else ("", "", word.partition("=")[2], None, None, None)
    quantity = head + tail
    if quantity not in known or (place and head not in USERS):
        raise SystemExit(f"`{word}` names no quantity that fits: {suggested(quantity, known)}")
    link = Link(variable, quantity, int(place or 1) - 1, nobody=None if nobody is None else _number(variable, nobody))
    if factor is not None:
        link.factor = _number(variable, factor) if _is_number(factor) else 0.0
        if link.factor == 0.0:
            raise SystemExit(f"`{word}`: `{factor}` is no factor; give a number other than 0")
    unit = known[quantity]
    if unit == "choice" and (bracket is not None or variable.type == "Enumeration" or tail == ".kind"):
        link.choices = _choices(link, bracket)
    elif unit != "choice":
        size = _size(variable, bracket, unit, quantity, model)
        link.factor *= size if quantity in CAR else 1.0 / size
    return link


def _size(variable: Variable, said: str | None, kind: str, quantity: str, model: Model) -> float:
    """The unit that a variable is in, in the world's."""
    stated, name, known = unit_of(variable), variable.name, " ".join(_NAMES[kind])
    if said is None and stated is None and kind != "1":
        raise SystemExit(f"the description states no unit of `{name}`: say which it is in, as {name}={quantity}[{kind}]; known are {known}")
    unit = said if said is not None else stated if stated is not None else "1"
    measure = _measure(unit, model)
    if measure is None or measure[0] != kind:
        raise SystemExit(f"`{name}` is in {unit}, and {quantity} in {kind}: take another quantity, or a unit of {known}")
    if said is not None and stated is not None and _measure(stated, model) != measure:
        raise SystemExit(f"the description says that `{name}` is in {stated}, not in {said}: leave [{said}] out, or correct the number by {quantity}*FACTOR")
    return measure[1]


def _measure(unit: str, model: Model) -> tuple[str, float] | None:
    """The kind of a unit and its size. A definition of the model counts before its name."""
    base = next((each.baseUnit for each in model.unitDefinitions if each.name == unit), None)
    if base is None:
        return UNITS.get(unit)
    others = (base.kg, base.A, base.K, base.mol, base.cd, base.offset)
    kind = _BASES.get((int(base.m), int(base.s), int(base.rad)))
    return None if kind is None or any(map(float, others)) else (kind, float(base.factor))


def _choices(link: Link, bracket: str | None) -> list[float]:
    """The FMU's numbers for the values of a choice."""
    variable, name = link.variable, link.variable.name
    given = [_number(variable, each.strip()) for each in bracket.split(",")] if bracket else []
    some = [*items(variable), "0", "1", "2"]
    if link.quantity == "car.stop":
        if not given:
            raise SystemExit(f"say which values of `{name}` brake, as {name}=car.stop[{some[1]}]")
        return given
    values = CHOICES[COLUMNS[link.column]]
    if len(given) != len(values):
        shown = ",".join(some[: len(values)])
        raise SystemExit(f"say which values of `{name}` stand for {', '.join(values)}, in this order, as {name}={link.quantity}[{shown}]")
    return given


def _is_number(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


def _number(variable: Variable, text: str) -> float:
    """A value of a variable, written as a number or as a name."""
    if text in items(variable):
        return items(variable)[text]
    if not _is_number(text):
        raise SystemExit(f"`{text}` is no value of `{variable.name}`: {suggested(text, items(variable)) if items(variable) else 'give a number'}, or a quantity")
    return float(text)
