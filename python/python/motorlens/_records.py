"""What users give, as the native part takes it."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import Any, Optional, Union

import numpy as np

from ._native import MotorlensError

#: A record: the path of a log, or a table of columns.
Record = Union[str, "os.PathLike[str]", Mapping[str, Any], Any]
#: What is known of the motor: the path of a motor.toml, or its content as a dict.
KnownMotor = Union[str, "os.PathLike[str]", Mapping[str, Any], None]


def as_array(values: Any) -> np.ndarray:
    """One-dimensional 64-bit numbers."""
    array = np.ascontiguousarray(values, dtype=np.float64)
    if array.ndim != 1:
        raise MotorlensError(f"a column has the shape {array.shape}\n  do: give one value a sample")
    return array


def _table(record: Any, number: int) -> tuple[str, dict[str, bytes], dict[str, str]]:
    names = list(record.keys()) if isinstance(record, Mapping) else list(record.columns)
    columns = {str(name): as_array(record[name]).tobytes() for name in names}
    return f"record {number}", columns, {}


def as_list(records: Iterable[Record]) -> list[Record]:
    """The records as a list; refuses a single one in its place."""
    if isinstance(records, (str, os.PathLike, Mapping)) or hasattr(records, "columns"):
        raise MotorlensError("records is one record\n  do: give a list of them: [record]")
    return list(records)


def as_records(records: Iterable[Record]) -> list[Any]:
    """Paths stay paths, tables become bytes by column."""
    return [
        record if isinstance(record, (str, os.PathLike)) else _table(record, number)
        for number, record in enumerate(as_list(records), 1)
    ]


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    return repr(float(value))


def as_motor(motor: KnownMotor) -> tuple[Optional[str], Optional[str]]:
    """The path of a motor file, or the text of one."""
    if motor is None:
        return None, None
    if not isinstance(motor, Mapping):
        return os.fspath(motor), None
    plain = [f"{key} = {_toml(value)}" for key, value in motor.items() if not isinstance(value, Mapping)]
    for key, table in motor.items():
        if isinstance(table, Mapping):
            plain += [f"[{key}]", *(f"{name} = {_toml(value)}" for name, value in table.items())]
    return None, "\n".join(plain) + "\n"
