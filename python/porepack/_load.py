"""Loads the compiled part of the package."""

from __future__ import annotations

import importlib
import os
from types import ModuleType


def load_core() -> ModuleType:
    """porepack._core, with threads of OpenMP that sleep while they wait: turning in a loop they would take the processor from others.

    OpenMP reads its settings when it is loaded, so that they are needed only then. What the user has set stays, and so does what another
    package that has loaded OpenMP before has chosen.
    """
    settings = {"OMP_WAIT_POLICY": "passive", "GOMP_SPINCOUNT": "3000"}
    if settings.keys() & os.environ.keys():
        settings = {}
    os.environ.update(settings)
    try:
        return importlib.import_module("porepack._core")
    finally:
        for name in settings:
            del os.environ[name]
