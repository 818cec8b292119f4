"""A classification tree by scikit-learn.

    pip install scikit-learn==1.9.1
    python record.py > new.json && mv new.json values.json

Fits the rows of `values.json`, which were drawn at random, each with a class: the splits that a tree of depth 3 makes, feature and value, depth first,
"at most" first; `bounded` has those of a tree with at least 8 rows in a leaf.
"""

import json
from pathlib import Path

import sklearn
from sklearn.tree import DecisionTreeClassifier

known = json.loads(Path(__file__).with_name("values.json").read_text())
rows, hits = known["rows"], known["hits"]


def splits(min_rows):
    found = DecisionTreeClassifier(max_depth=3, min_samples_leaf=min_rows, random_state=0).fit(rows, hits).tree_

    def walk(node):
        if found.children_left[node] < 0:
            return []
        split = [int(found.feature[node]), float(found.threshold[node])]
        return [split, *walk(found.children_left[node]), *walk(found.children_right[node])]

    return walk(0)


versions = {"scikit-learn": sklearn.__version__}
print(json.dumps({"versions": versions, "rows": rows, "hits": hits, "splits": splits(1), "bounded": splits(8)}))
