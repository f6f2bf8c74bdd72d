"""Groups of measures: JSON, agreement with each other, and pooling over samples."""

import json
from dataclasses import replace

import numpy as np
import pytest
from networks import double_triangle, packing, together

from workflow.data.build import make_frame, repeat
from workflow.data.contact_law import ContactLaw
from workflow.errors import InputError
from workflow.measures.density import scattering
from workflow.measures.registry import GROUPS, Settings, chosen_groups, measure_groups, plain, shells
from workflow.measures.rigidity import rigidity
from workflow.measures.samples import pool

LAW = ContactLaw(kn=1.0, kt=1.0, mu=0.5, kr=1e-2)
SETTINGS = Settings(LAW)


def stressed(seed: int, grains: int = 60):
    """A random packing with random forces of both signs."""
    frame, rng = packing(grains, 0.82, seed), np.random.default_rng(seed)
    table = frame.interactions
    pairs = {"i": table.i, "j": table.j, "branch": table.branch, "gap": table.gap,
             "normal": rng.normal(size=len(table)), "tangential": rng.normal(size=len(table))}  # fmt: skip
    return make_frame(frame.position, frame.diameter, frame.cell, pairs)


@pytest.mark.parametrize("law", [LAW, replace(LAW, mur=5e-3), replace(LAW, mu=0.0, f0=1.0)])
def test_every_group_is_plain_json(law):
    result = measure_groups(stressed(1), Settings(law), chosen_groups(["all"], 0))
    assert json.loads(json.dumps(result, allow_nan=False)) == result
    assert list(result) == list(GROUPS)
    broken = {name: part["error"] for name, part in result.items() if "error" in part}
    assert set(broken) <= ({"rigid_clusters"} if not law.mu else set()), broken


def test_groups_agree_with_each_other():
    frame = stressed(2)
    result = measure_groups(frame, SETTINGS, list(GROUPS))
    populations = result["forces"]["populations"]
    z = sum(populations[sign]["coordination"] for sign in ("repulsive", "tensile", "vanishing"))
    assert z == pytest.approx(2 * len(frame.interactions) / frame.grains)
    fixed = rigidity(frame, law=LAW)
    assert result["self_stress"]["states"] == fixed.hyperstaticity == sum(result["self_stress"]["hyperstaticity"])
    floppy = result["floppy_modes"]
    assert floppy["mechanisms"] + 3 * floppy["loose_grains"] == fixed.mechanisms
    assert sum(s * n for s, n in zip(*result["clusters"]["aggregates"]["sizes"].values(), strict=True)) == frame.grains
    assert result["clusters"]["stressed"]["loops"] <= result["clusters"]["aggregates"]["loops"]
    assert result["vibrations"]["frequency"].count(0.0) == fixed.floppy_modes
    covered = result["holes"]["grid"]["number"]
    assert covered >= result["holes"]["number"] > 0  # at a contact the mesh pinches off cusps


def test_self_stress_of_known_clusters():
    found = measure_groups(together(double_triangle(), double_triangle()), SETTINGS, ["self_stress"])["self_stress"]
    assert found == {"states": 2, "number": 2, "hyperstaticity": [1, 1], "grains": [4, 4], "interactions": [5, 5]}


def test_what_is_measured_unasked_depends_on_size():
    assert "rigidity" in chosen_groups(None, 1400)
    assert "rigidity" not in chosen_groups(None, 10**6)
    assert chosen_groups(["none"], 10) == []
    assert chosen_groups(["holes", "forces"], 10) == ["holes", "forces"]
    with pytest.raises(InputError, match="'hoels' is no group"):
        chosen_groups(["hoels"], 10)


def test_a_group_that_cannot_be_had_says_why_and_spares_the_others():
    lonely = make_frame([[1.0, 1.0]], 1.0, (6.0, 6.0))
    found = measure_groups(lonely, Settings(replace(LAW, mu=0.0)), ["rigid_clusters", "forces"])
    assert "friction" in found["rigid_clusters"]["error"]
    assert found["forces"]["percolation"]["threshold"] is None


def test_numbers_without_value_become_none():
    assert plain({"a": np.array([1.0, np.nan]), "b": (np.float64(np.inf), np.int64(3))}) == {"a": [1.0, None], "b": [None, 3]}


def test_pooling_gives_mean_and_standard_deviation():
    samples = [{"x": 1.0, "flag": True, "list": [1, 2], "none": None, "text": "a", "deep": {"y": 4}, "uneven": [1]},
               {"x": 3.0, "flag": False, "list": [3, 2], "none": 2.0, "text": "b", "deep": {"y": 4}, "uneven": [1, 2]}]  # fmt: skip
    pooled = pool(samples, SETTINGS)
    assert pooled["x"] == {"mean": 2.0, "scatter": pytest.approx(np.sqrt(2.0)), "samples": 2}
    assert pooled["flag"] == {"true": 1, "samples": 2}
    assert pooled["list"] == {"mean": [2.0, 2.0], "scatter": [pytest.approx(np.sqrt(2.0)), 0.0]}
    assert pooled["none"] == {"mean": 2.0, "scatter": None, "samples": 1}
    assert pooled["deep"]["y"] == {"mean": 4.0, "scatter": 0.0, "samples": 2}
    assert "text" not in pooled
    assert "uneven" not in pooled
    with pytest.raises(InputError, match="no samples"):
        pool([], SETTINGS)


def test_intensities_of_samples_of_any_size_are_averaged_shell_by_shell():
    small, large = stressed(4), repeat(stressed(5), (3, 3))
    pooled = pool([measure_groups(frame, SETTINGS, ["density"]) for frame in (small, large)], SETTINGS)["density"]["shells"]
    edges = shells(large, SETTINGS)
    twins = [scattering(frame, edges) for frame in (small, large)]
    assert pooled["edges"] == pytest.approx(edges.tolist())
    both = (twins[0].vectors > 0) & (twins[1].vectors > 0)
    mean = (twins[0].intensity + twins[1].intensity) / 2
    error = np.abs(twins[0].intensity - twins[1].intensity) / 2  # of two values
    for row in np.flatnonzero(both):
        assert pooled["intensity"][row] == pytest.approx(mean[row])
        assert pooled["error"][row] == pytest.approx(error[row])
    alone = (twins[0].vectors == 0) & (twins[1].vectors > 0)
    assert alone.any()
    assert [pooled["error"][row] for row in np.flatnonzero(alone)] == [None] * int(alone.sum())
