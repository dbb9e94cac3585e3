"""A URDF in MuJoCo: the joint's friction and damping are MuJoCo's, and the motor is the line from its effort to its velocity.

Its ros2_control block is read as hardware_interface reads it: ROS itself is no package of Python's registry.
"""
import math, pathlib, re, sys
import mujoco
import xml.etree.ElementTree as tree

described = tree.parse(sys.argv[1]).getroot()
limit = next(described.iter("limit"))
dynamics = next(described.iter("dynamics"))
text = open(sys.argv[1]).read()


def controlled(robot):
    """Holds the block to component_parser.cpp and resource_manager.cpp of hardware_interface; its limits are the joint's own."""
    joint = robot.find("joint")
    block = robot.find("ros2_control")
    assert block.get("name") and block.get("type") in ("system", "actuator", "sensor")
    assert block.find("hardware/plugin").text.count("/") == 1
    (own,) = block.findall("joint")
    assert own.get("name") == joint.get("name"), "a joint that the description does not have is refused"
    commands = {c.get("name"): c for c in own.findall("command_interface")}
    states = {s.get("name") for s in own.findall("state_interface")}
    assert set(commands) == {"effort", "velocity"} and states == {"position", "velocity"}
    for name, command in commands.items():
        values = {p.get("name"): float(p.text) for p in command.findall("param")}
        most = float(limit.get(name))
        assert values == {"min": -most, "max": most}, (name, values)


controlled(described)
nominal = float(re.search(r"shaft at (\S+) V;", text).group(1))
armature = float(re.search(r"seen there: (\S+) kg", text).group(1))
stall = float(limit.get("effort"))
# At the no-load speed, damping takes what back-EMF leaves; the file says so.
slope = stall / float(limit.get("velocity")) - float(dynamics.get("damping"))
per_volt, per_speed = map(float, re.search(r"effort = (\S+) \* u - (\S+) \* speed", text).groups())
assert math.isclose(per_volt, stall / nominal, rel_tol=1e-5) and math.isclose(per_speed, slope, rel_tol=1e-5), text
# The robot's own: torques of weight (sine, cosine) and hoist, N m.
sine, cosine, hoist = map(float, pathlib.Path(sys.argv[1] + ".robot").read_text().split())
PARTS = 20
spec = mujoco.MjSpec.from_file(sys.argv[1])
spec.option.timestep = 1e-3 / PARTS
spec.option.gravity = [0, 0, 0]
joint = spec.joints[0]
# As the file's comment says: URDF has no place for it.
joint.armature = armature
# A URDF does not tell how hard friction is.
joint.solref_friction = [2e-3 / PARTS, 1]
joint.solimp_friction = [0.9999, 0.9999, 0.001, 0.5, 2]
body = joint.parent
body.mass, body.inertia, body.explicitinertial = 1e-9, [1e-12] * 3, True
model = spec.compile()
data = mujoco.MjData(model)
data.qpos[0], data.qvel[0] = map(float, sys.argv[2:4])
for line in sys.stdin:
    for _ in range(PARTS):
        x = data.qpos[0]
        load = sine * math.sin(x) + cosine * math.cos(x) + hoist
        data.qfrc_applied[0] = stall * float(line) / nominal - slope * data.qvel[0] - load
        mujoco.mj_step(model, data)
    print(repr(float(data.qpos[0])))
