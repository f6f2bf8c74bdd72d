"""Arrays as pandas DataFrames, for those who ask: pandas is an extra and loaded when it is used."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from workflow.errors import EnvironmentFault

if TYPE_CHECKING:
    import pandas


def data_frame(columns: Mapping[str, np.ndarray]) -> pandas.DataFrame:
    """Columns of equal length, (rows,), or (rows, 2) as NAME_x and NAME_y.  Raises EnvironmentFault without pandas."""
    try:
        import pandas
    except ImportError:
        raise EnvironmentFault("pandas is not installed; pip install pandas") from None
    flat: dict[str, np.ndarray] = {}
    for name, values in columns.items():
        flat |= {name: values} if values.ndim == 1 else {f"{name}_x": values[:, 0], f"{name}_y": values[:, 1]}
    return pandas.DataFrame(flat)
