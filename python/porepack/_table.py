"""CSV of the library as columns."""

from __future__ import annotations

import csv
from typing import Any, Iterable


def columns_of(lines: Iterable[str]) -> dict[str, list[Any]]:
    """By name: numbers where all fields are numbers, NaN where one is empty; else text. pandas takes it: ``DataFrame(columns)``."""
    rows = list(csv.reader(line for line in lines if line.strip() and not line.startswith("#")))
    if not rows:
        return {}
    return {name: _values([row[n] for row in rows[1:]]) for n, name in enumerate(rows[0])}


def _values(fields: list[str]) -> list[Any]:
    for kind in (int, float):
        try:
            return [float("nan") if kind is float and field == "" else kind(field) for field in fields]
        except ValueError:
            continue
    return fields
