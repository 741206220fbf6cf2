"""Sextant from Python: run a scenario, read a trace or a recording, sweep a scenario's configuration, command a drive.

    import sextant

    run = sextant.run("configs/scenarios/constant_torque.toml", overrides={"duration_s": 0.5})
    print(run.verdict, run.metrics["torque_ripple_pp_nm"])
    run.trace[["torque_reference_nm", "torque_mean_nm"]].plot()

docs/python.md has all of it.
"""

from sextant_py.control_unit import Vcu
from sextant_py.errors import UserError
from sextant_py.inject import inject
from sextant_py.set import get_parameters, set_parameters

from .mil_run import Run, run
from .parameter_sweep import sweep
from .signal_frame import read

__all__ = ["Run", "UserError", "Vcu", "get_parameters", "inject", "read", "run", "set_parameters", "sweep"]
