"""Draw figures of sources: which there are, which samples one figure may average, and under what names they are written."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

from workflow.data.files import writable_folder
from workflow.data.frame import Frame
from workflow.data.notes import tell
from workflow.errors import ArchiveError, InputError, WorkflowError
from workflow.measures.alike import differing, in_words, kinds, labels
from workflow.measures.registry import Settings
from workflow.pipeline.sources import Source
from workflow.reports.paper import FORMATS, PLAIN, Paper, on
from workflow.reports.registry import FIGURES, FRAMES, Figure, Shown, figures_of

ALL = "all"


class NotDrawn(NamedTuple):
    """A figure that was not drawn, and why."""

    name: str
    reason: str


def draw(
    sources: Sequence[Source], asked: Sequence[str], out: Path, formats: Sequence[str], paper: Paper = PLAIN
) -> Iterator[Path | NotDrawn]:
    """Draw the figures ``asked`` for (none: the usual ones) into ``out`` on ``paper``; each path that is written.

    ["all"]: those that apply; of each that does not the reason.  Raises InputError before anything is drawn for a name that
    the first source has not, for several sources of a figure of one, and for a frame that lacks what a figure needs.
    """
    chosen = _chosen(sources[0], asked)
    every = list(asked) == [ALL]
    prepared = _Prepared(sources)
    if not every:
        for name, figure in chosen.items():
            prepared.check(name, figure)
    writable_folder(out)
    for name, figure in chosen.items():
        try:
            with on(paper):
                yield from _draw(name, figure, prepared, out, formats)
        except WorkflowError as fault:
            if not every or isinstance(fault, ArchiveError):
                raise
            yield NotDrawn(name, str(fault).removeprefix(f"--figure {name} ").removeprefix(f"{name}: "))


class _Prepared:
    """Sources with what figures show of them, made when it is first asked for."""

    def __init__(self, sources: Sequence[Source]) -> None:
        self.sources = sources
        self._told: list[Sequence[str]] = []

    @cached_property
    def samples(self) -> list[tuple[Frame, Settings]]:
        """The frames with the settings of their measures."""
        found = [source.frame() for source in self.sources]
        for frame, _ in found:
            tell(frame.notes)
        return found

    @cached_property
    def runs(self) -> list[Shown]:
        """The runs.  Raises InputError for dumps."""
        if any(source.run is None for source in self.sources):
            raise InputError("figures of runs need run directories; leave the dumps out")
        folders = [source.folder.resolve().name for source in self.sources]
        if len(set(folders)) < len(folders):
            folders = [source.name for source in self.sources]
        names = labels([source.parameters() for source in self.sources], folders)
        return [_shown(source, name) for source, name in zip(self.sources, names, strict=True)]

    def tell_apart(self, free: Sequence[str]) -> None:
        """Say, once, that these are no samples to average."""
        if free not in self._told:
            self._told.append(free)
            different = differing([source.parameters() for source in self.sources], free)
            tell([f"not averaged, the samples differ in more than the seed: {in_words(different)}"])

    def check(self, name: str, figure: Figure) -> None:
        """Raises InputError if the figure cannot show these."""
        if len(self.sources) > 1 and not figure.several:
            raise InputError(f"--figure {name} shows one sample; give one directory, or figures that show a mean")
        if figure.of == FRAMES:
            for frame, _ in self.samples:
                figure.check(frame)
        elif any(source.run is None for source in self.sources):
            raise InputError(f"--figure {name} needs run directories; leave the dumps out")


def _draw(name: str, figure: Figure, prepared: _Prepared, out: Path, formats: Sequence[str]) -> Iterator[Path | NotDrawn]:
    """Draw one figure, once for each kind of sample."""
    prepared.check(name, figure)
    shown: Sequence[object] = prepared.samples if figure.of == FRAMES else prepared.runs
    parts = _parts(figure, prepared.sources)
    if len(parts) > 1:
        prepared.tell_apart(figure.free or ())
    for members, label in parts:
        paths = [out / f"{name}{label}.{kind}" for kind in figure.formats or formats]
        if figure.draw([shown[k] for k in members], paths) is False:
            yield NotDrawn(name, "there is nothing to draw in it")
        else:
            yield from paths


def draw_one(source: Source, name: str, path: Path | None) -> Path:
    """Draw the figure ``name`` of one source into the file ``path`` (None: NAME.png in its folder, or the only format).

    Raises InputError for a name or a format that does not exist, and where there is nothing to draw.
    """
    figure = _named(source, [name])[name]
    path = source.folder / f"{name}.{(*figure.formats, 'png')[0]}" if path is None else path
    if path.suffix[1:].lower() not in (known := figure.formats or FORMATS):
        raise InputError(f"'{path}' has no format of this figure; end its name in one of .{', .'.join(known)}")
    sample: object
    if figure.of == FRAMES:
        frame, settings = source.frame()
        figure.check(frame)
        sample = frame, settings
    elif source.run is None:
        raise InputError(f"figure '{name}' needs a run directory")
    else:
        sample = _shown(source, source.folder.name)
    if figure.draw([sample], [path]) is False:
        raise InputError(f"figure '{name}': there is nothing to draw in '{source.name}'")
    return path


def _shown(source: Source, name: str) -> Shown:
    """The run of a source under a name."""
    assert source.run is not None  # of dumps the caller has said so
    return Shown(source.run, name, source.number)


def _chosen(source: Source, asked: Sequence[str]) -> dict[str, Figure]:
    """The figures of ``source`` by name, in the order asked for."""
    known = figures_of(source.figures)
    if not asked:
        return {name: figure for name, figure in known.items() if figure.unasked}
    return _named(source, list(known) if list(asked) == [ALL] else asked, also=f", or {ALL}")


def _named(source: Source, names: Sequence[str], also: str = "") -> dict[str, Figure]:
    """The figures ``names`` of ``source``.  Raises InputError for one that it has not."""
    known = figures_of(source.figures)
    for name in names:
        if name not in known:
            other = any(name in figures for figures in FIGURES.values())
            what = f"shows nothing of '{source.name}'" if other else "is not known"
            raise InputError(f"figure '{name}' {what}; choose from {', '.join(known)}{also}")
    return {name: known[name] for name in names}


def _parts(figure: Figure, sources: Sequence[Source]) -> list[tuple[list[int], str]]:
    """The sources of each figure with the mark in its name: a mean is of samples that differ in the seed alone."""
    every = list(range(len(sources)))
    if len(sources) == 1 or figure.free is None:
        return [(every, "")]
    found = kinds([source.parameters() for source in sources], figure.free)
    if len(found) == 1:
        return [(every, "")]
    return [(members, f".{number}") for number, members in enumerate(found, 1)]
