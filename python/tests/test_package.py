"""The package as its users call it. Real logs are read in place; where they are absent the test says so."""

import json
import os
import pathlib
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import motorlens

DATA = pathlib.Path(os.environ.get("MOTORLENS_DATA", pathlib.Path(__file__).parents[3] / "shared/data"))


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


def test_the_readmes_lines_reproduce_the_answer_of_the_demo(tmp_path, monkeypatch):
    readme = (pathlib.Path(__file__).parents[1] / "README.md").read_text()
    lines = next(block for block in readme.split("```python\n")[1:] if "hidden=" in block).split("```")[0]
    assert len(lines.strip().splitlines()) <= 10
    monkeypatch.chdir(tmp_path)
    names = {}
    exec(lines, names)
    found = names["found"]
    assert found.verdict == "explained" and found.effects == ["dead_zone"], found.headline
    level = found.parameters.set_index("name").loc["dead_zone.width"]
    assert abs(level.value - 0.5994) < 0.005 and level.low < 0.5994 < level.high


def test_the_hidden_effect_and_its_size_are_found(found):
    assert found.effects == ["coulomb"] and found.verdict == "explained"
    level = found.parameters.set_index("name").loc["coulomb.level"]
    assert level.low < 0.3 < level.high
    assert found.candidates.iloc[0]["effect"] == "coulomb"


def test_the_document_is_that_of_the_command_line(found):
    document = found.to_dict()
    assert document["schema"] == 1 and document["ladder"][0]["effects"] == []
    assert json.loads(json.dumps(document)) == document


@pytest.mark.parametrize("kind", ["dict", "pandas", "polars"])
def test_tables_give_the_same_answer_as_their_files(logs, found, kind):
    import pandas
    import polars

    make = {"dict": dict, "pandas": pandas.DataFrame, "polars": polars.DataFrame}[kind]
    motor = {"gear_ratio": 104, "counts_per_rev": 5000, "encoder_shaft": "output"}
    tables = [make(columns(path)) for path in logs["training"][:3]]
    again = motorlens.discover(tables, motor=motor)
    assert again.effects == found.effects
    gain = [f.parameters.set_index("name").loc["gain", "value"] for f in (again, found)]
    assert gain[0] == pytest.approx(gain[1], rel=1e-3)


def test_a_model_simulates_as_compare_does_and_steps_as_it_simulates(logs, found):
    run = motorlens.compare(found.model, logs["held_out"], motor=logs["motor"]).runs[0]
    table = columns(logs["held_out"][0])
    angle = found.model.simulate(table["time_s"], table["voltage_v"])
    count = 2 * np.pi / 5000
    assert np.ptp(angle - run.simulated) < 1e-9, "but for where in its count the encoder begins"
    assert abs((angle - run.simulated)[0]) <= count
    motor = found.model.start(1e-3)
    steps = [motor.step(v) for v in table["voltage_v"][:500]]
    assert np.allclose(steps[:-1], angle[1:500], atol=1e-9)


def test_a_model_is_saved_and_read_and_exported(found, tmp_path):
    found.model.save(tmp_path / "model.json")
    again = motorlens.load_model(tmp_path / "model.json")
    assert again.to_dict() == found.model.to_dict() and again.effects == ["coulomb"]
    motorlens.export(again, "python", tmp_path / "motor.py")
    namespace = {"__name__": "motor"}
    exec((tmp_path / "motor.py").read_text(), namespace)
    motor, mine = namespace["Motor"](), again.start(1e-3)
    for k in range(2000):
        volts = 6.0 if k % 700 < 400 else -3.0
        assert motor.step(volts) == pytest.approx(mine.step(volts), abs=1e-12)


def test_an_export_that_would_lose_an_effect_is_refused_with_its_cost(logs, tmp_path):
    lossy = motorlens.fit(logs["training"], effects=["backlash"], motor=logs["motor"]).model
    with pytest.raises(motorlens.MotorlensError, match="(?s)no place for backlash.*rad.*allow_missing"):
        lossy.export("urdf", tmp_path / "motor.urdf", torque_per_volt=0.1)
    assert not (tmp_path / "motor.urdf").exists()
    said = lossy.export("urdf", tmp_path / "motor.urdf", torque_per_volt=0.1, allow_missing=True)
    assert any("backlash" in line for line in said) and (tmp_path / "motor.urdf").exists()


def test_gains_follow_from_a_model_and_friction_compensation_pays(found):
    tuned = found.model.tune(period_s=0.01)
    assert tuned.position["kp"] > 0 and tuned.velocity["ki"] > 0
    assert tuned.feedforward["ks_v"] == pytest.approx(0.3, abs=0.02)
    errors = tuned.trials.set_index("compensation")["position_rms"]
    assert len(tuned.courses) == len(errors) and errors.iloc[1] > 2 * errors.iloc[-1], errors
    ideal, real = tuned.courses[0], tuned.courses[1]
    assert ideal.time_s.shape == ideal.wanted_rad.shape == real.reached_rad.shape
    rms = np.sqrt(np.mean((real.wanted_rad - real.reached_rad) ** 2))
    assert rms == pytest.approx(errors.iloc[1], rel=0.02)
    with pytest.raises(motorlens.MotorlensError, match="(?s)phase margin of 90.*do: give 20 to 80"):
        motorlens.tune(found.model, phase_margin_deg=90)


def test_two_sets_of_one_motor_are_the_same_and_those_of_another_are_not(logs, tmp_path):
    alike = motorlens.same(logs["training"][:2], logs["training"][2:4], logs["motor"], effects=["coulomb"])
    assert alike.verdict == "same", alike.why
    # One record was made by twice its voltage: that motor would have half the gain.
    other = [columns(path) for path in logs["training"][2:4]]
    for table in other:
        table["voltage_v"] = 2 * table["voltage_v"]
    apart = motorlens.same(logs["training"][:2], other, logs["motor"], effects=["coulomb"])
    assert apart.verdict == "different" and "gain" in apart.why, apart.why
    gain = apart.parameters.set_index("name").loc["gain"]
    assert gain.differs and gain.second[0] == pytest.approx(gain["first"][0] / 2, rel=0.02)


def test_an_effect_is_added_to_a_fit_and_found_worth_it(logs):
    plain = motorlens.fit(logs["training"], motor=logs["motor"])
    added = motorlens.add(plain.model, "coulomb", logs["training"], validate=logs["held_out"], motor=logs["motor"])
    assert added.worth_adding and added.model.effects == ["coulomb"]
    fit = motorlens.fit(logs["training"], effects=["coulomb"], motor=logs["motor"])
    assert fit.train["rmse"] < 0.1 * plain.train["rmse"]


def test_effects_are_a_table_and_a_plan_is_a_programme_or_nothing(logs):
    table = motorlens.effects()
    assert {"coulomb", "backlash", "sensor_lag"} <= set(table["name"])
    plan = motorlens.plan(logs["training"][:2], motor=logs["motor"], seconds=4)
    assert plan is None or (plan["why"] and plan["programme"])


def test_other_threads_run_meanwhile(logs):
    ticks, done = [], threading.Event()

    def tick():
        while not done.is_set():
            ticks.append(time.monotonic())
            time.sleep(0.001)

    thread = threading.Thread(target=tick)
    thread.start()
    begun = time.monotonic()
    motorlens.discover(logs["training"], motor=logs["motor"])
    seconds = time.monotonic() - begun
    done.set()
    thread.join()
    assert max(np.diff(ticks)) < max(0.1, 0.5 * seconds)


def test_a_progress_function_sees_the_models_and_stops_the_search_by_raising(logs):
    events = []
    motorlens.discover(logs["training"], motor=logs["motor"], progress=events.append)
    assert {"effects": [], "rmse": pytest.approx(events[0]["rmse"])} == events[0]
    assert any(event.get("trying") == "backlash" for event in events)

    def stop(event):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        motorlens.discover(logs["training"], motor=logs["motor"], progress=stop)


def test_ctrl_c_ends_a_search_soon(logs):
    words = ["import motorlens", "print('begun', flush=True)"]
    records = logs["training"] + logs["repeats"]
    words.append(f"while True: motorlens.discover({[str(path) for path in records]!r}, motor={str(logs['motor'])!r})")
    child = subprocess.Popen([sys.executable, "-c", "\n".join(words)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    child.stdout.readline()
    time.sleep(0.5)
    child.send_signal(signal.SIGINT)
    _, said = child.communicate(timeout=20)
    assert child.returncode != 0 and "KeyboardInterrupt" in said and "panicked" not in said, said


def test_what_cannot_be_used_is_refused_with_a_remedy(logs, tmp_path):
    table = columns(logs["training"][0])
    with pytest.raises(motorlens.MotorlensError, match="(?s)no column voltage_v.*do: give"):
        motorlens.discover([{"time_s": table["time_s"]}])
    with pytest.raises(motorlens.MotorlensError, match="(?s)time does not rise.*do: "):
        motorlens.discover([{name: values[::-1] for name, values in table.items()}])
    with pytest.raises(motorlens.MotorlensError, match="give a list"):
        motorlens.discover(table)
    with pytest.raises(motorlens.MotorlensError, match="did you mean coulomb"):
        motorlens.fit(logs["training"], effects=["coulom"])
    with pytest.raises(motorlens.MotorlensError, match="absent.csv"):
        motorlens.discover([tmp_path / "absent.csv"])


def test_findings_show_themselves_in_a_notebook(found):
    page = found._repr_html_()
    assert "coulomb.level" in page and "data:image/png;base64" in page


def test_the_notebook_runs_on_a_real_log():
    if not (DATA / "undcmotor-angle").is_dir():
        pytest.skip(f"no real logs at {DATA}")
    import nbclient
    import nbformat

    os.environ["MOTORLENS_DATA"] = str(DATA)
    path = pathlib.Path(__file__).parents[1] / "examples/real_motor.ipynb"
    notebook = nbformat.read(path, as_version=4)
    nbclient.NotebookClient(notebook, timeout=300).execute()
    said = "".join(o.get("text", "") for cell in notebook.cells for o in cell.get("outputs", []))
    assert "effects:" in said and "validation rmse" in said
