"""What users give, as the native part takes it."""

from __future__ import annotations

import os
import re
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Optional, Union

import numpy as np

from . import _native
from ._native import MotorlensError

#: A record: the path of a log, a table of columns, or a :class:`Log`.
Record = Union[str, "os.PathLike[str]", Mapping[str, Any], Any]
#: What is known of the motor: the path of a motor.toml, or its content as a dict.
KnownMotor = Union[str, "os.PathLike[str]", Mapping[str, Any], None]
#: Paths of files, each with an effect of one's own.
EffectFiles = Sequence[Union[str, "os.PathLike[str]"]]

NEEDED = ("time_s", "voltage_v")
MEASURED = ("angle_rad", "speed_rad_s")
OPTIONAL = ("current_a", "supply_v")


class Log(Mapping[str, np.ndarray]):
    """A record of a log file, as :func:`read` made it: its columns by name, arrays (n,) in SI units."""

    def __init__(self, native: _native.NativeRecord) -> None:
        self._native = native
        self._columns = {name: np.frombuffer(column) for name, column in native.columns()}

    @property
    def name(self) -> str:
        """Its name in messages: that of its file, and of the test where a file holds several."""
        return self._native.name

    @property
    def warnings(self) -> list[str]:
        """Data quality problems of the file, in sentences."""
        return self._native.warnings

    def __getitem__(self, name: str) -> np.ndarray:
        return self._columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def __repr__(self) -> str:
        time = self._columns["time_s"]
        return f"Log({self.name!r}, {len(time)} samples, {time[-1] - time[0]:.4g} s, columns {', '.join(self)})"


def as_array(values: Any) -> np.ndarray:
    """One-dimensional 64-bit numbers."""
    try:
        array = np.ascontiguousarray(values, dtype=np.float64)
    except (TypeError, ValueError) as why:
        raise MotorlensError(f"a column is no numbers: {why}\n  do: give one number a sample") from None
    if array.ndim != 1:
        raise MotorlensError(f"a column has the shape {array.shape}\n  do: give one value a sample")
    return array


def _named(record: Any, name: str) -> tuple[Any, list[Any]]:
    """A table that is indexed by column, and the names of its columns."""
    if hasattr(record, "collect") and hasattr(record, "lazy"):
        record = record.collect()
    if isinstance(record, Mapping):
        return record, list(record)
    if isinstance(record, np.ndarray) and record.dtype.names:
        return record, list(record.dtype.names)
    names = getattr(record, "column_names", getattr(record, "columns", None))
    if names is None:
        raise MotorlensError(
            f"{name} is of type {type(record).__name__}\n"
            "  do: give a path, or a table: a dict of arrays, or a DataFrame of pandas or polars"
        )
    return record, list(names)


def _table(record: Any, name: str) -> tuple[str, dict[str, bytes]]:
    """The columns of a record; what else a table has is left alone, and so are rows without a number, as in files."""
    record, names = _named(record, name)
    missing = [wanted for wanted in NEEDED if wanted not in names]
    if not missing and not any(wanted in names for wanted in MEASURED):
        missing = [" or ".join(MEASURED)]
    if missing:
        raise MotorlensError(
            f"{name}: there is no column {missing[0]}; its columns are {', '.join(map(str, names))}\n"
            "  do: give time_s, voltage_v and angle_rad or speed_rad_s by these names, in SI units"
        )
    columns = {wanted: as_array(record[wanted]) for wanted in NEEDED + MEASURED + OPTIONAL if wanted in names}
    lengths = {wanted: len(column) for wanted, column in columns.items()}
    if len(set(lengths.values())) > 1:
        raise MotorlensError(f"{name}: columns of different length, {lengths}\n  do: give one value a sample in each")
    for wanted in OPTIONAL:
        if wanted in columns and np.isnan(columns[wanted]).any():
            del columns[wanted]
    blank = np.zeros(lengths["time_s"], dtype=bool)
    for column in columns.values():
        blank |= np.isnan(column)
    if blank.any() and not blank.all():
        warnings.warn(f"{name}: {blank.sum()} of {len(blank)} rows lack a number and are left out", stacklevel=4)
        columns = {wanted: column[~blank] for wanted, column in columns.items()}
    return name, {wanted: column.tobytes() for wanted, column in columns.items()}


def as_list(records: Iterable[Record]) -> list[Record]:
    """The records as a list; refuses a single one in its place."""
    if isinstance(records, (str, os.PathLike, Mapping)) or hasattr(records, "columns"):
        raise MotorlensError("records is one record\n  do: give a list of them: [record]")
    return list(records)


def as_records(records: Iterable[Record], called: str = "record") -> list[Any]:
    """Paths stay paths, tables become bytes by column; `called` and a number are the name of a table."""
    given: list[Any] = []
    for number, record in enumerate(as_list(records), 1):
        if isinstance(record, Log):
            given.append(record._native)
        elif isinstance(record, (str, os.PathLike)):
            given.append(record)
        else:
            given.append(_table(record, f"{called} {number}"))
    return given


def as_names(names: Union[str, Iterable[str]]) -> list[str]:
    """Names of effects; one text may hold several, as on the command line."""
    return [name.strip() for name in names.split(",") if name.strip()] if isinstance(names, str) else list(names)


def read(
    path: Union[str, "os.PathLike[str]"],
    map: Optional[str] = None,
    motor: Union[str, "os.PathLike[str]", None] = None,
    skip: Iterable[str] = (),
    **options: Any,
) -> list[Log]:
    """Reads a log file of any layout; a file may hold several records.

    Without ``map`` a file whose columns are not the canonical ones is refused with a guess at its mapping, to be given here:
    ``map="time=t:ms,voltage=u,angle=enc:counts"``. ``motor`` is the path of a motor.toml; ``skip`` lists seconds to leave out
    (``"3.2..4.0"``). ``options`` are those by which ``motorlens discover`` reads logs, with ``_`` for ``-``: ``rate=100`` (Hz),
    ``supply_volts=11.1``, ``counts_per_rev=1320``, ``hold="first"``, ``format="wpilib-sysid"``.
    """
    words = [os.fspath(path)]
    for name, value in {"map": map, "motor": motor, **options}.items():
        if value is not None:
            words.append(f"--{name.replace('_', '-')}={value}")
    words += [f"--skip={seconds}" for seconds in skip]
    return [Log(native) for native in _native.read(words)]


def _toml(value: Any) -> str:
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    return repr(float(value))


def _key(name: str) -> str:
    # A dot would begin a table of its own.
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else _toml(name)


def as_motor(motor: KnownMotor) -> tuple[Optional[str], Optional[str]]:
    """The path of a motor file, or the text of one."""
    if motor is None:
        return None, None
    if not isinstance(motor, Mapping):
        return os.fspath(motor), None
    plain = [f"{_key(key)} = {_toml(value)}" for key, value in motor.items() if not isinstance(value, Mapping)]
    for key, table in motor.items():
        if isinstance(table, Mapping):
            plain += [f"[{_key(key)}]", *(f"{_key(name)} = {_toml(value)}" for name, value in table.items())]
    return None, "\n".join(plain) + "\n"
