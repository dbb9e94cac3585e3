"""Logs that several tests read."""

import numpy as np
import pytest

import motorlens


@pytest.fixture(scope="session")
def logs(tmp_path_factory):
    """Logs of a simulated motor with dry friction."""
    return motorlens.simulate(tmp_path_factory.mktemp("logs"), effects=["coulomb=0.3"], seconds=5)


def columns(path):
    names = [line for line in open(path) if not line.startswith("#")][0].strip().split(",")
    rows = np.genfromtxt([line for line in open(path) if not line.startswith("#")], delimiter=",", skip_header=1)
    return {name: rows[:, k] for k, name in enumerate(names)}


@pytest.fixture(scope="session")
def found(logs):
    return motorlens.discover(logs["training"] + logs["repeats"], validate=logs["held_out"], motor=logs["motor"])
