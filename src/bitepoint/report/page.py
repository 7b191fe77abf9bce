"""What all pages share: one style, tables, and the plotting library once."""

from __future__ import annotations

import html
from collections.abc import Iterable, Sequence
from typing import Any

from bitepoint.metrics import Metrics

BLUE, ORANGE, GREEN, GREY, RED = "#1f6fb4", "#e07b00", "#2a8f4b", "#8a8f98", "#c0392b"


def figures_table(figures: Metrics) -> str:
    """Return the figures of merit as an HTML table."""
    return table((), ((name.replace("_", " "), str(metric)) for name, metric in figures.items()))


def table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return an HTML table; the first cell of a row is its name."""
    head = "".join(f"<th>{html.escape(cell)}</th>" for cell in header)
    body = "".join(
        f"<tr><th>{html.escape(row[0])}</th>{''.join(f'<td>{html.escape(cell)}</td>' for cell in row[1:])}</tr>"
        for row in rows
    )
    return f"<table>{f'<tr>{head}</tr>' if header else ''}{body}</table>"


def bullets(lines: Iterable[str], title: str) -> str:
    """Return a list with a title, or nothing where there are no lines."""
    items = "".join(f"<li>{html.escape(line)}</li>" for line in lines)
    return f"<p>{html.escape(title)}:</p><ul>{items}</ul>" if items else ""


def pictures(figures: Sequence[tuple[str, Any]]) -> str:
    """Return Plotly figures with their captions, one after the other; the first carries the library."""
    from plotly import io

    library: Any = io
    return "".join(
        (f"<h2>{html.escape(caption)}</h2>" if caption else "")
        + library.to_html(figure, full_html=False, include_plotlyjs=n == 0)
        for n, (caption, figure) in enumerate(figures)
    )


def page(title: str, summary: str, body: str, footer: str) -> str:
    """Return a self-contained HTML page; the body is HTML, all else plain text."""
    return _PAGE.format(title=html.escape(title), summary=html.escape(summary), body=body, footer=html.escape(footer))


_PAGE = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>{title}</title>
<style>
body {{ font: 15px/1.5 system-ui, sans-serif; color: #222; margin: 2rem auto; max-width: 1150px; padding: 0 1rem; }}
h1 {{ font-size: 1.3rem; margin-bottom: .2rem; }}
h2 {{ font-size: 1.05rem; margin: 1.6rem 0 0; }}
table {{ border-collapse: collapse; margin: 1rem 0; }}
th {{ text-align: left; font-weight: normal; color: #555; padding: .15rem 2rem .15rem 0; }}
td {{ text-align: right; font-variant-numeric: tabular-nums; padding-left: 1.2rem; }}
footer {{ color: #777; font-size: .85rem; margin: 1rem 0; }}
</style></head><body>
<h1>{title}</h1>
<p>{summary}</p>
{body}
<footer>{footer}</footer>
</body></html>
"""
