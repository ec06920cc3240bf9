"""Tables of other libraries."""

import numpy as np
import pandas
import polars
import pyarrow
import pytest
import truing
from truing.tables import columns, csv

LONG = "a name of more than twelve bytes: ä"
DATA = {"point": ["p1", "", LONG], "x_mm": [0.1, -2.5, 1e-17], "step": [3, 1, 2]}


@pytest.mark.parametrize("library", [pandas.DataFrame, polars.DataFrame, pyarrow.table, dict])
def test_tables_of_all_libraries_are_the_same(library):
    found = columns(library(DATA))
    assert list(found) == ["point", "x_mm", "step"]
    assert found["point"] == DATA["point"]
    assert np.array_equal(found["x_mm"], DATA["x_mm"])
    assert found["step"].dtype.kind == "i" and found["step"].tolist() == [3, 1, 2]
    assert csv(library(DATA)) == csv(DATA)


def test_slices_pieces_and_missing_cells_are_read():
    table = pyarrow.concat_tables([pyarrow.table(DATA), pyarrow.table(DATA)])
    found = columns(table.slice(1, 4))
    assert found["step"].tolist() == [1, 2, 3, 1] and found["point"] == ["", LONG, "p1", ""]
    gaps = pyarrow.table({"n": pyarrow.array([1, None, 3]), "t": ["a", None, "c"], "b": [True, False, True]})
    found = columns(gaps.slice(1, 2))
    assert np.isnan(found["n"][0]) and found["n"][1] == 3.0 and found["t"] == ["", "c"]
    assert found["b"].tolist() == [False, True]
    assert csv(gaps.slice(1, 1)).splitlines()[1] == ",,False"
    narrow = pyarrow.table({"x": pyarrow.array([1.5, 2.5], pyarrow.float32()), "k": pyarrow.array([7, 8], pyarrow.uint8())})
    assert columns(narrow)["x"].tolist() == [1.5, 2.5] and columns(narrow)["k"].tolist() == [7, 8]
    assert columns(pyarrow.table({"x": pyarrow.array([], pyarrow.float64())}))["x"].shape == (0,)


def test_many_slices_are_those_of_the_library():
    draws = np.random.default_rng(3)
    words = [None if draws.random() < 0.2 else LONG[: draws.integers(0, 30)] for _ in range(200)]
    numbers = [None if draws.random() < 0.2 else float(v) for v in draws.normal(size=200)]
    for layout in (pyarrow.string(), pyarrow.large_string(), pyarrow.string_view(), None):
        of_words = pyarrow.array(words).dictionary_encode() if layout is None else pyarrow.array(words, layout)
        table = pyarrow.table({"w": of_words, "v": numbers})
        for start, length in draws.integers(0, 100, (20, 2)).tolist():
            found = columns(table.slice(start, length))
            assert found["w"] == [word or "" for word in words[start : start + length]]
            expected = [np.nan if v is None else v for v in numbers[start : start + length]]
            assert np.array_equal(found["v"], expected, equal_nan=True)


def test_categories_become_text():
    table = pandas.DataFrame({"use": pandas.Categorical(["fit", "check", "fit"])})
    assert columns(table)["use"] == ["fit", "check", "fit"]


def test_what_is_no_table_is_refused():
    with pytest.raises(truing.InputError, match="neither numbers nor text"):
        columns(pyarrow.table({"when": pyarrow.array([0], pyarrow.timestamp("s"))}))
    with pytest.raises(truing.InputError, match="two columns named 'a'"):
        columns(pyarrow.Table.from_arrays([pyarrow.array([1]), pyarrow.array([2])], names=["a", "a"]))
    with pytest.raises(truing.InputError, match="not a single column"):
        columns(polars.Series("a", [1.0]))
    with pytest.raises(truing.InputError, match="got list"):
        columns([1, 2])
    with pytest.raises(truing.InputError, match="one value a row"):
        columns({"a": np.zeros((2, 2))})
    with pytest.raises(truing.InputError, match="equally long"):
        csv({"a": [1], "b": [1, 2]})


def test_a_table_can_be_read_again_and_outlives_its_reading():
    table = pyarrow.table(DATA)
    first, second = columns(table), columns(table)
    del table
    assert first["point"] == second["point"] and np.array_equal(first["x_mm"], DATA["x_mm"])


def test_a_case_of_a_data_frame_is_solved():
    draws = np.random.default_rng(8)
    points = draws.uniform(-200.0, 200.0, (12, 3))
    moved = points + [1.0, 2.0, 3.0] + draws.normal(0.0, 0.01, (12, 3))
    frame = polars.DataFrame(
        {
            "point": [f"p{i}" for i in range(12)],
            **{f"from_{axis}_mm": points[:, k] for k, axis in enumerate("xyz")},
            **{f"to_{axis}_mm": moved[:, k] for k, axis in enumerate("xyz")},
        }
    )
    solved = truing.solve(truing.Case("frame-fit", {"pairs": frame}, {"noise": {"point_mm": 0.01}}))
    fit = truing.frame_fit.fit(points, moved, 0.01)
    assert np.allclose(solved.estimates.matrix, fit.matrix, rtol=0.0, atol=1e-12)
