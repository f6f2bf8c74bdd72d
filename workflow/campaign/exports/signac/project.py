"""The operations of a job (signac-flow): python project.py run; then `wf sweep study.toml --out . --adopt workspace`."""

import shlex

from flow import FlowProject


class Study(FlowProject):
    """A job is a point of the study, its run directory is `run`."""


@Study.post.isfile("run/measures.json")
@Study.operation(cmd=True)
def run(job):
    """One run; an interrupted one is continued."""
    return f"sh point.sh {shlex.quote(job.document['scene'])} {shlex.quote(job.fn('run'))}"


if __name__ == "__main__":
    Study().main()
