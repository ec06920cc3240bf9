"""Many cases at once, on one process and on a cluster that loses a worker."""

import json
import os
import signal
import threading
import time

import numpy as np
import pytest
import truing
from pyarrow import parquet
from truing import fleet, fleet_page


def written(folder, seed, stretch=0.0):
    draws = np.random.default_rng(seed)
    from_mm = draws.uniform(-400.0, 400.0, (20, 3))
    to_mm = from_mm * [1.0 + stretch, 1.0, 1.0] + draws.normal(0.0, 0.005, (20, 3))
    pairs = {"point": [f"p{i}" for i in range(20)]}
    for k, axis in enumerate("xyz"):
        pairs[f"from_{axis}_mm"], pairs[f"to_{axis}_mm"] = from_mm[:, k], to_mm[:, k]
    truing.Case("frame-fit", {"pairs": pairs}, {"noise": {"point_mm": 0.005}}).write(folder)
    return str(folder)


@pytest.fixture
def machines(tmp_path):
    cases = [written(tmp_path / "cases" / f"m{seed:02}", seed, 2e-4 * (seed % 2)) for seed in range(12)]
    broken = tmp_path / "cases" / "m12"
    broken.mkdir()
    (broken / "case.toml").write_text('kind = "frame-fit"\nkey = 1\n', encoding="utf-8")
    line = {f"{side}_{axis}_mm": np.arange(5.0) * (axis == "x") for side in ("from", "to") for axis in "xyz"}
    free = truing.Case("frame-fit", {"pairs": {"point": list("abcde"), **line}})
    return [*cases, str(broken), str(free.write(tmp_path / "cases" / "m13")), str(tmp_path / "cases" / "m14")]


def test_every_case_is_a_row(machines, tmp_path):
    rows = parquet.read_table(fleet.run(reversed(machines), tmp_path / "out")).to_pylist()
    assert [row["case"] for row in rows] == sorted(machines)
    assert [row["status"] for row in rows[-3:]] == ["unusable", "not-determined", "unreadable"]
    assert rows[12]["line"] == 2 and "key" in rows[12]["message"]
    assert "rotation" in rows[13]["free_direction"]
    for k, row in enumerate(rows[:12]):
        assert row["status"] == "answered" and row["kind"] == "frame-fit"
        assert ("scale" in "".join(row["effects"])) == bool(k % 2), row["effects"]
        assert json.loads(row["answer"])["verdict"] == row["verdict"]
    stretched = rows[1]["sizes"]
    assert any(abs(size["value"] - 200.0) < 5.0 * size["std"] for size in stretched if size["unit"] == "ppm")


def test_what_did_not_change_is_not_computed_again(machines, tmp_path, monkeypatch):
    first = fleet.run(machines, tmp_path / "out").read_bytes()
    calls = []
    real = fleet.loop
    monkeypatch.setattr(fleet, "loop", lambda folder, **options: calls.append(folder) or real(folder, **options))
    assert fleet.run(machines, tmp_path / "out").read_bytes() == first and calls == []
    with open(os.path.join(machines[3], "pairs.csv"), "a", encoding="utf-8") as table:
        table.write("# touched\n")
    fleet.run(machines, tmp_path / "out")
    assert calls == [machines[3]]
    assert fleet.content_key(machines[0], "loop") != fleet.content_key(machines[0], "solve")
    assert not [name for name in os.listdir(tmp_path / "out" / "rows") if name.startswith(".")]


def test_a_cluster_that_loses_a_worker_answers_the_same_bytes(machines, tmp_path):
    distributed = pytest.importorskip("dask.distributed")
    alone = fleet.run(machines, tmp_path / "alone").read_bytes()
    rows = tmp_path / "together" / "rows"
    cluster = distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
    with cluster, distributed.Client(cluster) as client:
        victim = sorted(client.run(os.getpid).values())[0]
        killed = threading.Event()

        def kill():
            # In the middle: some rows are there, and others are not.
            while not (rows.is_dir() and len(list(rows.glob("[!.]*.json"))) >= 2):
                time.sleep(0.005)
            os.kill(victim, signal.SIGKILL)
            killed.set()

        killer = threading.Thread(target=kill)
        killer.start()
        together = fleet.run(machines, tmp_path / "together", client=client).read_bytes()
        killer.join()
    assert killed.is_set() and together == alone


def test_the_page_says_what_machines_share_and_what_changed(tmp_path):
    # Every machine is stretched by 200 ppm in spring; in autumn one of them by 400 ppm.
    stretches = {"a": (2e-4, 2e-4), "b": (2e-4, 4e-4), "c": (2e-4, 2e-4)}
    cases = [
        written(tmp_path / name / season, 10 * n + k, stretch)
        for n, (name, both) in enumerate(stretches.items())
        for k, (season, stretch) in enumerate(zip(["1-spring", "2-autumn"], both))
    ]
    table = fleet.run([*cases, str(tmp_path / "d" / "1-spring")], tmp_path / "out")
    text = fleet.page(table, machine=lambda case: case.rsplit("/", 2)[-2]).read_text(encoding="utf-8")
    assert "<h1>4 machines, 7 cases</h1>" in text
    shared, changed, look = (text.split(f"<h2>{title}")[1].split("<h2>")[0] for title in ("What they", "What changed", "To be"))
    assert "<td class=n>3</td>" in shared and "ppm" in shared
    assert changed.count("<tr><td>b</td>") >= 1 and "<tr><td>a</td>" not in changed and "<tr><td>c</td>" not in changed
    assert "unreadable" in look
    # Values to the place of their uncertainty, with a minus sign.
    assert fleet_page._with_expanded(-8.3071, 11.2) == "−8 ± 11" and fleet_page._with_expanded(0.0996, 0.0996) == "0.10 ± 0.10"
    assert fleet_page._with_expanded(-12345.6, 2345.0) == "−12300 ± 2300" and fleet_page._with_expanded(2.5, 0.0) == "2.5"
