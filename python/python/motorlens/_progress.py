"""Progress on standard error, where a person watches: a terminal or a notebook."""

from __future__ import annotations

import contextlib
import json
import sys
from collections.abc import Callable, Iterator
from typing import Any, Optional, Union

from . import _native

#: True, False, or a function that gets every event as a dict; None shows a bar in a terminal and in a notebook.
Progress = Union[bool, None, Callable[[dict[str, Any]], object]]

_WIDTH = 20


class _Bar:
    """Effects tried on the model so far, generations, or the share of a call that is done; a line stays for each model that was fitted."""

    def __init__(self, generations: int, trials: int) -> None:
        self.generations, self.trials = generations, trials
        self.library = len(json.loads(_native.effects([])))
        self.depth = self.tried = self.shown = 0

    def __call__(self, event: dict[str, Any]) -> None:
        if "trying" in event:
            if event["depth"] != self.depth:
                self.depth, self.tried = event["depth"], 0
            self.tried += 1
            self._bar(self.tried, self.trials or self.library - self.depth, f"trying {event['trying']}")
        elif "generation" in event:
            self._bar(event["generation"], self.generations, f"IAE {event['iae']:.4g}")
        elif "share" in event:
            self._bar(round(100 * event["share"]), 100, f"{event['share']:.0%} done")
        else:
            self._line(f"{', '.join(event['effects']) or 'base model'}: rmse {event['rmse']:.4g}")

    def _bar(self, done: int, of: int, what: str) -> None:
        full = min(_WIDTH, round(_WIDTH * done / max(of, done, 1)))
        self._write(f"[{'#' * full}{'.' * (_WIDTH - full)}] {what}", "")

    def _line(self, text: str) -> None:
        self._write(text, "\n")
        self.shown = 0

    def _write(self, text: str, end: str) -> None:
        print(f"\r{text:<{self.shown}}", end=end, file=sys.stderr, flush=True)
        self.shown = len(text)

    def close(self) -> None:
        """Takes the bar away, so that what is printed next begins a line."""
        if self.shown:
            print("\r" + " " * self.shown + "\r", end="", file=sys.stderr, flush=True)


def _watched() -> bool:
    """Whether a person sees standard error."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    in_notebook = type(shell).__name__ == "ZMQInteractiveShell"
    return in_notebook or (sys.stderr is not None and sys.stderr.isatty())


@contextlib.contextmanager
def watching(
    progress: Progress, generations: int = 0, trials: int = 0
) -> Iterator[Optional[Callable[[str], object]]]:
    """What the native part calls with each event in JSON, while the call lasts.

    A bar is full after so many ``generations``, or ``trials`` of effects (0: all that the model does not have).
    """
    if progress is None:
        progress = _watched()
    if progress is False:
        yield None
        return
    bar = _Bar(generations, trials) if progress is True else None
    told = bar or progress
    assert callable(told)
    try:
        yield lambda text: told(json.loads(text))
    finally:
        if bar is not None:
            bar.close()
