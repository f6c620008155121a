"""What the tests of the Python package share: small scenes, and the program beside it."""

import json
import os
import pathlib
import subprocess
import tempfile

import numpy

import porepack

PROGRAM = os.environ["POREPACK_PROGRAM"]
SOURCE = pathlib.Path(os.environ["POREPACK_SOURCE_FOLDER"])

# What a second run of the same work changes.
COSTS = {
    "seconds",
    "set_up_seconds",
    "updates_per_second",
    "peak_memory_bytes",
    "expected_memory_bytes",
    "engine_wall_time_s",
    "wall_time_s",
}


def gyroid(cells=24, periods=1):
    """A boolean array [x, y, z]: True on one side of a gyroid, whose porosity is 1/2."""
    x, y, z = numpy.meshgrid(*[2.0 * numpy.pi * periods * (numpy.arange(cells) + 0.5) / cells] * 3, indexing="ij")
    return numpy.sin(x) * numpy.cos(y) + numpy.sin(y) * numpy.cos(z) + numpy.sin(z) * numpy.cos(x) < 0.0


def pebbles():
    """A bed of 40 spheres of 10 mm in a tube of 40 mm."""
    tube = porepack.Vessel("cylinder", diameter_m=0.04, height_m=0.3)
    return porepack.pour(porepack.Shape("sphere", diameter_m=0.01), tube, 40)


def array_of_spheres():
    """Body-centred cubic spheres in a periodic box of 10 mm."""
    box = porepack.Vessel("box", size_m=[0.01] * 3, periodic=[True] * 3)
    return porepack.Packing(porepack.Shape("sphere", diameter_m=0.008), box, [[0.002, 0.002, 0.002], [0.007, 0.007, 0.007]])


def pebbles_in_gray(bed):
    """A scan of the bed's middle: 100 in pores, 200 in grains, smoothed once along each axis."""
    size = 5e-4
    x, y, z = numpy.meshgrid(*[(numpy.arange(48) + 0.5) * size - 0.012] * 2, (numpy.arange(40) + 0.5) * size + 0.008, indexing="ij")
    gray = numpy.full(x.shape, 100.0)
    for centre in bed.positions_m:
        gray[(x - centre[0]) ** 2 + (y - centre[1]) ** 2 + (z - centre[2]) ** 2 < 0.005**2] = 200.0
    for axis in range(3):
        gray = (numpy.roll(gray, 1, axis) + 2.0 * gray + numpy.roll(gray, -1, axis)) / 4.0
    return gray.astype(numpy.float32)


def program(*arguments):
    """The program's result as JSON; its files go to a folder that is removed."""
    with tempfile.TemporaryDirectory() as folder:
        command = [PROGRAM, *map(str, arguments), "--json", "--output", folder]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise AssertionError(f"{' '.join(command)}\n{done.stderr}")
        return json.loads(done.stdout)


def same(python, json_value, path=""):
    """Places where a result of Python differs from the program's JSON: all bits count, costs do not."""
    if isinstance(python, dict) and isinstance(json_value, dict):
        differences = [f"{path}: keys {set(python) ^ set(json_value)}"] if (set(python) ^ set(json_value)) - COSTS else []
        for key in sorted((set(python) & set(json_value)) - COSTS):
            differences += same(python[key], json_value[key], f"{path}/{key}")
        return differences
    if isinstance(python, (list, tuple)) and isinstance(json_value, list) and len(python) == len(json_value):
        return [found for n, pair in enumerate(zip(python, json_value)) for found in same(*pair, f"{path}/{n}")]
    if isinstance(python, float) and python != python:
        return [] if json_value is None else [f"{path}: not a number, and {json_value}"]
    return [] if python == json_value else [f"{path}: {python!r} and {json_value!r}"]
