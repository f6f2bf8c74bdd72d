"""Scene method2: the paper's sets, the Maxwell gas, what is imposed and how stiff contacts are in which stage."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from workflow.errors import InputError
from workflow.scene.method1 import Method1
from workflow.scene.method2 import Method2
from workflow.scene.placement import VELOCITIES, gaussian
from workflow.scene.registry import scene_from, to_toml


@pytest.mark.parametrize(
    ("given", "expected"),
    [  # Phi_I, kappa while aggregating, kappa at the end: G07 sec. III B 2 and table IV
        ({}, (0.36, 1e5, 1e5)),
        ({"series": "A"}, (0.36, 1e5, 1e5)),
        ({"series": "A0"}, (0.13, 1e5, 1e5)),
        ({"series": "B"}, (0.26, 1e2, 1e4)),
        ({"series": "B", "phi0": 0.3}, (0.3, 1e2, 1e4)),
        ({"series": "B", "kappa": 1e3}, (0.26, 1e2, 1e3)),
        ({"kappa": 1e4}, (0.36, 1e4, 1e4)),
        ({"kappa": 1e4, "soft_kappa": 1e3}, (0.36, 1e3, 1e4)),
    ],
)
def test_series(given: dict[str, Any], expected: tuple[float, float, float]) -> None:
    scene = scene_from({"scene": "method2", **given})
    assert isinstance(scene, Method2)
    assert (scene.phi0, scene.soft_law.kn, scene.law_in_units.kn) == pytest.approx(expected)
    soft, hard = scene.soft_law, scene.law_in_units
    assert soft.kt / soft.kn == pytest.approx(hard.kt / hard.kn)
    assert soft.kr / soft.kn == pytest.approx(hard.kr / hard.kn)


def test_toml_repeats_the_scene() -> None:
    scene = Method2(series="B", mur=0.5, rolling=True)
    assert 'series = "B"' in to_toml(scene)
    assert scene_from({"scene": "method2", **scene.as_mapping()}) == scene


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"cohesion": False}, "no aggregate"),
        ({"barostat": "berendsen"}, "barostat"),
        ({"series": "C"}, "series"),
        ({"v0": -1.0}, "v0"),
        ({"soft_kappa": 1.0}, "soft_kappa"),
    ],
)
def test_value_that_is_not_allowed_is_named(given: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        scene_from({"scene": "method2", **given})


def test_same_gas_as_method_1() -> None:
    """G07: both methods start from the same I-state."""
    one, two = Method1(n=80, seed=3).discs(), Method2(n=80, seed=3).discs()
    assert np.array_equal(one.diameter, two.diameter)
    assert np.array_equal(one.position, two.position)


def test_gas_has_the_speed_asked_for_and_no_momentum() -> None:
    scene = Method2(n=300, v0=0.95, d0=4e-3)
    discs = scene.discs()
    velocity = discs.velocity
    assert velocity is not None
    mass_of_square = np.mean(discs.diameter**2 * (velocity**2).sum(axis=1))  # of a disc of mass 1 at the same temperature
    assert np.sqrt(mass_of_square) == pytest.approx(0.95 * math.sqrt(4e-3), rel=1e-12)
    # 300 terms of order 0.06, each rounded at 1e-16
    assert np.abs(discs.diameter**2 @ velocity).max() < 1e-14
    assert scene.start_energy == pytest.approx(0.5 * np.sum(discs.diameter**2 * (velocity**2).sum(axis=1)), rel=1e-12)


SIZES = np.random.default_rng(8).uniform(0.5, 1.0, 40_000)


@pytest.mark.parametrize("meaning", VELOCITIES)
def test_meanings_of_v0(meaning: str) -> None:
    """Momentum zero, and exactly V0 in that which V0 means; of uniform sizes the others follow from the moments of d."""
    velocity, mass = gaussian(SIZES, 0.3, meaning, np.random.default_rng(5)), SIZES**2
    square = (velocity**2).sum(axis=1)
    assert np.abs(mass @ velocity).max() < 1e-10  # 40 000 terms of order 0.1, each rounded at 1e-17
    rms, energy = np.sqrt(np.mean(square)), np.mean(mass * square)
    # <1/d^2> = 2 and <d^2> = 7/12 of d uniform in [1/2, 1]
    expected = {
        "temperature": (0.3, 0.3**2 / 2.0), "unit_disc": (0.3 * math.sqrt(2.0), 0.3**2),
        "same": (0.3, 0.3**2 * 7.0 / 12.0), "mean_energy": (0.3 * math.sqrt(12.0 / 7.0), 0.3**2),
    }[meaning]  # fmt: skip
    named = 1 if meaning in ("unit_disc", "mean_energy") else 0
    assert (rms, energy)[named] == pytest.approx(expected[named], rel=1e-12)
    # means of exponential distributions: 1/sqrt(40000) = 0.5 %, four standard deviations
    assert (rms, energy)[1 - named] == pytest.approx(expected[1 - named], rel=0.02)
    # equal temperature: m <v^2> does not depend on size; one Gaussian: <v^2> does not
    small = SIZES < 0.75
    alike = mass * square if meaning in ("temperature", "unit_disc") else square
    assert alike[small].mean() == pytest.approx(alike[~small].mean(), rel=0.03)
    other = square if meaning in ("temperature", "unit_disc") else mass * square
    assert abs(other[small].mean() / other[~small].mean() - 1.0) > 0.3
    component = velocity[:, 0] * (SIZES if meaning in ("temperature", "unit_disc") else 1.0)
    # kurtosis 3 of a Gaussian, standard error sqrt(24/40000) = 0.025; neither axis nor sign is preferred
    assert np.mean((component / component.std()) ** 4) == pytest.approx(3.0, abs=0.1)
    assert np.mean(velocity[:, 0] ** 2) == pytest.approx(np.mean(velocity[:, 1] ** 2), rel=0.03)


def test_meanings_differ_by_scale_or_weight_alone() -> None:
    """The same draw: equal temperatures are one gas at two speeds, and so are equal Gaussians."""
    draw = {meaning: gaussian(SIZES[:200], 0.3, meaning, np.random.default_rng(5)) for meaning in VELOCITIES}
    for one, two in (("temperature", "unit_disc"), ("same", "mean_energy")):
        ratio = draw[one] / draw[two]
        assert ratio == pytest.approx(ratio[0, 0], rel=1e-12)
        assert ratio[0, 0] < 0.95


@pytest.mark.parametrize("meaning", VELOCITIES)
def test_one_grain_does_not_move(meaning: str) -> None:
    assert not gaussian(np.ones(1), 1.0, meaning, np.random.default_rng(0)).any()


def test_meaning_of_v0_reaches_the_gas() -> None:
    """A disc of mass 1 has V0 V* in the mean square, instead of the mean over all."""
    usual, unit = (Method2(n=300, velocities=meaning).discs() for meaning in ("temperature", "unit_disc"))
    assert usual.velocity is not None and unit.velocity is not None
    mean = np.mean(unit.diameter**2 * (unit.velocity**2).sum(axis=1))
    assert mean == pytest.approx(9.48**2 * 1e-3, rel=1e-12)
    assert np.array_equal(np.sign(usual.velocity), np.sign(unit.velocity))


def test_stages_know_their_law_and_stress() -> None:
    scene = Method2(series="B", pstar=0.02)
    assert [scene.pressure_of(stage) for stage in scene.stages.values()] == [None, None, 0.0, 0.0, 0.02, 0.02]
    assert [scene.law_of(stage).kn for stage in scene.stages.values()] == pytest.approx([1e2, 1e2, 1e2, 1e4, 1e4, 1e4])


def test_fast_gas_takes_a_smaller_step() -> None:
    """Five steps in the tail at the root mean square of the relative velocity; the aggregate is not fast any more."""
    fast, usual = Method2(n=50, v0=95.0), Method2(n=50, v0=9.48)
    assert fast.step_of("aggregate").step * 5.0 * math.sqrt(2.0) * 95.0 * math.sqrt(1e-3) == pytest.approx(1e-3)
    assert {fast.step_of(stage).step for stage in list(fast.stages.values())[1:]} == {usual.step_choice.step}
    assert usual.step_of("aggregate").step == Method2(n=50, v0=0.0).step_choice.step


def test_soft_contacts_take_a_longer_step() -> None:
    """In proportion to 1/sqrt(kappa), as G07 sec. III B 2 says, unless the tail sets it; hard ones whatever the order."""
    scene = Method2(series="B", v0=0.1, pstar=0.0)
    assert scene.step_of("relax").step == pytest.approx(10.0 * scene.step_of("load").step)
    assert scene.step_of("stiffen") == scene.step_of("settle") == scene.step_choice
    softer = Method2(kappa=1e3, soft_kappa=1e5)
    assert softer.step_of("stiffen").step == Method2(kappa=1e5).step_choice.step
    given = Method2(series="B", step=1e-4)
    assert {given.step_of(stage).step for stage in given.stages.values()} == {1e-4}
