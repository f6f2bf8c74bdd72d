"""One self-contained HTML page: its frame, style and tables; the pages of studies are text, figures and tables."""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any

from workflow.data.files import atomic_write
from workflow.reports.figures import BLUE, FILL, GREEN, INK, ORANGE, OUTLINE, RATTLER, RED

COLOURS = {"red": RED, "green": GREEN, "blue": BLUE, "orange": ORANGE, "ink": INK, "fill": FILL, "rattler": RATTLER,
           "outline": OUTLINE}  # fmt: skip


def template(name: str) -> str:
    """The text of a file of templates/."""
    return files("workflow.reports").joinpath("templates", name).read_text(encoding="utf-8")


def document(title: str, body: str, *, style: str = "", script: str = "", data: Any = None) -> str:
    """The whole page.  ``body``: HTML; ``style`` and ``script`` beside those of every page; ``data``: JSON for the script.

    Nothing from elsewhere is loaded and no script but this one runs: the page's own policy forbids it to the browser.
    """
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode("ascii")
    return Template(template("page.html")).substitute(
        title=escape(title), body=body, style=Template(template("page.css")).substitute(COLOURS) + style, script=script,
        policy=f"'sha256-{digest}'" if script else "'none'",
        # no tag can begin inside the data, whatever a name in them says
        data=json.dumps(data, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c"),
    )  # fmt: skip


def write_page(path: Path, title: str, parts: Sequence[tuple[str, Any]]) -> None:
    """Write a page of ``parts``: ("heading", text), ("text", text), ("code", text), ("image", file), ("table", rows as
    mappings)."""
    body = "\n".join(_PARTS[kind](content) for kind, content in parts)
    with atomic_write(path) as draft:
        draft.write_text(document(title, f"<h1>{escape(title)}</h1>{body}"), encoding="utf-8")


def _table(rows: Sequence[Mapping[str, Any]]) -> str:
    return table([name.replace("_", " ") for name in rows[0]], [[_shown(value) for value in row.values()] for row in rows])


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table of texts; the first column names the row."""
    top = "".join(f'<th scope="col">{escape(name)}</th>' for name in head)
    lines = (
        f'<tr><th scope="row">{escape(row[0])}</th>{"".join(f"<td>{escape(cell)}</td>" for cell in row[1:])}</tr>'
        for row in rows
    )
    return f'<div class="wide"><table><thead><tr>{top}</tr></thead><tbody>{"".join(lines)}</tbody></table></div>'


def _shown(value: Any) -> str:
    return "—" if value is None else f"{value:.3g}" if isinstance(value, float) else str(value)


def _image(path: Path) -> str:
    return f"<img alt='{escape(path.stem)}' src='data:image/png;base64,{base64.b64encode(path.read_bytes()).decode()}'>"


_PARTS: dict[str, Callable[[Any], str]] = {
    "heading": lambda text: f"<h2>{escape(text)}</h2>",
    "text": lambda text: f"<p>{escape(text)}</p>",
    "code": lambda text: f"<p><code>{escape(text)}</code></p>",
    "image": _image,
    "table": _table,
}
