"""Deploys kirigami sheets and gives access to their results: the program kirireel as a library.

    import kirireel
    run = kirireel.deploy(kirireel.read("data/cap"), contacts="auto")
    print(run.outcome, run.position[-1])    # metres; samples x bricks x 3
    picture = run.render(view="iso")        # height x width x 4, RGBA
    run.save("out/cap")                     # the files that `kirireel record` leaves

SI units, z up, indices from 0. Options have their names in scene.toml, and the values that the
command line takes: contacts="auto", thickness=0.02, gravity=(0, 0, -9.81), ground=True.
"""

from ._kirireel import (
    Error,
    InputError,
    Model,
    OutputError,
    Run,
    RunError,
    Sample,
    Trajectory,
    __version__,
    deploy,
    generate,
    open,
    read,
)

__all__ = [
    "Error",
    "InputError",
    "Model",
    "OutputError",
    "Run",
    "RunError",
    "Sample",
    "Trajectory",
    "__version__",
    "deploy",
    "generate",
    "open",
    "read",
]
