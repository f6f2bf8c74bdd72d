"""The figures of the studies that check the code, in the registry of figures; each is drawn from the rows of its study."""

from __future__ import annotations

from workflow.reports.registry import FIGURES, STUDY, Figure, imported


def _of(module: str, name: str, meaning: str) -> Figure:
    return Figure(meaning, imported(f"workflow.verification.{module}_figures:{name}"), STUDY)


FIGURES["accuracy"] = {
    "few": _of("accuracy", "few_figure", "errors of few bodies against run time, or against steps per period"),
    "packings": _of("accuracy", "many_figure", "packings and their energy residual against run time"),
}
FIGURES["stability"] = {"map": _of("stability", "stability_map", "what is stable over stiff and extreme parameters")}
FIGURES["crosscheck"] = {
    "few": _of("crosscheck", "few_figure", "errors of few bodies over steps, by engine"),
    "packings": _of("crosscheck", "packing_figure", "packings of several engines on their way and at their end"),
}
