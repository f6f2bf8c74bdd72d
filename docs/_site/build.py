"""Build the site of the documentation: python docs/_site/build.py [FOLDER], by default site/.

Pages, notebooks and pictures of docs/, pages of other folders, files that they link to, pages and figures made from the code
are put together in build/site, with the links of the site; Sphinx does the rest.  A warning is an error.
"""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

from law_figures import law_figures
from reference import generated_pages
from repository import PAGES_OF_DOCS, ROOT, linked_files, navigation, outside_pages, rewritten, site_path
from sphinx.cmd.build import main as sphinx

HERE = Path(__file__).resolve().parent
STAGED = ROOT / "build" / "site"


def stage() -> None:
    """Write the source tree of the site, anew."""
    shutil.rmtree(STAGED, ignore_errors=True)
    for path in (*PAGES_OF_DOCS, *outside_pages(), *linked_files()):
        site = site_path(path)
        target = STAGED / site
        target.parent.mkdir(parents=True, exist_ok=True)
        if path.endswith(".md"):
            target.write_text(rewritten((ROOT / path).read_text(encoding="utf-8"), path), encoding="utf-8")
        else:
            shutil.copyfile(ROOT / path, target)
    for site, content in {**generated_pages(), **law_figures()}.items():
        target = STAGED / site
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(content if isinstance(content, bytes) else content.encode())
    for site, contents in navigation().items():
        with open(STAGED / site, "a", encoding="utf-8") as page:
            page.write(contents)


def main(words: list[str]) -> int:
    """Stage and build; the status of Sphinx."""
    os.environ["COLUMNS"] = "100"  # width of the usage of commands
    stage()
    out = Path(words[0]) if words else ROOT / "site"
    shutil.rmtree(out, ignore_errors=True)
    return sphinx(["-q", "-W", "--keep-going", "-c", str(HERE), "-d", str(ROOT / "build" / "doctrees"), str(STAGED), str(out)])


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
