"""What the files of runs, studies and reproductions are, in the words of their RO-Crate metadata."""

from __future__ import annotations

from typing import NamedTuple

from workflow.campaign.study import POINTS


class FileKind(NamedTuple):
    """What a file is: ``made`` by the run, or what it was made from."""

    media: str
    meaning: str
    made: bool = True


RUN_FILES = {
    "scene.toml": FileKind("application/toml", "the scene: every parameter, repeats the run", made=False),
    "deck.in": FileKind("text/plain", "the LAMMPS input", made=False),
    "grains.data": FileKind("text/plain", "initial grains, a LAMMPS data file", made=False),
    "run.json": FileKind("application/json", "status, command, versions, hashes and times of the run"),
    "run.h5": FileKind("application/x-hdf5", "the archive, H5MD: frames, contacts, time series, provenance"),
    "measures.json": FileKind("application/json", "the measures of the last frame"),
    "series.txt": FileKind("text/plain", "time series, a row for each sample"),
    "log.lammps": FileKind("text/plain", "the log of LAMMPS"),
    "grains.dump": FileKind("text/plain", "frames: grains, as LAMMPS wrote them"),
    "contacts.dump": FileKind("text/plain", "frames: contacts, as LAMMPS wrote them"),
    "tracks.dump": FileKind("text/plain", "positions of grains between the frames"),
}
STUDY_FILES = {
    POINTS: FileKind("application/json", "the points of the study: the values that make each scene", made=False),
    "results.csv": FileKind("text/csv", "what was varied and what came out, a row for each finished point"),
}
BOARD = "scoreboard.json"
BOARD_FILES = {
    BOARD: FileKind("application/json", "the scoreboard: number by number, ours beside the paper's"),
    "scoreboard.csv": FileKind("text/csv", "the numbers of the scoreboard, with seeds and digests"),
    "scoreboard.md": FileKind("text/markdown", "the scoreboard, to read"),
    "scoreboard.html": FileKind("text/html", "the scoreboard with its figures, for a browser"),
}
