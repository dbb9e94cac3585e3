"""Progress on standard error, where a person watches."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from typing import Optional, Union

#: True, False, or a function that gets every event as a dict; None shows it where standard error is a terminal.
Progress = Union[bool, None, Callable[[dict], object]]


def _line(event: dict) -> str:
    if "trying" in event:
        return f"trying {event['trying']} on {event['depth']} effects"
    if "generation" in event:
        return f"generation {event['generation']}, IAE {event['iae']:.4g}"
    return f"{', '.join(event['effects']) or 'base model'}: rmse {event['rmse']:.4g}"


def _show(event: dict) -> None:
    end = "\n" if "rmse" in event else "\r"
    print(f"\r{_line(event):<60}", end=end, file=sys.stderr, flush=True)


def as_callback(progress: Progress) -> Optional[Callable[[str], object]]:
    """What the native part calls with each event in JSON."""
    if progress is None:
        progress = sys.stderr.isatty()
    if progress is False:
        return None
    told = _show if progress is True else progress
    return lambda text: told(json.loads(text))
