"""One self-contained HTML page of a study: text, figures, tables."""

from __future__ import annotations

import base64
from collections.abc import Callable, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

from workflow.archive.write import replacing

_PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title><style>
:root {{ color-scheme: light dark; --ink: #222; --paper: #fff; --line: #ccc; --shade: #f4f4f4 }}
@media (prefers-color-scheme: dark) {{ :root {{ --ink: #ddd; --paper: #17181a; --line: #444; --shade: #222427 }} }}
body {{ font: 15px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--paper); max-width: 1150px;
  margin: 2rem auto; padding: 0 1rem }}
h1 {{ font-size: 1.5rem }} h2 {{ font-size: 1.15rem; margin-top: 2rem }}
img {{ width: 100%; background: #fff; border-radius: 4px }}
.wide {{ overflow-x: auto }}
table {{ border-collapse: collapse; font-size: 13px; font-variant-numeric: tabular-nums }}
th, td {{ padding: .2rem .6rem; border-bottom: 1px solid var(--line); text-align: left }}
tr:nth-child(even) td {{ background: var(--shade) }}
code {{ background: var(--shade); padding: .1rem .3rem }}
</style></head><body><h1>{title}</h1>{body}</body></html>
"""


def write_page(path: Path, title: str, parts: Sequence[tuple[str, Any]]) -> None:
    """Write a page of ``parts``: ("heading", text), ("text", text), ("code", text), ("image", file), ("table", rows as
    mappings)."""
    body = "\n".join(_PARTS[kind](content) for kind, content in parts)
    with replacing(path) as draft:
        draft.write_text(_PAGE.format(title=escape(title), body=body), encoding="utf-8")


def _table(rows: Sequence[Mapping[str, Any]]) -> str:
    head = "".join(f"<th>{escape(name.replace('_', ' '))}</th>" for name in rows[0])
    lines = ("".join(f"<td>{escape(_shown(value))}</td>" for value in row.values()) for row in rows)
    return f"<div class='wide'><table><tr>{head}</tr>{''.join(f'<tr>{line}</tr>' for line in lines)}</table></div>"


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
