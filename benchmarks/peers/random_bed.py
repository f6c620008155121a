#!/usr/bin/env python3
"""Permeability of 30 random spheres (c = 0.3, a periodic box) by Peclet and by PorePack, in one run: difference to a fine reference, and seconds.

    POREPACK=build/porepack peers/bin/python benchmarks/peers/random_bed.py random_bed.csv

The reference is PorePack with --tolerance 0.003, whose interval is in the table. Both codes get the exact spheres, and one grid per row.
"""

import csv
import importlib.metadata
import json
import math
import os
import pathlib
import random
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
SPHERES, FRACTION, CELLS = 30, 0.3, (32, 48, 64)
RADIUS = (3 * FRACTION / (4 * math.pi * SPHERES)) ** (1 / 3)


def places():
    """One after the other, where there is room: the same ones in each run."""
    draw, found = random.Random(1), []
    while len(found) < SPHERES:
        at = [draw.random() for _ in range(3)]
        if all(sum(min(abs(a - b), 1 - abs(a - b)) ** 2 for a, b in zip(at, other)) > (2.02 * RADIUS) ** 2 for other in found):
            found.append(at)
    return found


def by_peclet(centres, cells):
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
        distance = np.minimum(distance, np.sqrt(sum(d * d for d in apart)) - RADIUS)
    solver.set_solid(np.asfortranarray(distance), cutcell_pressure=True)
    mean = lambda: float(np.mean(solver.get_w()))
    found = peclet.march_to_steady(solver, mean, rtol=1e-6, max_steps=5000)
    if not found.converged:
        raise SystemExit(f"Peclet: not converged, {found.reason}")
    return mean()


def by_porepack(file, *options):
    done = subprocess.run(
        [POREPACK, "lbm", file, "--fields", "none", "--output", str(pathlib.Path(file).parent), "--json", *options], capture_output=True, text=True
    )
    if done.returncode != 0:
        raise SystemExit(done.stderr)
    return json.loads(done.stdout)


def main():
    centres = places()
    rows = [["cells", "code", "version", "difference", "seconds"]]
    versions = {"Peclet": importlib.metadata.version("peclet-flow")}
    versions["PorePack"] = subprocess.run([POREPACK, "--version"], capture_output=True, text=True).stdout.split("\n")[0].removeprefix("porepack ")
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "packing.json"
        file.write_text(
            json.dumps(
                {
                    "format": "porepack-packing",
                    "version": 1,
                    "container": {"kind": "box", "size_m": [1, 1, 1], "periodic": [True, True, True]},
                    "shapes": [{"id": "sphere", "capsules": [{"a_m": [0, 0, 0], "b_m": [0, 0, 0], "radius_m": RADIUS}]}],
                    "bodies": [{"shape": "sphere", "position_m": at, "orientation": [1, 0, 0, 0]} for at in centres],
                }
            )
        )
        reference = by_porepack(str(file), "--tolerance", "0.003")
        k, (low, high) = reference["permeability_m2"], reference["permeability_interval_m2"]
        rows.append(["reference", "PorePack", versions["PorePack"], f"{low / k - 1:.5f} to {high / k - 1:.5f}", f"{reference['wall_time_s']:.1f}"])
        print(*rows[-1], flush=True)
        for cells in CELLS:
            for code, value in (
                ("Peclet", lambda: by_peclet(centres, cells)),
                (
                    "PorePack",
                    lambda: by_porepack(str(file), "--voxel-size", str(1 / cells), "--grids", "1", "--iteration-tolerance", "1e-6")[
                        "permeability_m2"
                    ],
                ),
            ):
                begin = time.perf_counter()
                found = value()
                rows.append([cells, code, versions[code], f"{found / k - 1:.5f}", f"{time.perf_counter() - begin:.2f}"])
                print(*rows[-1], flush=True)
    with open(sys.argv[1] if len(sys.argv) > 1 else "random_bed.csv", "w", newline="") as output:
        csv.writer(output, lineterminator="\n").writerows(rows)


if __name__ == "__main__":
    main()
