"""What a host program relies on: messages, Ctrl-C, threads, memory, progress, help."""

import dataclasses
import inspect
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import warnings

import numpy

import porepack
from support import array_of_spheres, gyroid, pebbles

PERIODIC = {"periodic": (True, True, True)}


class Messages(unittest.TestCase):
    def refused(self, function, fault, *, kind=porepack.UserError, fix="", where=""):
        with self.assertRaisesRegex(kind, fault) as caught:
            function()
        self.assertIn(fix, caught.exception.fix)
        self.assertIn(where, caught.exception.where)
        self.assertNotIn("--", str(caught.exception))  # keys of Python, no flags of the program

    def test_arrays(self):
        mask = gyroid()
        space = porepack.PoreSpace
        self.refused(lambda: space(mask), "voxel_size_m = None", where="PoreSpace()")
        self.refused(lambda: space(mask, -1e-5), "voxel_size_m = -1e-05")
        self.refused(lambda: space(mask[0], 1e-5), "the array has 2 axes", fix="array[:, :, None]")
        self.refused(lambda: space(mask[:0], 1e-5), "holds no voxel")
        self.refused(lambda: space(numpy.zeros_like(mask), 1e-5), "nothing of the array is pore")
        self.refused(lambda: space(~numpy.zeros_like(mask), 1e-5), "all of the array is pore")
        self.refused(lambda: space(mask.astype(int), 1e-5), "which values are pores", fix="pore=0")
        self.refused(lambda: space(mask.astype(float), 1e-5), "which values are pores", fix="pore=0")
        self.refused(lambda: space(mask.astype(complex), 1e-5, pore=1), "of the type complex128", fix="astype")
        self.refused(lambda: space(numpy.where(mask, numpy.nan, 1.0), 1e-5, threshold=0.5), "not finite", fix="nan_to_num")
        self.refused(lambda: space(mask * (1 << 30), 1e-5, pore=0), "the value 1073741824", fix="array == value")
        self.refused(lambda: space(mask, 1e-5, axes="xyy"), "axes = 'xyy'")
        self.refused(lambda: space(mask, 1e-5, unit_m=0.001), "`unit_m` has no effect", fix="remove it")
        self.refused(lambda: space(mask, 1e-5, poor=1), "unknown key `poor`")
        self.refused(lambda: space(mask, 1e-5, threshold=1, pore=1), "`threshold` has no effect")
        self.refused(lambda: space(3.0, 1e-5), "a float is no pore space")
        self.refused(lambda: space("nowhere.npy"), "no such image")

    def test_shapes_vessels_and_packings(self):
        ball, tube = porepack.Shape("sphere", diameter_m=0.01), porepack.Vessel("cylinder", diameter_m=0.04, height_m=0.1)
        self.refused(lambda: porepack.Shape("tetrapd"), "is not known", fix='"tetrapod"', where="Shape()")
        self.refused(lambda: porepack.Shape("sphere", diametre_m=1), "unknown key `diametre_m`", fix="`diameter_m`")
        self.refused(lambda: porepack.Shape("sphere", diameter_m="thin"), "is not a number")
        self.refused(lambda: porepack.Shape("sphere", diameter_m=float("nan")), "is not finite")
        self.refused(lambda: porepack.Shape("sphere", diameter_m=object()), "of the type object")
        self.refused(lambda: porepack.Vessel("cylinder", diameter_m=0.1), "height_m")
        self.refused(lambda: porepack.pour(porepack.Shape("sphere", diameter_m=1.0), tube, 3), "too large for the container")
        self.refused(lambda: porepack.pour(ball, tube, 3, protocol=[{"kind": "tip"}]), "is not known", where="pour()")
        self.refused(lambda: porepack.Packing(ball, tube, [[0, 0, 0.01], [0, 0, 0.012]]), "overlap by 0.008 m")
        self.refused(lambda: porepack.Packing(ball, tube, [0, 0, 0.01]), "does not hold the positions")
        self.refused(lambda: porepack.Packing(ball, tube, [[0, 0, 0.01]], [[2, 0, 0, 0]]), "the pose of grain 0")
        self.refused(lambda: porepack.PoreSpace(([[0, 0, 0]], [[0, 0, 1]]), vessel=tube), "triangle 0 has the vertex 1")
        self.refused(lambda: porepack.read_result(tempfile.gettempdir()), "there are no results")
        self.refused(lambda: porepack.Packing.read("nowhere.json"), "nowhere.json")

    def test_flows(self):
        space = porepack.PoreSpace(gyroid(), 1e-5, **PERIODIC)
        self.refused(lambda: porepack.permeability(space, tolerence=0.1), "unknown key `tolerence`", fix="`tolerance`")
        self.refused(lambda: porepack.permeability(space, grids=2.5), "not a whole number", where="permeability()")
        self.refused(lambda: porepack.tortuosity(space, kind="tortuous"), "no tortuosity is called tortuous")
        closed = numpy.ones((8, 8, 8), bool)
        closed[:, :, 3] = False
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            walled = porepack.PoreSpace(closed, 1e-5)
        self.refused(lambda: porepack.permeability(walled), "", kind=porepack.NumericalError)

    def test_keys_without_effect(self):
        space, bed = porepack.PoreSpace(gyroid(), 1e-5, **PERIODIC), array_of_spheres()
        for function in (
            lambda: porepack.permeability(space, fields="vti"),
            lambda: porepack.tortuosity(space, dot_spacing_m=1e-3),
            lambda: porepack.tortuosity(space, diffusive=False),
            lambda: porepack.PoreSpace(bed, slice_pixel_m=1e-3),
            lambda: porepack.PoreSpace(bed, pore=1),
            lambda: porepack.PoreSpace(bed, voxel_size_m=1e-3),
            lambda: porepack.PoreSpace(gyroid(), 1e-5, dims=[1, 1, 1]),
            lambda: porepack.surface(bed, voxel_size_m=1e-3),
            lambda: porepack.falling_head(1e-9, scale_uncertainty=0.1),
            lambda: porepack.analyse_falling_head([], noise_m=0.1),
        ):
            self.refused(function, "has no effect here")

    def test_kinds_are_those_of_python(self):
        self.assertTrue(issubclass(porepack.UserError, ValueError))
        self.assertTrue(issubclass(porepack.NumericalError, ArithmeticError))
        self.assertEqual(porepack.UserError.__module__, "porepack")


class Arrays(unittest.TestCase):
    def test_layout_and_type_do_not_matter(self):
        mask = gyroid()
        mask[3:9, 5, :] = False  # the axes differ
        half_way = {**PERIODIC, "walls": "half_way"}
        expected = porepack.permeability(porepack.PoreSpace(mask, 1e-5, **half_way)).value_m2
        swapped = mask.transpose(2, 1, 0)
        for array, keys in (
            (numpy.asfortranarray(mask), {}),
            (numpy.repeat(mask, 2, axis=0)[::2], {}),
            (mask.astype(">i4"), {"pore": 1}),
            (mask.astype(numpy.int64) * 7, {"pore": 7}),
            (mask.astype(numpy.float32), {"threshold": 0.5, "pore_side": "above"}),
            (swapped, {"axes": "zyx"}),
        ):
            space = porepack.PoreSpace(array, 1e-5, **half_way, **keys)
            self.assertEqual(porepack.permeability(space).value_m2, expected)
        numpy.testing.assert_array_equal(porepack.PoreSpace(mask, 1e-5, **PERIODIC).voxels(), mask.astype(numpy.uint8))

    def test_walls_of_a_mask(self):
        """By default around the largest balls: an interval, and the phases of the array."""
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # nothing of it is thin
            space = porepack.PoreSpace(gyroid(), 1e-5, **PERIODIC)
        k = porepack.permeability(space)
        half_way = porepack.permeability(porepack.PoreSpace(gyroid(), 1e-5, **PERIODIC, walls="half_way"))
        self.assertEqual(space.kind, "image")
        self.assertTrue(k.interval_m2[0] < k.value_m2 < k.interval_m2[1])
        self.assertIn("places of the walls", k.interval_meaning)
        self.assertIsNone(half_way.interval_m2)
        self.assertAlmostEqual(space.porosity().value, 0.5, delta=0.005)
        numpy.testing.assert_array_equal(space.voxels() == 1, gyroid())
        # Of the gyroid's other half, which is its mirror image, the same k.
        other = porepack.permeability(porepack.PoreSpace(~gyroid(), 1e-5, **PERIODIC))
        self.assertAlmostEqual(other.value_m2 / k.value_m2, 1.0, delta=0.02)

    def test_a_mask_of_noise_has_a_k(self):
        """Single voxels: too thin for coarser grids, so no interval, and it is said."""
        for part in (0.8, 0.97):
            mask = numpy.random.default_rng(2).random((20, 20, 20)) < part
            with self.assertWarnsRegex(porepack.PorePackWarning, "one or two voxels wide"):
                space = porepack.PoreSpace(mask, 1e-5, **PERIODIC)
            k = porepack.permeability(space)
            self.assertTrue(k.converged)
            self.assertIsNone(k.interval_m2)
            half_way = porepack.permeability(porepack.PoreSpace(mask, 1e-5, **PERIODIC, walls="half_way"))
            self.assertAlmostEqual(k.value_m2 / half_way.value_m2, 1.0, delta=0.5)

    def test_thin_parts_are_said(self):
        thin = gyroid()
        thin[::4] = False
        thin[1::4] = True
        with self.assertWarnsRegex(porepack.PorePackWarning, "one or two voxels wide"):
            porepack.PoreSpace(thin, 1e-5, **PERIODIC)

    def test_flow_field(self):
        k = porepack.permeability(porepack.PoreSpace(gyroid(), 1e-5, **PERIODIC), flow=True, superficial_velocity_m_per_s=2e-4)
        self.assertEqual(k.flow.velocity_m_per_s.shape, (24, 24, 24, 3))
        self.assertTrue((k.flow.phase == gyroid()).all())
        through = k.flow.velocity_m_per_s[..., 2].mean(axis=(0, 1))
        numpy.testing.assert_allclose(through, 2e-4, rtol=1e-3)
        self.assertEqual(float(abs(k.flow.velocity_m_per_s[~gyroid()]).max()), 0.0)
        self.assertIsNone(porepack.permeability(porepack.PoreSpace(gyroid(), 1e-5, **PERIODIC)).flow)

    def test_poses(self):
        cell = array_of_spheres()
        again = porepack.Packing(porepack.Shape("sphere", diameter_m=0.008), cell.vessel, cell.positions_m, cell.orientations)
        numpy.testing.assert_array_equal(again.positions_m, cell.positions_m)
        self.assertAlmostEqual(porepack.PoreSpace(again).porosity().value, 1.0 - 2.0 * numpy.pi / 6.0 * 0.8**3, delta=2e-4)
        self.assertEqual(len(again), 2)

    def test_surface_in_and_out(self):
        bed = pebbles()
        made = porepack.surface(bed)
        section = [0.01, 0.03]
        of_surface = porepack.PoreSpace(made, vessel=bed.vessel, section_m=section)
        self.assertEqual(of_surface.kind, "surface")
        exact = porepack.PoreSpace(bed, section_m=section).porosity().value
        self.assertAlmostEqual(of_surface.porosity().value, exact, delta=0.005)


class Host(unittest.TestCase):
    def test_interrupted_within_a_second(self):
        """Ctrl-C, sent to a process that computes: KeyboardInterrupt, no child is left, and the next call works."""
        script = (
            "import numpy, os, porepack, sys, time\n"
            "mask = numpy.random.default_rng(1).random((90, 90, 90)) < 0.7\n"
            "space = porepack.PoreSpace(mask, 1e-5, periodic=(True,) * 3, walls='half_way')\n"
            "print('begins', flush=True)\n"
            "try:\n"
            "    porepack.permeability(space, iteration_tolerance=1e-12)\n"
            "except KeyboardInterrupt:\n"
            "    print('interrupted', os.path.exists(f'/proc/{os.getpid()}/task/{os.getpid()}/children') and\n"
            "          open(f'/proc/{os.getpid()}/task/{os.getpid()}/children').read(), flush=True)\n"
            "    print(space.porosity(), flush=True)\n"
        )
        # A shell that runs this in the background lets it ignore the signal, and children inherit that.
        listen = lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)
        child = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True, preexec_fn=listen)
        self.assertEqual(child.stdout.readline(), "begins\n")
        time.sleep(2.0)
        child.send_signal(signal.SIGINT)
        sent = time.monotonic()
        self.assertEqual(child.stdout.readline().split(), ["interrupted"])
        self.assertLess(time.monotonic() - sent, 5.0)  # a second on an idle machine
        self.assertRegex(child.stdout.readline(), "^porosity 0.(69|70)")
        child.stdout.close()
        self.assertEqual(child.wait(), 0)

    def test_two_threads_and_a_free_interpreter(self):
        space = porepack.PoreSpace(gyroid(), 1e-5, **PERIODIC)
        expected = porepack.permeability(space).value_m2
        found, counted = [], [0]
        workers = [threading.Thread(target=lambda: found.append(porepack.permeability(space).value_m2)) for _ in range(2)]
        for worker in workers:
            worker.start()
        while any(worker.is_alive() for worker in workers):
            counted[0] += 1
            time.sleep(0.001)
        self.assertEqual(found, [expected, expected])
        self.assertGreater(counted[0], 10)

    def test_progress(self):
        seen = []
        porepack.set_progress(lambda label, fraction, seconds, detail: seen.append((label, fraction, seconds)))
        try:
            pebbles()
            self.assertTrue(seen)
            self.assertTrue(all(0.0 <= fraction <= 1.0 for _, fraction, _ in seen))

            def stop(*_):
                raise RuntimeError("enough")

            porepack.set_progress(stop)
            self.assertRaisesRegex(RuntimeError, "enough", pebbles)
        finally:
            porepack.set_progress(True)

    def test_memory_does_not_grow(self):
        space = porepack.PoreSpace(gyroid(16), 1e-5, **PERIODIC)

        def resident():
            return int(pathlib.Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")

        for _ in range(20):
            porepack.permeability(space, flow=True)
        before = resident()
        for _ in range(100):
            porepack.permeability(space, flow=True)
        self.assertLess(resident() - before, 5e6)

    def test_an_array_costs_a_byte_per_voxel(self):
        script = (
            "import numpy, porepack, resource\n"
            "array = numpy.ones((300, 300, 300), bool)\n"
            "array[::7] = False\n"
            "porepack.PoreSpace(array[:8, :8, :8], 1e-5, periodic=(True,) * 3, walls='half_way')\n"
            "before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss\n"
            "space = porepack.PoreSpace(array, 1e-5, periodic=(True,) * 3, walls='half_way')\n"
            "print((resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) * 1024 / array.size)\n"
        )
        done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
        self.assertLess(float(done.stdout), 1.1)


class Help(unittest.TestCase):
    def test_every_public_name_is_explained(self):
        for name in porepack.__all__:
            thing = getattr(porepack, name)
            text = inspect.getdoc(thing) or ""
            self.assertGreater(len(text), 20, name)
            parameters = inspect.signature(thing).parameters if inspect.isfunction(thing) else {}
            for parameter in parameters:
                self.assertIn(parameter, text, f"{name}: {parameter} is not explained")
            if dataclasses.is_dataclass(thing):
                for field in dataclasses.fields(thing):
                    self.assertIn(field.name, text, f"{name}: {field.name} is not explained")

    def test_keys_are_those_of_the_program(self):
        self.assertIn("grid_ratio", [key.name for key in porepack.keys("lbm")])
        self.assertIn("voxel size", repr(porepack.keys("lbm")))

    def test_results_say_what_they_are(self):
        space = porepack.PoreSpace(gyroid(), 1e-5, **PERIODIC)
        k = porepack.permeability(space)
        self.assertIn("95 %", str(k))
        half_way = porepack.PoreSpace(gyroid(), 1e-5, **PERIODIC, walls="half_way")
        self.assertIn("no uncertainty", str(porepack.permeability(half_way)))
        self.assertIn("no uncertainty known", repr(half_way))
        for thing in (space, k, pebbles()):
            self.assertIn("<div>", thing._repr_html_())
        self.assertIn("image/png", space._repr_html_())


if __name__ == "__main__":
    unittest.main()
