"""Random formulas of signal temporal logic on random traces, and their robustness in rtamt: `python record_robustness.py 40 5 > robustness.json`.

The first number is that of formulas, the second that of traces for each. Needs `pip install rtamt==0.4.10`. A formula is a nested list: ["part", i, c] is
`x_i - c >= 0`, ["always", from, to, a], ["until", from, to, a, b], ["not", a], ["and", a, b]; `to` is null without a bound. A pair is a formula,
the samples of three signals, and the robustness at every sample.

`tests/episode/robustness.rs` reads `robustness.json`, or the file that FALSIFY_RTAMT names.
"""

import json
import random
import sys

import rtamt


def formula(stream, depth):
    if depth == 0 or stream.random() < 0.15:
        return ["part", stream.randrange(3), stream.choice([-1.0, 0.0, 0.5, 1.25])]
    word = stream.choice(["not", "and", "or", "always", "always", "eventually", "eventually", "until", "until"])
    inner = [formula(stream, depth - 1) for _ in range(2 if word in ("and", "or", "until") else 1)]
    if word in ("not", "and", "or"):
        return [word, *inner]
    begin = stream.choice([0, 0, 1, 2, 5])
    bound = [0, None] if stream.random() < 0.3 else [begin, begin + stream.choice([0, 1, 2, 4, 9, 30])]
    return [word, *bound, *inner]


def written(tree):
    word, *rest = tree
    if word == "part":
        index, constant = rest
        return f"(x{index} >= ({constant}))"
    if word == "not":
        return f"(not {written(rest[0])})"
    if word in ("and", "or"):
        return f"({written(rest[0])} {word} {written(rest[1])})"
    begin, end, *inner = rest
    bound = "" if end is None else f"[{begin},{end}]"
    if word == "until":
        return f"({written(inner[0])} until{bound} {written(inner[1])})"
    return f"({word}{bound} {written(inner[0])})"


def main(formulas, traces):
    stream = random.Random(7)
    pairs = []
    for _ in range(formulas):
        tree = formula(stream, stream.randrange(1, 5))
        for _ in range(traces):
            # A specification remembers values of its formula, so each trace has one of its own.
            specification = rtamt.StlDiscreteTimeSpecification()
            for index in range(3):
                specification.declare_var(f"x{index}", "float")
            specification.spec = written(tree)
            specification.parse()
            # rtamt fails on a single sample.
            samples = stream.randrange(2, 25)
            # Many values are equal, so that ties occur.
            values = lambda: [stream.choice([stream.randrange(-3, 4), round(stream.uniform(-3, 3), 3)]) for _ in range(samples)]
            signals = [values() for _ in range(3)]
            data = {"time": list(range(samples)), **{f"x{i}": list(map(float, signal)) for i, signal in enumerate(signals)}}
            try:
                robustness = [value for _, value in specification.evaluate(data)]
            except IndexError:
                robustness = None
            shown = robustness and [value if abs(value) < 1e300 else ("inf" if value > 0 else "-inf") for value in robustness]
            pairs.append([tree, signals, shown])
    json.dump({"rtamt": "0.4.10", "pairs": pairs}, sys.stdout, separators=(",", ":"))


main(int(sys.argv[1]), int(sys.argv[2]))
