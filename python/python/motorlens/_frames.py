"""Tables of answers."""

from __future__ import annotations

import html
from typing import Any


#: What names a row, and what it says, stand before the rest.
FIRST = ("name", "effect", "record", "compensation", "value", "unit", "low", "high")


def as_frame(rows: list[dict[str, Any]]) -> Any:
    """A DataFrame, or the rows themselves where pandas is not installed."""
    rows = [{**{name: row[name] for name in FIRST if name in row}, **row} for row in rows]
    try:
        import pandas
    except ImportError:
        return rows
    return pandas.DataFrame(rows)


def as_html(frame: Any) -> str:
    """A table for a notebook, of a DataFrame or of rows."""
    if hasattr(frame, "to_html"):
        return str(frame.to_html(index=False))
    if not frame:
        return ""

    def line(cells: Any, tag: str) -> str:
        return "<tr>" + "".join(f"<{tag}>{html.escape(str(cell))}</{tag}>" for cell in cells) + "</tr>"

    return "<table>" + line(frame[0], "th") + "".join(line(row.values(), "td") for row in frame) + "</table>"


def as_page(head: str, *parts: Any) -> str:
    """What an answer shows in a notebook: a sentence, tables, and the pictures that functions among `parts` draw."""
    page = f"<p><b>{html.escape(head)}</b></p>"
    for part in parts:
        if callable(part):
            page += _picture(part)
        elif isinstance(part, str):
            page += f"<p>{html.escape(part)}</p>"
        else:
            page += as_html(part)
    return page


def _picture(draw: Any) -> str:
    """A picture within the page; nothing where matplotlib is not installed."""
    try:
        import base64
        import io

        from matplotlib import pyplot
    except ImportError:
        return ""
    drawn = draw()
    figure = getattr(drawn, "figure", None) or drawn
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=80)
    # Notebooks would show it a second time.
    pyplot.close(figure)
    return f'<img src="data:image/png;base64,{base64.b64encode(file.getvalue()).decode()}"/>'
