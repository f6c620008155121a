"""Shapes, vessels and packings."""

from __future__ import annotations

import os
import tempfile
from typing import TYPE_CHECKING, Any, Iterable, Mapping, Sequence

from porepack._keys import refuse_without_effect

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from porepack import _core


class Shape:
    """The shape of a grain, or a mixture of several.

    Parameters
    ----------
    kind : str
        "tetrapod", "dolos", "tetrahedron", "star", "sphere", "rod", "cylinder", "ring", "box", "cube", "lobed", "prism", "capsules",
        "mesh" (a file), "library" (a folder of meshes) or "mixture".
    folder : path, optional
        Files of meshes are relative to it; default: the current folder.
    **keys
        Those of the table [shape] of case.toml, in metres: ``porepack.keys("shape")``.

    Raises
    ------
    UserError
        The keys do not determine a shape, or a mesh is faulty.

    Examples
    --------
    >>> porepack.Shape("tetrapod", sphericity=0.53, volume_m3=1e-7)  # doctest: +SKIP
    """

    def __init__(self, kind: str, *, folder: str | os.PathLike[str] = ".", **keys: Any) -> None:
        from porepack import _core

        self._core = _core.Shape({"kind": kind, **keys}, os.fspath(folder))

    @property
    def kind(self) -> str:
        """The kind that was given."""
        return self._core.kind

    @property
    def names(self) -> list[str]:
        """Of a mixture or a library, the names of its shapes."""
        return self._core.names

    def measures(self, density_kg_per_m3: float = 1000.0) -> dict[str, Any]:
        """Volume, surface, sphericity, convexity, inertia, with the keys of ``porepack shape``.

        Parameters
        ----------
        density_kg_per_m3 : float
            For mass and inertia.
        """
        return self._core.measures(density_kg_per_m3)

    def __repr__(self) -> str:
        measures = self.measures()
        volume = f"{measures['volume_m3']:.4g} m³"
        sphericity = f", sphericity {measures['sphericity']:.4f}" if "sphericity" in measures else ""
        return f"<Shape {self.kind}: volume {volume}{sphericity}>"


class Vessel:
    """The container of a packing; its floor is at z = 0, z is up.

    Parameters
    ----------
    kind : str
        "cylinder", "box", "annulus", "cone" or "mesh" (a closed surface of the inner space, in a file).
    folder : path, optional
        The file of a mesh is relative to it; default: the current folder.
    **keys
        Those of the table [container] of case.toml, in metres: ``porepack.keys("container")``.

    Examples
    --------
    >>> porepack.Vessel("cylinder", diameter_m=0.1, height_m=0.3)  # doctest: +SKIP
    """

    def __init__(self, kind: str, *, folder: str | os.PathLike[str] = ".", **keys: Any) -> None:
        from porepack import _core

        self._core = _core.Vessel({"kind": kind, **keys}, os.fspath(folder))

    @classmethod
    def _of(cls, core: _core.Vessel) -> Vessel:
        vessel = cls.__new__(cls)
        vessel._core = core
        return vessel

    @property
    def height_m(self) -> float:
        """Inner height in metres."""
        return self._core.height_m

    @property
    def area_m2(self) -> float:
        """Inner horizontal area in square metres, mean over the height."""
        return self._core.area_m2

    @property
    def bounds_m(self) -> tuple[list[float], list[float]]:
        """Lowest and highest corner of the inner space in metres."""
        return self._core.low_m, self._core.high_m

    @property
    def periodic(self) -> list[bool]:
        """Along x, y, z."""
        return self._core.periodic

    def wall_distance_m(self, point_m: Sequence[float]) -> float:
        """Distance of a point from the nearest side in metres; negative outside. Floor and opening do not count."""
        x, y, z = point_m
        return self._core.wall_distance(x, y, z)

    def __repr__(self) -> str:
        keys = dict(self._core.keys())
        kind = keys.pop("kind")
        return f"Vessel({', '.join([repr(kind)] + [f'{key}={_short(value)}' for key, value in keys.items()])})"


class Packing:
    """Grains in a vessel, at rest.

    ``pour()`` makes one; ``Packing.read()`` reads packing.json; the constructor takes poses.

    Parameters
    ----------
    shape : Shape
        Of the grains, or a mixture.
    vessel : Vessel
        Their container.
    positions_m : array (grains, 3)
        Of the origin of the shape's frame, in metres.
    orientations : array (grains, 4), optional
        Quaternions w, x, y, z from the shape's frame; default: not turned.
    shape_of : sequence of int, optional
        Number of each grain's shape in a mixture; default: 0.
    overlap_allowed : bool
        Grains may overlap at will (Boolean models).

    Raises
    ------
    UserError
        Grains overlap each other or a wall by more than a tenth of the thickness of the thinnest.
    """

    def __init__(
        self,
        shape: Shape,
        vessel: Vessel,
        positions_m: ArrayLike,
        orientations: ArrayLike | None = None,
        *,
        shape_of: Iterable[int] | None = None,
        overlap_allowed: bool = False,
    ) -> None:
        import numpy

        from porepack import _core

        positions = numpy.asarray(positions_m, dtype=float)
        count = len(positions) if positions.ndim else 0
        turns = [[1.0, 0.0, 0.0, 0.0]] * count if orientations is None else orientations
        shapes = [0] * count if shape_of is None else [int(n) for n in shape_of]
        self._core = _core.Packing(shape._core, vessel._core, positions, numpy.asarray(turns, dtype=float), shapes, overlap_allowed)
        self.report: dict[str, Any] = {}

    @classmethod
    def _of(cls, core: _core.Packing, report: dict[str, Any] | None = None) -> Packing:
        packing = cls.__new__(cls)
        packing._core = core
        packing.report = report or {}
        return packing

    @classmethod
    def read(cls, file: str | os.PathLike[str]) -> Packing:
        """Read packing.json or packing.json.gz; UserError names the place of a fault."""
        from porepack import _core

        return cls._of(_core.read_packing(os.fspath(file)))

    def write(self, file: str | os.PathLike[str]) -> None:
        """Write packing.json; the same packing gives the same bytes."""
        self._core.write(os.fspath(file))

    def __len__(self) -> int:
        return len(self._core)

    @property
    def vessel(self) -> Vessel:
        """Their container."""
        return Vessel._of(self._core.vessel)

    @property
    def positions_m(self) -> NDArray[Any]:
        """Positions of the grains, (grains, 3), in metres; a copy."""
        return self._core.positions_m

    @property
    def orientations(self) -> NDArray[Any]:
        """Quaternions w, x, y, z, (grains, 4); a copy."""
        return self._core.orientations

    @property
    def shape_of(self) -> NDArray[Any]:
        """Number of each grain's shape in ``shape_names``."""
        return self._core.shape_of

    @property
    def shape_names(self) -> list[str]:
        """Names of the shapes."""
        return self._core.shape_names

    def bed(self) -> dict[str, float]:
        """Height of the bed, its porosity, and the standard uncertainty of that: bed_height_m, porosity_bed, porosity_bed_uncertainty."""
        return self._core.bed()

    def contacts(self) -> dict[str, Any]:
        """Number of contacts, and overlaps in metres: of grains (largest, mean) and with walls (largest)."""
        return self._core.contacts()

    def relaxed(self, **keys: Any) -> Packing:
        """These grains brought to rest: overlaps vanish, contacts appear; ``report`` says how far they moved.

        Parameters
        ----------
        **keys
            Of the table [packing]: friction, stiffness, density, ...
        """
        return Packing._of(*self._core.relaxed(keys))

    def __repr__(self) -> str:
        bed = self.bed()
        uncertainty = 2.0 * bed["porosity_bed_uncertainty"]
        return (
            f"<Packing of {len(self)} grains in {self.vessel}: height {bed['bed_height_m']:.4g} m, "
            f"porosity {bed['porosity_bed']:.4f} ± {uncertainty:.1g} (95 %)>"
        )

    def _repr_html_(self) -> str:
        from porepack._pore_space import PoreSpace

        bed = PoreSpace(self, section_m=(0.0, self.bed()["bed_height_m"]), ends="planes")
        return bed._repr_html_()


def pour(
    shape: Shape,
    vessel: Vessel,
    grains: int | None = None,
    *,
    seed: int = 1,
    protocol: Sequence[Mapping[str, Any]] = (),
    target_porosity: float | None = None,
    folder: str | os.PathLike[str] | None = None,
    **keys: Any,
) -> Packing:
    """Pour grains into a vessel until they rest.

    Parameters
    ----------
    shape : Shape
        Of the grains, or a mixture.
    vessel : Vessel
        What they fall into.
    grains : int, optional
        How many; default: until the bed reaches ``fill_height_m``, which is half the vessel's height if it is not given.
    seed : int
        Of all random poses: the same seed gives the same packing.
    protocol : sequence of dict
        Steps after the pour, in order, each with the keys of ``porepack.keys("protocol")``: {"kind": "tap", "number": 20,
        "height_m": 0.002}.
    target_porosity : float, optional
        At which taps and vibration end.
    folder : path, optional
        An existing folder for snapshots, from which an interrupted pour resumes, and packing.json; default: a temporary one.
    **keys
        Those of the table [packing], ``porepack.keys("packing")``: friction, engine = "liggghts", density_kg_per_m3, ...

    Returns
    -------
    Packing
        Its ``report`` holds what the stage pack of a case reports: at_rest, coordination_number, steps, seconds, ...

    Raises
    ------
    UserError
        A grain does not fit, or a key is wrong. EngineError: LIGGGHTS is missing or failed.

    Examples
    --------
    >>> bed = porepack.pour(porepack.Shape("sphere", diameter_m=0.01),
    ...                     porepack.Vessel("cylinder", diameter_m=0.06, height_m=0.3), 100)  # doctest: +SKIP
    """
    from porepack import _core

    refuse_without_effect(keys, "pour()", ("file", "friction_uncertainty"))
    packing_keys = {"grains": grains, "seed": seed, **keys}
    protocol_keys = {"step": [dict(step) for step in protocol] or None, "target_porosity": target_porosity}
    with tempfile.TemporaryDirectory(prefix="porepack_") as temporary:
        where = temporary if folder is None else os.fspath(folder)
        return Packing._of(*_core.pour(shape._core, vessel._core, packing_keys, protocol_keys, where))


def _short(value: Any) -> str:
    """A value of a vessel's table; of a mesh only its length."""
    return f"[{len(value)} entries]" if isinstance(value, list) and len(value) > 3 else repr(value)
