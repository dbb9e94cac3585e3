"""What users give: logs, tables, effects of their own, and what is refused."""

import json
import pathlib

import numpy as np
import pytest
from conftest import columns

import motorlens


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


@pytest.mark.parametrize("kind", ["pandas", "polars", "lazy", "arrow", "structured"])
def test_what_else_a_table_has_is_left_alone_and_so_are_rows_without_a_number(logs, kind):
    import pandas
    import polars
    import pyarrow

    frame = pandas.DataFrame(columns(logs["training"][0]))
    whole = motorlens.fit([frame], motor=logs["motor"])
    frame["remark"] = "warm"
    frame["counter"] = range(len(frame))
    frame.loc[7, "angle_rad"] = np.nan
    make = {
        "pandas": lambda table: table,
        "polars": polars.from_pandas,
        "lazy": lambda table: polars.from_pandas(table).lazy(),
        "arrow": pyarrow.Table.from_pandas,
        "structured": lambda table: table.to_records(index=False),
    }[kind]
    with pytest.warns(UserWarning, match="record 1: 1 of .* rows lack a number"):
        fit = motorlens.fit([make(frame)], motor=logs["motor"])
    assert fit.train["samples"] == whole.train["samples"] - 1
    assert fit.train["rmse"] == pytest.approx(whole.train["rmse"], rel=1e-3)


def test_a_log_of_any_layout_is_read_with_the_options_of_the_command_line(logs, tmp_path):
    table = columns(logs["training"][0])
    rows = zip(1000 * table["time_s"], 255 / 12 * table["voltage_v"], np.round(5000 / 2 / np.pi * table["angle_rad"]))
    path = tmp_path / "board.csv"
    path.write_text("millis,pwm,enc\n" + "".join(f"{t:.0f},{u:.3f},{n:.0f}\n" for t, u, n in rows))
    mapping = "time=millis:ms,duty=pwm:255,angle=enc:counts"
    with pytest.raises(motorlens.MotorlensError, match="it looks like"):
        motorlens.read(path)
    (log,) = motorlens.read(path, mapping, supply_volts=12, counts_per_rev=5000, skip=["4.5.."])
    assert log.name.startswith("board") and set(log) == {"time_s", "voltage_v", "angle_rad"}, log
    assert log["time_s"][-1] < 4.5 and np.allclose(log["voltage_v"], table["voltage_v"][: len(log["time_s"])], atol=1e-3)
    fit = motorlens.fit([log], effects="coulomb", motor={"gear_ratio": 104, "encoder_shaft": "output"})
    level = fit.parameters.set_index("name").loc["coulomb.level"]
    assert level.value == pytest.approx(0.3, abs=0.02)


def test_a_servos_log_is_told_by_its_content():
    (log,) = motorlens.read(pathlib.Path(__file__).parents[1] / "examples/data/bam-sts3250/up_and_down.json")
    assert len(log["time_s"]) == 273 and np.abs(log["voltage_v"]).max() <= 12.9, log


def test_an_effect_of_ones_own_and_a_value_that_is_known_are_taken(logs, tmp_path):
    own = tmp_path / "fan.toml"
    lines = ["[[parameter]]", "name = 'drag'", "unit = 'V s/rad'", "low = 0", "typical = 0.01", "high = 1"]
    own.write_text("\n".join(["name = 'fan'", "port = 'torque'", "formula = '-drag * speed'", *lines]))
    fit = motorlens.fit(logs["training"][:1], effects=["fan"], effect_files=[own], motor=logs["motor"])
    assert fit.model.effects == ["fan"] and motorlens.Model.from_dict(fit.model.to_dict()).effects == ["fan"]
    known = {"gear_ratio": 104, "fixed": {"coulomb.level": 0.25}}
    fit = motorlens.fit(logs["training"][:1], effects=["coulomb"], motor=known)
    assert fit.parameters.set_index("name").loc["coulomb.level", "value"] == 0.25


def test_calls_that_simulate_compare_motors_and_list_effects_take_ones_own_too(tmp_path):
    own = tmp_path / "fan.toml"
    lines = ["[[parameter]]", "name = 'drag'", "unit = 'V s/rad'", "low = 0", "typical = 0.1", "high = 1"]
    own.write_text("\n".join(["name = 'fan'", "port = 'torque'", "formula = '-drag * speed'", *lines]))
    names = list(motorlens.effects(effect_files=[own])["name"])
    assert names[-1] == "fan" and names[:-1] == list(motorlens.effects()["name"])
    fan = motorlens.simulate(tmp_path / "fan", effects=["fan=0.3"], effect_files=[own], seconds=4)
    bare = motorlens.simulate(tmp_path / "bare", seconds=4)
    turned = [np.abs(np.diff(columns(made["training"][0])["angle_rad"])).sum() for made in (fan, bare)]
    assert turned[0] < 0.95 * turned[1], "a fan holds the shaft back"
    alike = motorlens.same(
        fan["training"][:1], fan["training"][1:2], fan["motor"], effects=["fan"], effect_files=[own]
    )
    assert alike.effects == ["fan"] and alike.verdict != "different", alike.why


def test_a_plan_weighs_effects_of_ones_own_too(logs, tmp_path):
    own = tmp_path / "lobe.toml"
    lines = ["[[parameter]]", "name = 'size'", "unit = 'V'", "low = -6", "typical = 0.3", "high = 6"]
    own.write_text("\n".join(["name = 'lobe_of_a_plan'", "port = 'torque'", "formula = '-size * sin(3 * angle)'", *lines]))
    events = []
    motorlens.plan(logs["training"][:1], motor=logs["motor"], seconds=4, effect_files=[own], progress=events.append)
    assert "lobe_of_a_plan" in {event.get("trying") for event in events}


def test_effects_that_one_call_is_given_are_unknown_to_the_next(logs, tmp_path):
    own = tmp_path / "lobe.toml"
    lines = ["[[parameter]]", "name = 'size'", "unit = 'V'", "low = -6", "typical = 0.3", "high = 6"]
    own.write_text("\n".join(["name = 'lobe_of_one_call'", "port = 'torque'", "formula = '-size * sin(3 * angle)'", *lines]))

    def trying(effect_files):
        events = []
        found = motorlens.discover(
            logs["training"][:2], motor=logs["motor"], most=1, effect_files=effect_files, progress=events.append
        )
        return {event["trying"] for event in events if "trying" in event}, json.dumps(found.to_dict())

    assert "lobe_of_one_call" in trying([own])[0]
    tried, told = trying([])
    assert "coulomb" in tried and "lobe_of_one_call" not in tried and "lobe_of_one_call" not in told
    plain = motorlens.fit(logs["training"][:1], motor=logs["motor"]).model
    for call in [
        lambda: motorlens.fit(logs["training"][:1], effects=["lobe_of_one_call"], motor=logs["motor"]),
        lambda: motorlens.add(plain, "lobe_of_one_call", logs["training"][:1], motor=logs["motor"]),
        lambda: motorlens.simulate(tmp_path / "s", effects=["lobe_of_one_call=0.5"]),
    ]:
        with pytest.raises(motorlens.MotorlensError, match="lobe_of_one_call"):
            call()
    # Another caller may describe another effect by the same name.
    other = tmp_path / "other.toml"
    other.write_text(own.read_text().replace("typical = 0.3", "typical = 0.4"))
    with pytest.raises(motorlens.MotorlensError, match="(?s)other.toml, line 1.*two different effects"):
        trying([own, other])
    assert "lobe_of_one_call" in trying([other])[0]


def test_what_cannot_be_used_is_refused_with_a_remedy(logs, tmp_path):
    table = columns(logs["training"][0])
    with pytest.raises(motorlens.MotorlensError, match="(?s)no column voltage_v.*do: give"):
        motorlens.discover([{"time_s": table["time_s"]}])
    with pytest.raises(motorlens.MotorlensError, match="(?s)there is no record.*do: "):
        motorlens.discover([])
    with pytest.raises(motorlens.MotorlensError, match="(?s)record 1 is of type ndarray.*do: give a path, or a table"):
        motorlens.discover([np.zeros((10, 3))])
    with pytest.raises(motorlens.MotorlensError, match="(?s)its columns are t, voltage_v.*by these names"):
        motorlens.fit([{"t": table["time_s"], "voltage_v": table["voltage_v"]}])
    with pytest.raises(motorlens.MotorlensError, match="unexpected argument '--nonsense'"):
        motorlens.simulate(tmp_path, nonsense=1)
    with pytest.raises(motorlens.MotorlensError, match="(?s)time does not rise.*do: "):
        motorlens.discover([{name: values[::-1] for name, values in table.items()}])
    with pytest.raises(motorlens.MotorlensError, match="give a list"):
        motorlens.discover(table)
    with pytest.raises(motorlens.MotorlensError, match="did you mean coulomb"):
        motorlens.fit(logs["training"], effects=["coulom"])
    with pytest.raises(motorlens.MotorlensError, match="absent.csv"):
        motorlens.discover([tmp_path / "absent.csv"])
