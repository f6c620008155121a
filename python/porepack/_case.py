"""Cases: folders with case.toml."""

from __future__ import annotations

import os
from typing import Any, Mapping


def run_case(
    folder: str | os.PathLike[str],
    up_to: str = "",
    *,
    output: str | os.PathLike[str] = "",
    set: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """Run a case, or resume it, as ``porepack run`` does.

    Parameters
    ----------
    folder : path
        With case.toml.
    up_to : str
        The last stage: "pack", "lbm", ...; default: all.
    output : path, optional
        Folder of the results; default: ``results`` in the case's folder.
    set : dict, optional
        Other values of keys, {"packing.grains": 40}; they need ``output``.

    Returns
    -------
    dict
        The results by stage, as of ``read_result()``.
    """
    from porepack import _core

    return read_result(_core.run_case(os.fspath(folder), up_to, os.fspath(output), dict(set or {})))


def read_result(folder: str | os.PathLike[str]) -> dict[str, Any]:
    """Results of a case by stage, with the keys of each result.json.

    Parameters
    ----------
    folder : path
        The case's folder, or its folder ``results``.

    Raises
    ------
    UserError
        There are none, or a file is not one; it names the key.
    """
    from porepack import _core

    return _core.read_result(os.fspath(folder))
