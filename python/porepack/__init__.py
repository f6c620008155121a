"""PorePack: how porous, tortuous and permeable a packing is, and how sure that is.

    >>> import porepack
    >>> space = porepack.PoreSpace(array, voxel_size_m=1e-5)  # True in the pores  # doctest: +SKIP
    >>> print(porepack.permeability(space))  # doctest: +SKIP

Lengths are in metres, and names end in their unit. ``porepack.keys("lbm")`` lists the keyword arguments that belong to a table of
case.toml.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from porepack._case import Study, read_result, run_case
from porepack._errors import EngineError, Error, MachineError, NumericalError, PorePackWarning, UserError
from porepack._falling_head import FallingHead, analyse_falling_head, falling_head
from porepack._flow import Flow, Grid, Permeability, Pores, Tortuosity, permeability, pores, tortuosity
from porepack._host import set_progress, set_threads
from porepack._keys import Key, Keys, keys
from porepack._packing import Packing, Shape, Vessel, pour
from porepack._pore_space import PoreSpace, Porosity, Surface, surface
from porepack._scan import Segmentation, fit, segment

__all__ = [
    "EngineError",
    "Error",
    "FallingHead",
    "Flow",
    "Grid",
    "Key",
    "Keys",
    "MachineError",
    "NumericalError",
    "Packing",
    "Permeability",
    "PorePackWarning",
    "PoreSpace",
    "Pores",
    "Porosity",
    "Segmentation",
    "Shape",
    "Study",
    "Surface",
    "Tortuosity",
    "UserError",
    "Vessel",
    "analyse_falling_head",
    "falling_head",
    "fit",
    "keys",
    "permeability",
    "pores",
    "pour",
    "read_result",
    "run_case",
    "segment",
    "set_progress",
    "set_threads",
    "surface",
    "tortuosity",
    "version",
]


def version() -> str:
    """Version and commit of the library."""
    from porepack import _core

    return f"{_core.version()} ({_core.git_hash()})"


if not TYPE_CHECKING:

    def __getattr__(name: str) -> object:
        """The compiled part, at first use."""
        if name != "_core":
            raise AttributeError(f"module 'porepack' has no attribute {name!r}")
        from porepack._load import load_core

        return load_core()
