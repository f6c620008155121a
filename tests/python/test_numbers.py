"""The package gives the program's numbers, to the last bit."""

import json
import pathlib
import tempfile
import unittest

import numpy

import porepack
from support import SOURCE, array_of_spheres, gyroid, pebbles, pebbles_in_gray, program, same


class SameNumbers(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.scratch.name)
        cls.bed, cls.cell = pebbles(), array_of_spheres()
        cls.bed.write(cls.folder / "bed.json")
        cls.cell.write(cls.folder / "cell.json")
        numpy.save(cls.folder / "gyroid.npy", gyroid().astype(numpy.uint8))
        cls.gray = pebbles_in_gray(cls.bed)
        numpy.save(cls.folder / "gray.npy", cls.gray)

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    def check(self, python, *arguments):
        self.assertEqual(same(python, program(*arguments)), [])

    def test_permeability_of_a_bed(self):
        k = porepack.permeability(porepack.PoreSpace(self.bed), 1e-3)
        self.check(k.details, "lbm", self.folder / "bed.json", "--voxel-size", 1e-3, "--fields", "none")

    def test_permeability_with_keys_of_three_tables(self):
        space = porepack.PoreSpace(self.bed, section_m=[0.01, 0.03], ends="planes")
        k = porepack.permeability(space, 1.25e-3, precision="single", grids=1)
        arguments = ["--section", "0.01,0.03", "--ends", "planes", "--precision", "single", "--grids", 1, "--fields", "none"]
        self.check(k.details, "lbm", self.folder / "bed.json", "--voxel-size", 1.25e-3, *arguments)
        self.assertIsNone(k.interval_m2)

    def test_tensor_of_a_periodic_cell(self):
        k = porepack.permeability(porepack.PoreSpace(self.cell), 1e-3, tensor=True)
        self.check(k.details, "lbm", self.folder / "cell.json", "--voxel-size", 1e-3, "--tensor", "--fields", "none")
        self.assertAlmostEqual(k.tensor_m2[0][0] / k.tensor_m2[2][2], 1.0, places=3)

    def test_image(self):
        """Flow along the array's second axis, which is called z."""
        with self.assertWarnsRegex(porepack.PorePackWarning, "planes of constant pressure"):
            space = porepack.PoreSpace(gyroid(), voxel_size_m=1e-5, axes="xzy")
        image = ["--image-voxel-size", 1e-5, "--image-pore", 1, "--image-axes", "yzx", "--image-walls", "balls"]
        self.check(porepack.permeability(space).details, "lbm", self.folder / "gyroid.npy", *image, "--fields", "none")

    def test_gray_image(self):
        with self.assertWarns(porepack.PorePackWarning):
            space = porepack.PoreSpace(self.gray, voxel_size_m=5e-4, threshold="half_level")
        self.assertEqual(space.kind, "gray image")
        image = ["--image-voxel-size", 5e-4, "--image-threshold", "half_level", "--image-axes", "zyx"]
        self.check(porepack.tortuosity(space).details, "tortuosity", "diffusive", self.folder / "gray.npy", *image)

    def test_tortuosity_factor(self):
        found = porepack.tortuosity(porepack.PoreSpace(self.bed), 1e-3)
        self.check(found.details, "tortuosity", "diffusive", self.folder / "bed.json", "--voxel-size", 1e-3)

    def test_shortest_paths(self):
        found = porepack.tortuosity(porepack.PoreSpace(self.bed), 1e-3, kind="shortest_path")
        self.check(found.details, "tortuosity", "shortest_path", self.folder / "bed.json", "--voxel-size", 1e-3)

    def test_dots_of_the_paper(self):
        found = porepack.tortuosity(porepack.PoreSpace(self.bed), kind="geometric_paper", dot_spacing_m=0.004)
        self.check(found.details, "tortuosity", "geometric_paper", self.folder / "bed.json", "--dot-spacing", 0.004)

    def test_pores(self):
        found = porepack.pores(porepack.PoreSpace(self.bed), 1e-3)
        self.check(found.details, "pores", self.folder / "bed.json", "--voxel-size", 1e-3)

    def test_surface(self):
        made = porepack.surface(self.bed, surface_deviation_m=5e-5)
        found = program("stl", self.folder / "bed.json", "--surface-deviation", 5e-5)
        self.assertEqual(len(made.faces), found["triangles"])
        self.assertAlmostEqual(made.volume_m3 / found["volume_m3"], 1.0, places=12)

    def test_pour(self):
        """A case poured by the program, and the same pour: the same file."""
        output = self.folder / "case"
        result = porepack.run_case(SOURCE / "cases" / "quickstart", "pack", output=output, set={"packing.grains": 12})
        keys = json.loads((output / "pack" / "manifest.json").read_text())["configuration"]
        given = {key: value for key, value in keys["packing"].items() if value not in ("auto", "", [])}
        vessel = porepack.Vessel(**{key: value for key, value in keys["container"].items() if value not in ("auto", "", [])})
        shape = porepack.Shape(**{key: value for key, value in keys["shape"].items() if value not in ("auto", "", [], False, {})})
        bed = porepack.pour(shape, vessel, **given)
        bed.write(self.folder / "again.json")
        self.assertEqual((self.folder / "again.json").read_bytes(), (output / "pack" / "packing.json").read_bytes())
        self.assertEqual(same(bed.report, result["pack"]), [])
        self.assertEqual(porepack.read_result(output), result)

    def test_shape(self):
        shape = porepack.Shape("dolos", sphericity=0.5, volume_m3=1e-7)
        self.check(shape.measures(), "shape", "dolos", "--sphericity", 0.5, "--volume", 1e-7)


if __name__ == "__main__":
    unittest.main()
