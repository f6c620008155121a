"""A stack of slices as tifffile reads it: the axes are z, y, x."""

import pathlib
import tempfile

import numpy
import tifffile

import porepack

random = numpy.random.default_rng(1)
z, y, x = numpy.meshgrid(*[numpy.arange(n) for n in (60, 48, 48)], indexing="ij")
gray = numpy.full(z.shape, 60.0)
for centre in random.uniform((0, 0, 0), (60, 48, 48), (60, 3)):
    distance = numpy.sqrt((z - centre[0]) ** 2 + (y - centre[1]) ** 2 + (x - centre[2]) ** 2)
    gray = numpy.maximum(gray, 60.0 + 140.0 * numpy.clip(7.0 - distance, 0.0, 1.0))
file = pathlib.Path(tempfile.mkdtemp()) / "stack.tif"
tifffile.imwrite(file, gray.astype(numpy.uint8), photometric="minisblack")

stack = tifffile.imread(file)
space = porepack.PoreSpace(stack, voxel_size_m=2e-5, axes="zyx", threshold=130)
print(space.porosity())
print(porepack.permeability(space))  # walls from the gray values
