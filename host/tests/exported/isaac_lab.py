"""Isaac Lab's own actuators, of its package, with NumPy in the place of torch.

Its simulator needs a graphics card, and its package brings the sources alone where nothing else is installed with it. What they import and
a motor has no use for is empty here.
"""
import importlib, pathlib, sys, types
import numpy

HOME = pathlib.Path(sys.prefix) / "isaaclab/isaaclab/source/isaaclab/isaaclab"


def stand_in(name, **content):
    module = sys.modules[name] = types.ModuleType(name)
    module.__dict__.update(content)
    return module


stand_in(
    "torch",
    Tensor=numpy.ndarray,
    inf=numpy.inf,
    zeros=lambda *shape, device: numpy.zeros(shape),
    zeros_like=numpy.zeros_like,
    all=numpy.all,
    clip=lambda x, min=None, max=None: numpy.clip(x, min, max),
)
stand_in("omni", log=stand_in("omni.log"))
stand_in("isaaclab", __path__=[str(HOME)])
utils = stand_in("isaaclab.utils", __path__=[str(HOME / "utils")], DelayBuffer=None, LinearInterpolation=None)
stand_in("isaaclab.utils.array", TENSOR_TYPE_CONVERSIONS={}, TENSOR_TYPES={})
stand_in("isaaclab.utils.assets", read_file=None)
utils.configclass = importlib.import_module("isaaclab.utils.configclass").configclass
import isaaclab.actuators
from isaaclab.utils.types import ArticulationActions


def actuator(cfg, joint):
    """The actuator of one joint in one robot that a configuration makes, as an articulation makes it."""
    return cfg.class_type(cfg, [joint], slice(None), num_envs=1, device="cpu")
