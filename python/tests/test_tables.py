"""Tables of reports in other libraries: which columns they share with Arrow, and which they copy."""

import pytest

from falsify_av.program import Report

pyarrow = pytest.importorskip("pyarrow")
from pyarrow import parquet  # noqa: E402

COLUMNS = {
    "ticks": pyarrow.array(range(1000), pyarrow.uint32()),
    "least_gap_m": pyarrow.array([0.25 * row for row in range(1000)], pyarrow.float64()),
    "collision": pyarrow.array([row % 3 == 0 for row in range(1000)], pyarrow.bool_()),
    "driving_mode": pyarrow.array(["emergency_stop and more letters than a view holds"] * 1000, pyarrow.string()),
}
NUMBERS = ("ticks", "least_gap_m", "collision")


class Capsule:
    """A table that offers nothing but Arrow's C interface of streams."""

    def __init__(self, table):
        self._table = table

    def __arrow_c_stream__(self, requested_schema=None):
        return self._table.__arrow_c_stream__(requested_schema)


@pytest.fixture
def table(tmp_path):
    """The table of a report, in several parts as those of large reports."""
    parquet.write_table(pyarrow.table(COLUMNS), tmp_path / "episodes.parquet", row_group_size=300)
    found = Report(tmp_path).table("episodes")
    return pyarrow.concat_tables([found.slice(0, 500), found.slice(500)])


def memory(column):
    """The first and the last address of the data of each part of a column."""
    buffers = [chunk.buffers()[-1] for chunk in column.chunks]
    return [(buffer.address, buffer.address + buffer.size) for buffer in buffers]


def is_shared(chunks, column):
    """Whether the data of Arrow's arrays lies in the memory of a column."""
    places = [chunk.buffers()[-1].address for chunk in chunks]
    return all(any(first <= place < last for first, last in memory(column)) for place in places)


def parts(series):
    """The parts of a series of polars as Arrow's arrays."""
    return [chunk.to_arrow() for chunk in series.get_chunks()]


def test_polars_shares_numbers_and_truth_values_and_copies_texts(table):
    polars = pytest.importorskip("polars")
    for frame in (polars.from_arrow(table), polars.DataFrame(Capsule(table))):
        assert frame.to_dict(as_series=False) == table.to_pydict()
        shared = {name: is_shared(parts(frame[name]), table[name]) for name in COLUMNS}
        assert shared == {**dict.fromkeys(NUMBERS, True), "driving_mode": False}
    joined = polars.from_arrow(table).rechunk()
    assert not is_shared(parts(joined["ticks"]), table["ticks"])


def test_pandas_shares_all_columns_with_types_of_arrow(table):
    pandas = pytest.importorskip("pandas")
    frame = table.to_pandas(types_mapper=pandas.ArrowDtype)
    for name in COLUMNS:
        assert is_shared(pyarrow.chunked_array(frame[name].array.__arrow_array__()).chunks, table[name]), name
    place = table.to_pandas()["least_gap_m"].to_numpy().ctypes.data
    assert not any(first <= place < last for first, last in memory(table["least_gap_m"])), "NumPy's columns are copies"
