"""A motor under WPILib's feedforward, by the acceleration that its own classes give for a voltage."""
import math, re, sys
import wpimath.controller

text = open(sys.argv[1]).read()
scope = {"wpimath": wpimath}
exec(text.split("--- Python (radians)")[1], scope)
f = scope["feedforward"]
arm = re.search(r"the log's less (\S+) rad", text)
late = re.search(r"acts (\S+) ms late", text)
assert late or "delay" not in text.lower(), text
delay = float(late.group(1)) * 1e-3 if late else 0.0
volts = [float(line) for line in sys.stdin]
PARTS = 20
dt = 1e-3 / PARTS


def acceleration(u, x, w):
    """Less friction, which a class takes off by the sign of the speed."""
    return f.maxAchievableAcceleration(u, x - float(arm.group(1)), w) if arm else f.maxAchievableAcceleration(u, w)


x, w, before = map(float, sys.argv[2:5])
for k in range(len(volts)):
    for part in range(PARTS):
        cell = math.floor((k * 1e-3 + (part + 0.5) * dt - delay) * 1e3)
        u = volts[cell] if cell >= 0 else before
        free = acceleration(u, x, 0.0)
        if w == 0.0 and abs(free) * f.getKa() <= f.getKs():
            continue
        way = w if w != 0.0 else math.copysign(1e-12, free)
        after = w + dt * acceleration(u, x, way)
        after = 0.0 if after * way < 0.0 else after
        x += dt * (w + after) / 2
        w = after
    print(repr(x))
