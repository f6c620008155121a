"""PoreSpy and OpenPNM make a pore network of an image. Prints the permeability of the network, and that of the flow in the image itself."""

import numpy
import openpnm
import porespy

import porepack

size, voxel = 60, 1e-5
numpy.random.seed(1)
pores = porespy.generators.overlapping_spheres(shape=[size] * 3, r=10, porosity=0.5)

net = openpnm.io.network_from_porespy(porespy.networks.snow2(pores, voxel_size=voxel).network)
net["pore.diameter"] = net["pore.equivalent_diameter"]
net["throat.diameter"] = net["throat.inscribed_diameter"]
sizes = openpnm.models.geometry.hydraulic_size_factors.pyramids_and_cuboids
net.add_model(propname="throat.hydraulic_size_factors", model=sizes)
water = openpnm.phase.Phase(network=net)
water["pore.viscosity"] = 1e-3
water.add_model(propname="throat.hydraulic_conductance", model=openpnm.models.physics.hydraulic_conductance.generic_hydraulic)
flow = openpnm.algorithms.StokesFlow(network=net, phase=water)
flow.set_value_BC(pores=net.pores("zmin"), values=1.0)
flow.set_value_BC(pores=net.pores("zmax"), values=0.0)
flow.run()
rate = flow.rate(pores=net.pores("zmin"), mode="group")[0]
print(f"permeability of the network {rate * 1e-3 / (size * voxel):.4g} m²")
print(porepack.permeability(porepack.PoreSpace(pores, voxel_size_m=voxel)))
