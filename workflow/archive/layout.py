"""Where things are in a run's HDF5 file (H5MD 1.1 with the contact tables, stage names and provenance beside it)."""

from dataclasses import fields

from workflow.data.frame import Interactions

GRAINS = "particles/grains"

# Time-dependent per-grain data: name in the file -> field of Frame.  The first three have a zero third component,
# because H5MD readers expect three dimensions.  A grain absent from a frame (not yet poured, or gone) holds NaN.
VECTORS = {"position": "position", "velocity": "velocity", "force": "force"}
SCALARS = {"angular_velocity": "omega", "torque": "torque"}
# Per-grain data that never change, (grains,) each.
CONSTANTS = {"id": "ids", "mass": "mass", "diameter": "diameter"}

# Contact tables of all frames end to end; frame k owns rows offset[k]:offset[k+1].  "i" and "j" are grain ids.
CONTACTS = "contacts"
OFFSET = "contacts/offset"
# field of Interactions -> name in the file; two were named before the words of docs/glossary.md
COLUMNS = {field.name: field.name for field in fields(Interactions)} | {"xi_t": "stretch", "xi_r": "rotation"}

# Positions of all grains at short intervals: time (F,), id (G,), position (F, G, 2), float32; only of scenes that ask for it.
TRACKS = "tracks"

STAGE = "stage"
PROVENANCE = "provenance"
# Time series.  MDAnalysis reads row k of every observable with frame k and fails when there is none, so a series with
# fewer rows than frames goes to SHORT_SERIES instead.
SERIES = "observables"
SHORT_SERIES = "series"

UNITS = ("length_unit", "force_unit", "time_unit")  # attributes of the file; each dataset has ``units`` (workflow.data.units)


def quantity_of(path: str) -> tuple[str, bool]:
    """Name under which `workflow.data.units` knows a dataset, and whether it is a column of the time series."""
    parts = path.split("/")
    leaf = parts[-2] if parts[-1] == "value" else parts[-1]
    if parts[0] in (SERIES, SHORT_SERIES):
        return leaf, True
    fields_of = VECTORS | SCALARS | CONSTANTS | {"edges": "cell"} | {stored: field for field, stored in COLUMNS.items()}
    return fields_of.get(leaf, "ids" if leaf == "id" else leaf), False


# What must be there: path -> (kinds of NumPy type, shape).  F frames, G grains, M contacts of all frames; numbers as they are.
REQUIRED: dict[str, tuple[str, tuple[str | int, ...]]] = {
    STAGE: ("SO", ("F",)),
    f"{GRAINS}/position/step": ("iu", ("F",)),
    f"{GRAINS}/position/time": ("f", ("F",)),
    f"{GRAINS}/box/edges/value": ("f", ("F", 3)),
    f"{GRAINS}/box/origin/value": ("f", ("F", 2)),
    **{f"{GRAINS}/{name}": ("iu" if name == "id" else "f", ("G",)) for name in CONSTANTS},
    **{f"{GRAINS}/{name}/value": ("f", ("F", "G", 3)) for name in VECTORS},
    **{f"{GRAINS}/{name}/value": ("f", ("F", "G")) for name in SCALARS},
    OFFSET: ("iu", ("F+1",)),
    **{
        f"{CONTACTS}/{name}": (
            {"i": "iu", "j": "iu", "sliding": "b", "rolling": "b"}.get(name, "f"),
            ("M", 2) if name == "branch" else ("M",),
        )
        for name in COLUMNS.values()
    },
}
