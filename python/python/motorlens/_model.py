"""A model: simulate, step, save, export."""

from __future__ import annotations

import json
import os
import pathlib
from collections.abc import Iterable, Mapping
from typing import Any, Optional, Union

import numpy as np

from . import _native
from ._native import MotorlensError
from ._progress import Progress, watching
from ._records import KnownMotor, Record, as_array, as_motor, as_records
from ._tune import Tuned, tune


class Motor:
    """A model on its way; see :meth:`Model.start`."""

    def __init__(self, native: _native.NativeRun) -> None:
        self._native = native

    def step(self, voltage_v: float) -> float:
        """Advances by a step under ``voltage_v`` (V); returns what the sensor shows, rad of the output shaft."""
        return self._native.step(float(voltage_v))

    @property
    def angle_rad(self) -> float:
        """What the sensor shows, rad of the output shaft."""
        return self._native.angle_rad

    @property
    def speed_rad_s(self) -> float:
        """Speed of the output shaft, rad/s."""
        return self._native.speed_rad_s

    @property
    def time_s(self) -> float:
        """Time since the start, s."""
        return self._native.time_s


class Model:
    """A fitted motor: base model and effects."""

    def __init__(self, native: _native.NativeModel) -> None:
        self._native = native

    def to_dict(self) -> dict[str, Any]:
        """The content of the model file."""
        content: dict[str, Any] = json.loads(self._native.to_json())
        return content

    @classmethod
    def from_dict(cls, content: Mapping[str, Any]) -> Model:
        """The model with the content of a model file, as :meth:`to_dict` gives it."""
        return _from_json(json.dumps(content))

    def __reduce__(self) -> tuple[Any, tuple[str]]:
        # For copies, and for other processes. A motor on its way stays behind.
        return _from_json, (self._native.to_json(),)

    @property
    def effects(self) -> list[str]:
        """Names of its effects, in the order they were added."""
        return [effect["effect"] for effect in self.to_dict()["effects"]]

    def simulate(self, time_s: Any, voltage_v: Any, angle_rad: float = 0.0, speed_rad_s: float = 0.0) -> np.ndarray:
        """Angle of the output shaft as the sensor shows it, without its counting.

        ``time_s`` (n,) rises, s; ``voltage_v`` (n,) is held from each time to the next, V; the motor is at ``angle_rad``
        (rad) at the first time, at rest or turning with ``speed_rad_s`` (rad/s) as it did for a while. Returns (n,), rad.
        :func:`compare` runs the same: a record that is in motion begins at the ``first_speed_rad_s`` of its run, found for the
        model, and an angle is moved within a count of the encoder.
        """
        time, volts = as_array(time_s), as_array(voltage_v)
        begin = float(angle_rad), float(speed_rad_s)
        return np.frombuffer(self._native.simulate(time.tobytes(), volts.tobytes(), *begin)).copy()

    def start(self, step_s: float = 1e-3, angle_rad: float = 0.0, speed_rad_s: float = 0.0) -> Motor:
        """The motor at ``angle_rad`` (rad), at rest or turning with ``speed_rad_s`` (rad/s).

        It is advanced in steps of ``step_s`` (s, at most 0.01).
        """
        return Motor(self._native.start(float(step_s), float(angle_rad), float(speed_rad_s)))

    def step(self, voltage_v: float) -> float:
        """Advances a motor of this model's own by a millisecond under ``voltage_v`` (V); returns its angle, rad.

        It begins at rest at angle 0. For more than one motor, other steps or another beginning, see :meth:`start`.
        """
        if not hasattr(self, "_motor"):
            self._motor = self.start()
        return self._motor.step(voltage_v)

    def tune(
        self, period_s: float = 0.005, phase_margin_deg: float = 60.0, limit_v: Optional[float] = None
    ) -> Tuned:
        """Gains for a controller; see :func:`tune`."""
        return tune(self, period_s, phase_margin_deg, limit_v)

    def save(self, path: Union[str, os.PathLike[str]]) -> None:
        """Writes the model file, whole or not at all."""
        self._native.write(os.fspath(path))

    def export(
        self,
        format: str,
        out: Union[str, os.PathLike[str]],
        step_s: Optional[float] = None,
        torque_per_volt: Optional[float] = None,
        name: Optional[str] = None,
        allow_missing: bool = False,
        bam_model: Optional[int] = None,
        on: Iterable[Record] = (),
        motor: KnownMotor = None,
        progress: Progress = None,
    ) -> list[str]:
        """Writes the model for another tool; see :func:`export`."""
        return export(
            self, format, out, step_s, torque_per_volt, name, allow_missing, bam_model, on, motor, progress
        )

    def __repr__(self) -> str:
        base = self.to_dict()["base"]
        return (
            f"Model(gain={base['gain']:.4g} rad/(s V), tau_m={base['tau_m']:.4g} s, "
            f"effects={self.effects or ['none']})"
        )


def _from_json(text: str) -> Model:
    return Model(_native.NativeModel.from_json(text))


def load_model(path: Union[str, os.PathLike[str]]) -> Model:
    """Reads a model file that ``motorlens`` or :meth:`Model.save` wrote."""
    return Model(_native.NativeModel.read(os.fspath(path)))


def export(
    model: Model,
    format: str,
    out: Union[str, os.PathLike[str]],
    step_s: Optional[float] = None,
    torque_per_volt: Optional[float] = None,
    name: Optional[str] = None,
    allow_missing: bool = False,
    bam_model: Optional[int] = None,
    on: Iterable[Record] = (),
    motor: KnownMotor = None,
    progress: Progress = None,
) -> list[str]:
    """Writes ``model`` for another tool into ``out``, and a second file beside it where the tool needs one.

    ``format`` is one that ``motorlens export --help`` lists. ``step_s`` is the step of a generated program or of MuJoCo's
    simulation, s; ``torque_per_volt`` the stall torque at the output shaft per volt, N m/V; ``name`` the joint's; ``bam_model`` 1 to 6.
    What the tool lacks costs is told on the records ``on`` (and ``motor``, as in :func:`discover`), or on a standard programme; a program
    (C, Python, Modelica, FMU) is run on those records in its own steps, and an MJCF by this Python where it has MuJoCo 4. ``progress`` is as in
    :func:`discover`; Ctrl-C ends MuJoCo's run too.
    Returns what to know of the files, and what the tool lacks, in sentences; raises :class:`MotorlensError` where it lacks an effect
    of the model, or errs on the records by more than a hundredth above the model, unless ``allow_missing``.
    """
    how = (step_s, torque_per_volt, name, bam_model)
    path, text = as_motor(motor)
    with watching(progress) as told:
        content, beside, notes, lost = model._native.export(format, how, as_records(on), path, text, told)
    if lost and not allow_missing:
        raise MotorlensError(" ".join(lost) + "\n  do: give allow_missing=True to write it all the same")
    _native.write_file(os.fspath(out), content)
    if beside is not None:
        ending, program = beside
        _native.write_file(os.fspath(pathlib.Path(out).with_suffix(f".{ending}")), program.encode())
    return notes + lost
