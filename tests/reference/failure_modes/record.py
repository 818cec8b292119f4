"""Partitions and trees by scikit-learn.

    pip install scikit-learn==1.9.1
    python record.py > values.json

`partitions`: points, two labellings, and their adjusted Rand index and the silhouette of the first.
`tree`: a table with a class for each row, and the splits that a tree of depth 3 makes: feature, value and the hits and rows of its
leaves, in the order of depth first, "at most" first.
"""

import json
import random

import sklearn
from sklearn.metrics import adjusted_rand_score, silhouette_score
from sklearn.tree import DecisionTreeClassifier

draw = random.Random(5)


def partition(n, clusters, mistakes):
    labels = [i % clusters for i in range(n)]
    points = [[round(label * 3 + draw.gauss(0, 1), 3), round(draw.gauss(0, 1), 3)] for label in labels]
    other = [draw.randrange(clusters) if draw.random() < mistakes else (label + 1) % clusters for label in labels]
    return {
        "points": points,
        "a": labels,
        "b": other,
        "adjusted_rand": adjusted_rand_score(labels, other),
        "silhouette": silhouette_score(points, labels),
    }


def tree():
    rows = [[round(draw.uniform(0, 30), 2), round(draw.uniform(-60, 60), 1), float(draw.random() < 0.4)] for _ in range(400)]
    rate = lambda d, b, h: 0.95 if d <= 12 and h else 0.6 if d <= 12 else 0.4 if b > 20 else 0.05
    hits = [int(draw.random() < rate(*row)) for row in rows]
    found = DecisionTreeClassifier(max_depth=3, random_state=0).fit(rows, hits).tree_
    splits, leaves = [], []

    def walk(node, members):
        if found.children_left[node] < 0:
            leaves.append([sum(hits[i] for i in members), len(members)])
            return
        feature, value = int(found.feature[node]), float(found.threshold[node])
        splits.append([feature, value])
        walk(found.children_left[node], [i for i in members if rows[i][feature] <= value])
        walk(found.children_right[node], [i for i in members if rows[i][feature] > value])

    walk(0, list(range(len(rows))))
    return {"rows": rows, "hits": hits, "splits": splits, "leaves": leaves}


print(
    json.dumps(
        {
            "versions": {"scikit-learn": sklearn.__version__},
            "partitions": [partition(60, 3, 0.3), partition(41, 2, 0.9), partition(30, 5, 0.0)],
            "tree": tree(),
        }
    )
)
