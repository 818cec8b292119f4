"""A classification tree by scikit-learn.

    pip install scikit-learn==1.9.1
    python record.py > new.json && mv new.json values.json

Fits the rows of `values.json`, which were drawn at random, each with a class: the splits that a tree of depth 3 makes, feature and value, depth first,
"at most" first.
"""

import json
from pathlib import Path

import sklearn
from sklearn.tree import DecisionTreeClassifier

known = json.loads(Path(__file__).with_name("values.json").read_text())
rows, hits = known["rows"], known["hits"]
found = DecisionTreeClassifier(max_depth=3, random_state=0).fit(rows, hits).tree_
splits = []


def walk(node):
    if found.children_left[node] >= 0:
        splits.append([int(found.feature[node]), float(found.threshold[node])])
        walk(found.children_left[node])
        walk(found.children_right[node])


walk(0)
print(json.dumps({"versions": {"scikit-learn": sklearn.__version__}, "rows": rows, "hits": hits, "splits": splits}))
