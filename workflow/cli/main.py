"""wf: parse and dispatch.  Exit status: 0 ok, 1 failed, 2 misuse, 3 a run that is not in equilibrium, 130 interrupted."""

from __future__ import annotations

import errno
import os
import resource
import signal
import sys
from importlib import import_module

from workflow import DISTRIBUTION, __version__
from workflow.cli.parser import Parser
from workflow.cli.terminal import escaped_output
from workflow.errors import WorkflowError

DEBUG = "WORKFLOW_TRACEBACK"
MEMORY = 600e6  # bytes of address space below which the libraries do not load, or wait for ever for threads they cannot start
COMMANDS = (
    "run", "resume", "deck", "measure", "plot", "report", "export", "sweep", "reproduce", "status", "verify", "bench",
    "scale", "crosscheck", "accuracy", "stability", "doctor", "schema", "archive", "units", "completion",
)  # fmt: skip


def parser(chosen: str | None = None) -> Parser:
    """The whole command line, or that of one command: the modules of the others cost half a second to load."""
    top = Parser(
        prog="wf", description="Cohesive discs and granular heaps on LAMMPS: scene -> deck -> run -> archive -> measures.",
        epilog="exit status: 0 ok, 1 failed, 2 misuse, 3 the run is not in equilibrium, 130 interrupted",
    )  # fmt: skip
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
    with escaped_output():
        try:
            return _command(words) if _room() else 1
        except BrokenPipeError:
            _drop_output()
            return 0
        except KeyboardInterrupt:
            print("wf: interrupted", file=sys.stderr)
            return 130


def _room() -> bool:
    """False, with a sentence, where 'ulimit -v' leaves too little memory to begin."""
    if (limit := resource.getrlimit(resource.RLIMIT_AS)[0]) == resource.RLIM_INFINITY:
        return True
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # its threads, one for each core, take memory of their own
    if limit < MEMORY:
        _failed(f"'ulimit -v' allows {limit / 1e6:.0f} MB of memory here, {MEMORY / 1e6:.0f} MB are needed; raise it")
    return limit >= MEMORY


def _command(words: list[str]) -> int:
    """Run one command; what its input can cause is a message, never a traceback."""
    try:
        from workflow.scene.registry import load_scenes  # NumPy comes with it

        load_scenes()
        arguments = parser(words[0] if words and words[0] in COMMANDS else None).parse_args(words)
        status = int(arguments.action(arguments) or 0)
        sys.stdout.flush()  # here, where a full disk and a reader that has gone are caught
        return status
    except WorkflowError as fault:
        return _failed(str(fault), fault.status)
    except BrokenPipeError:
        raise
    except OSError as fault:
        _drop_output()
        return _failed(_os_words(fault))
    except ImportError as fault:
        package = (fault.name or "workflow").partition(".")[0]
        return _failed(f"a library does not load ({fault}); 'ulimit -a' shows the limits, pip install --force-reinstall "
                       f"{DISTRIBUTION if package == 'workflow' else package} mends it")  # fmt: skip
    except MemoryError:
        return _failed("the memory that is free here is not enough for this; give fewer grains, or a larger machine")
    except UnicodeError as fault:
        return _failed(f"a text cannot be written or read as {fault.encoding} ({fault.reason}); rename the file it names"
                       if isinstance(fault, UnicodeEncodeError | UnicodeDecodeError) else str(fault))  # fmt: skip
    except (ValueError, OverflowError, RecursionError) as fault:
        if os.environ.get(DEBUG):
            raise
        said = (str(fault) or type(fault).__name__).splitlines()[0]
        return _failed(f"{said}; a value or a file that was given cannot be used ({DEBUG}=1 shows where)")


def _failed(words: str, status: int = 1) -> int:
    print(f"wf: {words}", file=sys.stderr)
    return status


def _os_words(fault: OSError) -> str:
    """Which file, what is wrong, what to do."""
    name, words = fault.filename or "a file", fault.strerror or fault
    if fault.errno in (errno.ENOSPC, errno.EDQUOT, errno.EACCES, errno.EROFS, errno.EIO, errno.EFBIG):
        return f"{name} cannot be written: {words}; make room or choose another place"
    if fault.errno in (errno.ENOMEM, errno.EAGAIN, errno.EMFILE, errno.ENFILE):
        return f"{name}: {words}; a limit of this machine is reached ('ulimit -a' shows them)"
    return f"'{name}': {words}; check that it is what the command expects"


def _drop_output() -> None:
    """Forget what standard output could not take, or Python complains of it once more at its end."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


if __name__ == "__main__":
    sys.exit(main())
