# A joint under Isaac Lab's own DC motor, with PhysX's joint friction by its description: static friction holds, dynamic and viscous friction
# act in motion. A command is an effort; what the position's and the velocity's gains add is nothing where the joint is where it is to be.
import math, re

text = open(sys.argv[1]).read()
scope = {}
exec(text, scope)
c = scope["MOTOR"]
motor = actuator(c, c.joint_names_expr[0])
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
armature, holds, rubs, viscous = (
    float(values[0, 0]) for values in (motor.armature, motor.friction, motor.dynamic_friction, motor.viscous_friction)
)
for k in range(len(volts)):
    for part in range(PARTS):
        cell = math.floor((k * 1e-3 + (part + 0.5) * dt - delay) * 1e3)
        share = (volts[cell] if cell >= 0 else before) / nominal
        asked = numpy.array([[c.saturation_effort * (share - w / c.velocity_limit)]])
        place, speed = numpy.array([[x]]), numpy.array([[w]])
        applied = motor.compute(ArticulationActions(place, speed, asked), place, speed).joint_efforts
        effort = float(applied[0, 0]) - sine * math.sin(x) - cosine * math.cos(x) - hoist
        if w == 0.0 and abs(effort) <= holds:
            continue
        way = w if w != 0.0 else effort
        rub = math.copysign(rubs, way) + viscous * w
        after = w + dt * (effort - rub) / armature
        after = 0.0 if after * way < 0.0 else after
        x += dt * (w + after) / 2
        w = after
    print(repr(x))
