"""Errors and warnings of PorePack."""

from __future__ import annotations

import re


class Error(Exception):
    """What PorePack ends with: what is wrong, and advice.

    Attributes
    ----------
    fault : str
        What is wrong.
    where : str
        The function, file and line, or key; empty where there is nothing to say, as the following.
    allowed : str
        What is allowed.
    fix : str
        How to fix it.
    """

    __module__ = "porepack"

    def __init__(self, fault: str, where: str = "", allowed: str = "", fix: str = "") -> None:
        self.fault, self.where, self.allowed, self.fix = (_without_flags(text) for text in (fault, where, allowed, fix))
        lines = [self.fault]
        for label, text in (("where:   ", self.where), ("allowed: ", self.allowed), ("fix:     ", self.fix)):
            if text:
                lines.append("  " + label + text)
        super().__init__("\n".join(lines))


class UserError(Error, ValueError):
    """The input is wrong, and the user can fix it."""

    __module__ = "porepack"


class NumericalError(Error, ArithmeticError):
    """Not converged, diverged, or no path leads through the pores."""

    __module__ = "porepack"


class EngineError(Error, RuntimeError):
    """LIGGGHTS, OpenFOAM or another program is missing or failed."""

    __module__ = "porepack"


class MachineError(Error, RuntimeError):
    """The disk is full, or the memory does not suffice."""

    __module__ = "porepack"


class PorePackWarning(UserWarning):
    """Something that a result should not be used without knowing."""

    __module__ = "porepack"


def _without_flags(text: str) -> str:
    """Name the keys instead of the flags of the program: --image-pore 0 becomes pore=0."""
    text = re.sub(r",? --image-\.\.\.", "", text)
    if "--" not in text:
        return text
    from porepack._keys import key_of_flag

    def keyword(found: re.Match[str]) -> str:
        key = key_of_flag(found.group(1))
        if key is None:
            return found.group(0)
        return key + "=" if found.group(2) else key

    return re.sub(r"(--[a-z][a-z-]*[a-z])( (?=[A-Z0-9\"\[(-]))?", keyword, text)
