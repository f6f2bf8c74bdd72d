"""Jobs of Slurm, PBS and LSF: what they ask for, and that no field of a profile becomes more than it is."""

from __future__ import annotations

import shlex
import subprocess
from pathlib import Path
from typing import Any

import pytest
import tomli_w

from workflow.campaign.cluster import CLUSTERS, Profile, profile_of
from workflow.campaign.portable import job_script
from workflow.errors import InputError

ATTACKS = ["a\n#SBATCH --uid=0", "a\r\nb", "$(touch broken)", "`touch broken`", "a;touch broken", 'a"b', "a'b", "a b", "a|b", "a\0b",
           "a$b", "-x y z", "é"]  # fmt: skip
AWKWARD = [
    "$(touch broken)",
    "`touch broken`",
    "it's",
    'a "b"',
    "a;b & c | d > e",
    "a\\b",
    "*",
    "~",
    "$HOME",
    "#x",
    "!!",
    "é ü",
]


@pytest.mark.parametrize("attack", ATTACKS)
@pytest.mark.parametrize("field", ["account", "partition", "modules", "directives"])
def test_words_of_directives_are_plain(field: str, attack: str) -> None:
    for value in (attack, f"--mem={attack}"):
        with pytest.raises(InputError, match=field):
            Profile(**{field: [value] if field in ("modules", "directives") else value})


@pytest.mark.parametrize("attack", ["a\nb", "a\rb", "a\0b", "\x1b[2J"])
@pytest.mark.parametrize("field", ["launcher", "lmp", "lammps_include", "compiler"])
def test_words_of_the_script_stand_on_one_line(field: str, attack: str) -> None:
    with pytest.raises(InputError, match=f"{field} = .* it must be a text on one line"):
        Profile(**{field: attack})


@pytest.mark.parametrize("scheduler", CLUSTERS)
def test_the_shell_reads_exactly_the_words_of_the_profile(scheduler: str, tmp_path: Path) -> None:
    for word in AWKWARD:
        launcher = f"run {shlex.quote(word)} {{ranks}}"
        profile = Profile(scheduler=scheduler, launcher=launcher, lmp=word, lammps_include=word, compiler=word, ranks=3)
        script = job_script(profile, "name")
        settings = script.split("# Runs deck.in")[0]
        show = 'printf "%s\\0" "${launch[@]}" "$lmp" "$include" "$compiler"'
        done = subprocess.run(["bash", "-c", settings + show], cwd=tmp_path, capture_output=True, check=True)
        assert done.stdout.decode().split("\0")[:-1] == ["run", word, "3", word, word, word]
        assert subprocess.run(["bash", "-n"], input=script, text=True, check=False).returncode == 0
    assert list(tmp_path.iterdir()) == []


def test_what_each_scheduler_is_asked() -> None:
    common: dict[str, Any] = {"account": "phys-1", "partition": "long", "ranks": 8, "time": "1-02:30:00"}
    slurm = Profile(**common, directives=["--mem-per-cpu=2G", "-C rome"])
    assert [line for line in job_script(slurm, "heap-1").splitlines() if line.startswith("#SBATCH")] == [
        "#SBATCH --job-name=heap-1", "#SBATCH --output=job-%j.out", "#SBATCH --open-mode=append", "#SBATCH --requeue",
        "#SBATCH --time=26:30:00", "#SBATCH --account=phys-1", "#SBATCH --partition=long", "#SBATCH --ntasks=8",
        "#SBATCH --mem-per-cpu=2G", "#SBATCH -C rome",
    ]  # fmt: skip
    assert slurm.launch == ["srun", "-n", "8"]
    pbs = Profile(scheduler="pbs", **common, cores_per_node=4)
    assert pbs.head("heap-1", "") == [
        "#PBS -N heap-1", "#PBS -j oe", "#PBS -r y", "#PBS -l select=2:ncpus=4:mpiprocs=4", "#PBS -l walltime=26:30:00",
        "#PBS -A phys-1", "#PBS -q long",
    ]  # fmt: skip
    lsf = Profile(scheduler="lsf", **common, directives=["-R span[ptile=4]"])
    assert lsf.head("heap-1", "job-%J.out") == [
        "#BSUB -J heap-1", "#BSUB -o job-%J.out", "#BSUB -r", "#BSUB -n 8", "#BSUB -W 26:30", "#BSUB -P phys-1", "#BSUB -q long",
        "#BSUB -R span[ptile=4]",
    ]  # fmt: skip
    assert Profile().launch == []  # one rank needs no launcher
    with pytest.raises(InputError, match="2 nodes of 4 must have equal shares"):
        Profile(scheduler="pbs", ranks=5, cores_per_node=4)
    assert "#BSUB -W 00:02" in Profile(scheduler="lsf", time=61).head("x", "x.out")  # minutes, rounded up


@pytest.mark.parametrize(
    ("field", "value", "words"),
    [
        ("scheduler", "cron", "one of slurm, pbs, lsf"),
        ("scheduler", ["slurm"], "one of slurm"),
        ("time", "tomorrow", "write HH:MM:SS"),
        ("time", "00:61:00", "write HH:MM:SS"),
        ("time", -5, "write HH:MM:SS"),
        ("margin", "24:00:00", "below the limit, 86400 s"),
        ("ranks", 0, "not below 1"),
        ("ranks", True, "not below 1"),
        ("ranks", "4", "not below 1"),
        ("modules", "gcc", "a list of texts"),
        ("modules", [3], "letters, digits"),
        ("directives", ["--array=1-9"], "by their full names"),
        ("directives", ["--time 99:00:00"], "by their full names"),
        ("directives", ["mem=4G"], "one option with at most one value"),
        ("launcher", "mpirun 'x", "No closing quotation"),
        ("launcher", 3, "a text on one line"),
        ("lmp", "", "name the LAMMPS program"),
    ],
)
def test_every_field_is_checked(field: str, value: Any, words: str) -> None:
    with pytest.raises(InputError) as caught:
        Profile(**{field: value})
    assert field in str(caught.value)
    assert words in str(caught.value)


def test_profiles_of_the_user_are_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    with pytest.raises(InputError, match=r"clusters.toml' cannot be read"):
        profile_of("hunter")
    file = tmp_path / "workflow" / "clusters.toml"
    file.parent.mkdir()
    tables = {
        "hunter": {"scheduler": "pbs", "time": "10:00:00", "account": "a"},
        "old": {"quue": "x"},
        "bad": {"account": "$(x)"},
    }
    file.write_text(tomli_w.dumps(tables))
    found = profile_of("hunter", time="00:10:00", account=None)
    assert (found.scheduler, found.time, found.margin, found.account) == ("pbs", 600, 30, "a")
    with pytest.raises(InputError, match="has no profile 'huntre'; there are: hunter, old, bad"):
        profile_of("huntre")
    with pytest.raises(InputError, match=r"profile 'old' in .*: unknown field 'quue'"):
        profile_of("old")
    with pytest.raises(InputError, match=r"profile 'bad' in .*: account: "):
        profile_of("bad")
    single = tmp_path / "one.toml"
    single.write_text('launcher = "mpirun -np {ranks}"\nranks = 2\n')
    assert profile_of(str(single)).launch == ["mpirun", "-np", "2"]
    single.write_text("launcher = ")
    with pytest.raises(InputError, match="is not TOML"):
        profile_of(str(single))
    assert profile_of(None, scheduler="lsf") == Profile(scheduler="lsf")
