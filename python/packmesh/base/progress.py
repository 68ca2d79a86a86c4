# SPDX-License-Identifier: AGPL-3.0-or-later
"""Progress of a packing, for functions and for people."""
from __future__ import annotations

import dataclasses
import html
import sys
from typing import Any, Optional

from packmesh.base.files import fitting

PAUSE = 10.0  # between lines where there is neither a terminal nor a notebook [s]


@dataclasses.dataclass(frozen=True)
class Progress:
    """Progress of a packing.

    stage: "relaxation", "growth", ...; sweep: number of sweeps or iterations; scale: common scale of the cells
    worst_overlap: deepest overlap with a clearance [µm]; unresolved: number of pairs that still overlap
    seconds: since packing began; remaining: time that is left [s], None in the first second and where there is no forecast
    text: all that, in a line
    """

    stage: str
    sweep: int
    scale: float
    worst_overlap: float
    unresolved: int
    seconds: float
    remaining: Optional[float]
    text: str

    @property
    def share(self) -> Optional[float]:
        """Share of the expected time that has passed, 0 to 1."""
        return None if self.remaining is None else self.seconds / (self.seconds + self.remaining)


class ProgressDisplay:
    """A line that changes, on a terminal or in a notebook; elsewhere a line every 10 s. To standard error."""

    def __init__(self, is_shown: bool) -> None:
        self.is_shown = is_shown
        self._output: Any = _notebook_output() if is_shown else None
        self._terminal = is_shown and self._output is None and sys.stderr.isatty()
        self._last = 0.0

    def __enter__(self) -> "ProgressDisplay":
        return self

    def __exit__(self, *_: Any) -> None:
        if self._output is not None:
            self._output.update({"text/plain": ""}, raw=True)
        elif self._terminal:
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)

    def show(self, *values: Any) -> None:
        """Called with the members of a Progress."""
        progress = Progress(*values)
        if self._output is not None:
            self._output.update(_rich(progress), raw=True)
        elif self._terminal:
            print("\r\x1b[K" + fitting(f"(packMesh) {_bar(progress.share)}{progress.text}"), end="", file=sys.stderr,
                  flush=True)
        elif progress.seconds > self._last + PAUSE:
            self._last = progress.seconds
            print(f"(packMesh) {progress.text}", file=sys.stderr, flush=True)


def _bar(share: Optional[float]) -> str:
    return "" if share is None else f"[{'#' * round(20 * share):20}] {100 * share:3.0f} % "


def _rich(progress: Progress) -> "dict[str, str]":
    """For notebooks: HTML, and text for those that show none."""
    value = "" if progress.share is None else f' value="{progress.share:.3f}"'
    return {
        "text/plain": _bar(progress.share) + progress.text,
        "text/html": f"<progress{value} max='1' style='width: 12em'></progress> {html.escape(progress.text)}"}


def _notebook_output() -> Any:
    """What shows and replaces an output of this cell of a notebook; None elsewhere."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None else None
    if shell is None or not hasattr(shell, "kernel"):
        return None
    from IPython.display import display

    return display({"text/plain": ""}, raw=True, display_id=True)
