"""Environments in which a pedestrian looks for the failures of a self-driving car.

``make`` and ``make_vec`` give Gymnasium environments of a scenario file, ``falsify_av.sb3.make_vec`` one for stable-baselines3, and
``falsify_av.pettingzoo.parallel_env`` one for PettingZoo. ``check`` returns what is wrong with scenario files. ``evaluate`` runs episodes of a
pedestrian that is a Python callable, and ``judge`` gives the verdict of a recording. ``run``, ``replay``, ``compare``, ``failures`` and ``export``
start the program ``falsify``, if it is installed. ``drivers`` has drivers under test that are Python objects.
"""

from gymnasium import register as _register

from . import drivers, pedestrians, program
from ._core import __version__
from .environments import PedestrianEnv, PedestrianVectorEnv, make, make_vec
from .evaluation import evaluate
from .judgement import judge
from .network import hunter, onnx
from .program import ProgramError, compare, export, failures, replay, run
from .scenarios import Diagnostic, ScenarioError, check, scenarios
from .worlds import RunUpWarning

__all__ = [
    "Diagnostic",
    "PedestrianEnv",
    "PedestrianVectorEnv",
    "ProgramError",
    "RunUpWarning",
    "ScenarioError",
    "__version__",
    "check",
    "compare",
    "drivers",
    "evaluate",
    "export",
    "failures",
    "hunter",
    "judge",
    "make",
    "make_vec",
    "onnx",
    "pedestrians",
    "program",
    "replay",
    "run",
    "scenarios",
]

_register(
    "falsify_av/Pedestrian-v0",
    entry_point="falsify_av.environments:PedestrianEnv",
    vector_entry_point="falsify_av.environments:PedestrianVectorEnv",
)
