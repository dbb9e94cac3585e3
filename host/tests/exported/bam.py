"""Parameters in BAM's own simulator, under an actuator of its voltage-controlled kind with nothing on the shaft."""
import json, math, sys
from bam.actuator import VoltageControlledActuator
from bam.actuators import actuators
from bam.model import load_model
from bam.parameter import Parameter
from bam.simulate import Simulator
from bam.testbench import Testbench


class Bare(Testbench):
    def __init__(self, log):
        pass

    def compute_mass(self, q, dq):
        return 0.0

    def compute_bias(self, q, dq):
        return 0.0


class Motor(VoltageControlledActuator):
    def __init__(self):
        super().__init__(Bare, vin=12.0, kp=1.0)

    def initialize(self):
        super().initialize()
        self.model.armature = Parameter(1.0, 0.0, 10.0)

    def get_extra_inertia(self):
        return self.model.armature.value


actuators["motor"] = Motor
model = load_model(sys.argv[1])
model.actuator.testbench = Bare({})
# A rollout of BAM shifts the commands of its log by this.
delay = json.load(open(sys.argv[1]))["command_delay"]
volts = [float(line) for line in sys.stdin]
PARTS = 40
dt = 1e-3 / PARTS
simulator = Simulator(model)
simulator.q, simulator.dq, before = map(float, sys.argv[2:5])
for k in range(len(volts)):
    for part in range(PARTS):
        cell = math.floor((k * 1e-3 + (part + 0.5) * dt - delay) * 1e3)
        simulator.step(volts[cell] if cell >= 0 else before, True, dt)
    print(repr(float(simulator.q)))
