"""The contact table of LAMMPS's computes as interactions: signs, parts of the normal force, limits, both orders of a pair."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from workflow.archive.dumps import Block
from workflow.archive.lammps_contacts import LammpsLaw, with_lammps_contacts
from workflow.data.balance import balance
from workflow.data.build import make_frame
from workflow.data.contact_law import ContactLaw
from workflow.data.frame import NO_CONTACTS, Frame
from workflow.errors import ArchiveError

LAW = ContactLaw(kn=1000.0, kt=1000.0, zeta=0.5, mu=0.5, f0=1.0, d0=0.01, kr=1.0, mur=0.01)
TOLD = LammpsLaw(LAW, 0.1875)
COLUMNS = ("id_i", "id_j", "fx", "fy", "tx", "ty", "rx", "ry")


def pair(gap: float) -> Frame:
    """Disc 1 of diameter 1 and disc 2 of diameter 0.5 above it across the periodic face."""
    frame = make_frame(np.array([[2.0, 3.9], [2.0, 0.65 + gap]]), np.array([1.0, 0.5]), np.array([4.0, 4.0]))
    return replace(frame, interactions=NO_CONTACTS)


def seen(gap: float, *row: float, columns: tuple[str, ...] = COLUMNS) -> Frame:
    block = Block(0, 0.0, np.zeros((3, 2)), columns, np.array([row]), 9)
    return with_lammps_contacts(block, pair(gap), TOLD, "contacts.dump")


# n is +y and t is -x, from grain 1 to grain 2: the force on 1 is -N n - T t
N, T = 1.5, 0.4


@pytest.mark.parametrize("swapped", [False, True])
def test_forces_have_the_signs_of_a_frame_whichever_grain_comes_first(swapped: bool) -> None:
    sign = -1.0 if swapped else 1.0
    ends = (2.0, 1.0) if swapped else (1.0, 2.0)
    rolled = 0.3
    frame = seen(-0.002, *ends, 0.0, -sign * N, sign * T, 0.0, rolled, 0.0)
    table = frame.interactions
    assert (table.i[0], table.j[0]) == (0, 1)
    assert table.branch[0] == pytest.approx([0.0, 0.748])
    assert table.normal_force[0] == pytest.approx(N) and table.tangential[0] == pytest.approx(T)
    assert table.elastic[0] == pytest.approx(2.0) and table.attraction[0] == -1.0 and table.viscous[0] == pytest.approx(0.5)
    assert balance(frame).force[1] == pytest.approx([-T, N])
    # r is the same whichever comes first, n is not; it acts at R* = 1/6: a moment R* (n x r) of i on j
    assert table.moment[0] == pytest.approx(-rolled / 6)


def test_elastic_displacements_are_undefined_not_zero() -> None:
    frame = seen(-0.002, 1, 2, 0.0, -N, T, 0.0, 0.0, 0.0)
    assert frame.lacks == {"xi_t", "xi_r"}
    assert np.isnan(frame.interactions.xi_t).all() and np.isnan(frame.interactions.xi_r).all()


def test_a_pair_in_the_tail_is_attracted_and_one_beyond_is_none() -> None:
    frame = seen(0.004, 1, 2, 0.0, 0.6, 0.0, 0.0, 0.0, 0.0)
    assert frame.interactions.attraction[0] == pytest.approx(-0.6) and frame.interactions.normal_force[0] == pytest.approx(-0.6)
    assert not frame.interactions.in_contact.any() and frame.interactions.viscous[0] == 0.0
    assert len(seen(0.02, 1, 2, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0).interactions) == 0


@pytest.mark.parametrize(("tangential", "slides"), [(0.5 * 2.5, True), (0.5 * 2.4, False)])
def test_a_contact_slides_where_it_is_at_the_limit_that_lammps_has(tangential: float, slides: bool) -> None:
    """mu |N without the attraction|."""
    assert bool(seen(-0.002, 1, 2, 0.0, -N, tangential, 0.0, 0.0, 0.0).interactions.sliding[0]) is slides


def test_without_rolling_columns_there_is_no_moment() -> None:
    frame = seen(-0.002, 1, 2, 0.0, -N, T, 0.0, columns=COLUMNS[:6])
    assert frame.interactions.moment[0] == 0.0


def test_a_missing_column_is_an_error_that_names_it() -> None:
    with pytest.raises(ArchiveError, match="column tx, ty missing"):
        seen(-0.002, 1, 2, 0.0, -N, columns=COLUMNS[:4])
