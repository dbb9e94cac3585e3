"""Gains for a controller."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Optional

import numpy as np

from ._frames import as_frame, as_page

if TYPE_CHECKING:
    from ._model import Model


@dataclass(frozen=True)
class Course:
    """A move there and back under one compensation, at each of n periods of the controller."""

    compensation: str
    #: (n,), s.
    time_s: np.ndarray
    #: (n,), rad of the output shaft.
    wanted_rad: np.ndarray
    #: (n,), rad of the output shaft.
    reached_rad: np.ndarray


@dataclass(frozen=True)
class StepResponse:
    """A loop's answer to a step of what is wanted, with all effects or without, at each of n periods of the controller."""

    #: position or velocity.
    of: str
    compensation: str
    #: (n,), s.
    time_s: np.ndarray
    #: (n,), rad of the output shaft; of the velocity rad/s.
    wanted: np.ndarray
    #: (n,), rad of the output shaft; of the velocity rad/s.
    reached: np.ndarray


@dataclass(frozen=True)
class Tuned:
    """Gains with their margins, and what the effects cost in tracking under them."""

    #: PI of the velocity, V and rad/s: kp, ki, kd and margins.
    velocity: dict[str, Any]
    #: PD of the position, V and rad: kp, ki, kd and margins.
    position: dict[str, Any]
    #: ks_v, kv_v_s_per_rad, ka_v_s2_per_rad, kg_v, dead_zone_v.
    feedforward: dict[str, float]
    #: Effects whose torque depends on the angle, with equation and parameters: what is commanded against them is -f.
    loads: list[dict[str, Any]]
    #: Tracking errors, one compensation after the other: a DataFrame.
    trials: Any
    #: Steps of the position (rad) and of the velocity (rad/s): rise and settling time, overshoot, what is left, and where the position
    #: does not come to rest the limit cycle's amplitude (rad) and frequency (Hz): a DataFrame.
    steps: Any
    #: Which compensation pays, a sentence each.
    advice: list[str]
    courses: list[Course] = field(repr=False)
    #: Those of ``steps``, in the same order.
    step_responses: list[StepResponse] = field(repr=False)
    document: dict[str, Any] = field(repr=False)

    def to_dict(self) -> dict[str, Any]:
        """The document that ``motorlens tune --json`` prints."""
        return self.document

    def _repr_html_(self) -> str:
        loops = [
            f"{name}: kp {gains['kp']:.4g}, ki {gains['ki']:.4g}, kd {gains['kd']:.4g}"
            for name, gains in (("velocity", self.velocity), ("position", self.position))
        ]
        return as_page("; ".join(loops), self.trials, *self.advice, self.plot, self.steps, self.plot_steps)

    def plot(self, axes: Any = None) -> Any:
        """How far each trial is from what was wanted, over time, and returns the axes. Needs matplotlib."""
        if axes is None:
            from matplotlib import pyplot

            _, axes = pyplot.subplots()
        for course in self.courses:
            axes.plot(course.time_s, course.wanted_rad - course.reached_rad, label=course.compensation)
        axes.set(xlabel="time / s", ylabel="tracking error / rad")
        axes.legend()
        return axes

    def plot_steps(self) -> Any:
        """The steps of the position and of the velocity under each compensation, and returns the figure. Needs matplotlib."""
        from matplotlib import pyplot

        figure, places = pyplot.subplots(1, 2, figsize=(10, 3.5))
        for of, unit, axes in zip(("position", "velocity"), ("rad", "rad/s"), places):
            responses = [response for response in self.step_responses if response.of == of]
            for response in responses:
                axes.plot(response.time_s, response.reached, label=response.compensation)
            for response in responses[:1]:
                axes.plot(response.time_s, response.wanted, color="black", linewidth=0.8)
            axes.set(xlabel="time / s", ylabel=f"{of} / {unit}")
            axes.legend(fontsize="small")
        figure.tight_layout()
        return figure


def _step(step: dict[str, Any]) -> dict[str, Any]:
    """A step as a row: the limit cycle in columns of its own."""
    cycle = step["limit_cycle"] or {"amplitude_rad": None, "frequency_hz": None}
    plain = {name: value for name, value in step.items() if name != "limit_cycle"}
    return {**plain, **{f"limit_cycle_{name}": value for name, value in cycle.items()}}


def tune(
    model: Model, period_s: float = 0.005, phase_margin_deg: float = 60.0, limit_v: Optional[float] = None
) -> Tuned:
    """PI of the velocity, PD of the position and feedforward for ``model``, and what its effects cost under them.

    ``period_s`` is the controller's (s, at most 0.1), ``phase_margin_deg`` that of both loops (20 to 80), ``limit_v`` the largest
    voltage of the controller (V; the model's supply if not given).
    """
    limit = None if limit_v is None else float(limit_v)
    text, courses, answers = model._native.tune(float(period_s), float(phase_margin_deg), limit)
    found = json.loads(text)
    rows = [
        {
            "compensation": trial["compensation"],
            "without_effects": trial["without_effects"],
            **{f"position_{name}": value for name, value in trial["position"].items()},
            **{f"velocity_{name}": value for name, value in trial["velocity"].items()},
        }
        for trial in found["trials"]
    ]
    runs = [
        Course(row["compensation"], *(np.frombuffer(column).copy() for column in columns))
        for row, columns in zip(rows, courses)
    ]
    responses = [
        StepResponse(step["of"], step["compensation"], *(np.frombuffer(column).copy() for column in columns))
        for step, columns in zip(found["steps"], answers)
    ]
    return Tuned(
        found["velocity"],
        found["position"],
        found["feedforward"],
        found["loads"],
        as_frame(rows),
        as_frame([_step(step) for step in found["steps"]]),
        found["advice"],
        runs,
        responses,
        found,
    )
