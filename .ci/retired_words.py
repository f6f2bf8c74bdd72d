"""Keep the words of the table "Retired words" in docs/glossary.md out of code.

    python .ci/retired_words.py [ROOT]      status 1 and one line "file:line: old, say new" for each that is found

Names are searched, not prose: of Python the name tokens, of C++ and of decks the words outside comments and strings.  A
cell of the first column holds one or more `words`; (folders) behind them, as in "`sweep` (plugins)", confine the row to
those, another remark says of which thing they are no name any more and cannot be checked.  A line that reads files of
older versions keeps their names and says so by the mark "retired:" in a comment.
"""

from __future__ import annotations

import io
import re
import sys
import tokenize
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

FOLDERS = ("plugins", "workflow", "lammps_inputs")
HEADING = "## Retired words"
MARK = "retired:"
ROW = re.compile(r"^\|(?P<old>[^|]*)\|(?P<new>[^|]*)\|", re.MULTILINE)
CODE = re.compile(r"`([^`]+)`")
SCOPE = re.compile(r"\(([^()`]+)\)\s*$")
CXX_PROSE = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"', re.DOTALL)
DECK_PROSE = re.compile(r"#[^\n]*|^\s*print\b[^\n]*", re.MULTILINE)


@dataclass(frozen=True)
class Retired:
    """A word that is not to be used, the standard one, and the folders it is kept out of."""

    word: str
    standard: str
    folders: tuple[str, ...]


def table(page: str) -> list[Retired]:
    """Rows of the table.  Raises SystemExit where heading or rows are missing, so that the check cannot pass by chance."""
    if HEADING not in page:
        raise SystemExit(f"docs/glossary.md has no heading '{HEADING}'")
    section = page.split(HEADING, 1)[1].split("\n## ", 1)[0]
    rows = []
    for row in ROW.finditer(section):
        scope = SCOPE.search(row["old"].rstrip())
        folders = tuple(re.split(r"[,\s]+", scope[1].strip())) if scope else FOLDERS
        if not set(folders) <= set(FOLDERS):
            continue  # a remark: retired as the name of one thing
        for word in CODE.findall(row["old"]):
            rows.append(Retired(word.removesuffix("()"), row["new"].strip(), folders))
    if not rows:
        raise SystemExit(f"docs/glossary.md: the table under '{HEADING}' holds no `word`")
    return rows


def without(prose: re.Pattern[str], text: str) -> str:
    """The text with its prose blanked out, line numbers kept."""
    return prose.sub(lambda found: re.sub(r"[^\n]", " ", found[0]), text)


def names(path: Path, text: str) -> Iterator[tuple[int, str]]:
    """(line, name) of every name that the file uses."""
    if path.suffix == ".py":
        for token in tokenize.generate_tokens(io.StringIO(text).readline):
            if token.type == tokenize.NAME:
                yield token.start[0], token.string
        return
    deck = path.suffix == ".in"
    code = without(DECK_PROSE if deck else CXX_PROSE, text)
    for number, line in enumerate(code.splitlines(), 1):
        for word in re.findall(r"[A-Za-z_]\w*(?:\.in\b)?", line):
            yield number, re.sub(r"^[vcf]_", "", word) if deck else word


def found_in(root: Path, rows: Iterable[Retired]) -> Iterator[str]:
    """A line for every retired word that stands in code, or names a file."""
    for folder in FOLDERS:
        retired = {row.word: row.standard for row in rows if folder in row.folders}
        for path in sorted((root / folder).rglob("*")):
            if path.suffix not in (".py", ".h", ".cpp", ".in"):
                continue
            here, text = path.relative_to(root), path.read_text(encoding="utf-8")
            if path.name in retired:
                yield f"{here}: retired name of a file, say {retired[path.name]}"
            lines = text.splitlines()
            for number, name in names(path, text):
                word = name.lstrip("_")  # private names too
                if word in retired and MARK not in lines[number - 1]:
                    yield f"{here}:{number}: '{word}' is retired, say {retired[word]}"


def main(root: Path) -> int:
    """Print what is found; the exit status."""
    rows = table((root / "docs" / "glossary.md").read_text(encoding="utf-8"))
    lines = list(found_in(root, rows))
    print("\n".join(lines) if lines else f"{len(rows)} retired words, none in code")
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parents[1]))
