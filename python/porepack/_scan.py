"""Scans: grains that are separated, or fitted."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

from porepack._errors import UserError
from porepack._keys import sorted_by_table
from porepack._packing import Packing, Shape, Vessel
from porepack._pore_space import PoreSpace, checked_array, checked_size
from porepack._table import columns_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from porepack import _core

SEGMENT_KEYS = ("separation", "keep_cut_grains", "on_floor", "keep_cavities", "smallest_grain", "library")


class Segmentation:
    """A scan divided into grains; ``segment()`` makes it.

    Attributes
    ----------
    report : dict
        What ``porepack image segment`` reports: porosity, section_m, numbers of grains, ...
    grains : dict
        Columns of the grains: volume, place, kind, ... pandas takes it.
    """

    def __init__(self, core: _core.Segmented) -> None:
        self._core = core
        self.report: dict[str, Any] = core.report
        self.grains: dict[str, list[Any]] = columns_of(core.grains.splitlines())

    @property
    def labels(self) -> NDArray[Any]:
        """Number of the grain of each voxel [x, y, z]; 0: pores."""
        return self._core.labels

    @property
    def phases(self) -> NDArray[Any]:
        """The voxels [x, y, z]: 0 grain, 1 pore, 2 outside the vessel."""
        return self._core.phases

    @property
    def stones(self) -> list[tuple[NDArray[Any], NDArray[Any]]]:
        """Vertices in metres and triangles of each whole grain, with ``library=True``."""
        return self._core.stones

    def pore_space(self, **keys: Any) -> PoreSpace:
        """The pore space, with walls from the gray values.

        Parameters
        ----------
        **keys
            Of the tables [geometry] and [section]; the default section is the one that the scan shows completely.
        """
        found = sorted_by_table(keys, ("geometry", "section"))
        return PoreSpace._of(self._core.pore_space(found["geometry"], found["section"]))

    def write(self, folder: str | os.PathLike[str]) -> None:
        """Write gray.vti, pore.vti, labels.vti, solid.stl, tables and pictures, and the stones."""
        self._core.write(os.fspath(folder))

    def __repr__(self) -> str:
        grains, porosity = self.report["grains"], self.report["porosity"]
        told = "" if porosity is None else f", porosity {porosity:.4f}"
        return f"<Segmentation: {grains['kept']} grains, {grains['whole']} of them whole{told}>"


def segment(
    source: Any, voxel_size_m: float | None = None, *, vessel: Vessel | None = None, axes: str = "xyz", **keys: Any
) -> Segmentation:
    """Divide a scan into grains: threshold, cavities filled, grains separated, incomplete grains removed.

    Parameters
    ----------
    source : array or path
        Gray values [x, y, z], or an image of any format (docs/images.md).
    voxel_size_m : float
        Of an array, or of a file that does not state it.
    vessel : Vessel, optional
        That the scan shows; default: the box that it fills, or ``find_container=True``.
    axes : str
        Of an array: names of its axes in the order of the indices; "zyx" for a stack of slices.
    **keys
        separation, keep_cut_grains, on_floor, keep_cavities, smallest_grain, library (``porepack image segment --help``), and those of
        the table [image]: threshold (default "volume"), pore_side, ...

    Raises
    ------
    UserError
        No gray levels, or no grain, are found.
    """
    from porepack import _core

    steps = {key: value for key, value in keys.items() if key in SEGMENT_KEYS}
    image = {key: value for key, value in keys.items() if key not in SEGMENT_KEYS}
    scan, size = _scan_and_size(source, voxel_size_m, axes, image, "segment()")
    return Segmentation(_core.segment(scan, size, None if vessel is None else vessel._core, steps, image))


def fit(
    source: Any, shape: Shape, voxel_size_m: float | None = None, *, vessel: Vessel | None = None, axes: str = "xyz", **keys: Any
) -> Packing:
    """Find grains of known shape in a scan: a packing of exact poses.

    Parameters
    ----------
    source : array or path
        Gray values [x, y, z], or an image of any format (docs/images.md).
    shape : Shape
        Of the grains: unions of capsules; several for a mixture.
    voxel_size_m : float
        Of an array, or of a file that does not state it.
    vessel : Vessel, optional
        That the scan shows; default: the box that it fills, or ``find_container=True``.
    axes : str
        Of an array: names of its axes in the order of the indices.
    **keys
        Of the table [image]: threshold (default "volume"), fitted_sizes, ...

    Returns
    -------
    Packing
        Its ``report`` holds what ``porepack image fit`` reports, and "table": columns with the uncertainty of each grain.
    """
    from porepack import _core

    image = dict(keys)
    scan, size = _scan_and_size(source, voxel_size_m, axes, image, "fit()")
    packing, report, table = _core.fit(scan, size, shape._core, None if vessel is None else vessel._core, image)
    return Packing._of(packing, {**report, "table": columns_of(table.splitlines())})


def _scan_and_size(source: Any, voxel_size_m: float | None, axes: str, image: dict[str, Any], where: str) -> tuple[Any, float]:
    if isinstance(source, (str, os.PathLike)):
        if axes != "xyz":
            raise UserError("`axes` of a file go from the fastest on", where, fix="PoreSpace(file, ...) reads it as the program does")
        if voxel_size_m is not None:
            image["voxel_size_m"] = [voxel_size_m]
        return os.fspath(source), 0.0
    return checked_array(source, axes, where), checked_size(voxel_size_m, where)
