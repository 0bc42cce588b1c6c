"""Random slews on two worker processes of Dask; one is killed in the middle, and nothing is lost.

    python dask_cluster.py [cases] [workers]

On a cluster a `SLURMCluster` or `KubeCluster` of dask-jobqueue or dask-kubernetes stands in the
place of `LocalCluster`.
"""

import os
import signal
import sys
import time

import numpy as np
from dask.distributed import Client, LocalCluster, as_completed
from scipy.spatial.transform import Rotation

import slewkit


def spec(case: int) -> dict:
    """A random slew from rest to rest; the case is its seed, so that every worker makes the
    same."""
    random = np.random.default_rng(case)
    return {
        "format": 1,
        "name": f"case {case}",
        "body": {"inertia_kg_m2": random.uniform(80, 120, 3)},
        "start": {"attitude": {"axis": [0, 0, 1], "angle_deg": 0}},
        "end": {"attitude": Rotation.random(random_state=case)},
        "maneuver": {"duration_s": 60, "steps": 100},
    }


def solve(cases: list[int]) -> list[tuple[int, str, float]]:
    """Status and cost of some cases; enough at a time that the scheduler does not become the
    work."""
    plans = [slewkit.plan(spec(case), strict=False) for case in cases]
    return [(case, plan.status, plan.cost) for case, plan in zip(cases, plans)]


def run(count: int, workers: int, kill: bool) -> tuple[list, float]:
    with LocalCluster(n_workers=workers, threads_per_worker=1,
        dashboard_address=None) as cluster, Client(cluster) as client:
        # So many that a worker which is done early finds more, and so few that handing them out
        # costs nothing.
        size = max(10, count // (16 * workers))
        batches = [list(range(first, min(first + size, count))) for first in range(0, count, size)]
        pids = list(client.run(os.getpid).values())
        # What every worker loads, once.
        client.run(solve, [0])
        began, results = time.perf_counter(), []
        # A batch whose worker dies goes to another: Dask's own doing, as a plan depends on nothing
        # but its spec.
        for done in as_completed(client.map(solve, batches), with_results=True):
            results += done[1]
            if kill:
                os.kill(pids[0], signal.SIGKILL)
                kill = False
        return sorted(results), time.perf_counter() - began


if __name__ == "__main__":
    count, workers = (int(text) for text in (sys.argv[1:] + ["1000", "2"][len(sys.argv) - 1 :])[:2])
    results, seconds = run(count, workers, kill=True)
    solved = sum(status == "solved" for _, status, _ in results)
    print(f"{workers} workers, one killed: {solved} of {count} solved in {seconds:.1f} s")
    assert [case for case, _, _ in results] == list(range(count)) and solved == count
    alone, time_alone = run(count, 1, kill=False)
    undisturbed, time_all = run(count, workers, kill=False)
    print(f"1 worker {time_alone:.1f} s, {workers} workers {time_all:.1f} s: {time_alone / time_all:.2f} times as fast")
    assert results == alone == undisturbed
