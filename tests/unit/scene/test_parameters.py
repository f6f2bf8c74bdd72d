"""Parameters of a scene: ranges, rules across parameters, TOML, digest, the derived step."""

from __future__ import annotations

import math
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from drawn import examples
from hypothesis import given
from hypothesis import strategies as st

from workflow.deck.template import render
from workflow.errors import InputError
from workflow.scene.method1 import Method1
from workflow.scene.parameter import quantity_of
from workflow.scene.registry import read_toml, scene_from, to_toml

INF, NAN = math.inf, math.nan

# parameter: allowed values, refused values.  Written down apart from the code: this is the promise to users.
RANGES: dict[str, tuple[list[Any], list[Any]]] = {
    "n": ([10, 1400, 1400.0, 10**9], [0, -1, 10.5, 10**9 + 1, 10**400, NAN, INF, "60", True, None]),
    "phi0": ([1e-3, 0.36, 0.53, 0.6], [0.0, -0.1, 0.6000001, 1e-320, NAN, "0.3", None]),
    "smallest": ([0.01, 0.5, 1, 1.0], [0.0, 0.009, 1.001, NAN]),
    "seed": ([0, 1, 2**63 - 1], [-1, 2**63, 0.5, "1", NAN]),
    "mu": ([0, 0.15, 10.0, INF], [-1e-9, -INF, NAN, "inf", None]),
    "rolling": ([True, False], [0, 1, "true", None]),
    "cohesion": ([True, False], [0, 1, "no", None]),
    "kappa": ([100, 1e5, 1e8], [99.9, 1.1e8, -3, 0, INF, NAN, 10**400, None]),
    "zeta": ([0, 0.8, 2.0], [-0.1, 2.1, NAN]),
    "d0": ([1e-6, 1e-3, 0.1], [0, 9e-7, 0.11, NAN]),
    "kt_ratio": ([1e-3, 1, 10], [0, -1, 10.1, NAN]),
    "kr_ratio": ([1e-6, 1e-4, 1], [0, -1, 1.1, NAN]),
    "mur": ([0, 0.005, 0.5, None], [-0.1, NAN, "x"]),
    "pstar": ([1e-6, 0.01, 100], [0, -1, 101, NAN]),
    "law": (["granular", None], ["hooke", "Granular", "", 1]),
    "barostat": (["inertial", "nph", "berendsen"], ["Inertial", "nose", "", 1, None]),
    "initial": (["fluid", "random_addition", "addition_by_size"], ["Fluid", "", 1]),
    "as_printed": ([True, False], [0, "yes", None]),
    "cell": (["lengths", "strain"], ["Lengths", "eq. 3", "", 1]),
    "cell_mass": ([1e-3, 0.3, 1e4], [0, -1, 1.1e4, NAN]),
    "rate_cap": ([0, 0.05, 10], [-0.1, NAN, INF]),
    "wall_cap": ([0, 0.05, 10], [-0.1, NAN, INF]),
    "convention": ([-1, 0, 1], [-2, 2, 0.5, "0"]),
    "berendsen_rate": ([1e-3, 1, 10], [0, -1, 10.1, NAN, INF]),
    "force_tolerance": ([1e-8, 1e-4, 1], [0, -1, 1.1, NAN]),
    "energy_tolerance": ([1e-12, 5e-8, 1], [0, -1, 1.1, NAN]),
    "hold": ([0, 1, 100, None], [-1, NAN, INF]),
    "drag": ([0, 1, 100], [-1, 101, NAN]),
    "dashpots": ([0, 0.5, 1], [-0.1, 1.1, NAN, None]),
    "max_time": ([1e-3, 500, 1e6], [0, -1, NAN, INF, 1e300]),
    "step": ([1e-6, 1e-4, None], [0, -1e-4, 1.0, NAN, INF, 1e-320]),
    "steps_per_period": ([14, 28, 1e4], [13.9, 1.1e4, NAN]),
    "skin": ([0.05, 1.0, None], [0, -1, 1.1, NAN]),
    "scheme": (["second", "paper"], ["first", 2, None]),
    "account": ([True, False], [0, "yes", None]),
    "frame_interval": ([0, 0.1, 10], [-1, NAN, INF]),
    "series_interval": ([1e-3, 0.2, 100], [0, -1, NAN, INF]),
    "checkpoint_interval": ([1e-2, 5, 1000], [0, -1, NAN, INF]),
}


def test_table_has_every_parameter() -> None:
    assert set(RANGES) == {item.name for item in fields(Method1)}


@pytest.mark.parametrize("name", RANGES)
def test_range(name: str) -> None:
    for value in RANGES[name][0]:
        scene = scene_from({"scene": "method1", name: value})
        assert getattr(scene, name) == value
        assert render(scene)
    accepted = []
    for value in RANGES[name][1]:
        try:
            scene_from({"scene": "method1", name: value}).variables()
            accepted.append(value)
        except InputError as fault:
            assert f"{name} = " in str(fault)
            assert len(str(fault)) < 400
    assert not accepted


@pytest.mark.parametrize("name", RANGES)
def test_parameter_is_explained(name: str) -> None:
    item = next(item for item in fields(Method1) if item.name == name)
    assert len(quantity_of(item).meaning) > 8


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"kapa": 1e4}, ["'kapa'", "did you mean kappa"]),
        ({"coehsion": False}, ["'coehsion'", "cohesion"]),
        ({"zzzzzz": 1}, ["'zzzzzz'", "known are", "kappa", "mu"]),
        ({"skin": 0.05, "d0": 0.05}, ["skin = 0.05", "d0 = 0.05"]),
        ({"n": 5}, ["n = 5", "use n = "]),
        ({"n": 12, "skin": 1.0}, ["n = 12", "use n = "]),
        ({"step": 1e-3}, ["step = 0.001", "unstable", "at most"]),
    ],
)
def test_rule(values: dict[str, Any], words: list[str]) -> None:
    with pytest.raises(InputError) as fault:
        scene_from({"scene": "method1", **values})
    assert all(word in str(fault.value) for word in words), fault.value


@pytest.mark.parametrize("values", [{"smallest": 0.5}, {"smallest": 1.0}, {"smallest": 0.1, "skin": 0.5}])
def test_advice_on_the_number_of_grains_is_exact(values: dict[str, Any]) -> None:
    """The number that the message names is the smallest that is allowed."""
    with pytest.raises(InputError) as fault:
        Method1(n=1, **values)
    least = int(str(fault.value).split("use n = ")[1].split()[0])
    assert Method1(n=least, **values).n == least
    with pytest.raises(InputError):
        Method1(n=least - 1, **values)


def test_advice_on_the_step_is_usable() -> None:
    with pytest.raises(InputError) as fault:
        Method1(step=1.0)
    at_most = float(str(fault.value).split("use at most ")[1].split(",")[0])
    assert Method1(step=at_most).step == at_most


@pytest.mark.parametrize("values", [{}, {"scene": None}, {"scene": 1}, {"scene": ["method1"]}, {"scene": "method2x"}])
def test_scene_name(values: dict[str, Any]) -> None:
    with pytest.raises(InputError, match="method1"):
        scene_from(values)


scalars = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.integers(-(10**400), 10**400),
    st.floats(),
    st.text(max_size=8),
    st.just([1]),
    st.just({}),
)
names = st.one_of(st.sampled_from(sorted(RANGES)), st.text(max_size=8))
# half of the values from the allowed ones, or hardly any mapping would get past the first parameter
values = names.flatmap(
    lambda name: st.tuples(st.just(name), st.one_of(st.sampled_from(RANGES.get(name, ([0], []))[0]), scalars))
)


@given(st.lists(values, max_size=6))
@examples(100)
def test_any_mapping_gives_a_scene_that_renders_or_an_input_error(chosen: list[tuple[str, Any]]) -> None:
    try:
        scene = scene_from({"scene": "method1", **dict(chosen)})
        text = render(scene)
    except InputError as fault:
        assert str(fault)
        return
    assert "index inf" not in text
    assert "index nan" not in text


toml_texts = st.one_of(
    st.text(max_size=60),
    st.lists(
        st.sampled_from(
            [
                "scene",
                "=",
                '"method1"',
                "kappa",
                "mu",
                "n",
                "1e5",
                "inf",
                "nan",
                "[a]",
                "[[b]]",
                "{",
                "}",
                '"',
                "\n",
                "#",
                "0x_",
                "1979-05-27",
                ".",
            ]
        ),
        max_size=12,
    ).map(" ".join),
)


@given(toml_texts)
@examples(100)
def test_any_text_gives_a_scene_or_an_input_error(text: str) -> None:
    path = _scratch / "scene.toml"
    path.write_bytes(text.encode("utf-8", "surrogatepass"))
    try:
        scene_from(read_toml(path))
    except InputError as fault:
        assert str(fault)


_scratch = Path()


@pytest.fixture(autouse=True, scope="module")
def scratch(tmp_path_factory: pytest.TempPathFactory) -> None:
    global _scratch
    _scratch = tmp_path_factory.mktemp("toml")


def allowed(name: str) -> Any:
    return st.sampled_from(RANGES[name][0])


scenes = st.fixed_dictionaries({}, optional={name: allowed(name) for name in sorted(RANGES)})


@given(scenes)
@examples(50)
def test_toml_round_trip(chosen: dict[str, Any]) -> None:
    try:
        scene = scene_from({"scene": "method1", **chosen})
    except InputError:  # the values do not go together
        return
    path = _scratch / "round.toml"
    path.write_text(to_toml(scene), encoding="utf-8")
    again = scene_from(read_toml(path))
    assert again == scene
    assert again.digest == scene.digest
    assert again.variables() == scene.variables()


def test_digest_is_stable() -> None:
    """Names runs/method1-HASH of today are found again tomorrow: a change of this value is a change of the format."""
    assert Method1().digest == scene_from({"scene": "method1", "n": 1400.0, "mu": 0.5}).digest
    assert Method1(hold=None).digest == Method1().digest


@pytest.mark.parametrize("name", RANGES)
def test_digest_is_sensitive(name: str) -> None:
    default = Method1()
    others = {value for value in RANGES[name][0] if value is not None and value != getattr(default, name)}
    digests = {scene_from({"scene": "method1", name: value}).digest for value in others}
    assert len(digests) == len(others)
    assert default.digest not in digests


@pytest.mark.parametrize("mu", [0.0, 0.5])
def test_step_follows_the_stiffness(mu: float) -> None:
    """Omega is the square root of stiffness over mass: a hundred times stiffer, ten times shorter."""
    soft, stiff = (Method1(kappa=kappa, mu=mu, cohesion=False).step_choice for kappa in (1e4, 1e6))
    assert soft.step / stiff.step == pytest.approx(10.0, rel=1e-12)
    assert soft.period / stiff.period == pytest.approx(10.0, rel=1e-12)


@given(scenes)
@examples(50)
def test_step_stays_stable(chosen: dict[str, Any]) -> None:
    """Below a quarter of the period of two smallest discs on a spring: m* = m/2, omega^2 = 2 K_N/m."""
    try:
        scene = scene_from({"scene": "method1", **chosen})
    except InputError:
        return
    mass = scene.smallest**2
    pair = 2.0 * math.pi / math.sqrt(2.0 * scene.law_in_units.kn / mass)
    assert 0.0 < scene.step_choice.step < 0.25 * pair
    assert scene.step_choice.step <= 0.25 * scene.step_choice.period
    assert scene.step_choice.step <= scene.step_choice.limit


@pytest.mark.parametrize("mu", [0.0, 0.5])
@pytest.mark.parametrize("scheme", ["paper", "second"])
def test_strong_damping_shortens_the_step(mu: float, scheme: str) -> None:
    """A damping force that lags: the growth factor of x'' = -w^2 x - 2 z w x' turns above 1 at the limit."""
    choice = Method1(cohesion=False, mu=mu, zeta=2.0, scheme=scheme).step_choice
    assert choice.step < 0.5 * Method1(cohesion=False, mu=mu, zeta=0.1, scheme=scheme).step_choice.step
    frequency, z = math.sqrt(6.0 * 1e5) / 0.5, math.sqrt(3.0) * 2.0  # six contacts of K_N, mass 1/4
    now, before = {"paper": (1.0, 0.0), "second": (1.5, -0.5)}[scheme]  # shares of the last two half-step velocities

    def growth(step: float) -> float:
        """Largest eigenvalue of v += -(w^2 x + 2 z w v*) h, x += v h (leapfrog) in x, v, v of the step before."""
        kick, damp = frequency**2 * step, 2.0 * z * frequency * step
        v = np.array([-kick, 1.0 - damp * now, -damp * before])
        return float(np.abs(np.linalg.eigvals([np.array([1.0, 0.0, 0.0]) + step * v, v, [0.0, 1.0, 0.0]])).max())

    assert growth(0.99 * choice.limit) < 1.0 < growth(1.01 * choice.limit)
    assert choice.step < {"paper": 0.3, "second": 0.55}[scheme] * choice.limit


def test_friction_and_rolling_resistance_only_shorten_the_step() -> None:
    plain = Method1(cohesion=False, mu=0.0).step_choice.step
    friction = Method1(cohesion=False, mu=0.5).step_choice.step
    rolling = Method1(cohesion=False, mu=0.5, rolling=True, kr_ratio=1.0).step_choice.step
    assert plain > friction > rolling


def test_short_tail_shortens_the_step() -> None:
    """Five steps in D0 at the approach speed when that is less than the share of the period."""
    scene = Method1(d0=1e-6, pstar=100.0, kappa=100.0)
    assert scene.step_choice.step * scene.approach_speed * 5.0 == pytest.approx(1e-6, rel=1e-9)
    assert "tail" in scene.step_choice.reason
    longer = Method1(d0=1e-2, pstar=1e-4, kappa=1e6)
    assert "period" in longer.step_choice.reason
    assert (
        Method1(cohesion=False, d0=1e-6, kappa=100.0).step_choice.reason
        == Method1(cohesion=False, kappa=100.0).step_choice.reason
    )


def test_approach_speed_from_the_work_of_the_pressure() -> None:
    """N grains gain P (A_start - A_jammed) between them, A_jammed at solid fraction 0.8."""
    scene = Method1(cohesion=False, phi0=0.4, smallest=1.0)
    area = math.pi / 4.0  # of a grain of mass 1
    assert 0.5 * scene.approach_speed**2 == pytest.approx(1.0 * (area / 0.4 - area / 0.8), rel=1e-12)


def test_units_of_the_law() -> None:
    """kappa = K_N a/F0, or K_N/P without cohesion."""
    assert Method1(kappa=1e4).law_in_units.kn == 1e4
    assert Method1(kappa=1e4, cohesion=False).law_in_units.kn == 1e4
    assert Method1(kappa=1e4, cohesion=False).law_in_units.f0 == 0.0
    assert Method1(kappa=1e4, pstar=10.0).law_in_units.kn == 1e5
    assert Method1(rolling=True, mu=0.5).law_in_units.mur == pytest.approx(0.005, rel=1e-15)
    assert Method1(rolling=False, mur=0.3).law_in_units.mur == 0.0


def test_what_is_left_out() -> None:
    assert Method1(rolling=True).left_out() == []
    assert any("friction" in what for what in Method1(mu=0.0).left_out())
    assert any("attraction" in what for what in Method1(cohesion=False).left_out())
