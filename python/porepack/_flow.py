"""What is computed in a pore space: permeability, tortuosities, pores."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from porepack._keys import refuse_without_effect
from porepack._pore_space import PoreSpace

if TYPE_CHECKING:
    from numpy.typing import NDArray


@dataclass(frozen=True)
class Grid:
    """One of the grids of a permeability, coarse to fine.

    Attributes
    ----------
    voxel_size_m : float
    permeability_m2 : float
    nodes : int
        Pore nodes.
    steps : int
    seconds : float
        With set-up.
    converged : bool
    """

    voxel_size_m: float
    permeability_m2: float
    nodes: int
    steps: int
    seconds: float
    converged: bool


@dataclass(frozen=True, repr=False)
class Flow:
    """The flow field of the finest grid, as arrays [x, y, z]; memory is not copied.

    Attributes
    ----------
    velocity_m_per_s : array (nx, ny, nz, 3)
        Scaled to the key ``superficial_velocity_m_per_s``.
    pressure_Pa : array (nx, ny, nz)
        Of water.
    phase : array (nx, ny, nz)
        0 grain, 1 pore, 2 outside the vessel.
    spacing_m, origin_m : list of 3 floats
        Size of a voxel, and the lowest corner of the first.
    """

    velocity_m_per_s: NDArray[Any]
    pressure_Pa: NDArray[Any]
    phase: NDArray[Any]
    spacing_m: list[float]
    origin_m: list[float]

    def __repr__(self) -> str:
        return f"<Flow on {' x '.join(str(n) for n in self.phase.shape)} voxels of {self.spacing_m[2]:.4g} m>"


@dataclass(frozen=True)
class Permeability:
    """A permeability, and how sure it is.

    Attributes
    ----------
    value_m2 : float
        Extrapolated from three grids where there are three, else that of the finest.
    interval_m2 : (float, float) or None
        Numerical, of 95 %; None: no uncertainty is known, and ``interval_meaning`` says why.
    interval_meaning : str
    budget_m2 : dict or None
        Half widths of the interval's parts, which are added: grid, iteration, mass_balance, ...
    grids : tuple of Grid
    direction : str
    porosity : float
        Of the section.
    hydraulic_tortuosity : float
        Of the finest grid.
    converged : bool
        The relative iteration error is below its tolerance.
    steps : int
        Of the finest grid.
    seconds : float
        Of all grids.
    flow : Flow or None
        Where it was asked for.
    details : dict
        All that the stage lbm of a case reports, with the keys of its result.json.
    """

    value_m2: float
    interval_m2: tuple[float, float] | None
    interval_meaning: str
    budget_m2: dict[str, float] | None
    grids: tuple[Grid, ...]
    direction: str
    porosity: float
    hydraulic_tortuosity: float
    converged: bool
    steps: int
    seconds: float
    flow: Flow | None = field(default=None, repr=False)
    details: dict[str, Any] = field(default_factory=dict, repr=False)

    @property
    def tensor_m2(self) -> list[list[float]] | None:
        """By rows, where it was asked for with tensor=True."""
        return self.details.get("permeability_tensor_m2")

    def __float__(self) -> float:
        return self.value_m2

    def __str__(self) -> str:
        text = f"permeability {self.value_m2:.4g} m²"
        if self.interval_m2 is None:
            text += f" ({self.interval_meaning})"
        else:
            text += f" ({self.interval_m2[0]:.4g} to {self.interval_m2[1]:.4g}, numerical, 95 %)"
        grids = "1 grid" if len(self.grids) == 1 else f"{len(self.grids)} grids"
        return text + f" along {self.direction}, {grids}, {self.seconds:.2g} s" + ("" if self.converged else ", NOT CONVERGED")

    def _repr_html_(self) -> str:
        from html import escape

        return f"<div>{escape(str(self))}</div>"


def permeability(
    space: PoreSpace,
    voxel_size_m: float = 0.0,
    *,
    direction: str = "z",
    flow: bool = False,
    checkpoint: str | os.PathLike[str] = "",
    **keys: Any,
) -> Permeability:
    """Permeability by lattice Boltzmann, with its interval.

    Parameters
    ----------
    space : PoreSpace
        Its walls are exact where it is made of grains or a surface; of images see PoreSpace.
    voxel_size_m : float
        Of the finest grid; 0: a tenth of the grain's thickness. An image has its own.
    direction : {"z", "x", "y"}
        Of the flow; x and y in boxes only.
    flow : bool
        Keep the flow field.
    checkpoint : path, optional
        A file from which an interrupted run resumes, and which it updates.
    **keys
        Those of the table [lbm], ``porepack.keys("lbm")``: tolerance, grids, precision, walls, tensor, ...

    Returns
    -------
    Permeability

    Raises
    ------
    NumericalError
        No path leads through the pores, or the flow does not become steady.

    Notes
    -----
    D3Q19 with two relaxation times and interpolated walls; docs/theory.md has the equations and their sources.

    Examples
    --------
    >>> k = porepack.permeability(porepack.PoreSpace(array, voxel_size_m=1e-5))  # doctest: +SKIP
    >>> k.value_m2, k.interval_m2  # doctest: +SKIP
    """
    from porepack import _core

    refuse_without_effect(keys, "permeability()", ("fields",), "flow=True keeps the flow field")
    result, arrays = _core.permeability(space._core, float(voxel_size_m), flow, os.fspath(checkpoint), {"direction": direction, **keys})
    grids = tuple(
        Grid(
            voxel_size_m=one["voxel_size_m"],
            permeability_m2=one["permeability_m2"],
            nodes=one["fluid_nodes"],
            steps=one["steps"],
            seconds=one["seconds"] + one["set_up_seconds"],
            converged=one["converged"],
        )
        for one in result["grids"]
    )
    return Permeability(
        value_m2=result["permeability_m2"],
        interval_m2=result["permeability_interval_m2"],
        interval_meaning=result["interval_meaning"],
        budget_m2=result["half_width_parts_m2"],
        grids=grids,
        direction=result["direction"],
        porosity=result["porosity"],
        hydraulic_tortuosity=result["hydraulic_tortuosity"],
        converged=result["converged"],
        steps=result["steps"],
        seconds=sum(grid.seconds for grid in grids),
        flow=None if arrays is None else Flow(**arrays),
        details=result,
    )


_OF_DOTS = ("dot_spacing_m", "slice_spacing_m", "largest_angle_deg", "dot_pixel_m", "dot_radius_m")


@dataclass(frozen=True)
class Tortuosity:
    """A tortuosity of one kind.

    Attributes
    ----------
    kind : str
        "diffusive": the tortuosity factor porosity D0/D_eff; "shortest_path": mean length of the shortest paths over the length of the
        section; "geometric_paper": the paper's dots.
    value : float
    interval : (float, float) or None
        Of 95 %: numerical of the tortuosity factor, else by the standard error of the mean over paths; None: none is known.
    direction : str
    details : dict
        All that is reported, with the keys of result.json.
    """

    kind: str
    value: float
    interval: tuple[float, float] | None
    direction: str
    details: dict[str, Any] = field(default_factory=dict, repr=False)

    def __float__(self) -> float:
        return self.value

    def __str__(self) -> str:
        name = "tortuosity factor" if self.kind == "diffusive" else f"tortuosity ({self.kind})"
        because = self.details.get("no_interval_because", "no interval known")
        sure = f" ({because})" if self.interval is None else f" ({self.interval[0]:.4f} to {self.interval[1]:.4f}, 95 %)"
        return f"{name} {self.value:.4f}{sure} along {self.direction}"


def tortuosity(space: PoreSpace, voxel_size_m: float = 0.0, *, kind: str = "diffusive", direction: str = "z", **keys: Any) -> Tortuosity:
    """A tortuosity of the section.

    Parameters
    ----------
    space : PoreSpace
    voxel_size_m : float
        0: a tenth of the grain's thickness, or the image's own.
    kind : {"diffusive", "shortest_path", "geometric_paper"}
        See Tortuosity; that of the flow comes with ``permeability()``.
    direction : {"z", "x", "y"}
        x and y for periodic boxes and images; the paper's dots go along z.
    **keys
        Of the table [tortuosity], for the paper's dots: ``porepack.keys("tortuosity")``.

    Raises
    ------
    NumericalError
        No path leads through the pores.
    """
    from porepack import _core

    refuse_without_effect(keys, "tortuosity()", ("shortest_path", "diffusive"), 'kind="..." chooses')
    if kind != "geometric_paper":
        refuse_without_effect(keys, "tortuosity()", _OF_DOTS, "it belongs to the kind geometric_paper")
    found = _core.tortuosity(space._core, float(voxel_size_m), kind, {"direction": direction, **keys})
    if kind == "diffusive":
        return Tortuosity(kind, found["tortuosity_factor"], found["interval"], found["direction"], found)
    value, error = found[f"tortuosity_{kind}"], 2.0 * found["standard_error"]
    interval = (value - error, value + error) if error >= 0.0 else None
    return Tortuosity(kind, value, interval, found.get("direction", "z"), found)


@dataclass(frozen=True)
class Pores:
    """Sizes of the pores of a section.

    Attributes
    ----------
    diameter_median_m, diameter_10_percent_m, diameter_90_percent_m : float
        By volume, of the largest sphere in the pores that covers a point.
    critical_diameter_m : dict
        By axis: of the largest sphere that passes through; None where none does.
    pores, throats : int
        Of the network: basins of the distance to the walls, and ways between them.
    surface_per_volume_per_m : float
        Of the section.
    details : dict
        All that is reported, with the keys of result.json.
    """

    diameter_median_m: float
    diameter_10_percent_m: float
    diameter_90_percent_m: float
    critical_diameter_m: dict[str, float | None]
    pores: int
    throats: int
    surface_per_volume_per_m: float
    details: dict[str, Any] = field(default_factory=dict, repr=False)


def pores(space: PoreSpace, voxel_size_m: float = 0.0) -> Pores:
    """Chords, pore sizes, throats, critical diameter of the section.

    Parameters
    ----------
    space : PoreSpace
    voxel_size_m : float
        0: a tenth of the grain's thickness, or the image's own.
    """
    from porepack import _core

    found = _core.pores(space._core, float(voxel_size_m))
    return Pores(
        diameter_median_m=found["pore_diameter_median_m"],
        diameter_10_percent_m=found["pore_diameter_10_percent_m"],
        diameter_90_percent_m=found["pore_diameter_90_percent_m"],
        critical_diameter_m=found["critical_diameter_m"],
        pores=found["network"]["pores"],
        throats=found["network"]["throats"],
        surface_per_volume_per_m=found["surface_per_volume_per_m"],
        details=found,
    )
