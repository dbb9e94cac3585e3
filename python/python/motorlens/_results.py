"""Answers as dataclasses, with tables where pandas is installed and plots where matplotlib is."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Optional

import numpy as np

from ._frames import as_page
from ._model import Model


@dataclass(frozen=True)
class Run:
    """A record and the model's open-loop simulation beside it, for each of its n samples."""

    record: str
    #: rad, or rad/s where only the speed is measured.
    unit: str
    #: (n,), s.
    time_s: np.ndarray
    #: (n,), in ``unit``.
    measured: np.ndarray
    #: (n,), in ``unit``.
    simulated: np.ndarray
    #: The speed at which the simulation begins, rad/s: 0 from rest, else found for the model.
    first_speed_rad_s: float

    def plot(self, axes: Any = None) -> Any:
        """Measured and simulated over time, and returns the axes. Needs matplotlib."""
        if axes is None:
            from matplotlib import pyplot

            _, axes = pyplot.subplots()
        axes.plot(self.time_s, self.measured, label="measured")
        axes.plot(self.time_s, self.simulated, label="simulated", linestyle="--")
        axes.set(xlabel="time / s", ylabel=self.unit, title=self.record)
        axes.legend()
        return axes


def _plotted(runs: list[Run]) -> Any:
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(len(runs), 1, squeeze=False, figsize=(8, 2.6 * len(runs)))
    for run, place in zip(runs, axes[:, 0]):
        run.plot(place)
    figure.tight_layout()
    return figure


@dataclass(frozen=True)
class Comparison:
    """Open-loop simulations of a model over records, and how far they are off."""

    #: rmse, ae, me, iae, nrmse_fit_percent and samples over all records.
    pooled: dict[str, float]
    #: The same for each record, and first_speed_rad_s: a DataFrame.
    records: Any
    runs: list[Run]
    #: Of the errors: rad, or rad/s where only the speed is measured.
    unit: str

    def plot(self) -> Any:
        """Each record with the model's simulation, and returns the figure. Needs matplotlib."""
        return _plotted(self.runs)

    def _repr_html_(self) -> str:
        return as_page(f"rmse {self.pooled['rmse']:.4g} {self.unit}", self.records, self.plot)


@dataclass(frozen=True)
class Fit:
    """Parameters of a model whose effects were given."""

    model: Model
    #: name, value, unit, low, high (95 %), identifiable: a DataFrame.
    parameters: Any
    #: rmse, ae, me, iae, nrmse_fit_percent and samples on the records fitted, in rad or rad/s.
    train: dict[str, float]
    #: The same on the records of ``validate``; None without any.
    validation: Optional[dict[str, float]]
    #: What the sizes of the effects rest on that no record tells, in sentences; None where there is nothing of the kind.
    supposes: Optional[str]
    document: dict[str, Any] = field(repr=False)

    def to_dict(self) -> dict[str, Any]:
        """The document that ``motorlens fit --json`` prints."""
        return self.document

    def _repr_html_(self) -> str:
        effects = ", ".join(self.model.effects) or "no effects"
        head = f"Model with {effects}: rmse {self.train['rmse']:.4g}"
        return as_page(head, *filter(None, [self.supposes]), self.parameters)


@dataclass(frozen=True)
class Addition:
    """What adding an effect did."""

    effect: str
    #: Whether blocks that are held out of the records fitted confirm it.
    worth_adding: bool
    #: Why, in a sentence.
    why: str
    #: The model with it.
    model: Model
    #: name, value, unit, low, high (95 %), identifiable: a DataFrame.
    parameters: Any
    #: What the sizes of the effects rest on that no record tells, in sentences; None where there is nothing of the kind.
    supposes: Optional[str]
    document: dict[str, Any] = field(repr=False)

    def to_dict(self) -> dict[str, Any]:
        """The document that ``motorlens add --json`` prints."""
        return self.document

    def _repr_html_(self) -> str:
        return as_page(self.why, *filter(None, [self.supposes]), self.parameters)


@dataclass(frozen=True)
class Same:
    """Whether two sets of records come from one motor."""

    #: same (no difference shows), different, or open where the records leave it so.
    verdict: str
    #: Why, in a sentence.
    why: str
    #: Effects of the models that were fitted.
    effects: list[str]
    #: name, unit, first and second (value and 95 % interval), deviations, differs; the most different first: a DataFrame.
    parameters: Any
    #: Parameters that not both sets determine.
    open: list[str]
    document: dict[str, Any] = field(repr=False)

    def to_dict(self) -> dict[str, Any]:
        """The document that ``motorlens same --json`` prints."""
        return self.document

    def _repr_html_(self) -> str:
        verdict = "no difference shows" if self.verdict == "same" else self.verdict
        return as_page(f"{verdict}: {self.why}", self.parameters)


@dataclass(frozen=True)
class Findings:
    """What a discovery found."""

    #: Accepted effects, in the order they were added; empty where nothing is worth adding.
    effects: list[str]
    #: explained, partly_explained, unexplained or bad_data.
    verdict: str
    #: The verdict in a sentence.
    headline: str
    #: name, value, unit, low, high (95 %), identifiable: a DataFrame.
    parameters: Any
    #: The first diagnosis, best first: a DataFrame.
    candidates: Any
    #: Sets of effects that these records cannot tell apart.
    rivals: list[list[str]]
    #: For each effect the smallest size that these records would show.
    detection_limits: list[dict[str, Any]]
    #: Data quality problems: fault, where and fix, a sentence each.
    data_faults: list[dict[str, str]]
    model: Model
    runs: list[Run] = field(repr=False)
    document: dict[str, Any] = field(repr=False)

    def to_dict(self) -> dict[str, Any]:
        """The document that ``motorlens discover --json`` prints."""
        return self.document

    def plot(self) -> Any:
        """Each record with the model's simulation, and returns the figure. Needs matplotlib."""
        return _plotted(self.runs)

    def _repr_html_(self) -> str:
        rivals = [f"These records cannot tell apart: {', '.join(names)}." for names in self.rivals]
        return as_page(self.headline, *rivals, self.parameters, self.plot)
