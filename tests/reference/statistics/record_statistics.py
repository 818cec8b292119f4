"""Records intervals, tests and corrections from numpy, scipy and statsmodels into statistics.json.

Run it with a Python that has these (`pip install scipy statsmodels`). Each name holds a list of cases, each a list of numbers:

wilson              hits, trials, alpha, low, high
student_tails       t, degrees of freedom, two-sided p
student_quantile    degrees of freedom, two-sided 95 % quantile
quantile            share, quantile, then the numbers
mcnemar             pairs in which only the first is true, only the second, exact p
p, holm             raw p-values and their corrections, the same tests in the same places
welch               size of the first group, p, low, high, then the numbers of both groups
"""

import json
import pathlib

import numpy
import scipy
import statsmodels
from scipy import stats
from statsmodels.stats.contingency_tables import mcnemar
from statsmodels.stats.multitest import multipletests
from statsmodels.stats.proportion import proportion_confint

rng = numpy.random.default_rng(20230924)
record = {"versions": {module.__name__: module.__version__ for module in (numpy, scipy, statsmodels)}}

record["wilson"] = [
    [hits, trials, alpha, *map(float, proportion_confint(hits, trials, alpha, "wilson"))]
    for hits, trials in [(90, 100), (900, 1000), (0, 1000), (1000, 1000), (1, 7), (550_000, 1_000_000)]
    for alpha in (0.05, 0.05 / 3, 0.05 / 11)
]
record["student_tails"] = [
    [t, degrees, float(2 * stats.t.sf(t, degrees))]
    for t in (0.1, 1.0, 2.0, 4.3, 12.0, 200.0)
    for degrees in (1, 2, 3.7, 9, 31, 1000)
    if 2 * stats.t.sf(t, degrees) > 1e-250
]
record["student_quantile"] = [[df, float(stats.t.ppf(0.975, df))] for df in (1, 1.5, 2, 2.7, 4, 9, 31, 100, 1e6)]
record["quantile"] = []
for size in (1, 2, 3, 4, 5, 8, 11, 40):
    numbers = rng.normal(5, 2, size).tolist()
    record["quantile"] += [[share, float(numpy.quantile(numbers, share)), *numbers] for share in (0.01, 0.5, 0.9, 0.99)]
record["mcnemar"] = [
    [a, b, float(mcnemar([[0, a], [b, 0]], exact=True).pvalue)]
    for a, b in [(0, 0), (0, 1), (1, 9), (7, 7), (12, 30), (150, 200), (5, 400), (49_500, 50_500)]
]
record["p"] = [
    [0.01, 0.04, 0.03, 0.005],
    [0.5],
    [0.2, 0.2, 0.9, 0.001, 0.001, 0.0004, 1.0],
    rng.uniform(0, 0.2, 30).tolist(),
]
record["holm"] = [multipletests(p, method="holm")[1].tolist() for p in record["p"]]
record["welch"] = []
for first, second in [(3, 3), (5, 3), (10, 5)]:
    a, b = rng.normal(0.9, 0.03, first), rng.normal(0.84, 0.05, second)
    test = stats.ttest_ind(a, b, equal_var=False)
    interval = test.confidence_interval()
    record["welch"].append([first, float(test.pvalue), float(interval.low), float(interval.high), *a, *b])

text = json.dumps(record, default=float)
pathlib.Path(__file__).with_name("statistics.json").write_text(text.replace(']], "', ']],\n"') + "\n")
print(record["versions"])
