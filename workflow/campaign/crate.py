"""RO-Crate metadata of runs and studies: which software made which files from which, when, and with what end.

A folder with ro-crate-metadata.json is a research object that repositories (Zenodo, WorkflowHub) and their tools read: a
Process Run Crate 0.5 (https://w3id.org/ro/wfrun/process/0.5), one CreateAction for each run, failed ones too, and one for
the scoreboard of a reproduction.
"""

from __future__ import annotations

import hashlib
import json
import platform
import re
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from workflow import DISTRIBUTION, __version__
from workflow.campaign.crate_files import BOARD, BOARD_FILES, RUN_FILES, STUDY_FILES, FileKind
from workflow.campaign.study import FAILED, POINTS, WAITING, Point, Study, standing_in
from workflow.data.files import atomic_write, open_plain, regular
from workflow.errors import ArchiveError, EnvironmentFault, InputError, WorkflowError
from workflow.runs import directory as rundir
from workflow.runs.directory import RunDirectory, timestamp
from workflow.scene.base import Scene
from workflow.scene.parameter import quantity_of

METADATA = "ro-crate-metadata.json"
PROFILE = "https://w3id.org/ro/wfrun/process/0.5"
TERMS = {"sha256": "https://w3id.org/ro/terms/workflow-run#sha256"}  # RO-Crate 1.1 has none
STATUS = {rundir.FINISHED: "Completed", rundir.RUNNING: "Active", rundir.PREPARED: "Potential"}
NO_LICENSE = {"@id": "#license", "@type": "CreativeWork", "name": "no licence stated",
              "description": "No licence is stated: ask the authors before you use these data."}  # fmt: skip
HOMES = {"lammps": "https://www.lammps.org", "mpich": "https://www.mpich.org", "numpy": "https://numpy.org",
         "scipy": "https://scipy.org", "h5py": "https://www.h5py.org"}  # fmt: skip


@dataclass(frozen=True)
class Attribution:
    """Who made the data (``author``, with ``orcid`` if any), and the URI of the ``license`` under which others may use them.

    Raises InputError for an ORCID or a licence that is no URI, and for an ORCID without author.
    """

    author: str | None = None
    orcid: str | None = None
    license: str | None = None

    def __post_init__(self) -> None:
        for name, value, example in (
            ("orcid", self.orcid, "https://orcid.org/0000-0002-1825-0097"),
            ("license", self.license, "https://spdx.org/licenses/CC-BY-4.0"),
        ):
            if value is not None and not value.startswith(("https://", "http://")):
                raise InputError(f"--{name} {value} is not allowed: it must be a URI, for example {example}")
        if self.orcid and not self.author:
            raise InputError(f"--orcid {self.orcid} has no name; give --author NAME too")


def write_crate(folder: Path, attribution: Attribution) -> Path:
    """Write ro-crate-metadata.json of the run or the study in ``folder``; where it is.

    Raises InputError if the folder holds neither, ArchiveError if a record or a file cannot be read, EnvironmentFault
    without the package rocrate.
    """
    builder = _Crate(folder, attribution)
    if (folder / POINTS).is_file():
        builder.study(Study.open(folder))
    else:
        builder.run(RunDirectory.open(folder))
    text = json.dumps(builder.document(), indent=1, ensure_ascii=False) + "\n"
    with atomic_write(folder / METADATA) as draft:
        draft.write_text(text, encoding="utf-8")
    return folder / METADATA


class _Crate:
    """The crate of ``folder`` while it is put together."""

    def __init__(self, folder: Path, attribution: Attribution) -> None:
        try:
            from rocrate.rocrate import ROCrate
        except ImportError:
            raise EnvironmentFault(f"RO-Crate metadata need the package rocrate: pip install '{DISTRIBUTION}[crate]'") from None
        self.folder, self.crate = folder, ROCrate(version="1.1")
        self.crate.metadata.extra_terms.update(TERMS)
        self.root = self.crate.root_dataset
        profile = self.add(PROFILE, "CreativeWork", name="Process Run Crate", version="0.5")
        self.root["conformsTo"] = profile
        self.root["license"] = (
            self.add(attribution.license, "CreativeWork", name=attribution.license.rpartition("/")[2],
                     description="the licence of these data") if attribution.license else self.add(**NO_LICENSE)
        )  # fmt: skip
        self.agent = None
        if attribution.author:
            self.agent = self.add(attribution.orcid or "#author", "Person", name=attribution.author)
            self.root["author"] = self.agent
        self.ended: list[str] = []
        self.actions: list[Any] = []

    def add(self, identifier: str | None = None, kind: str | None = None, **properties: Any) -> Any:
        """A contextual entity; one that is there already is taken."""
        from rocrate.model.contextentity import ContextEntity

        identifier, kind = identifier or properties.pop("@id"), kind or properties.pop("@type")
        known = self.crate.get(identifier)
        return known or self.crate.add(ContextEntity(self.crate, identifier, {"@type": kind, **properties}))

    def files(self, kinds: Mapping[str, FileKind], below: str = "") -> tuple[list[Any], list[Any]]:
        """The files that are there: what was read, what was made."""
        read: list[Any] = []
        made: list[Any] = []
        for name, kind in kinds.items():
            path = self.folder / below / name
            if not regular(path):
                continue
            entity = self.crate.add_file(path, below + name, properties={
                "name": name, "description": kind.meaning, "encodingFormat": kind.media,
                "contentSize": str(path.stat().st_size), "sha256": _sha256(path),
            })  # fmt: skip
            (made if kind.made else read).append(entity)
        return read, made

    def run(self, directory: RunDirectory) -> None:
        """The folder is one run."""
        state, scene = directory.state, _scene_in(directory)
        title = f"{scene.title}, {scene.sample}" if scene else f"run of {state['scene']}"
        self.root["name"] = title
        self.root["description"] = f"A discrete-element run on LAMMPS ({state['status']}): {title}. Command: {_command(state)}"
        self.action(directory, f"#run-{state['digest'][:16]}", list(scene.as_mapping()) if scene else [])

    def study(self, study: Study) -> None:
        """The folder holds many runs, and perhaps the scoreboard of a paper."""
        names = sorted({str(point.values["scene"]) for point in study.points})
        self.root["name"] = f"study {study.folder.resolve().name}: {len(study.points)} runs of {', '.join(names)}"
        varied = ", ".join(study.varied) or "nothing"
        self.root["description"] = f"Discrete-element runs on LAMMPS. Varied: {varied}. Each folder in points/ is a run."
        self.files(STUDY_FILES)
        archives = [archive for point in study.points for archive in self.point(study, point)]
        if regular(self.folder / BOARD):
            self.scoreboard(archives)

    def point(self, study: Study, point: Point) -> list[Any]:
        """One run of a study, if it was begun; its archive."""
        below, directory = f"points/{point.name}/", study.directory(point)
        now = standing_in(str(directory.path))
        if now.status == WAITING:
            return []
        self.crate.add_dataset(directory.path, below, properties={
            "name": study.label(point), "description": f"run of {point.values['scene']}: {now.status}",
        })  # fmt: skip
        try:
            return self.action(directory, f"#run-{point.name}", study.varied, below)
        except WorkflowError as fault:  # a record that cannot be read: that is what is known of it
            self.mention(f"#run-{point.name}", study.label(point), _public(str(fault)), instrument=self.software({}),
                         actionStatus=_status(FAILED), error=_public(now.reason or str(fault)))  # fmt: skip
            return []

    def action(self, directory: RunDirectory, name: str, stated: Iterable[str], below: str = "") -> list[Any]:
        """What one run did, with the parameters ``stated``; its archive."""
        state, scene = directory.state, _scene_in(directory)
        more = scene.files() if scene else {}
        kinds = {**RUN_FILES, **{file: FileKind("text/plain", "read by the deck", made=False) for file in more}}
        read, made = self.files(kinds, below)
        given = [self.parameter(name, scene, one) for one in stated] if scene else []
        failed = state["status"] in (rundir.FAILED, rundir.INTERRUPTED)
        reason = (
            {"error": _public(state.get("reason") or "") or f"{state['status']}; 'wf resume' continues it"} if failed else {}
        )
        self.mention(
            name, f"{scene.title}, {scene.sample}" if scene else f"run of {state['scene']}", _command(state),
            instrument=self.software(state["versions"]), object=read + [one for one in given if one], result=made,
            actionStatus=_status(state["status"]), **reason, **_times(state),
        )  # fmt: skip
        self.ended += [_times(state)["endTime"]] if state.get("finished") else []
        return [file for file in made if file["name"] == "run.h5"]

    def parameter(self, action: str, scene: Scene, name: str) -> Any:
        """A value of the scene, None if it has none of this name."""
        value = {"scene": scene.name, **scene.as_mapping()}.get(name)
        known = next((quantity_of(item) for item in fields(scene) if item.name == name), None)
        if value is None:
            return None
        said = {"description": known.meaning, "unitText": known.unit} if known else {}
        shown = value if isinstance(value, bool | int | str) else repr(value)  # JSON knows no infinity
        return self.add(f"{action}-{name}", "PropertyValue", name=name, value=shown,
                        **{key: words for key, words in said.items() if words})  # fmt: skip

    def software(self, versions: Mapping[str, str]) -> Any:
        """This package as it was, with what it ran on."""
        of = {"workflow": __version__, "python": platform.python_version(), **versions}
        pages = {name: (f"https://pypi.org/project/{name}/{of[name]}/", url) for name, url in HOMES.items() if name in of}
        pages["python"] = (f"https://docs.python.org/release/{of['python']}/", "https://www.python.org")
        needs = [self.add(page, "SoftwareApplication", name=name, softwareVersion=of[name], url=url)
                 for name, (page, url) in pages.items()]  # fmt: skip
        words = ", ".join(of[name] for name in ("platform", "libc", "processor") if name in of)
        mark = hashlib.sha256(json.dumps(of, sort_keys=True).encode()).hexdigest()[:8]
        return self.add(
            f"pkg:generic/{DISTRIBUTION}@{of['workflow']}#{mark}", "SoftwareApplication", name=DISTRIBUTION,
            softwareVersion=of["workflow"], description="discrete-element simulation of discs on LAMMPS, command wf",
            softwareRequirements=needs, **({"operatingSystem": words} if words else {}),
        )  # fmt: skip

    def scoreboard(self, archives: list[Any]) -> None:
        """The comparison of the runs with a paper."""
        try:
            with open_plain(self.folder / BOARD) as file:
                board = json.loads(file.read())
            paper, made = str(board["paper"]), board["provenance"]
            command = _public(str(made["command"]))
        except (OSError, ValueError, KeyError, TypeError, RecursionError) as fault:
            raise ArchiveError(f"'{self.folder / BOARD}' is no scoreboard ({fault}); make it again: wf reproduce") from None
        self.root["name"] = f"reproduction of {paper}"
        self.root["citation"] = self.add("#paper", "ScholarlyArticle", name=paper)
        figures = [path for path in sorted((self.folder / "figures").glob("*.*")) if regular(path)]
        media = {".png": "image/png", ".pdf": "application/pdf", ".svg": "image/svg+xml"}
        drawn = {f"figures/{path.name}": FileKind(media.get(path.suffix, "text/plain"), "a figure, as the paper has it")
                 for path in figures}  # fmt: skip
        _, files = self.files({**BOARD_FILES, **drawn})
        self.mention("#comparison", f"comparison with {paper}", command, instrument=self.software({}), object=archives,
                     result=files, actionStatus=_status(rundir.FINISHED))  # fmt: skip

    def mention(self, name: str, title: str, command: str, **properties: Any) -> None:
        """An action, named by the root."""
        agent = {"agent": self.agent} if self.agent else {}
        self.actions.append(self.add(name, "CreateAction", name=title, description=command, **agent, **properties))

    def document(self) -> dict[str, Any]:
        """The JSON-LD document; published when the last run ended, so that the same runs give the same bytes."""
        if self.actions:
            self.root["mentions"] = self.actions[0] if len(self.actions) == 1 else self.actions
        self.root["datePublished"] = max(self.ended, default=timestamp().replace("Z", "+00:00"))
        document: dict[str, Any] = self.crate.metadata.generate()
        return document


def _scene_in(directory: RunDirectory) -> Scene | None:
    """The scene of a run, None where scene.toml is damaged or was never written."""
    with suppress(WorkflowError):
        return directory.scene
    return None


def _command(state: Mapping[str, Any]) -> str:
    return _public(str(state.get("command") or f"wf run of the scene {state['scene']}"))


def _public(text: str) -> str:
    """A command or a message without the folders of this machine: of an absolute path the last part."""
    return re.sub(r"""(?<![^\s='"(])/(?:[^\s/'"]+/)+""", "", text)


def _status(status: str) -> str:
    return f"http://schema.org/{STATUS.get(status, 'Failed')}ActionStatus"


def _times(state: Mapping[str, Any]) -> dict[str, str]:
    names = {"startTime": "started", "endTime": "finished"}
    return {name: str(state[entry]).replace("Z", "+00:00") for name, entry in names.items() if state.get(entry)}


def _sha256(path: Path) -> str:
    try:
        with open_plain(path) as file:
            return hashlib.file_digest(file, "sha256").hexdigest()  # type: ignore[arg-type]
    except OSError as fault:
        raise ArchiveError(f"'{path}' cannot be read ({fault.strerror}); restore it, or run again") from None
