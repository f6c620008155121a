"""The surface of a bed is passed to trimesh, and a surface of trimesh is used as a solid."""

import numpy
import trimesh

import porepack

box = porepack.Vessel("box", size_m=[0.02, 0.02, 0.05])
bed = porepack.pour(porepack.Shape("rod", diameter_m=0.004, length_m=0.008), box, 30, seed=1)
found = porepack.surface(bed)
grains = trimesh.Trimesh(found.vertices, found.faces)
print(f"closed: {grains.is_watertight}, volume {grains.volume:.4g} m³")

ball = trimesh.creation.icosphere(subdivisions=4, radius=0.004)
layers = [ball.copy().apply_translation(numpy.array(place)) for place in ((0.005, 0.005, 0.005), (0.005, 0.005, 0.015))]
duct = porepack.Vessel("box", size_m=[0.01, 0.01, 0.02], periodic=[True, True, True])
print(porepack.permeability(porepack.PoreSpace(trimesh.util.concatenate(layers), vessel=duct), 5e-4))
