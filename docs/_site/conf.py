"""Configuration of Sphinx for `docs/_site/build.py`; nothing of the site is fetched from elsewhere."""

from __future__ import annotations

from typing import Any

import latex2mathml.converter
from docutils import nodes
from pygments.lexers.special import TextLexer
from sphinx.application import Sphinx

from workflow import __version__

project = "workflow"
html_title = f"workflow {__version__}"
extensions = ["myst_nb", "sphinx_copybutton"]
html_theme = "furo"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_copy_source = html_show_sourcelink = html_show_copyright = False
html_math_renderer = "mathml"
copybutton_prompt_text = "$ "
myst_enable_extensions = ["dollarmath", "attrs_inline"]
myst_heading_anchors = 4
nb_execution_mode = "force"
nb_execution_in_temp = True
nb_execution_timeout = 300
nb_execution_raise_on_error = True
exclude_patterns = ["**/README.rst"]
highlight_language = "text"
smartquotes = False  # two dashes begin an option


def _mathml(text: str, display: str) -> str:
    return str(latex2mathml.converter.convert(text, display=display))


def _inline(writer: Any, node: nodes.math) -> None:
    writer.body.append(_mathml(node.astext(), "inline"))
    raise nodes.SkipNode


def _block(writer: Any, node: nodes.math_block) -> None:
    writer.body.append(f'<div class="math">{_mathml(node.astext(), "block")}</div>\n')
    raise nodes.SkipNode


def setup(app: Sphinx) -> None:
    """Set formulas as MathML, which browsers draw without a script; leave decks of LIGGGHTS without colours."""
    app.add_lexer("liggghts", TextLexer)
    app.add_html_math_renderer("mathml", inline_renderers=(_inline, None), block_renderers=(_block, None))
