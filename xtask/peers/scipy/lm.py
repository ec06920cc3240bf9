"""SciPy's trust region on the tracker problem: lm.py FOLDER RUNS

Sparse analytic Jacobian and LSMR, whose default tolerances end at a higher cost. Prints a line of JSON per run; the solution goes to scipy.bin
beside the problem.
"""

import json
import os
import resource
import sys
import time

import numpy as np
from scipy.optimize import least_squares
from scipy.sparse import csr_matrix

folder, runs = sys.argv[1], int(sys.argv[2])
I, J, K = (int(n) for n in open(os.path.join(folder, "dims.txt")).read().split())
pairs = [(a, b) for a in range(J) for b in range(a + 1, J)]
first, second = np.array(pairs).T
displacements = np.fromfile(os.path.join(folder, "obs.bin")).reshape(K, J, I)
start = np.fromfile(os.path.join(folder, "init.bin"))
at_d, at_distance = 3 * I, 3 * I + I * J
at_p = at_distance + len(pairs)
free = np.setdiff1d(np.arange(start.size), [0, 1, 2, 4, 5, 8])
column_of = np.full(start.size, -1)
column_of[free] = np.arange(free.size)

k, j, i = (n.ravel() for n in np.meshgrid(*map(np.arange, (K, J, I)), indexing="ij"))
range_rows = np.arange(k.size)
xyz = np.arange(3)
point_columns = at_p + 3 * (k * J + j)[:, None] + xyz
station_columns = 3 * i[:, None] + xyz
kk, n = (m.ravel() for m in np.meshgrid(np.arange(K), np.arange(len(pairs)), indexing="ij"))
rigid_rows = range_rows.size + np.arange(kk.size)
first_columns = at_p + 3 * (kk * J + first[n])[:, None] + xyz
second_columns = at_p + 3 * (kk * J + second[n])[:, None] + xyz
rows = np.concatenate([np.repeat(range_rows, 3), np.repeat(range_rows, 3), range_rows,
                       np.repeat(rigid_rows, 3), np.repeat(rigid_rows, 3), rigid_rows])
columns = column_of[np.concatenate([point_columns.ravel(), station_columns.ravel(),
                                    at_d + i * J + j, first_columns.ravel(),
                                    second_columns.ravel(), at_distance + n])]
kept = columns >= 0
shape = (range_rows.size + rigid_rows.size, free.size)


def whole(x):
    full = start.copy()
    full[free] = x
    return full


def offsets(full):
    points = full[at_p:].reshape(K, J, 3)
    ranges = points[:, :, None, :] - full[:at_d].reshape(I, 3)
    rigid = points[:, first] - points[:, second]
    return ranges, rigid


def residuals(x):
    full = whole(x)
    ranges, rigid = offsets(full)
    dead_paths = full[at_d:at_distance].reshape(I, J).T
    u = np.linalg.norm(ranges, axis=-1) - displacements - dead_paths
    v = np.linalg.norm(rigid, axis=-1) - full[at_distance:at_p]
    return np.concatenate([u.ravel(), v.ravel()])


def jacobian(x):
    ranges, rigid = offsets(whole(x))
    g = (ranges / np.linalg.norm(ranges, axis=-1, keepdims=True)).reshape(-1, 3)
    h = (rigid / np.linalg.norm(rigid, axis=-1, keepdims=True)).reshape(-1, 3)
    values = np.concatenate([g.ravel(), -g.ravel(), np.full(len(g), -1.0), h.ravel(), -h.ravel(),
                             np.full(len(h), -1.0)])
    return csr_matrix((values[kept], (rows[kept], columns[kept])), shape=shape)


for _ in range(runs):
    begun, cpu_begun = time.perf_counter(), time.process_time()
    fit = least_squares(residuals, start[free], jacobian, method="trf", tr_solver="lsmr",
                        tr_options={"atol": 1e-14, "btol": 1e-14, "maxiter": 10 * start.size},
                        x_scale="jac", ftol=1e-12, xtol=1e-15, gtol=1e-15, max_nfev=100)
    taken, cpu = time.perf_counter() - begun, time.process_time() - cpu_begun
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    print(json.dumps({"ms": 1e3 * taken, "cpu_ms": 1e3 * cpu, "cost": fit.cost,
                      "evaluations": fit.nfev, "jacobians": fit.njev, "peak_kib": peak}))
whole(fit.x).tofile(os.path.join(folder, "scipy.bin"))
