"""The falling-head test."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass, field
from typing import Any, Iterable

from porepack._keys import refuse_without_effect
from porepack._table import columns_of

_UNCERTAINTIES = (
    "level_offset_uncertainty_m",
    "scale_uncertainty",
    "viscosity_uncertainty",
    "inertia_coefficient_uncertainty",
    "inertial_exponent_uncertainty",
)
_NOT_SIMULATED = ("causes", "computed_over_measured", *_UNCERTAINTIES)
_NOT_ANALYSED = ("start_level_m", "levels_m", "noise_m", "frames_per_s", "seed", "causes", "computed_over_measured")


@dataclass(frozen=True)
class FallingHead:
    """A simulated test.

    Attributes
    ----------
    levels_m : list of float
        Water levels above the sample.
    times_s : list of float
        At which they are passed, with the inertia of the water and the wire screens as configured; None where a level is not reached.
    times_darcy_forchheimer_s : list of float
        The same by Eq. 18 of Conzelmann et al., in closed form, without inertia of the water.
    curve : dict or None
        Columns of the level over time, where it was asked for.
    details : dict
        All that ``porepack falling-head simulate`` reports.
    """

    levels_m: list[float]
    times_s: list[float | None]
    times_darcy_forchheimer_s: list[float]
    curve: dict[str, list[Any]] | None = field(default=None, repr=False)
    details: dict[str, Any] = field(default_factory=dict, repr=False)


def falling_head(permeability_m2: float, inertial_permeability_m: float = math.inf, *, curve: bool = False, **keys: Any) -> FallingHead:
    """Water level over time above a sample.

    Parameters
    ----------
    permeability_m2 : float
        k, in m².
    inertial_permeability_m : float
        k_in, in m; infinite: Darcy's law alone.
    curve : bool
        Give the level over time too, with noise if ``noise_m`` is given.
    **keys
        Of the table [falling_head]: sample_length_m, start_level_m, levels_m, ... ``porepack.keys("falling_head")``.
    """
    from porepack import _core

    refuse_without_effect(keys, "falling_head()", _NOT_SIMULATED)
    found, table = _core.falling_head(permeability_m2, inertial_permeability_m, curve, keys)
    return FallingHead(
        levels_m=found["levels_m"],
        times_s=found["times_full_equation_s"],
        times_darcy_forchheimer_s=found["times_s"],
        curve=None if table is None else columns_of(table.splitlines()),
        details=found,
    )


def analyse_falling_head(curves: Iterable[Any], **keys: Any) -> dict[str, Any]:
    """k and k_in from measured water levels, with intervals.

    Parameters
    ----------
    curves : list
        Each a CSV file (docs/falling-head.md), or a pair of sequences: times in seconds, levels above the sample in metres.
    **keys
        Of the table [falling_head]: sample_length_m, window_m, ... ``porepack.keys("falling_head")``.

    Returns
    -------
    dict
        What ``porepack falling-head analyse`` reports: of each packing under "packings", "least_squares" holds permeability_m2,
        permeability_interval_m2, the verdict, ...

    Raises
    ------
    UserError
        A curve is too short, its level rises, or it ends above the window.
    """
    from porepack import _core

    refuse_without_effect(keys, "analyse_falling_head()", _NOT_ANALYSED)
    given = [
        os.fspath(curve) if isinstance(curve, (str, os.PathLike)) else tuple([float(x) for x in part] for part in curve) for curve in curves
    ]
    return _core.analyse_falling_head(given, keys)
