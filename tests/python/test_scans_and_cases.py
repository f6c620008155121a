"""Scans, falling heads, cases and studies: the program's numbers, and what Python adds."""

import csv
import math
import pathlib
import shutil
import tempfile
import unittest
import warnings

import numpy

import porepack
from support import SOURCE, pebbles, pebbles_in_gray, program, same


class Scans(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.scratch.name)
        cls.gray = pebbles_in_gray(pebbles())
        numpy.save(cls.folder / "scan.npy", cls.gray)
        cls.flags = ["--image-voxel-size", 5e-4, "--image-axes", "zyx"]

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    def quietly(self, function, *arguments, **keys):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return function(*arguments, **keys)

    def different(self, report, found):
        """But for what names the source."""
        return [line for line in same(report, found) if not line.startswith(("/format", "/orientation", "/voxel_size_from"))]

    def test_segmented(self):
        found = self.quietly(porepack.segment, self.gray, 5e-4, library=True, keep_cut_grains=True)
        expected = program("image", "segment", self.folder / "scan.npy", *self.flags, "--keep-cut-grains", "--library")
        self.assertEqual(self.different(found.report, expected), [])
        self.assertEqual(found.labels.shape, self.gray.shape)
        self.assertEqual(found.labels.max(), len(found.grains["grain"]))
        self.assertTrue(((found.phases == 0) <= (found.labels > 0)).all())
        self.assertEqual(len(found.stones), found.report["library"]["stones"])
        space = self.quietly(found.pore_space)
        self.assertEqual(space.kind, "gray image")
        # As read from the file that it writes.
        found.write(self.folder / "segmented")
        again = self.quietly(porepack.PoreSpace, self.folder / "segmented" / "gray.vti")
        self.assertEqual(again.porosity(), space.porosity())

    def test_fitted(self):
        ball = porepack.Shape("sphere", diameter_m=0.01)
        found = self.quietly(porepack.fit, self.gray, ball, 5e-4)
        expected = program("image", "fit", self.folder / "scan.npy", *self.flags, "--shape", "sphere", "--diameter", 0.01)
        report = {key: value for key, value in found.report.items() if key not in ("table", "search_s", "poses_s")}
        expected = {key: value for key, value in expected.items() if key not in ("search_s", "poses_s")}
        self.assertEqual(self.different(report, expected), [])
        self.assertEqual(len(found), len(found.report["table"]["x_m"]))


class FallingHeads(unittest.TestCase):
    ANALYSED = {"sample_length_m": 0.1, "window_m": [0.1, 1.3]}
    KEYS = {"start_level_m": 1.6, **ANALYSED}

    def test_simulated_and_analysed(self):
        test = porepack.falling_head(8.9e-7, 3.9e-3, curve=True, noise_m=1e-4, **self.KEYS)
        flags = ["--sample-length", 0.1, "--window", "0.1,1.3"]
        expected = program(
            "falling-head",
            "simulate",
            "--permeability",
            8.9e-7,
            "--inertial-permeability",
            3.9e-3,
            "--noise",
            1e-4,
            "--start-level",
            1.6,
            *flags,
        )
        self.assertEqual(same(test.details, expected), [])
        with tempfile.TemporaryDirectory() as folder:
            curve = pathlib.Path(folder) / "curve.csv"
            with curve.open("w", newline="") as out:
                csv.writer(out).writerows([("time_s", "level_m"), *zip(test.curve["time_s"], test.curve["level_m"])])
            of_arrays = porepack.analyse_falling_head([(test.curve["time_s"], numpy.array(test.curve["level_m"]))], **self.ANALYSED)
            of_file = porepack.analyse_falling_head([curve], **self.ANALYSED)
            expected = program("falling-head", "analyse", curve, *flags)
        self.assertEqual(same(of_file, expected), [])
        fitted = of_arrays["packings"][0]["least_squares"]
        self.assertEqual(fitted, of_file["packings"][0]["least_squares"])
        low, high = fitted["permeability_interval_m2"]
        self.assertTrue(low < 8.9e-7 < high, fitted)

    def test_darcy_alone(self):
        test = porepack.falling_head(1e-9, math.inf, levels_m=[0.5], **self.KEYS)
        # h + L falls exponentially, with g k / (nu L).
        time = 1e-6 * 0.1 / (9.81 * 1e-9) * math.log(1.7 / 0.6)
        self.assertAlmostEqual(test.times_darcy_forchheimer_s[0] / time, 1.0, places=9)

    def test_bad_curves(self):
        with self.assertRaisesRegex(porepack.UserError, "2 times and 1 levels"):
            porepack.analyse_falling_head([([0, 1], [1])])
        with self.assertRaisesRegex(porepack.UserError, "does not follow"):
            porepack.analyse_falling_head([([0, 0], [1, 0.5])])
        with self.assertRaisesRegex(porepack.UserError, "there is no curve"):
            porepack.analyse_falling_head([])


class Cases(unittest.TestCase):
    def test_study(self):
        with tempfile.TemporaryDirectory() as scratch:
            folder = pathlib.Path(scratch)
            shutil.copy(SOURCE / "cases" / "sphere_array" / "packing.json", folder)
            case = (SOURCE / "cases" / "sphere_array" / "case.toml").read_text()
            (folder / "case.toml").write_text(case)
            (folder / "study.toml").write_text('up_to = "voxelise"\n[[axis]]\nkey = "geometry.voxel_size_m"\nvalues = [4e-3, 5e-3]\n')
            study = porepack.Study(folder)
            self.assertEqual([point["state"] for point in study.status()], ["missing", "missing"])
            self.assertEqual(study.table(), {})
            done = study.run()
            self.assertEqual((len(done["done"]), done["failed"]), (2, []))
            self.assertEqual(study.table()["geometry.voxel_size_m"], [4e-3, 5e-3])
            self.assertIn("2 points, 2 done", repr(study))

    def test_a_case_that_fails(self):
        with self.assertRaisesRegex(porepack.UserError, "names no table"):
            porepack.run_case(SOURCE / "cases" / "quickstart", set={"grains": 3}, output="/nowhere")
        with self.assertRaisesRegex(porepack.UserError, "folder of their own"):
            porepack.run_case(SOURCE / "cases" / "quickstart", set={"packing.grains": 3})
        with self.assertRaises(porepack.UserError):
            porepack.Study(SOURCE / "cases" / "quickstart")


if __name__ == "__main__":
    unittest.main()
