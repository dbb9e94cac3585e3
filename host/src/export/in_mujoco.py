"""Runs an MJCF that motorlens wrote, and the program beside it where there is one, under a voltage for each step of MuJoCo.

Arguments: the file, and the first angle (rad) and speed (rad/s). Beside it: motor.volts. Writes motor.shown: after each step the reading (rad),
and the speed (rad/s) of the shaft on which the encoder sits. Numbers are 64-bit ones in the machine's order. Prints how many steps are done.
"""

import os
import pathlib
import runpy
import shutil
import sys
import time

try:
    import mujoco
    import numpy
except ImportError as missing:
    sys.exit(f"{sys.executable} has no {missing.name} (pip install 'mujoco>=4' there)")
if int(mujoco.__version__.split(".")[0]) < 4:
    sys.exit(f"MuJoCo {mujoco.__version__} of {sys.executable} has no dcmotor (pip install 'mujoco>=4' there)")

file = pathlib.Path(sys.argv[1])
angle, speed = map(float, sys.argv[2:4])
# Where MuJoCo writes its warnings to.
os.chdir(file.parent)
model = mujoco.MjModel.from_xml_path(str(file))
data = mujoco.MjData(model)
program = file.with_suffix(".py")
motor = runpy.run_path(str(program))["Motor"](model, data) if program.exists() else None
if motor:
    motor.reset(data, angle, speed)
else:
    data.qpos[:], data.qvel[:] = angle, speed
    winding = model.actuator_actadr[0] + model.actuator_actnum[0] - 1
    data.act[winding] = speed * model.numeric("holding_current").data[0]
    if model.actuator_delay[0] > 0.0:
        held = numpy.full((model.actuator_history[0, 0], 1), speed * model.numeric("holding_voltage").data[0])
        mujoco.mj_initCtrlHistory(model, data, 0, None, held)

joint = model.sensor("encoder").objid[0]
place, dof = model.jnt_qposadr[joint], model.jnt_dofadr[joint]
volts = numpy.fromfile(file.with_suffix(".volts"))
shown = numpy.empty((len(volts), 2))
told_s = time.monotonic()
try:
    for step, volt in enumerate(volts.tolist()):
        if motor:
            reading = motor.step(data, volt)
        else:
            data.ctrl[0] = volt
            mujoco.mj_step(model, data)
            reading = data.qpos[place]
        shown[step] = reading, data.qvel[dof]
        if step + 1 == len(volts) or time.monotonic() - told_s > 0.1:
            told_s = time.monotonic()
            print(step + 1, flush=True)
except (BrokenPipeError, KeyboardInterrupt):
    # Whoever asked has gone, and cannot take these files away any more.
    shutil.rmtree(file.parent, ignore_errors=True)
    os._exit(1)
shown.tofile(file.with_suffix(".shown"))
