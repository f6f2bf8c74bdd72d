"""Draw figures of sources: which there are, which samples one figure may average, and under what names they are written."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from workflow.data.notes import tell
from workflow.errors import InputError
from workflow.measures.alike import differing, in_words, kinds
from workflow.pipeline.sources import Source
from workflow.reports.registry import FIGURES, FRAMES, RUNS, Figure, Shown, figures_of


def draw(sources: Sequence[Source], asked: str | None, out: Path, formats: Sequence[str]) -> Iterator[Path]:
    """Draw the figures that are ``asked`` for (names with commas, "all", None: the usual ones) into ``out``; each path that is
    written.

    Raises InputError before anything is drawn for a name that the first source has not, for several sources of a figure of
    one, and for a frame that lacks what a figure needs.
    """
    chosen = _chosen(sources[0], asked)
    alone = [name for name, figure in chosen.items() if not figure.several]
    if len(sources) > 1 and alone:
        raise InputError(f"--figure {alone[0]} shows one sample; give one directory, or figures that show a mean")
    of_frames = [figure for figure in chosen.values() if figure.of == FRAMES]
    samples = [source.frame() for source in sources] if of_frames else []
    for frame, _ in samples:
        tell(frame.notes)
        for figure in of_frames:
            figure.check(frame)
    runs = [_shown(source) for source in sources]
    out.mkdir(parents=True, exist_ok=True)
    for name, figure in chosen.items():
        if figure.of == RUNS and None in runs:
            raise InputError(f"--figure {name} needs run directories; leave the dumps out")
        shown: Sequence[object] = samples if figure.of == FRAMES else runs
        for members, label in _parts(name, figure, sources):
            paths = [out / f"{name}{label}.{kind}" for kind in figure.formats or formats]
            if figure.draw([shown[k] for k in members], paths) is not False:
                yield from paths


def draw_one(source: Source, name: str, path: Path | None) -> Path:
    """Draw the figure ``name`` of one source into the file ``path`` (None: NAME.png in its folder, or the only format).

    Raises InputError for a name or a format that does not exist, and where there is nothing to draw.
    """
    figure = _named(source, [name])[name]
    path = source.folder / f"{name}.{(*figure.formats, 'png')[0]}" if path is None else path
    if path.suffix[1:].lower() not in (known := figure.formats or _formats()):
        raise InputError(f"'{path}' has no format of this figure; end its name in one of .{', .'.join(sorted(known))}")
    sample: object
    if figure.of == FRAMES:
        frame, settings = source.frame()
        figure.check(frame)
        sample = frame, settings
    elif source.run is None:
        raise InputError(f"figure '{name}' needs a run directory")
    else:
        sample = _shown(source)
    if figure.draw([sample], [path]) is False:
        raise InputError(f"figure '{name}': there is nothing to draw in '{source.name}'")
    return path


def _formats() -> Iterable[str]:
    """Those that matplotlib writes."""
    from matplotlib.backend_bases import FigureCanvasBase

    return FigureCanvasBase.get_supported_filetypes()


def _shown(source: Source) -> Shown | None:
    """The run of a source, None for dumps."""
    return None if source.run is None else Shown(source.run, source.run.path.name, source.number)


def _chosen(source: Source, asked: str | None) -> dict[str, Figure]:
    """The figures of ``source`` by name, in the order asked for."""
    known = figures_of(source.figures)
    if asked is None:
        return {name: figure for name, figure in known.items() if figure.unasked}
    return _named(source, list(known) if asked == "all" else asked.split(","), also=", or all")


def _named(source: Source, names: Sequence[str], also: str = "") -> dict[str, Figure]:
    """The figures ``names`` of ``source``.  Raises InputError for one that it has not."""
    known = figures_of(source.figures)
    for name in names:
        if name not in known:
            other = any(name in figures for figures in FIGURES.values())
            what = f"shows nothing of '{source.name}'" if other else "is not known"
            raise InputError(f"figure '{name}' {what}; choose from {', '.join(known)}{also}")
    return {name: known[name] for name in names}


def _parts(name: str, figure: Figure, sources: Sequence[Source]) -> list[tuple[list[int], str]]:
    """The sources of each figure with the mark in its name: a mean is of samples that differ in the seed alone."""
    every = list(range(len(sources)))
    if len(sources) == 1 or figure.free is None:
        return [(every, "")]
    parameters = [source.parameters() for source in sources]
    found = kinds(parameters, figure.free)
    if len(found) == 1:
        return [(every, "")]
    tell([f"{name}: not averaged, the samples differ in more than the seed: {in_words(differing(parameters, figure.free))}"])
    return [(members, f".{number}") for number, members in enumerate(found, 1)]
