"""Many simulated machines on a cluster of this computer, workers killed while it runs.

    python fleet_of_machines.py 500 --workers 2 --kill 20

prints how long one process and the cluster take, and fails where a case is lost or doubled or a byte differs.
"""

import argparse
import os
import random
import signal
import tempfile
import threading
import time
from pathlib import Path

import numpy as np
import truing
from dask.distributed import Client, LocalCluster
from pyarrow import parquet
from truing import fleet


def write_machine(folder: Path, number: int) -> str:
    """Twenty points before and after; every third machine is stretched by 200 ppm along x."""
    draws = np.random.default_rng(number)
    stretch = [1.0 + 2e-4 * (number % 3 == 0), 1.0, 1.0]
    from_mm = draws.uniform(-400.0, 400.0, (20, 3))
    to_mm = from_mm * stretch + draws.normal(0.0, 0.005, (20, 3))
    pairs = {"point": [f"p{i}" for i in range(20)]}
    for k, axis in enumerate("xyz"):
        pairs[f"from_{axis}_mm"], pairs[f"to_{axis}_mm"] = from_mm[:, k], to_mm[:, k]
    case = truing.Case("frame-fit", {"pairs": pairs}, {"noise": {"point_mm": 0.005}})
    return str(case.write(folder / f"machine-{number:04}"))


def kill_workers(
    client: Client, options: argparse.Namespace, rows: Path, killed: "list[int]", done: threading.Event
) -> None:
    """Kills a worker each time that a further share of the rows is there."""
    draws = random.Random(1)
    while not done.wait(0.1):
        # As a batch system does: whoever is not there any more is replaced.
        client.cluster.scale(options.workers)
        share = (len(killed) + 1) * options.cases // (options.kill + 1)
        if len(killed) == options.kill or len(list(rows.glob("[!.]*.json"))) < share:
            continue
        alive = client.run(os.getpid)
        if alive:
            pid = draws.choice(sorted(alive.values()))
            os.kill(pid, signal.SIGKILL)
            killed.append(pid)


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("cases", type=int, nargs="?", default=500)
    arguments.add_argument("--workers", type=int, default=2)
    arguments.add_argument("--kill", type=int, default=20)
    options = arguments.parse_args()
    os.environ["RAYON_NUM_THREADS"] = "1"
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        cases = [write_machine(folder / "cases", number) for number in range(options.cases)]
        started = time.perf_counter()
        alone = fleet.run(cases, folder / "alone").read_bytes()
        alone_s = time.perf_counter() - started
        killed: "list[int]" = []
        with LocalCluster(
            n_workers=options.workers, threads_per_worker=1, dashboard_address=None
        ) as cluster, Client(cluster) as client:
            rows = folder / "together" / "rows"
            done = threading.Event()
            killer = threading.Thread(target=kill_workers, args=(client, options, rows, killed, done))
            started = time.perf_counter()
            killer.start()
            table = fleet.run(cases, folder / "together", client=client)
            together_s = time.perf_counter() - started
            done.set()
            killer.join()
        names = parquet.read_table(table)["case"].to_pylist()
        assert names == sorted(cases), "a case is lost or doubled"
        assert table.read_bytes() == alone, "a byte differs from those of one process"
        statuses = set(parquet.read_table(table)["status"].to_pylist())
        assert statuses == {"answered"}, statuses
        print(f"{len(cases)} cases: one process {alone_s:.1f} s; {options.workers} workers, {len(killed)} killed, {together_s:.1f} s")
        print(fleet.page(table).stat().st_size, "bytes of page; the same table")


if __name__ == "__main__":
    main()
