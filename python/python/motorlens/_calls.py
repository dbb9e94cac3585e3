"""The verbs."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable
from typing import Any, Optional, Union

import numpy as np

from . import _native
from ._frames import as_frame
from ._model import Model
from ._progress import Progress, watching
from ._records import EffectFiles, KnownMotor, Record, as_list, as_motor, as_names, as_records
from ._results import Addition, Comparison, Findings, Fit, Run, Same


def discover(
    records: Iterable[Record],
    validate: Iterable[Record] = (),
    motor: KnownMotor = None,
    most: int = 4,
    effect_files: EffectFiles = (),
    progress: Progress = None,
) -> Findings:
    """Fits, diagnoses and adds effects until nothing is worth adding.

    ``records`` and ``validate`` are lists of paths or tables (see :mod:`motorlens`); those of ``validate`` touch no fit and no
    choice of an effect. ``motor`` is the path of a motor.toml or its content as a dict, ``most`` the largest number of
    effects. ``effect_files`` are paths of descriptions of effects of your own, which are tried among the others. ``progress`` shows a
    bar in a terminal and in a notebook, if not given; a function gets every event as a dict, and stops the call by raising.
    Ctrl-C stops it; other threads run meanwhile. Raises :class:`MotorlensError` on records that no fit can use.
    """
    records, validate = as_list(records), as_list(validate)
    path, text = as_motor(motor)
    given, judges = as_records(records), as_records(validate, "validation record")
    with watching(progress) as told:
        document, native = _native.discover(given, judges, path, text, most, list(effect_files), told)
    found, model = json.loads(document), Model(native)
    return Findings(
        effects=found["effects"],
        verdict=found["verdict"],
        headline=found["headline"],
        parameters=as_frame(found["parameters"]),
        candidates=as_frame(found["candidates"]),
        rivals=found["rivals"],
        detection_limits=found.get("detection_limits", []),
        data_faults=found["data_faults"],
        model=model,
        runs=compare(model, records + validate, motor).runs,
        document=found,
    )


def fit(
    records: Iterable[Record],
    effects: Union[str, Iterable[str]] = (),
    validate: Iterable[Record] = (),
    motor: KnownMotor = None,
    method: str = "fast",
    population: int = 80,
    generations: int = 800,
    seed: int = 1,
    effect_files: EffectFiles = (),
    progress: Progress = None,
) -> Fit:
    """Finds the parameters of a model with the given ``effects``.

    ``method`` is fast, ga, conventional, paper or feedforward; ``population``, ``generations`` and ``seed`` are the genetic
    algorithm's. The rest is as in :func:`discover`.
    """
    path, text = as_motor(motor)
    how = (method, as_names(effects), int(population), int(generations), int(seed))
    given, judges = as_records(records), as_records(validate, "validation record")
    with watching(progress, int(generations)) as told:
        document, native = _native.fit(given, judges, path, text, how, list(effect_files), told)
    found = json.loads(document)
    parameters = as_frame(found["parameters"])
    return Fit(Model(native), parameters, found["train"], found["validation"], found["supposes"], found)


def add(
    model: Model,
    effect: str,
    records: Iterable[Record],
    validate: Iterable[Record] = (),
    motor: KnownMotor = None,
    effect_files: EffectFiles = (),
    progress: Progress = None,
) -> Addition:
    """Adds ``effect`` to ``model``, refits, and says whether it is worth it.

    ``progress`` sees the model refitted as it is, the effect on trial, and the model with it. The rest is as in :func:`discover`.
    """
    path, text = as_motor(motor)
    given, judges = as_records(records), as_records(validate, "validation record")
    # The first half is the model as it is.
    with watching(progress, trials=2) as told:
        document, native = _native.add(model._native, effect, given, judges, path, text, list(effect_files), told)
    found = json.loads(document)
    parameters = as_frame(found["parameters"])
    worth, why, supposes = found["worth_adding"], found["why"], found["supposes"]
    return Addition(effect, worth, why, Model(native), parameters, supposes, found)


def compare(model: Model, records: Iterable[Record], motor: KnownMotor = None) -> Comparison:
    """Simulates ``model`` over every record, in an open loop; nothing is fitted.

    ``records`` and ``motor`` are as in :func:`discover`. The answer has the errors over all records and for each, in rad or rad/s as its
    ``unit`` tells, and in ``runs`` the arrays (n,) of each record's n samples.
    """
    path, text = as_motor(motor)
    document, runs = _native.compare(model._native, as_records(records), path, text)
    found = json.loads(document)
    arrays = []
    for (name, unit, *columns), row in zip(runs, found["records"]):
        time, measured, simulated = (np.frombuffer(column).copy() for column in columns)
        arrays.append(Run(name, unit, time, measured, simulated, row["first_speed_rad_s"]))
    return Comparison(found["pooled"], as_frame(found["records"]), arrays, found["unit"])


def plan(
    records: Iterable[Record],
    motor: KnownMotor = None,
    volts: Optional[float] = None,
    seconds: float = 8.0,
    effect_files: EffectFiles = (),
    progress: Progress = None,
) -> Optional[dict[str, Any]]:
    """The experiment that would tell apart what ``records`` leave open; None where nothing is open.

    A dict with ``why``, a sentence, and ``programme``, which ``motorlens capture --programme`` runs, within ``volts`` (V; what the
    records reached, if not given) and ``seconds``. The rest is as in :func:`discover`.
    """
    path, text = as_motor(motor)
    with watching(progress) as told:
        answer = _native.plan(as_records(records), path, text, volts, float(seconds), list(effect_files), told)
    return None if answer is None else json.loads(answer)


def same(
    first: Iterable[Record],
    second: Iterable[Record],
    motor: KnownMotor = None,
    effects: Union[str, Iterable[str], None] = None,
    effect_files: EffectFiles = (),
    progress: Progress = None,
) -> Same:
    """Whether two sets of records come from one motor, and which parameters differ beyond their intervals.

    ``effects`` are those of the models that are fitted to either set and to both; if not given, what :func:`discover` finds on the
    first set. The rest is as in :func:`discover`.
    """
    path, text = as_motor(motor)
    names = None if effects is None else as_names(effects)
    with watching(progress) as told:
        given = as_records(first, "record"), as_records(second, "second record")
        found = json.loads(_native.same(*given, names, path, text, list(effect_files), told))
    return Same(
        verdict=found["verdict"],
        why=found["why"],
        effects=found["effects"],
        parameters=as_frame(found["parameters"]),
        open=found["open"],
        document=found,
    )


def effects(effect_files: EffectFiles = ()) -> Any:
    """The effects: name, port, title, equation, source, signature and parameters, as a DataFrame.

    Those of your own that ``effect_files`` describe stand last.
    """
    return as_frame(json.loads(_native.effects(list(effect_files))))


def simulate(
    out: Union[str, "os.PathLike[str]"],
    effects: Union[str, Iterable[str]] = (),
    hidden: Optional[int] = None,
    effect_files: EffectFiles = (),
    **options: Any,
) -> dict[str, Any]:
    """Writes logs of the virtual motor into the directory ``out``.

    ``effects`` are names, with or without a size (``"coulomb=0.3"``); ``hidden`` is a seed that picks effects and does not tell.
    ``effect_files`` are paths of descriptions of effects of your own, which ``effects`` may name.
    ``options`` are those of ``motorlens simulate``: ``seed=2``, ``seconds=8`` (s), ``rate=500`` (Hz), ``excitation="staircase"``. Returns a
    dict with the paths: ``motor``, ``training``, ``repeats``, ``held_out``.
    """
    words = ["--out", os.fspath(out)]
    for effect in as_names(effects):
        words += ["--effect", effect]
    if hidden is not None:
        words += ["--hidden", str(hidden)]
    for name, value in options.items():
        words += [f"--{name.replace('_', '-')}", str(value)]
    written: dict[str, Any] = json.loads(_native.simulate(words, list(effect_files)))
    return written
