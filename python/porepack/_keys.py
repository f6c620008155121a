"""The keys of case.toml, which are the keyword arguments of this module."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

from porepack._errors import UserError

# The tables whose keys the functions take.
TABLES = ("shape", "container", "packing", "protocol", "geometry", "section", "image", "lbm", "tortuosity", "falling_head")


class Key(NamedTuple):
    """One key of a table: its name, unit, type, allowed values, default and meaning."""

    name: str
    unit: str
    type: str
    allowed: str
    default: str
    meaning: str


class Keys(list[Key]):
    """The keys of one table; printed as a list with their meaning."""

    def __repr__(self) -> str:
        return "\n".join(f"{key.name}: {key.type}, {key.allowed}; default {key.default or 'none'}\n    {key.meaning}" for key in self)


def keys(table: str) -> Keys:
    """Keys of a table of case.toml: name, unit, type, allowed values, default, meaning.

    Parameters
    ----------
    table : str
        "shape", "container", "packing", "protocol", "geometry", "section", "image", "lbm", "tortuosity", ...

    Examples
    --------
    >>> porepack.keys("lbm")  # doctest: +SKIP
    """
    from porepack import _core

    return Keys(Key(*row) for row in _core.keys_of_table(table))


@lru_cache(maxsize=None)
def table_of(key: str, tables: tuple[str, ...]) -> str | None:
    """The first of these tables that has the key."""
    return next((table for table in tables if key in _names(table)), None)


@lru_cache(maxsize=None)
def _names(table: str) -> frozenset[str]:
    return frozenset(key.name for key in keys(table))


@lru_cache(maxsize=None)
def _flags() -> dict[str, str]:
    from porepack import _core

    flags = {"--container": "vessel", "--unit": "unit_m", "--section": "section_m"}
    for table in TABLES:
        for key in _names(table):
            flag = _core.flag_of(key)
            flags.setdefault(flag.replace("--", "--image-", 1) if table == "image" else flag, key)
    return flags


def key_of_flag(flag: str) -> str | None:
    """The keyword argument that stands for a flag of the program, or None."""
    return _flags().get(flag)


def sorted_by_table(arguments: dict[str, object], tables: tuple[str, ...]) -> dict[str, dict[str, object]]:
    """Keyword arguments by the table that has them; unknown ones stay in the first table, which refuses them with the nearest known key."""
    found: dict[str, dict[str, object]] = {table: {} for table in tables}
    for key, value in arguments.items():
        if value is not None:
            found[table_of(key, tables) or tables[0]][key] = value
    return found


def refuse_without_effect(arguments: dict[str, object], where: str, without_effect: tuple[str, ...], fix: str = "remove it") -> None:
    """A key that would change nothing is an error."""
    for key in without_effect:
        if arguments.get(key) is not None:
            raise UserError(f"`{key}` has no effect here", where, fix=fix)
