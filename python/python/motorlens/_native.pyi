from collections.abc import Callable
from os import PathLike
from typing import Optional, Union, final

__all__ = [
    "MotorlensError",
    "NativeModel",
    "NativeRecord",
    "NativeRun",
    "__version__",
    "add",
    "compare",
    "discover",
    "effects",
    "fit",
    "plan",
    "read",
    "same",
    "simulate",
    "write_file",
]

__version__: str

_Path = Union[str, PathLike[str]]
_Table = tuple[str, dict[str, bytes]]
_Given = Union[NativeRecord, _Path, _Table]
_Told = Optional[Callable[[str], object]]
_Run = tuple[str, str, bytes, bytes, bytes]
_Course = tuple[bytes, bytes, bytes]

class MotorlensError(Exception): ...

@final
class NativeRecord:
    @property
    def name(self) -> str: ...
    @property
    def warnings(self) -> list[str]: ...
    def columns(self) -> list[tuple[str, bytes]]: ...

@final
class NativeRun:
    def step(self, voltage_v: float) -> float: ...
    @property
    def angle_rad(self) -> float: ...
    @property
    def speed_rad_s(self) -> float: ...
    @property
    def time_s(self) -> float: ...

@final
class NativeModel:
    @staticmethod
    def read(path: _Path) -> NativeModel: ...
    @staticmethod
    def from_json(text: str) -> NativeModel: ...
    def write(self, path: _Path) -> None: ...
    def to_json(self) -> str: ...
    def simulate(self, time_s: bytes, voltage_v: bytes, angle_rad: float, speed_rad_s: float) -> bytes: ...
    def start(self, step_s: float, angle_rad: float, speed_rad_s: float) -> NativeRun: ...
    def tune(
        self, period_s: float, phase_margin_deg: float, limit_v: Optional[float]
    ) -> tuple[str, list[_Course], list[_Course]]: ...
    def export(
        self,
        format: str,
        how: tuple[Optional[float], Optional[float], Optional[str], Optional[int]],
        on: list[_Given],
        motor_path: Optional[_Path],
        motor_text: Optional[str],
        progress: _Told,
    ) -> tuple[bytes, Optional[tuple[str, str]], list[str], list[str]]: ...

def read(words: list[str]) -> list[NativeRecord]: ...
def write_file(path: _Path, content: bytes) -> None: ...
def discover(
    given: list[_Given],
    validate: list[_Given],
    motor_path: Optional[_Path],
    motor_text: Optional[str],
    most: int,
    own: list[_Path],
    progress: _Told,
) -> tuple[str, NativeModel]: ...
def fit(
    given: list[_Given],
    validate: list[_Given],
    motor_path: Optional[_Path],
    motor_text: Optional[str],
    how: tuple[str, list[str], int, int, int],
    own: list[_Path],
    progress: _Told,
) -> tuple[str, NativeModel]: ...
def add(
    model: NativeModel,
    effect: str,
    given: list[_Given],
    validate: list[_Given],
    motor_path: Optional[_Path],
    motor_text: Optional[str],
    own: list[_Path],
    progress: _Told,
) -> tuple[str, NativeModel]: ...
def plan(
    given: list[_Given],
    motor_path: Optional[_Path],
    motor_text: Optional[str],
    volts: Optional[float],
    seconds: float,
    own: list[_Path],
    progress: _Told,
) -> Optional[str]: ...
def compare(
    model: NativeModel,
    given: list[_Given],
    motor_path: Optional[_Path],
    motor_text: Optional[str],
) -> tuple[str, list[_Run]]: ...
def same(
    first: list[_Given],
    second: list[_Given],
    effects: Optional[list[str]],
    motor_path: Optional[_Path],
    motor_text: Optional[str],
    own: list[_Path],
    progress: _Told,
) -> str: ...
def effects(own: list[_Path]) -> str: ...
def simulate(options: list[str], own: list[_Path]) -> str: ...
