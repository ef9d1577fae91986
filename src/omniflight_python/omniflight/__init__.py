"""omniflight from Python: recordings, vehicles, effects, plans, simulation, comparison and diagnosis.

SI units and radians; world axes east, north, up; body axes forward, left, up; attitudes are unit quaternions
w, x, y, z (world <- body). What cannot be done raises Error. Arrays of a recording are read-only views: they are not
copied, and keep the recording alive.

    import omniflight as of
    vehicle = of.load_vehicle("omnimorph")
    flight = of.simulate(of.plan("trajectory_2"), vehicle, of.Model([("hung_cable", {"linear_density": 0.3})]))
    print(of.diagnose([flight], vehicle).summary)
"""

import json as _json
import os as _os
import pathlib as _pathlib
import typing as _typing

try:
    import numpy as _numpy  # noqa: F401
except ImportError:
    raise ImportError("omniflight needs numpy and was built for Debian's Python: apt-get install python3-numpy, and run "
                      "/usr/bin/python3") from None

from .errors import Error


def _find_configs():
    """The libraries look above the running program, which here is Python; so look above this package, too."""
    for folder in _pathlib.Path(__file__).resolve().parents:
        if (folder / "configs" / "vehicles").is_dir():
            return str(folder / "configs")
    return None


if "OMNIFLIGHT_CONFIGS" not in _os.environ and (_found := _find_configs()):
    _os.environ["OMNIFLIGHT_CONFIGS"] = _found

from . import _native  # noqa: E402  (the module reads the environment when it is used)
from ._native import (Effect, Model, Note, Parameter, Plan, Plant, Polytope, Recording, Rotor, Signal,  # noqa: E402
                      Trajectory, Vehicle, WrenchSet, canonical_signals, effect, effects, load, load_model, read_plan,
                      vehicle_names)

__all__ = [
    "ComparedRow", "Diagnosis", "Effect", "Error", "Model", "Note", "Parameter", "Plan", "Plant", "Polytope",
    "Recording", "Rotor", "Signal", "Tracking", "Trajectory", "Vehicle", "WrenchSet", "assess", "canonical_signals",
    "check", "compare", "design", "diagnose", "effect", "effects", "frame", "load", "load_model", "load_vehicle",
    "plan", "read_plan", "simulate", "vehicle_names",
]


def _overrides(values):
    return [f"{field}={_json.dumps(value)}" for field, value in (values or {}).items()]


def load_vehicle(spec, overrides=None):
    """A vehicle by its name under configs/vehicles (or name@variant) or the path of its YAML.

    overrides: {field: value} as in {"mass": 1.4} (kg) or {"rotors.drag_ratio": 0.006} (m, of all rotors).
    """
    return _native._load_vehicle(_os.fspath(spec), _overrides(overrides))


def plan(mission, vehicle="", overrides=None, seed=None, budget_s=None):
    """A certified 6D trajectory for a mission, by its name under configs/missions or the path of its YAML.

    vehicle: name or path instead of the mission's; overrides: fields of it, see load_vehicle; seed: instead of the
    mission's; budget_s: time to stay within [s]. Raises Error (incomplete: no path in time; impossible: proven).
    """
    return _native._plan(_os.fspath(mission), _os.fspath(vehicle), _overrides(overrides), seed, budget_s)


def simulate(trajectory, vehicle, model=None, *, sensors="", gains=None, hold_s=2.0, seed=1):
    """Flies a Plan or Trajectory in closed loop in this process and returns the Recording, with the truth beside it.

    model: physics that the controller does not know; sensors: a name under configs/sensors or a path, '' for perfect
    ones; gains: {"kp": (3 numbers), "kv": ..., "ki": ..., "kR": ..., "kw": ..., "kI": ...}; hold_s: time at rest
    before and after [s]. The plant steps at 1 kHz, the controller at 250 Hz; the same seed gives the same bits.
    Raises Error (incomplete) when the vehicle leaves its reference by more than 2 m.
    """
    if isinstance(trajectory, Plan):
        trajectory = trajectory.trajectory
    return _native._simulate(vehicle, trajectory, model if model is not None else Model(), _os.fspath(sensors),
                             dict(gains or {}), hold_s, seed)


class Tracking(_typing.NamedTuple):
    """How a flight followed its reference while that moved."""
    window_s: tuple            # (from, to) [s]
    position_rmse_m: object    # (3,) world x y z [m]
    attitude_rmse_deg: object  # (3,) about body x y z [deg]
    worst_position_m: float    # m
    mean_power_W: float        # W, mechanical; 0 without rotor speeds
    t_s: object                # (n,) [s]
    error: object              # (n, 6) position [m] and attitude [deg]


class ComparedRow(_typing.NamedTuple):
    """One figure of two flights; ratio is real over simulated, 0 where there is none."""
    channel: str
    unit: str
    simulated: float
    real: float
    ratio: float


def assess(recording, vehicle):
    """Tracking of a recording; the vehicle's coefficients give the power. Raises Error without reference or pose."""
    return Tracking(**_native._assess(recording, vehicle))


def compare(simulated, real, vehicle):
    """Two recordings side by side: a list of ComparedRow (RMSE of position [m] and attitude [deg], power [W], ...)."""
    return [ComparedRow(*row) for row in _native._compare(simulated, real, vehicle)]


class Diagnosis:
    """Where a recording and the model differ, and which physics explains it.

    verdict    nothing_missing, explained, ambiguous, unexplained, unusable, checked or unfinished
    summary    a paragraph for a pilot
    findings   list of dicts: effect, probability, sentence, parameters (name, value, unit, interval95), ...
    data       everything, as in diagnosis.json (schema omniflight.diagnosis/1)
    model      Model of what was found, for simulate()
    model_yaml text of model.yaml, for `omniflight fly --effects`
    """

    def __init__(self, native):
        self.verdict, self.summary, self.model = native.verdict, native.summary, native.model
        self.model_yaml = native.model_yaml()
        self.data = _json.loads(native.json())
        self.findings = self.data["findings"]

    def __repr__(self):
        return f"<Diagnosis {self.verdict}: {', '.join(f['effect'] for f in self.findings) or 'no effect'}>"


def diagnose(recordings, vehicle, held_out=(), *, told="", only=(), exclude=(), budget_s=0.0, threads=0):
    """Locates, names and fits what the model of `vehicle` lacks in these recordings.

    held_out: recordings that are only predicted; told: path of a told.yaml; only, exclude: ids of effects;
    budget_s: time [s] after which the answer is 'unfinished' (0: none); threads: of the search (0: as many as there
    are processors, up to 4). Other Python threads go on meanwhile; Ctrl-C ends it.
    """
    return Diagnosis(_native._diagnose(list(recordings), vehicle, list(held_out), _os.fspath(told), list(only),
                                       list(exclude), budget_s, threads))


def check(recordings, vehicle, *, told=""):
    """What these recordings can and cannot tell, in seconds and without a fit: a Diagnosis that is 'checked'."""
    return Diagnosis(_native._check(list(recordings), vehicle, _os.fspath(told)))


def design(vehicle, alphas_rad=(0.0,), f_max_N=0.0, mass_kg=0.0):
    """Feasible force and torque sets over the tilt, as the dict of design.json (tilts there are in degrees).

    f_max_N [N] and mass_kg [kg]: 0 takes the vehicle's.
    """
    return _json.loads(_native._design(vehicle, list(alphas_rad), f_max_N, mass_kg))


def frame(recording, signals=None, t_s=None):
    """A pandas.DataFrame of signals on one time base, a column a component ('position_0' ...; index: s).

    signals: names (default: all); t_s: (n,) times [s] (default: those of the first signal). NaN outside a signal.
    """
    try:
        import pandas
    except ImportError:
        raise Error("bad_input", "a data frame needs pandas, which is not installed", "frame",
                    "Install python3-pandas, or take recording[name].resample(t_s)") from None
    names = list(recording) if signals is None else list(signals)
    if not names:
        return pandas.DataFrame()
    if t_s is None:
        t_s = recording[names[0]].t_s
    columns = {}
    for name in names:
        values = recording[name].resample(t_s)
        for k in range(values.shape[1]):
            columns[name if values.shape[1] == 1 else f"{name}_{k}"] = values[:, k]
    return pandas.DataFrame(columns, index=pandas.Index(t_s, name="t_s"))
