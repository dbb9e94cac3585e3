from collections.abc import Callable
from os import PathLike
from typing import Optional, Union

__version__: str

Table = tuple[str, dict[str, bytes], dict[str, str]]
Given = Union[str, PathLike[str], Table]
Progress = Optional[Callable[[str], object]]

class MotorlensError(Exception): ...

class NativeRun:
    def step(self, voltage_v: float) -> float: ...
    @property
    def angle_rad(self) -> float: ...
    @property
    def speed_rad_s(self) -> float: ...
    @property
    def time_s(self) -> float: ...

class NativeModel:
    @staticmethod
    def read(path: Union[str, PathLike[str]]) -> NativeModel: ...
    def write(self, path: Union[str, PathLike[str]]) -> None: ...
    def to_json(self) -> str: ...
    def simulate(self, time_s: bytes, voltage_v: bytes, angle_rad: float) -> bytes: ...
    def start(self, step_s: float, angle_rad: float) -> NativeRun: ...
    def tune(
        self, period_s: float, phase_margin_deg: float, limit_v: Optional[float]
    ) -> tuple[str, list[tuple[bytes, bytes, bytes]]]: ...
    def export(
        self, format: str, step_s: Optional[float], torque_per_volt: Optional[float], name: Optional[str]
    ) -> tuple[bytes, Optional[tuple[str, str]], list[str], list[str]]: ...

def discover(
    given: list[Given],
    validate: list[Given],
    motor_path: Optional[str],
    motor_text: Optional[str],
    most: int,
    progress: Progress,
) -> tuple[str, NativeModel]: ...
def fit(
    given: list[Given],
    validate: list[Given],
    motor_path: Optional[str],
    motor_text: Optional[str],
    how: tuple[str, list[str], int, int, int],
    progress: Progress,
) -> tuple[str, NativeModel]: ...
def add(
    model: NativeModel,
    effect: str,
    given: list[Given],
    validate: list[Given],
    motor_path: Optional[str],
    motor_text: Optional[str],
) -> tuple[str, NativeModel]: ...
def plan(
    given: list[Given],
    motor_path: Optional[str],
    motor_text: Optional[str],
    volts: Optional[float],
    seconds: float,
    progress: Progress,
) -> Optional[str]: ...
def compare(
    model: NativeModel,
    given: list[Given],
    motor_path: Optional[str],
    motor_text: Optional[str],
) -> tuple[str, list[tuple[str, str, bytes, bytes, bytes]]]: ...
def same(
    first: list[Given],
    second: list[Given],
    effects: Optional[list[str]],
    motor_path: Optional[str],
    motor_text: Optional[str],
    progress: Progress,
) -> str: ...
def effects() -> str: ...
def simulate(options: list[str]) -> str: ...
