"""What PorePack says while it works: log, warnings, progress."""

from __future__ import annotations

import logging
import sys
import time
import warnings
from html import escape
from types import ModuleType
from typing import Any, Callable

from porepack._errors import PorePackWarning, UserError

Progress = Callable[[str, float, float, str], None]

_logger = logging.getLogger("porepack")
threads = 0
_progress: bool | Progress = True
_line_length = 0
_shown: Any = None  # the notebook's output that shows progress


def set_progress(progress: bool | Progress) -> None:
    """Choose how the progress of long steps is shown.

    Parameters
    ----------
    progress : bool or callable
        True: a line on the terminal or in the notebook, for steps of more than a second; the default. False: nothing. A function: it is
        called with the label of the step, the fraction of its time that has passed (in [0, 1]; 1 ends it), the seconds since it began,
        and a detail. An exception in it ends the work, and is raised by the function that does the work.
    """
    global _progress
    _progress = progress


def set_threads(number: int) -> None:
    """Set the number of threads of each following call; 0: OMP_NUM_THREADS, else the cores that this process may use."""
    global threads
    if not 0 <= number <= 1024:
        raise UserError(f"{number} threads", "set_threads()", "0 to 1024")
    threads = int(number)


def on_log(warning: bool, line: str) -> None:
    """Pass one line on: to warnings, or to the logger "porepack"."""
    if warning:
        warnings.warn(line, PorePackWarning, stacklevel=_outside())
    else:
        _logger.info(line)


def on_progress(label: str, fraction: float, seconds: float, detail: str) -> None:
    """Show how far a step is."""
    if callable(_progress):
        _progress(label, fraction, seconds, detail)
    elif _progress and _is_watched():
        _draw(label, fraction, seconds, detail)


def _outside() -> int:
    """How many frames lie between on_log() and the caller of this package."""
    frame, level = sys._getframe(1), 1
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] == "porepack":
        frame, level = frame.f_back, level + 1
    return level


def _is_watched() -> bool:
    return _notebook() is not None or (sys.stderr is not None and sys.stderr.isatty())


def _notebook() -> ModuleType | None:
    """IPython, where the code runs in its kernel."""
    ipython = sys.modules.get("IPython")
    return ipython if ipython is not None and hasattr(ipython.get_ipython(), "kernel") else None


def _draw(label: str, fraction: float, seconds: float, detail: str) -> None:
    global _line_length
    if fraction >= 1.0:
        text = ""
    elif seconds < 1.0:
        return
    else:
        left = f", {_time(seconds * (1.0 - fraction) / fraction)} left" if fraction >= 0.1 else ""
        text = f"{label} {100.0 * fraction:.0f} %{left}{'  ' + detail if detail else ''}"
    if (ipython := _notebook()) is not None:
        return _draw_in_notebook(ipython, text)
    sys.stderr.write("\r" + text.ljust(_line_length) + ("\r" if not text else ""))
    sys.stderr.flush()
    _line_length = len(text)


def _draw_in_notebook(ipython: ModuleType, text: str) -> None:
    """One output of the cell, which is replaced each time and empty in the end."""
    global _shown
    line = ipython.display.HTML(f"<small>{escape(text)}</small>" if text else "")
    if _shown is not None:
        _shown.update(line)
    elif text:
        _shown = ipython.display.display(line, display_id=True)
    if not text:
        _shown = None


def _time(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 100.0 else time.strftime("%H:%M:%S", time.gmtime(seconds))
