"""A classification tree by scikit-learn.

    pip install scikit-learn==1.9.1
    python record.py > values.json

A table with a class for each row, and the splits that a tree of depth 3 makes: feature and value, depth first, "at most" first.
"""

import json
import random

import sklearn
from sklearn.tree import DecisionTreeClassifier

draw = random.Random(5)
rows = [[round(draw.uniform(0, 30), 2), round(draw.uniform(-60, 60), 1), float(draw.random() < 0.4)] for _ in range(400)]


def rate(distance, bearing, hidden):
    return 0.95 if distance <= 12 and hidden else 0.6 if distance <= 12 else 0.4 if bearing > 20 else 0.05


hits = [int(draw.random() < rate(*row)) for row in rows]
found = DecisionTreeClassifier(max_depth=3, random_state=0).fit(rows, hits).tree_
splits = []


def walk(node):
    if found.children_left[node] >= 0:
        splits.append([int(found.feature[node]), float(found.threshold[node])])
        walk(found.children_left[node])
        walk(found.children_right[node])


walk(0)
print(json.dumps({"versions": {"scikit-learn": sklearn.__version__}, "rows": rows, "hits": hits, "splits": splits}))
