#!/usr/bin/env python3
"""Permeability of simple cubic sphere arrays by Peclet (peclet-flow of PyPI) and by PorePack, in one run on one machine: error and seconds.

    python3 -m venv peers && peers/bin/pip install peclet-flow
    POREPACK=build/porepack peers/bin/python benchmarks/peers/sphere_arrays.py sphere_arrays.csv

K is known to seven digits (Zick & Homsy; boundary integrals). Both codes get the sphere's exact distance, one grid, three places of the
sphere relative to the grid; the error is the largest of the three, the seconds are the least of all runs at these places, two threads each.
Peclet marches with its own settings for creeping flow and stops at a change of 1e-6; PorePack stops at an iteration error of 1e-6.
"""

import csv
import importlib.metadata
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import time

os.environ.setdefault("OMP_NUM_THREADS", "2")
os.environ.setdefault("OMP_PROC_BIND", "false")

try:
    import numpy as np
    import peclet.flow as peclet
except ImportError as missing:
    print("skipped:", missing)
    sys.exit(77)

POREPACK = os.environ.get("POREPACK", "porepack")
EXACT = {0.125: 4.291589, 0.343: 15.39949}
PLACES = ((0.5, 0.5, 0.5), (0.513, 0.507, 0.521), (0.531, 0.489, 0.502))
CELLS = (16, 24, 32, 48)
REPEATS = 2


def drag_factor(radius, fraction, permeability):
    return 2 * radius**2 / (9 * fraction * permeability)


def by_peclet(radius, centres, cells):
    """The mean velocity under a force of 1, which is k, of spheres in a periodic box of edge 1."""
    solver = peclet.Solver((cells, cells, cells), extent=(1.0, 1.0, 1.0))
    solver.set_rho(1.0)
    solver.set_mu(1.0)
    solver.set_dt(0.1)
    solver.set_advection(False)
    solver.set_body_force([0.0, 0.0, 1.0])
    grid = np.meshgrid(*solver.cell_centers(), indexing="ij")
    distance = np.full((cells, cells, cells), 1.0)
    for centre in centres:
        apart = [np.abs(a - p) for a, p in zip(grid, centre)]
        apart = [np.minimum(d, 1.0 - d) for d in apart]
        distance = np.minimum(distance, np.sqrt(sum(d * d for d in apart)) - radius)
    solver.set_solid(np.asfortranarray(distance), cutcell_pressure=True)
    mean = lambda: float(np.mean(solver.get_w()))
    found = peclet.march_to_steady(solver, mean, rtol=1e-6, max_steps=5000)
    if not found.converged:
        raise SystemExit(f"Peclet: not converged, {found.reason}")
    return mean()


def by_porepack(radius, centres, folder, *options):
    """What `porepack lbm` answers for the same spheres."""
    packing = {
        "format": "porepack-packing",
        "version": 1,
        "container": {"kind": "box", "size_m": [1, 1, 1], "periodic": [True, True, True]},
        "shapes": [{"id": "sphere", "capsules": [{"a_m": [0, 0, 0], "b_m": [0, 0, 0], "radius_m": radius}]}],
        "bodies": [{"shape": "sphere", "position_m": list(centre), "orientation": [1, 0, 0, 0]} for centre in centres],
    }
    file = pathlib.Path(folder) / "packing.json"
    file.write_text(json.dumps(packing))
    command = [POREPACK, "lbm", str(file), "--fields", "none", "--output", str(folder), "--json", *map(str, options)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(done.stderr)
    return json.loads(done.stdout)


def one_grid(cells):
    return "--voxel-size", 1 / cells, "--grids", 1, "--iteration-tolerance", 1e-6


def versions():
    porepack = subprocess.run([POREPACK, "--version"], capture_output=True, text=True).stdout.split("\n")[0].removeprefix("porepack ")
    return {"Peclet": importlib.metadata.version("peclet-flow"), "PorePack": porepack}


def main():
    output = sys.argv[1] if len(sys.argv) > 1 else "sphere_arrays.csv"
    version = versions()
    with open(output, "w", newline="") as file, tempfile.TemporaryDirectory() as folder:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(["solid_fraction", "cells", "code", "version", "worst_error", "seconds"])
        for fraction, exact in EXACT.items():
            radius = (3 * fraction / (4 * math.pi)) ** (1 / 3)
            for cells in CELLS:
                codes = {
                    "Peclet": lambda place: by_peclet(radius, [place], cells),
                    "PorePack": lambda place: by_porepack(radius, [place], folder, *one_grid(cells))["permeability_m2"],
                }
                errors, seconds = {code: 0.0 for code in codes}, {code: math.inf for code in codes}
                for _ in range(REPEATS):
                    for place in PLACES:
                        for code, permeability in codes.items():  # in turn
                            begin = time.perf_counter()
                            k = permeability(place)
                            seconds[code] = min(seconds[code], time.perf_counter() - begin)
                            error = drag_factor(radius, fraction, k) / exact - 1
                            if abs(error) > abs(errors[code]):
                                errors[code] = error
                for code in codes:
                    row = [fraction, cells, code, version[code], f"{errors[code]:.5f}", f"{seconds[code]:.2f}"]
                    rows.writerow(row)
                    file.flush()
                    print(*row)


if __name__ == "__main__":
    main()
