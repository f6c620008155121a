"""The pore space that the solvers use, and what is measured of it without a flow."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Dict, Sequence

from porepack._errors import UserError
from porepack._keys import keys as all_keys
from porepack._keys import refuse_without_effect, sorted_by_table
from porepack._packing import Packing, Vessel

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from porepack import _core

_OF_SURFACES = ("surface_deviation_m", "contact_gap_m", "slice_spacing_m", "slice_pixel_m")


class PoreSpace:
    """Pores between grains, inside a vessel, and the section of them that is evaluated.

    Parameters
    ----------
    source : Packing, array, surface or path
        A packing; an array [x, y, z] of NumPy; an object with ``vertices`` and ``faces`` in metres (of trimesh, or what ``surface()``
        returns), or a pair of such arrays; or a file: packing.json, an image (docs/images.md), or STL.
    voxel_size_m : float, optional
        Of an array, or of an image file that does not state it, in metres.
    vessel : Vessel, optional
        Needed for a surface. Of an array or an image, the box that it fills if not given.
    axes : str
        Of an array: the names of its axes in the order of the indices; "zyx" for a stack of slices as tifffile reads it.
    periodic : three bools, optional
        Of an array: sides of its box along x, y, z that are joined.
    unit_m : float
        Of an STL file: length of its unit in metres.
    **keys
        Of the tables [geometry] (section_m, trim_m, reservoir_m, film_thickness_m), [section] (ends, buffer_m) and [image] (pore,
        threshold, pore_side, ...): ``porepack.keys("image")``.

    Notes
    -----
    A boolean array is True in the pores; its walls are smoother than its voxels, and k has an interval (``walls="balls"``,
    docs/images.md). Of other values, ``pore=1`` (or a list of values) or ``threshold=`` says which are pores; with a threshold, walls
    come from the gray values. An array becomes one byte per voxel with ``walls="half_way"``, else two.

    Raises
    ------
    UserError
        What is given is not understood, with what is allowed.

    Examples
    --------
    >>> space = porepack.PoreSpace(array, voxel_size_m=1e-5)  # doctest: +SKIP
    """

    def __init__(
        self,
        source: Any,
        voxel_size_m: float | None = None,
        *,
        vessel: Vessel | None = None,
        axes: str = "xyz",
        periodic: Sequence[bool] | None = None,
        unit_m: float = 1.0,
        **keys: Any,
    ) -> None:
        found = sorted_by_table(keys, ("geometry", "section", "image"))
        refuse_without_effect(found["geometry"], "PoreSpace()", _OF_SURFACES)
        refuse_without_effect(found["image"], "PoreSpace()", ("fit", "fitted_sizes", "fit_memory_bytes"), "porepack.fit() finds grains")
        surface = _surface_arrays(source)
        is_file, is_packing = isinstance(source, (str, os.PathLike)), isinstance(source, Packing)
        is_array = not (is_file or is_packing or surface)
        sides = None if periodic is None else tuple(bool(side) for side in periodic)
        _refuse_without_effect(is_array, is_file, voxel_size_m=voxel_size_m, axes=axes, periodic=sides, unit_m=unit_m)
        if found["image"] and not (is_array or is_file):
            raise UserError(
                f"`{next(iter(found['image']))}` has no effect here",
                "PoreSpace()",
                "keys of images for arrays and image files",
                "remove it",
            )
        if is_packing:
            self._core = _of_packing(source, vessel, found)
        elif surface:
            self._core = _of_surface(*surface, vessel, found)
        elif is_file:
            self._core = _of_file(source, voxel_size_m, vessel, unit_m, found)
        else:
            self._core = _of_array(source, voxel_size_m, vessel, axes, sides, found)

    @classmethod
    def _of(cls, core: _core.PoreSpace) -> PoreSpace:
        space = cls.__new__(cls)
        space._core = core
        return space

    @property
    def vessel(self) -> Vessel:
        """What the pore space lies in."""
        return Vessel._of(self._core.vessel)

    @property
    def section_m(self) -> tuple[float, float]:
        """Heights of the two planes between which the pore space is evaluated, in metres."""
        return self._core.section_m

    @property
    def kind(self) -> str:
        """What the solid is: "packing", "surface", "image" or "gray image"."""
        return self._core.kind

    def porosity(self) -> Porosity:
        """Pore volume of the section over its volume: exact along lines but for half-way walls, else of the voxels."""
        found = self._core.porosity()
        uncertainty = found["standard_uncertainty"]
        return Porosity(found["value"], uncertainty if uncertainty >= 0.0 else None)

    def voxels(self, voxel_size_m: float = 0.0) -> NDArray[Any]:
        """The section as an array [x, y, z] of bytes: 0 grain, 1 pore, 2 outside the vessel.

        Parameters
        ----------
        voxel_size_m : float
            Adjusted so that the section is a whole number of voxels; 0: a tenth of the grain's thickness, or the image's own.
        """
        return self._core.voxels(voxel_size_m)[0]

    def __repr__(self) -> str:
        low, high = self.section_m
        article = "an" if self.kind == "image" else "a"
        return f"<PoreSpace of {article} {self.kind} in {self.vessel}: section {low:.4g} to {high:.4g} m, {self.porosity()}>"

    def _repr_html_(self) -> str:
        from html import escape

        from porepack._picture import section_html

        low, high = self.vessel.bounds_m
        bottom, top = self.section_m
        size = max(high[0] - low[0], high[1] - low[1], top - bottom) / 120.0
        return section_html(self.voxels(size if self.kind in ("packing", "surface") else 0.0), escape(repr(self)))


@dataclass(frozen=True)
class Porosity:
    """Pore volume over volume.

    Attributes
    ----------
    value : float
        The porosity of the section.
    standard_uncertainty : float or None
        Of the integration; None: not known (an image without gray walls).
    """

    value: float
    standard_uncertainty: float | None

    @property
    def interval(self) -> tuple[float, float] | None:
        """Of 95 %; None where no uncertainty is known."""
        if self.standard_uncertainty is None:
            return None
        return self.value - 2.0 * self.standard_uncertainty, self.value + 2.0 * self.standard_uncertainty

    def __float__(self) -> float:
        return self.value

    def __str__(self) -> str:
        if self.standard_uncertainty is None:
            return f"porosity {self.value:.4f} (no uncertainty known)"
        return f"porosity {self.value:.4f} ± {2.0 * self.standard_uncertainty:.1g} (95 %)"


@dataclass(frozen=True, repr=False)
class Surface:
    """The closed surface of all grains.

    Attributes
    ----------
    vertices : array (n, 3)
        In metres.
    faces : array (m, 3)
        Numbers of the vertices of each triangle, counter-clockwise from outside.
    largest_deviation_m : float
        From the exact grains, measured.
    volume_m3, area_m2 : float
        Of the triangles.
    """

    vertices: NDArray[Any]
    faces: NDArray[Any]
    largest_deviation_m: float
    volume_m3: float
    area_m2: float

    def __repr__(self) -> str:
        return (
            f"<Surface of {len(self.faces)} triangles: volume {self.volume_m3:.4g} m³, area {self.area_m2:.4g} m², "
            f"within {self.largest_deviation_m:.2g} m of the grains>"
        )


def surface(packing: Packing, **keys: Any) -> Surface:
    """The grains as one closed surface, made by CGAL; trimesh takes it as ``trimesh.Trimesh(s.vertices, s.faces)``.

    Parameters
    ----------
    packing : Packing
        The grains.
    **keys
        Of the table [geometry]: surface_deviation_m, contact_gap_m.

    Raises
    ------
    NumericalError
        No closed surface was found.
    """
    from porepack import _core

    refuse_without_effect(keys, "surface()", tuple(key.name for key in all_keys("geometry") if key.name not in _OF_SURFACES[:2]))
    made = _core.surface_of_packing(packing._core, keys)
    return Surface(made["vertices_m"], made["triangles"], made["largest_deviation_m"], made["volume_m3"], made["area_m2"])


_Tables = Dict[str, Dict[str, Any]]


def _of_packing(packing: Packing, vessel: Vessel | None, found: _Tables) -> _core.PoreSpace:
    from porepack import _core

    if vessel is not None:
        raise UserError("a packing has its own vessel", "PoreSpace()", fix="remove `vessel`")
    return _core.space_of_packing(packing._core, found["geometry"], found["section"])


def _of_surface(vertices: Any, triangles: Any, vessel: Vessel | None, found: _Tables) -> _core.PoreSpace:
    from porepack import _core

    if vessel is None:
        raise UserError("a surface needs a vessel", "PoreSpace()", fix='vessel=porepack.Vessel("box", size_m=[...])')
    return _core.space_of_surface(vertices, triangles, vessel._core, found["geometry"], found["section"])


def _of_file(file: Any, voxel_size_m: float | None, vessel: Vessel | None, unit_m: float, found: _Tables) -> _core.PoreSpace:
    from porepack import _core

    image = found["image"] if voxel_size_m is None else {**found["image"], "voxel_size_m": [voxel_size_m]}
    core_vessel = None if vessel is None else vessel._core
    return _core.space_of_file(os.fspath(file), core_vessel, unit_m, found["geometry"], found["section"], image)


def _of_array(
    source: Any, voxel_size_m: float | None, vessel: Vessel | None, axes: str, sides: tuple[bool, ...] | None, found: _Tables
) -> _core.PoreSpace:
    from porepack import _core

    image = dict(found["image"])
    refuse_without_effect(image, "PoreSpace()", ("file", "dims", "type", "byte_order", "header_bytes", "field"))
    array = checked_array(source, axes, "PoreSpace()")
    size_m = checked_size(voxel_size_m, "PoreSpace()")
    if array.dtype == bool and not {"pore", "threshold"} & image.keys():
        if array.all() or not array.any():
            what = "all" if array.all() else "nothing"
            raise UserError(f"{what} of the array is pore", "PoreSpace()", "a mask that is True in the pores")
        image["pore"] = 1
        image.setdefault("walls", "balls")
    core_vessel = None if vessel is None else vessel._core
    return _core.space_of_array(
        array, size_m, None if sides is None else list(sides), core_vessel, found["geometry"], found["section"], image
    )


def _surface_arrays(source: Any) -> tuple[Any, Any] | None:
    """Vertices and triangles of a surface; None: it is none."""
    if isinstance(source, tuple) and len(source) == 2:
        return source
    if hasattr(source, "vertices") and hasattr(source, "faces"):
        return source.vertices, source.faces
    return None


def checked_array(source: Any, axes: str, where: str) -> NDArray[Any]:
    """An array of three axes in the order x, y, z and of native byte order; UserError for anything else."""
    import numpy

    if not hasattr(source, "__array__") and not isinstance(source, (list, tuple)):
        raise UserError(
            f"a {type(source).__name__} is no pore space",
            where,
            "a Packing, an array of NumPy, a surface (an object with vertices and faces, or both as a pair), or the name of a file",
        )
    array = numpy.asarray(source)
    if array.ndim != 3:
        raise UserError(
            f"the array has {array.ndim} axes",
            where,
            "an array [x, y, z]",
            "one slice: array[:, :, None], periodic=(False, False, True)",
        )
    if 0 in array.shape:
        raise UserError(f"the array of shape {array.shape} holds no voxel", where)
    if sorted(axes) != ["x", "y", "z"]:
        raise UserError(f"axes = {axes!r}", where, 'x, y and z once each, in the order of the array\'s indices: "zyx"')
    if not array.dtype.isnative:
        array = array.astype(array.dtype.newbyteorder("="))
    return array.transpose([axes.index(axis) for axis in "xyz"])


def checked_size(voxel_size_m: float | None, where: str) -> float:
    """The voxel size of an array, which must be given."""
    if voxel_size_m is None or not 0.0 < voxel_size_m < float("inf"):
        raise UserError(f"voxel_size_m = {voxel_size_m}", where, "the edge length of a voxel in metres, as 1e-5")
    return float(voxel_size_m)


def _refuse_without_effect(is_array: bool, is_file: bool, **given: Any) -> None:
    """A parameter that would change nothing is an error."""
    used = {"voxel_size_m": is_array or is_file, "axes": is_array, "periodic": is_array, "unit_m": is_file}
    unset = {"voxel_size_m": None, "axes": "xyz", "periodic": None, "unit_m": 1.0}
    for name, value in given.items():
        if value != unset[name] and not used[name]:
            raise UserError(f"`{name}` has no effect here", "PoreSpace()", fix="remove it")
