"""What a running `wf` shows on a terminal and in a file."""

from __future__ import annotations

import os
import re
import select
import signal
from collections.abc import Callable
from pathlib import Path

from wf_process import ENDLESS, QUICK, Running, Wf


def test_terminal_rewrites_one_line(running: Callable[..., Running]) -> None:
    main, side = os.openpty()
    run = running(*ENDLESS, stderr=side)
    os.close(side)
    text = ""
    while len(re.findall("\r(?!\n)", text)) < 2:  # two states on the same line
        assert select.select([main], [], [], 20.0)[0], f"nothing more is shown: {text!r}"
        text += os.read(main, 4096).decode()
    run.process.send_signal(signal.SIGINT)
    run.process.communicate(timeout=30)
    while select.select([main], [], [], 0.1)[0]:
        try:
            text += os.read(main, 4096).decode()
        except OSError:  # the other side is closed
            break
    os.close(main)
    head, *states = re.split("\r(?!\n)", text)
    assert "directory slow" in head
    for state in states[:-1]:
        assert "\n" not in state
    for state in states:
        assert re.match(r"compress 1/2  t [\d.]+  left (unknown|~\S+ \S+)  Phi 0\.\d+", state)
    last, _, after = states[-1].partition("\r\n")
    assert "\r" not in last
    assert after.startswith("wf: interrupted")


def test_file_gets_plain_lines(wf: Wf, tmp_path: Path) -> None:
    done = wf("run", *QUICK, "--max-time", "20", "--out", "new")
    assert "\r" not in done.stderr
    assert "\x1b" not in done.stderr
    assert done.stderr.endswith("\n")
