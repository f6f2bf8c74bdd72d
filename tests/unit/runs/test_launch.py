"""Programs are started in one place, which says what they printed, and why they failed."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from workflow.errors import EngineError
from workflow.runs.installation import engine
from workflow.runs.launch import deck_command, run_deck, run_program

pytestmark = pytest.mark.engine


def python(program: str) -> list[str]:
    return [sys.executable, "-c", program]


def test_output_is_what_was_printed_and_then_the_log(tmp_path: Path) -> None:
    (tmp_path / "log.lammps").write_text("of an earlier run\n")
    done = run_program(python("print('said'); open('log.lammps', 'w').write('logged')"), tmp_path)
    assert (done.status, done.output()) == (0, "said\nlogged")
    assert run_program(python("print('said')"), tmp_path).output() == "said\n"


def test_failed_program_is_told_with_its_error_or_its_last_line(tmp_path: Path) -> None:
    for program, words in (
        ("import sys; print('ERROR: no such style'); print('more'); sys.exit(3)", "ERROR: no such style"),
        ("import sys; print('first', file=sys.stderr); print('last', file=sys.stderr); sys.exit(1)", "last"),
        ("import sys; sys.exit(7)", "exit status 7, no message"),
    ):
        done = run_program(python(program), tmp_path)
        assert done.words == words
        with pytest.raises(EngineError, match=f"stopped: {words}"):
            done.output()


def test_program_without_end_is_ended_after_the_patience(tmp_path: Path) -> None:
    with pytest.raises(EngineError, match="did not end within 1 s"):
        run_program(python("import os, time; open('pid', 'w').write(str(os.getpid())); time.sleep(60)"), tmp_path, patience=1.0)
    with pytest.raises(ProcessLookupError):
        os.kill(int((tmp_path / "pid").read_text()), 0)


def test_values_become_variables_of_the_deck_and_its_words_the_message(tmp_path: Path) -> None:
    (tmp_path / "deck.in").write_text("log log.lammps\nprint 'RESULT $(2*v_half)'\n")
    assert "RESULT 7" in run_deck(tmp_path, "deck.in", {"half": 3.5}).output()
    assert "half" in run_deck(tmp_path, "deck.in").words


def test_ranks_are_started_by_the_mpiexec_of_the_engine() -> None:
    found = engine()
    alone = deck_command(found, "deck.in", {"n": 1}, 1)
    assert alone[-3:] == ["deck.in", "n", "1"]
    assert deck_command(found, "deck.in", {"n": 1}, 3) == [str(found.mpiexec), "-n", "3", *alone]
