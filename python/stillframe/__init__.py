"""stillframe from Python: scenes in, numpy arrays out.

    import stillframe as sf

    scene = sf.Scene("config/scenes/metrology_frame.yaml")  # a file, YAML text or a dict
    linear = scene.linearise()         # linear.A, .B, .C, .D; linear.second_order.M ... G
    design = scene.design()            # design.K_P, design.margins.all_disk
    run = scene.run("first_run")       # passive and active; run.verdict, run.active.sigma

Every call is one call of the program of the same name, whose JSON it reads: the numbers are those of the
programs to the last bit, and what is wrong is raised as InputError, Refusal or RunFailed, with the file,
line and key that the program names. Units are SI. The keys of each result are in docs/json, and
`stillframe VERB --help` has them in words: sf.help("modes"). Those of a scene: sf.help("scene").
"""

from ._documents import Document
from ._log import Log, read_log
from ._program import InputError, ProgramError, Refusal, RunFailed, help, program, version
from ._scene import Design, LinearModel, Modes, Run, Scene, SingularValues, identify, read_run

__all__ = [
    "Design", "Document", "InputError", "LinearModel", "Log", "Modes", "ProgramError", "Refusal", "Run", "RunFailed", "Scene",
    "SingularValues",
    "help", "identify", "program", "read_log", "read_run", "version",
]
