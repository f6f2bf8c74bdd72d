"""Where frames come from: runs, and dumps of other programs with what the user knows of their law."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from workflow.archive.foreign import Sample
from workflow.archive.read import Archive
from workflow.archive.samples import Files
from workflow.data.frame import Frame
from workflow.errors import InputError
from workflow.measures.registry import Settings, chosen_groups
from workflow.pipeline.archived import archived
from workflow.pipeline.collect import measures_of, no_packing, settings_of
from workflow.pipeline.dumps import measures_of_dump
from workflow.runs.directory import ARCHIVE, RunDirectory


@dataclass(frozen=True)
class Run:
    """A frame of a run; ``options``: fields of `Settings`."""

    path: Path
    number: int = -1
    options: Mapping[str, Any] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """What it is called: the path of the run."""
        return str(self.path)

    @property
    def folder(self) -> Path:
        """Where to write what is made of it."""
        return self.path

    @property
    def figures(self) -> tuple[str, ...]:
        """Groups of the figures that show it."""
        return RunDirectory.open(self.path).scene.figures

    @cached_property
    def run(self) -> RunDirectory:
        """The run, with its archive."""
        return archived(RunDirectory.open(self.path))

    def frame(self) -> tuple[Frame, Settings]:
        """The frame, and the settings of its measures.  Raises InputError under a law that the measures do not know."""
        frame, scene = self.one_frame(), self.run.scene
        law = scene.law_of(frame.stage)
        if law is None:
            raise InputError(no_packing(self.run))
        return frame, settings_of(scene, law, **self.options)

    def frames(self) -> Iterator[Frame]:
        """Every frame, read one at a time."""
        with Archive(self.run / ARCHIVE) as archive:
            yield from archive.frames

    def one_frame(self) -> Frame:
        """The frame alone."""
        with Archive(self.run / ARCHIVE) as archive:
            return archive.frame(self.number)

    def measures(self, groups: Sequence[str] | None) -> dict[str, Any]:
        """The measures of the frame with ``groups``, see `measures_of`."""
        return measures_of(self.run, self.number, groups=groups, **self.options)

    def parameters(self) -> dict[str, Any]:
        """What a sample must share with others to be averaged with them, and its seed."""
        scene = self.run.scene
        with Archive(self.run / ARCHIVE) as archive:
            stage = archive.frame(self.number).stage
        return {"scene": scene.name, **scene.as_mapping(), "stage of the frame": stage}


@dataclass(frozen=True)
class Dumps:
    """A frame of a sample in dumps of another program: ``sample`` opens them, ``load`` reads the frame with what is known of
    its law."""

    files: Files
    sample: Callable[[], Sample]
    load: Callable[[], tuple[Frame, Settings]]
    number: int = -1
    figures: tuple[str, ...] = ("network",)
    run: None = None

    @property
    def name(self) -> str:
        """What it is called: the path of the first dump."""
        return str(self.files.grains[0])

    @property
    def folder(self) -> Path:
        """Where to write what is made of it."""
        return self.files.grains[0].parent

    def frame(self) -> tuple[Frame, Settings]:
        """The frame, and the settings of its measures."""
        return self.load()

    def frames(self) -> Iterator[Frame]:
        """Every frame, read one at a time."""
        yield from self.sample().frames()

    def one_frame(self) -> Frame:
        """The frame alone."""
        return self.sample().frame(self.number)

    def measures(self, groups: Sequence[str] | None) -> dict[str, Any]:
        """The measures of the frame with ``groups``, and ``notes`` of what is to be said of it."""
        frame, law = self.load()
        return measures_of_dump(frame, law, chosen_groups(groups, frame.grains))

    def parameters(self) -> dict[str, Any]:
        """What a sample must share with others to be averaged with them, and its seed."""
        frame = self.one_frame()
        walls = [not periodic for periodic in frame.periodic]
        return {"data": "dump", "grains": frame.grains, "walls": walls, "not given": sorted(frame.lacks - {"time"})}


Source = Run | Dumps
