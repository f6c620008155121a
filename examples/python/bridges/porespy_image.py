"""PoreSpy makes an image; PorePack computes its permeability, with an interval."""

import numpy
import porespy

import porepack

numpy.random.seed(1)
pores = porespy.generators.overlapping_spheres(shape=[60, 60, 60], r=10, porosity=0.6)
space = porepack.PoreSpace(pores, voxel_size_m=1e-5)
print(f"porosity {pores.mean():.4f} by counting voxels; {space.porosity()} of the section")
print(porepack.permeability(space))
