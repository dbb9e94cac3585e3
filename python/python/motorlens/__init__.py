"""motorlens: fits a geared DC motor's model to logs, and names the missing physical effect.

Records are paths of logs or tables (a dict of arrays, a pandas or a polars DataFrame) with the columns ``time_s``,
``voltage_v`` (at the driver's output, held from each sample to the next) and ``angle_rad`` or ``speed_rad_s`` (of the
output shaft), each an array (n,) with a value for each of the record's n samples; ``current_a`` and ``supply_v`` are optional. SI units
throughout: s, V, rad, rad/s, A. Logs of other columns and units are read with :func:`read`.

    >>> import motorlens                                                       # doctest: +SKIP
    >>> found = motorlens.discover(["steps.csv"], validate=["unseen.csv"])     # doctest: +SKIP
    >>> found.effects, found.verdict                                           # doctest: +SKIP
    (['coulomb'], 'explained')
"""

from ._calls import add, compare, discover, effects, fit, plan, same, simulate
from ._model import Model, Motor, export, load_model
from ._native import MotorlensError, __version__
from ._records import Log, read
from ._results import Addition, Comparison, Findings, Fit, Run, Same
from ._tune import Course, StepResponse, Tuned, tune

__all__ = [
    "Addition",
    "Comparison",
    "Course",
    "Findings",
    "Fit",
    "Log",
    "Model",
    "Motor",
    "MotorlensError",
    "Run",
    "Same",
    "StepResponse",
    "Tuned",
    "__version__",
    "add",
    "compare",
    "discover",
    "effects",
    "export",
    "fit",
    "load_model",
    "plan",
    "read",
    "same",
    "simulate",
    "tune",
]
