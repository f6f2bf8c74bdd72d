"""wf: parse and dispatch.  Exit status: 0 ok, 1 failed, 2 misuse, 130 interrupted."""

from __future__ import annotations

import argparse
import errno
import os
import signal
import sys
from importlib import import_module

from workflow import __version__
from workflow.errors import WorkflowError
from workflow.scene.presets import load_scenes

COMMANDS = (
    "run", "resume", "deck", "measure", "plot", "report", "export", "sweep", "reproduce", "status", "verify", "bench",
    "scale", "crosscheck", "accuracy", "stability", "doctor",
)  # fmt: skip


def parser(chosen: str | None = None) -> argparse.ArgumentParser:
    """The whole command line, or that of one command: the modules of the others cost half a second to load."""
    top = argparse.ArgumentParser(
        prog="wf",
        description="Cohesive discs and granular heaps on LAMMPS: scene -> deck -> run -> archive -> measures.",
    )
    top.add_argument("--version", action="version", version=f"wf {__version__}")
    commands = top.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for name in COMMANDS if chosen is None else (chosen,):
        import_module(f"workflow.cli.{name}").declare(commands)
    return top


def main(words: list[str] | None = None) -> int:
    """Run one command; errors meant for the user become one message on stderr."""
    if words is None:  # as a program: SIGTERM is the Control-C of schedulers, and of jobs in the background, deaf to SIGINT
        signal.signal(signal.SIGTERM, signal.default_int_handler)
        words = sys.argv[1:]
    try:
        load_scenes()
        arguments = parser(words[0] if words and words[0] in COMMANDS else None).parse_args(words)
        status = int(arguments.action(arguments) or 0)
        sys.stdout.flush()  # here, where a full disk and a reader that has gone are caught
        return status
    except WorkflowError as fault:
        print(f"wf: {fault}", file=sys.stderr)
        return fault.status
    except BrokenPipeError:
        _drop_output()
        return 0
    except OSError as fault:
        if fault.errno not in (errno.ENOSPC, errno.EDQUOT, errno.EACCES, errno.EROFS, errno.EIO):
            raise
        _drop_output()
        print(
            f"wf: {fault.filename or 'a file'} cannot be written: {fault.strerror}; make room or choose another place",
            file=sys.stderr,
        )
        return 1
    except KeyboardInterrupt:
        print("wf: interrupted", file=sys.stderr)
        return 130


def _drop_output() -> None:
    """Forget what standard output could not take, or Python complains of it once more at its end."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


if __name__ == "__main__":
    sys.exit(main())
