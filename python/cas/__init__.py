# SPDX-License-Identifier: BSD-3-Clause
"""CAS from Python: hardware-in-the-loop simulation of UAVs, scripted. docs/use/python.md shows how.

    Casd, AsyncCasd     casd's command port
    Sim, AsyncSim       hilsim's control socket
    Bench               simulator, casd and controller for as long as a `with` block lasts
    run, start, compare, sweep, tune
                        `hils`, with its results
    read                a run's folder, .tlog, .ulg, .csv
    mavlink             a small codec
    env                 the simulator by reset and step, in this process (import cas.env)

Units are in the names. Frames are those of docs/use/frames_and_units.md: N is north-east-down, W east-north-up, B
forward-left-up, D forward-right-down.
"""

from . import mavlink, table
from .bench import Bench, Estimate
from .casd import AsyncCasd, Casd
from .errors import (CallError, CallTimeout, CasError, ConnectionLost, FormatError, Interlock, Interrupted,
                     LimitMissed, NoAcknowledgement, NoSuchVehicle, NotAuthorised, NotReached, NotRunning, NoVerdict,
                     ProgramEnded, ProgramMissing, Refused, RunError, WrongCall, WrongUse)
from .places import running_casds
from .results import Comparison, Run, Sweep, Tuning, read
from .rpc import AsyncClient, AsyncSubscription, Client, Subscription
from .hils import Running, compare, run, start, sweep, tune
from .sim import AsyncSim, Pose, Sim
from .table import Table, quantile, read_csv, rms, text_table
from .tlog import Tlog, control_delays, echo_delays, read_tlog
from .ulog import Ulog, read_ulog

__all__ = [
    "AsyncCasd", "AsyncClient", "AsyncSim", "AsyncSubscription", "Bench", "CallError", "CallTimeout", "CasError",
    "Casd", "Client", "Comparison", "ConnectionLost", "Estimate", "FormatError", "Interlock", "Interrupted", "LimitMissed",
    "NoAcknowledgement", "NoSuchVehicle", "NoVerdict", "NotAuthorised", "NotReached", "NotRunning", "Pose",
    "ProgramEnded", "ProgramMissing", "Refused", "Run", "RunError", "Running", "Sim", "Subscription", "Sweep", "Table", "Tlog",
    "Tuning", "Ulog", "WrongCall", "WrongUse", "compare", "control_delays", "echo_delays", "mavlink", "quantile", "read", "read_csv", "read_tlog",
    "read_ulog", "rms", "run", "running_casds", "start", "sweep", "table", "text_table", "tune",
]
__version__ = "0.1.0"
