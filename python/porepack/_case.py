"""Cases and studies: folders with case.toml or study.toml."""

from __future__ import annotations

import os
import pathlib
from typing import Any, Mapping

from porepack._table import columns_of


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


class Study:
    """A study: one case with several values of some keys.

    Parameters
    ----------
    folder : path
        With study.toml (docs/studies.md).

    Examples
    --------
    >>> pandas.DataFrame(porepack.Study("cases/paper_study").table())  # doctest: +SKIP
    """

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self.folder = os.fspath(folder)
        self.status()  # a folder that is none is refused here

    def run(self, points: str = "", max_time_s: float = 0.0) -> dict[str, Any]:
        """Run the points that have no current row, several at once, each in a process of its own.

        Parameters
        ----------
        points : str
            Names or numbers: "1,3-5"; default: all.
        max_time_s : float
            No point begins after so many seconds; 0: no limit.

        Returns
        -------
        dict
            "done" and "failed" points, ...
        """
        from porepack import _core

        return _core.run_study(self.folder, points, max_time_s)

    def status(self) -> list[dict[str, str]]:
        """Of each point: its name, its state (done, stale, running, interrupted, failed, missing), and why."""
        from porepack import _core

        return _core.study_status(self.folder)

    def table(self) -> dict[str, list[Any]]:
        """Columns of study.csv, one row per finished point; empty if no point has been run."""
        from porepack import _core

        file = pathlib.Path(_core.study_table(self.folder))
        return columns_of(file.read_text(encoding="utf-8").splitlines()) if file.exists() else {}

    def __repr__(self) -> str:
        states = [point["state"] for point in self.status()]
        return f"<Study {self.folder}: {len(states)} points, {states.count('done')} done>"
