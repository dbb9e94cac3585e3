"""A joint under Isaac Lab's DC motor, by the equations of its documentation and PhysX's joint friction.

The torque is the command, clipped by the line from stall to the no-load speed; a share of the nominal voltage commands the same line,
shifted. Static friction holds, dynamic and viscous friction act in motion.
"""
import math, pathlib, re, sys, types

module = types.ModuleType("isaaclab.actuators")
module.DCMotorCfg = types.SimpleNamespace
sys.modules.update({"isaaclab": types.ModuleType("isaaclab"), "isaaclab.actuators": module})
text = open(sys.argv[1]).read()
scope = {}
exec(text, scope)
c = scope["MOTOR"]
volts_at = re.search(r"at (\S+) V\.", text).group(1)
nominal = float(volts_at)
late = re.search(r"acts (\S+) s late", text)
delay = float(late.group(1)) if late else 0.0
# What is done below, the file says.
assert f"effort = saturation_effort * (u / {volts_at} - speed / velocity_limit)" in text, text
volts = [float(line) for line in sys.stdin]
# The robot's own: torques of weight (sine, cosine) and hoist, N m.
sine, cosine, hoist = map(float, pathlib.Path(sys.argv[1] + ".robot").read_text().split())
PARTS = 20
dt = 1e-3 / PARTS
x, w, before = map(float, sys.argv[2:5])
for k in range(len(volts)):
    for part in range(PARTS):
        cell = math.floor((k * 1e-3 + (part + 0.5) * dt - delay) * 1e3)
        share = (volts[cell] if cell >= 0 else before) / nominal
        effort = c.saturation_effort * (share - w / c.velocity_limit)
        top = min(c.saturation_effort * (1 - w / c.velocity_limit), c.effort_limit)
        bottom = max(c.saturation_effort * (-1 - w / c.velocity_limit), -c.effort_limit)
        effort = min(max(effort, bottom), top) - sine * math.sin(x) - cosine * math.cos(x) - hoist
        if w == 0.0 and abs(effort) <= c.friction:
            continue
        way = w if w != 0.0 else effort
        rub = math.copysign(c.dynamic_friction, way) + c.viscous_friction * w
        after = w + dt * (effort - rub) / c.armature
        after = 0.0 if after * way < 0.0 else after
        x += dt * (w + after) / 2
        w = after
    print(repr(x))
