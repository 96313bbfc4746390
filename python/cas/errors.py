# SPDX-License-Identifier: BSD-3-Clause
"""The errors, as exceptions. Each message names the remedy."""

from __future__ import annotations

from typing import Any, Optional


class CasError(Exception):
    """All exceptions of this package."""


class NotRunning(CasError):
    """No program listens at the expected address; the message names the program to start."""


class ConnectionLost(CasError):
    """The other end has gone while it was needed."""


class CallTimeout(CasError):
    """No answer came in time."""


class ProgramMissing(CasError):
    """A program of CAS is not installed, or not where CAS_BIN says."""


class ProgramEnded(CasError):
    """A program of a bench did not start, or ended by itself; the message has its last lines."""


class FormatError(CasError):
    """A file has wrong content."""


class CallError(CasError):
    """A call that was answered with an error (docs/develop/protocol.md, Errors).

    `code` is its number, `data` what a program may decide on: `status_texts`, `result`, `result_code`,
    `parameters`.
    """

    def __init__(self, method: str, code: int, message: str, data: Any = None) -> None:
        super().__init__(f"{method}: {message}")
        self.method = method
        self.code = code
        self.data: Any = data if data is not None else {}


class WrongCall(CallError):
    """No such method, or wrong parameters."""


class Refused(CallError):
    """The vehicle, or casd, refused; `data["status_texts"]` has the vehicle's own words."""


class NoAcknowledgement(CallError):
    """The vehicle did not acknowledge after all tries."""


class NoSuchVehicle(CallError):
    """No such vehicle has been heard (yet)."""


class NotAuthorised(CallError):
    """Over TCP the token is needed: Casd(address, token=...), or the Unix socket."""


class Interlock(CallError):
    """The vehicle does not say that it is in HIL, or two autopilots use its system id."""


_BY_CODE: dict[int, type[CallError]] = {
    -32601: WrongCall,
    -32602: WrongCall,
    -32000: Refused,
    -32001: NoAcknowledgement,
    -32002: NoSuchVehicle,
    -32003: NotAuthorised,
    -32004: Interlock,
}


def call_error(method: str, error: Any) -> CallError:
    """The exception of an `error` object of JSON-RPC."""
    code = int(error.get("code", 0))
    return _BY_CODE.get(code, CallError)(method, code, str(error.get("message", "")), error.get("data"))


class RunError(CasError):
    """`hils` did not end with 0. `exit_code` is its code, -9 if signal 9 ended it, `output` its output, `run` the run's folder as
    read, if it left results."""

    def __init__(self, message: str, exit_code: int, output: str, run: Optional[Any] = None) -> None:
        super().__init__(message)
        self.exit_code = exit_code
        self.output = output
        self.run = run


class LimitMissed(RunError):
    """Exit code 1: the run is valid, and a limit was missed or the flight not completed."""


class WrongUse(RunError):
    """Exit code 2: the scenario, a file that it names, or an option is wrong."""


class NoVerdict(RunError):
    """Exit code 3: the machine was too busy, or a program was not ready in time or ended early."""


class Interrupted(RunError):
    """Exit code 130, or ended by SIGINT."""


RUN_ERRORS: dict[int, type[RunError]] = {1: LimitMissed, 2: WrongUse, 3: NoVerdict, 130: Interrupted}


class NotReached(CasError):
    """An awaited state has not come in the simulated time allowed."""
