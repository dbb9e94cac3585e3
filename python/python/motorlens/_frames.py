"""Tables of answers."""

from __future__ import annotations

from typing import Any


def as_frame(rows: list[dict[str, Any]]) -> Any:
    """A DataFrame, or the rows themselves where pandas is not installed."""
    try:
        import pandas
    except ImportError:
        return rows
    return pandas.DataFrame(rows)
