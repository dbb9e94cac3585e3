"""What users see while a call lasts and of its answer: progress, Ctrl-C, notebooks."""

import contextlib
import io
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



def test_answers_show_themselves_in_a_notebook(logs, found):
    page = found._repr_html_()
    assert "coulomb.level" in page and "data:image/png;base64" in page
    compared = motorlens.compare(found.model, logs["held_out"], motor=logs["motor"])
    # Of a controller the tracking, and the steps.
    for answer, shown, pictures in [(compared, "rmse", 1), (found.model.tune(), "overshoot", 2)]:
        page = answer._repr_html_()
        assert shown in page and page.count("data:image/png;base64") == pictures
    fit = motorlens.fit(logs["training"][:1], motor=logs["motor"])
    alike = motorlens.same(logs["training"][:1], logs["training"][:1], logs["motor"], effects="coulomb")
    assert "tau_m" in fit._repr_html_() and "no difference shows: " in alike._repr_html_()


def test_progress_is_a_bar_that_leaves_a_line_for_each_model_and_nothing_else(logs):
    said = io.StringIO()
    with contextlib.redirect_stderr(said):
        motorlens.discover(logs["training"][:2], motor=logs["motor"], progress=True)
    lines = shown(said.getvalue())
    assert lines[0].startswith("base model: rmse") and lines[-1] == "" and all("rmse" in x for x in lines[:-1]), lines
    assert "[##########..........] trying" in said.getvalue(), said.getvalue()


def shown(said):
    # What a terminal shows: a carriage return goes back to the line's first column.
    lines = []
    for line in said.split("\n"):
        left = ""
        for part in line.split("\r"):
            left = part + left[len(part) :]
        lines.append(left.rstrip())
    return lines


def test_adding_an_effect_shows_both_models_and_a_bar_between_them(logs):
    plain = motorlens.fit(logs["training"][:2], motor=logs["motor"]).model
    said, events = io.StringIO(), []
    with contextlib.redirect_stderr(said):
        motorlens.add(plain, "coulomb", logs["training"][:2], motor=logs["motor"], progress=True)
    first, second, rest = shown(said.getvalue())
    assert first.startswith("base model: rmse") and second.startswith("coulomb: rmse") and rest == ""
    assert "[##########..........] trying coulomb" in said.getvalue(), said.getvalue()
    added = motorlens.add(plain, "coulomb", logs["training"][:2], motor=logs["motor"], progress=events.append)
    assert [event.get("effects") for event in events] == [[], None, ["coulomb"]]
    assert events[-1]["rmse"] == pytest.approx(added.document["after"]["train"]["rmse"])


def test_the_share_of_a_call_that_is_done_moves_the_bar(logs):
    from motorlens._progress import watching

    said = io.StringIO()
    with contextlib.redirect_stderr(said), watching(True) as told:
        told('{"share": 0.25}')
    assert "[#####...............] 25% done" in said.getvalue() and said.getvalue().endswith("\r"), said.getvalue()
    first, second, events = logs["training"][:2], logs["training"][2:3], []
    motorlens.same(first, second, motor=logs["motor"], effects="coulomb", progress=events.append)
    # Each set, both, each record of the first, and the halves of the second's only one.
    assert [event["share"] for event in events] == pytest.approx([k / 7 for k in range(1, 8)])


def test_progress_shows_in_a_notebook(logs):
    import nbclient
    import nbformat

    call = f"import motorlens; motorlens.discover([{str(logs['training'][0])!r}], motor={str(logs['motor'])!r});"
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(call)])
    nbclient.NotebookClient(notebook, timeout=300).execute()
    assert "base model: rmse" in "".join(o.get("text", "") for o in notebook.cells[0].outputs)


def test_a_progress_function_sees_the_models_and_stops_the_search_by_raising(logs):
    events = []
    motorlens.discover(logs["training"], motor=logs["motor"], progress=events.append)
    assert {"effects": [], "rmse": pytest.approx(events[0]["rmse"])} == events[0]
    assert any(event.get("trying") == "backlash" for event in events)

    def stop(event):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        motorlens.discover(logs["training"], motor=logs["motor"], progress=stop)


@pytest.mark.parametrize(
    "call",
    ["discover(r, motor=m)", "add(plain, 'backlash', r, motor=m)", "same(r, r, m, effects=['coulomb', 'backlash'])", "plan(r, m)"],
)
def test_ctrl_c_ends_a_search_soon(logs, call):
    records = logs["training"] + logs["repeats"]
    words = ["import motorlens", f"r, m = {[str(path) for path in records]!r}, {str(logs['motor'])!r}"]
    words += ["plain = motorlens.fit(r[:1], motor=m).model", "print('begun', flush=True)"]
    words.append(f"while True: motorlens.{call}")
    child = subprocess.Popen([sys.executable, "-c", "\n".join(words)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    child.stdout.readline()
    time.sleep(0.5)
    child.send_signal(signal.SIGINT)
    asked = time.monotonic()
    _, said = child.communicate(timeout=20)
    assert time.monotonic() - asked < 5
    assert child.returncode != 0 and "KeyboardInterrupt" in said and "panicked" not in said, said


def test_an_export_to_mujoco_is_run_there_and_tells_how_far_it_is(logs, found, tmp_path):
    record, events = [path for path in logs["training"] if "prbs" in path], []
    # How good it is there is asked where the other tools are.
    said = found.model.export(
        "mujoco", tmp_path / "motor.xml", allow_missing=True, on=record, motor=logs["motor"], progress=events.append
    )
    assert events[-1] == {"share": 1.0} and not any("did not run" in line for line in said), said


def test_ctrl_c_ends_mujocos_run_too_and_leaves_no_file(found, tmp_path):
    model, out, made = tmp_path / "model.json", tmp_path / "motor.xml", tmp_path / "made"
    found.model.save(model)
    made.mkdir()
    words = [
        "import motorlens, numpy",
        f"model = motorlens.load_model({str(model)!r})",
        "time = numpy.arange(0.0, 120.0, 0.01)",
        "volts = 6 * numpy.sign(numpy.sin(3 * time))",
        "log = {'time_s': time, 'voltage_v': volts, 'angle_rad': model.simulate(time, volts)}",
        "told = lambda event: print(event, flush=True)",
        f"model.export('mujoco', {str(out)!r}, on=[log], progress=told)",
    ]
    child = subprocess.Popen(
        [sys.executable, "-c", "\n".join(words)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "TMPDIR": str(made)},
    )
    assert "share" in child.stdout.readline(), child.communicate()
    child.send_signal(signal.SIGINT)
    asked = time.monotonic()
    _, said = child.communicate(timeout=20)
    assert time.monotonic() - asked < 5
    assert child.returncode != 0 and "KeyboardInterrupt" in said and "panicked" not in said, said
    assert not any(made.iterdir()) and not out.exists()


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


def test_the_notebook_runs_on_a_real_log():
    import nbclient
    import nbformat

    path = pathlib.Path(__file__).parents[1] / "examples/real_motor.ipynb"
    notebook = nbformat.read(path, as_version=4)
    # Its logs lie beside it.
    where = {"metadata": {"path": str(path.parent)}}
    nbclient.NotebookClient(notebook, timeout=300, resources=where).execute()
    said = "".join(o.get("text", "") for cell in notebook.cells for o in cell.get("outputs", []))
    assert "effects:" in said and "validation rmse" in said
