"""Every kernel points to the words it uses; `.ci/retired_words.py` keeps the retired ones out of it."""

from __future__ import annotations

from pathlib import Path

import pytest

KERNELS = Path(__file__).parents[3] / "plugins" / "kernels"


@pytest.mark.parametrize("kernel", sorted(KERNELS.glob("*.h")), ids=lambda file: file.name)
def test_every_kernel_points_to_the_glossary(kernel: Path) -> None:
    assert "docs/glossary.md" in kernel.read_text().split("*/")[0]
