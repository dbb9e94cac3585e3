"""The package as its users call it."""

import copy
import json
import os
import pathlib
import pickle
import subprocess
import sys

import numpy as np
import pytest
from conftest import columns

import motorlens

#: Logs of real motors.
DATA = pathlib.Path(__file__).parents[1] / "examples/data"


def test_the_readmes_lines_reproduce_the_answer_of_the_demo(tmp_path, monkeypatch):
    readme = (pathlib.Path(__file__).parents[1] / "README.md").read_text()
    lines = next(block for block in readme.split("```python\n")[1:] if "hidden=" in block).split("```")[0]
    assert len(lines.strip().splitlines()) <= 10
    monkeypatch.chdir(tmp_path)
    names = {}
    exec(lines, names)
    found = names["found"]
    assert found.verdict == "explained" and found.effects == ["dead_zone"], found.headline
    width = found.parameters.set_index("name").loc["dead_zone.width"]
    # As `motorlens reveal` tells it, in V: to four digits.
    hidden, rounded = 0.5994, 0.5e-4
    assert abs(width.value - hidden) < 0.005 and width.low - rounded < hidden < width.high + rounded


def test_the_hidden_effect_and_its_size_are_found(found):
    assert found.effects == ["coulomb"] and found.verdict == "explained"
    level = found.parameters.set_index("name").loc["coulomb.level"]
    assert level.low < 0.3 < level.high
    assert found.candidates.iloc[0]["effect"] == "coulomb"


def test_the_document_is_that_of_the_command_line(found):
    document = found.to_dict()
    assert document["schema"] == 1 and document["ladder"][0]["effects"] == []
    assert json.loads(json.dumps(document)) == document


def test_a_model_is_copied_and_sent_to_other_processes(found):
    again = pickle.loads(pickle.dumps(found.model))
    assert again.to_dict() == found.model.to_dict() == copy.deepcopy(found.model).to_dict()
    assert again.step(6.0) == found.model.start().step(6.0)


def test_a_model_simulates_as_compare_does_and_steps_as_it_simulates(logs, found):
    run = motorlens.compare(found.model, logs["held_out"], motor=logs["motor"]).runs[0]
    assert run.first_speed_rad_s == 0.0
    table = columns(logs["held_out"][0])
    angle = found.model.simulate(table["time_s"], table["voltage_v"])
    count = 2 * np.pi / 5000
    assert np.ptp(angle - run.simulated) < 1e-9, "but for where in its count the encoder begins"
    assert abs((angle - run.simulated)[0]) <= count
    motor = found.model.start(1e-3)
    steps = [motor.step(v) for v in table["voltage_v"][:500]]
    assert np.allclose(steps[:-1], angle[1:500], atol=1e-9)


def test_a_record_in_motion_is_simulated_and_exported_from_the_speed_that_compare_tells(tmp_path):
    rig, motor = DATA / "undcmotor-angle", DATA / "undcmotor-angle/motor.toml"
    train = sorted((rig / "train").glob("*.csv"))
    model = motorlens.fit(train, effects=["coulomb", "dead_zone"], motor=motor).model
    # From the fourth sample on, while the motor runs.
    table = {name: values[3:] for name, values in columns(rig / "validation/step.csv").items()}
    run = motorlens.compare(model, [table], motor=motor).runs[0]
    assert run.first_speed_rad_s > 1.0
    angle = model.simulate(table["time_s"], table["voltage_v"], run.measured[0], run.first_speed_rad_s)
    assert np.ptp(angle - run.simulated) < 1e-9, "but for where in its count the encoder begins"
    # Eight steps of the program from a sample to the next, as compare takes them, and twenty, as the export does if not asked.
    error = np.sqrt(np.mean((run.simulated - run.measured) ** 2))
    for parts in (8, 20):
        motorlens.export(model, "python", tmp_path / "motor.py", step_s=0.02 / parts)
        names = {"__name__": "motor"}
        exec((tmp_path / "motor.py").read_text(), names)
        program = names["Motor"](run.measured[0], run.first_speed_rad_s)
        readings = [program.reading]
        for volts in table["voltage_v"][:-1]:
            readings.append([program.step(volts) for _ in range(parts)][-1])
        assert parts != 8 or np.ptp(readings - run.simulated) < 1e-9
        assert abs(_error(readings, run) - error) < 0.01 * error


def _error(readings, run):
    """Root mean square of the readings beside the measurement, moved within a count as compare moves them."""
    count = 2 * np.pi / 2800
    apart = run.measured - readings
    return np.sqrt(np.mean((apart - np.clip(np.mean(apart), -count, count)) ** 2))


def test_an_export_whose_steps_are_too_long_for_a_record_is_refused(logs, found, tmp_path):
    record = [path for path in logs["training"] if "prbs" in path]
    with pytest.raises(motorlens.MotorlensError, match="(?s)more than a hundredth above it .give a step of.*allow_missing"):
        found.model.export("c", tmp_path / "motor.c", step_s=0.01, on=record, motor=logs["motor"])
    assert not (tmp_path / "motor.c").exists()
    found.model.export("c", tmp_path / "motor.c", on=record, motor=logs["motor"])


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


def test_an_export_is_judged_on_records_and_written_whole_or_not_at_all(logs, found, tmp_path):
    # WPILib has no inductance, and a record of quick reversals shows it.
    record = [path for path in logs["training"] if "prbs" in path]
    with pytest.raises(motorlens.MotorlensError, match="(?s)more than a hundredth above.*allow_missing"):
        found.model.export("wpilib", tmp_path / "gains.txt", on=record, motor=logs["motor"])
    assert not (tmp_path / "gains.txt").exists()
    said = found.model.export("bam", tmp_path / "m6.json", torque_per_volt=0.1, bam_model=6, name="arm")
    assert json.loads((tmp_path / "m6.json").read_text())["model"] == "m6" and said
    with pytest.raises(motorlens.MotorlensError, match="(?s)no folder.*do: make it first"):
        found.model.export("c", tmp_path / "nowhere/motor.c")


def test_gains_follow_from_a_model_and_friction_compensation_pays(found):
    tuned = found.model.tune(period_s=0.01)
    assert tuned.position["kp"] > 0 and tuned.velocity["ki"] > 0
    assert set(tuned.steps["of"]) == {"position", "velocity"} and (tuned.steps["height"] > 0).all()
    assert tuned.steps["limit_cycle_amplitude_rad"].isna().all(), "friction holds the shaft where it stops"
    assert tuned.feedforward["ks_v"] == pytest.approx(0.3, abs=0.02)
    errors = tuned.trials.set_index("compensation")["position_rms"]
    assert len(tuned.courses) == len(errors) and errors.iloc[1] > 2 * errors.iloc[-1], errors
    assert len(tuned.step_responses) == len(tuned.steps)
    for response, (_, row) in zip(tuned.step_responses, tuned.steps.iterrows()):
        assert (response.of, response.compensation) == (row["of"], row["compensation"])
        assert response.time_s.shape == response.wanted.shape == response.reached.shape
        assert response.wanted[-1] == pytest.approx(row["height"])
        assert max(0, response.reached.max() / row["height"] - 1) == pytest.approx(row["overshoot"], abs=1e-9)
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
    # Friction rests on no unit of the angle and on no supply.
    assert fit.supposes is None and added.supposes is None
    assert fit.train["rmse"] < 0.1 * plain.train["rmse"]
    assert list(fit.parameters) == ["name", "value", "unit", "low", "high", "identifiable"]


def test_effects_are_a_table_and_a_plan_is_a_programme_or_nothing(logs):
    table = motorlens.effects()
    assert {"coulomb", "backlash", "sensor_lag"} <= set(table["name"])
    plan = motorlens.plan(logs["training"][:2], motor=logs["motor"], seconds=4)
    assert plan is None or (plan["why"] and plan["programme"])


def test_the_types_are_complete_and_those_of_the_native_part_are_its_own(tmp_path):
    strict = ["mypy", "--strict", "--ignore-missing-imports", "--cache-dir", os.devnull, "--package", "motorlens"]
    for words in [strict, ["mypy.stubtest", "motorlens._native"]]:
        checked = subprocess.run([sys.executable, "-m", *words], capture_output=True, text=True, cwd=tmp_path)
        assert checked.returncode == 0, checked.stdout + checked.stderr


def test_every_public_name_has_a_description():
    for name in motorlens.__all__:
        thing = getattr(motorlens, name)
        assert name == "__version__" or (thing.__doc__ and not thing.__doc__.startswith(f"{name}(")), name
