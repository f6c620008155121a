"""Examples beside packages of PyPI, and the notebooks, run as a user would: with the Python of build/venv (requirements-test.txt)."""

import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

SOURCE = pathlib.Path(os.environ["POREPACK_SOURCE_FOLDER"])
EXAMPLES = SOURCE / "examples" / "python"
NUMBER = r"([0-9.]+(?:e-?[0-9]+)?)"


class Bridges(unittest.TestCase):
    """Each example in a folder of its own, which is removed."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def output(self, command):
        done = subprocess.run(command, cwd=self.folder, capture_output=True, text=True, check=False, stdin=subprocess.DEVNULL)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def run_example(self, name, *arguments):
        return self.output([sys.executable, "-W", "ignore", EXAMPLES / "bridges" / f"{name}.py", *arguments])

    def number(self, pattern, text):
        found = re.search(pattern.replace("#", NUMBER), text)
        self.assertIsNotNone(found, f"{pattern} in {text}")
        return float(found[1])

    def assert_interval(self, text):
        found = re.search(rf"permeability {NUMBER} m² \({NUMBER} to {NUMBER}, numerical, 95 %\)", text)
        self.assertIsNotNone(found, text)
        value, low, high = map(float, found.groups())
        self.assertLess(low, value)
        self.assertLess(value, high)
        return value

    def test_porespy_makes_an_image(self):
        text = self.run_example("porespy_image")
        counted, measured = self.number("porosity # by counting", text), self.number("; porosity #", text)
        self.assertAlmostEqual(counted, measured, delta=0.003)  # the walls keep the volume of the voxels
        self.assert_interval(text)

    def test_openpnm_has_a_network_of_the_image(self):
        text = self.run_example("openpnm_network")
        network, flow = self.number("of the network #", text), self.assert_interval(text)
        self.assertLess(max(network / flow, flow / network), 4.0)  # pores as pyramids and throats as boxes: a model of the image

    def test_tifffile_reads_a_stack(self):
        text = self.run_example("tifffile_stack")
        self.assertLess(0.5, self.number("porosity #", text))
        self.assert_interval(text)

    def test_trimesh_takes_and_gives_surfaces(self):
        text = self.run_example("trimesh_surfaces")
        self.assertIn("closed: True", text)
        grain = 3.1416 * 0.002**2 * 0.008 + 4.1888 * 0.002**3  # a capsule with an axis of 8 mm
        self.assertAlmostEqual(self.number("volume # m³", text) / (30 * grain), 1.0, delta=0.02)  # facets; contacts are joined
        self.assert_interval(text)

    def test_pyvista_shows_the_flow(self):
        text = self.run_example("pyvista_view")
        self.assertLess(20, self.number("cells, # streamlines", text))
        import matplotlib.image

        picture = matplotlib.image.imread(self.folder / "flow.png")[..., :3]
        grains = (abs(picture - [0.64, 0.55, 0.43]) < 0.2).all(axis=-1)  # about tan, in light and shadow
        self.assertLess(0.05, grains.mean())

    def test_pandas_holds_the_table_of_a_study(self):
        text = self.run_example("pandas_study", SOURCE / "cases" / "paper_study")
        for kind in ("dolos", "tetrahedron", "tetrapod"):
            self.assertRegex(text, rf"{kind} +8\.0 ")

    def test_matplotlib_draws_the_flow(self):
        self.assert_interval(self.run_example("matplotlib_plots"))
        self.assertLess(10000, (self.folder / "plots.png").stat().st_size)

    def test_notebooks_run(self):
        for name in ("first_bed", "own_scan"):
            notebook = EXAMPLES / "notebooks" / f"{name}.ipynb"
            self.output([sys.executable, "-m", "nbconvert", "--to", "html", "--execute", "--output-dir", self.folder, notebook])
            page = (self.folder / f"{name}.html").read_text(encoding="utf-8")
            self.assert_interval(page)
            self.assertIn('src="data:image/png', page)
            self.assertNotIn("s left", page)  # progress leaves nothing

    def test_taufactor_finds_the_same_tortuosity_factor(self):
        packages = os.environ["POREPACK_TAUFACTOR"]  # beside Debian's torch
        environment = {**os.environ, "PYTHONPATH": f"{os.environ['PYTHONPATH']}:{packages}"}
        command = ["/usr/bin/python3", "-W", "ignore", EXAMPLES / "bridges" / "taufactor_tau.py"]
        done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
        self.assertEqual(done.returncode, 0, done.stderr)
        theirs, ours = self.number("taufactor: #", done.stdout), self.number("half_way: tortuosity factor #", done.stdout)
        self.assertAlmostEqual(theirs, ours, delta=0.001)  # taufactor stops at 0.1 %
        self.assertLess(self.number("balls: tortuosity factor #", done.stdout), 0.98 * ours)  # without the steps of voxels


if __name__ == "__main__":
    unittest.main()
