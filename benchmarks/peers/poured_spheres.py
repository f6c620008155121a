#!/usr/bin/env python3
"""Spheres dropped into a box without side walls, by Peclet (peclet-dem of PyPI) and by PorePack, in one run on one machine.

    python3 -m venv peers && peers/bin/pip install peclet-dem
    POREPACK=build/porepack peers/bin/python benchmarks/peers/poured_spheres.py poured_spheres.csv

Both drop spheres (friction 0.35) from a lattice of 1.02 diameters, with small random speeds, until they rest. Columns: porosity between three
diameters above the floor and three below the highest sphere; the largest overlap of two spheres, in diameters; contacts per sphere between
the same heights (closer than 1e-3 diameters); seconds, one thread each. Peclet moves positions and speeds until constraints hold (XPBD); its
steps and the number of its iterations are ours to choose. Its bed counts as being at rest at a kinetic energy of 1e-4 m g d per sphere (else
the script ends after 3 s), that of PorePack at 1e-6. Without Peclet the script is skipped, and says so.
"""

import csv
import json
import math
import os
import pathlib
import random
import subprocess
import sys
import tempfile
import time

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OMP_PROC_BIND", "false")

try:
    import importlib.metadata

    import numpy as np
    import peclet.dem as peclet
except ImportError as missing:
    print("skipped:", missing)
    sys.exit(77)

POREPACK = os.environ.get("POREPACK", "porepack")
DIAMETER, FRICTION, WIDTH, SPHERES = 0.01, 0.35, 8, 1000  # WIDTH in diameters
PITCH, SEED, STEPS_S, ITERATIONS, LONGEST_S = 1.02, 1, (5e-4, 1e-4), 20, 3.0


def start():
    """Places and speeds on a lattice above the floor, at PorePack's pitch."""
    draw, across = random.Random(SEED), int(WIDTH / PITCH)
    apart = WIDTH / across * DIAMETER
    places = [((k % across + 0.5) * apart, (k // across % across + 0.5) * apart, (k // across**2 + 0.5) * PITCH * DIAMETER) for k in range(SPHERES)]
    return np.array(places), np.array([[draw.uniform(-0.1, 0.1), draw.uniform(-0.1, 0.1), 0.0] for _ in places])


def cap(height):
    """Volume of a sphere below this height above its lowest point."""
    height = min(max(height, 0.0), DIAMETER)
    return math.pi * height**2 * (1.5 * DIAMETER - height) / 3


def measure(places):
    """Porosity, largest overlap in diameters, contacts per sphere."""
    low, high = 3 * DIAMETER, places[:, 2].max() + DIAMETER / 2 - 3 * DIAMETER
    solid = sum(cap(high - z + DIAMETER / 2) - cap(low - z + DIAMETER / 2) for z in places[:, 2])
    apart = places[:, None] - places[None]
    apart[..., :2] -= WIDTH * DIAMETER * np.round(apart[..., :2] / (WIDTH * DIAMETER))
    distance = np.sqrt((apart**2).sum(-1)) + np.eye(len(places))
    inside = (places[:, 2] > low) & (places[:, 2] < high)
    contacts = (distance[inside] < 1.001 * DIAMETER).sum(1).mean()
    return 1 - solid / ((WIDTH * DIAMETER) ** 2 * (high - low)), 1 - distance.min() / DIAMETER, contacts


def by_peclet(step_s):
    places, speeds = start()
    simulation = peclet.Simulation(4 * SPHERES)
    simulation.initialize_shape("sphere", DIAMETER / 2)
    simulation.set_domain([WIDTH * DIAMETER, WIDTH * DIAMETER, 2 * places[:, 2].max()], periodic=[True, True, False])
    simulation.add_plane([0.0, 0.0, 0.0], [0.0, 0.0, 1.0])
    simulation.set_positions(places.astype(np.float32))
    simulation.set_velocities(speeds.astype(np.float32))
    simulation.set_material_params(0.3, 0.0, FRICTION)
    simulation.set_gravity([0.0, 0.0, -9.81])
    simulation.set_solver_iterations(ITERATIONS, ITERATIONS)
    simulation.set_dt(step_s)
    steps = round(0.02 / step_s)
    for look in range(round(LONGEST_S / 0.02)):
        simulation.step(steps)
        energy = 0.5 * (np.asarray(simulation.get_velocities()) ** 2).sum(1).mean()  # per mass
        if look > 20 and energy < 1e-4 * 9.81 * DIAMETER:
            return np.asarray(simulation.get_positions(), dtype=float)
    raise SystemExit(f"Peclet: not at rest after {LONGEST_S:g} s")


CASE = f"""
[shape]
kind = "sphere"
diameter_m = {DIAMETER}
[container]
kind = "box"
size_m = [{WIDTH * DIAMETER}, {WIDTH * DIAMETER}, {2 * SPHERES / WIDTH**2 * DIAMETER}]
periodic = [true, true, false]
[packing]
grains = {SPHERES}
fill = "lattice"
friction = {FRICTION}
horizontal_speed_m_per_s = 0.1
seed = {SEED}
"""


def by_porepack(folder):
    case = pathlib.Path(folder)
    (case / "case.toml").write_text(CASE)
    done = subprocess.run([POREPACK, "pack", str(case), "--json"], capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(done.stderr)
    packing = json.loads(next(case.rglob("packing.json")).read_text())
    return np.array([body["position_m"] for body in packing["bodies"]])


def main():
    porepack = subprocess.run([POREPACK, "--version"], capture_output=True, text=True).stdout.split("\n")[0].removeprefix("porepack ")
    version = importlib.metadata.version("peclet-dem")
    rows = [["code", "version", "pitch_of_the_start", "seed", "porosity", "largest_overlap", "contacts_per_sphere", "seconds"]]
    with tempfile.TemporaryDirectory() as folder:
        codes = [(f"Peclet, steps of {dt:g} s", version, lambda dt=dt: by_peclet(dt)) for dt in STEPS_S]
        for code, stated, pour in [*codes, ("PorePack", porepack, lambda: by_porepack(folder))]:
            begin = time.perf_counter()
            places = pour()
            seconds = time.perf_counter() - begin
            porosity, overlap, contacts = measure(places)
            rows.append([code, stated, PITCH, SEED, f"{porosity:.4f}", f"{overlap:.2g}", f"{contacts:.2f}", f"{seconds:.1f}"])
            print(*rows[-1], flush=True)
    with open(sys.argv[1] if len(sys.argv) > 1 else "poured_spheres.csv", "w", newline="") as output:
        csv.writer(output, lineterminator="\n").writerows(rows)


if __name__ == "__main__":
    main()
