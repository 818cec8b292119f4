"""Records Kaplan-Meier medians with 95 % intervals (log-log, as Brookmeyer and Crowley) from lifelines 0.30.3."""

import json
import math
import pathlib

import lifelines
from lifelines import KaplanMeierFitter
from lifelines.utils import median_survival_times

# Freireich et al., Blood 21, 1963: weeks of remission, 6-mercaptopurine and placebo; and two sets as of ten searches.
CASES = {
    "6-MP": ([6, 6, 6, 7, 10, 13, 16, 22, 23, 6, 9, 10, 11, 17, 19, 20, 25, 32, 32, 34, 35], [1] * 9 + [0] * 12),
    "placebo": ([1, 1, 2, 2, 3, 4, 4, 5, 5, 8, 8, 8, 8, 11, 11, 12, 12, 15, 17, 22, 23], [1] * 21),
    "most found": ([120, 340, 410, 560, 700, 910, 1300, 1800, 5000, 5000], [1] * 8 + [0] * 2),
    "few found": ([4100, 4700, 5000, 5000, 5000, 5000, 5000, 5000, 5000, 5000], [1] * 2 + [0] * 8),
}


def finite(value):
    value = float(value)
    return value if math.isfinite(value) else None


record = {"version": lifelines.__version__}
for name, (times, found) in CASES.items():
    fitter = KaplanMeierFitter().fit(times, found)
    interval = median_survival_times(fitter.confidence_interval_)
    ends = sorted((finite(end) for end in interval.iloc[0]), key=lambda end: math.inf if end is None else end)
    record[name] = {"times": times, "found": found, "median": finite(fitter.median_survival_time_), "interval": ends}
path = pathlib.Path(__file__).with_name("medians.json")
path.write_text(json.dumps(record) + "\n")
for name in CASES:
    print(name, record[name]["median"], record[name]["interval"])
