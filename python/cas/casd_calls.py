# SPDX-License-Identifier: BSD-3-Clause
"""The calls of casd, made by generate_calls.py from its `rpc.discover`. Not written by hand."""

from __future__ import annotations

from typing import Any, Awaitable, Dict, List, NotRequired, Optional, Protocol, TypedDict, Union, cast

from .rpc import AsyncSubscription, Subscription


class _Call(Protocol):
    def __call__(self, method: str, params: Dict[str, Any]) -> Any: ...


class _AsyncCall(Protocol):
    def __call__(self, method: str, params: Dict[str, Any]) -> Awaitable[Any]: ...


class _Subscribe(Protocol):
    def __call__(self, topic: str) -> Subscription[Any]: ...


class _AsyncSubscribe(Protocol):
    def __call__(self, topic: str) -> Awaitable[AsyncSubscription[Any]]: ...


def _given(**params: Any) -> Dict[str, Any]:
    """Without what was left out."""
    return {key: value for key, value in params.items() if value is not None}


JournalCall = TypedDict("JournalCall", {
    "at_s": float,  # by casd's clock
    "client": str,
    "method": str,
    "params": Any,  # null where it was longer than 1 KiB
    "refusal": NotRequired[str],
    "times": NotRequired[int],  # so often one after the other; left out: once
    "unix_us": int,  # by that of a recording
    "vehicle": int,  # system id; 0: none
})
Journal = TypedDict("Journal", {
    "calls": List[JournalCall],
    "forgotten": int,  # older ones
})
CasdReloadResult = TypedDict("CasdReloadResult", {
    "reloaded": bool,
})
AutopilotLog = TypedDict("AutopilotLog", {
    "bytes": NotRequired[int],
    "file": NotRequired[str],
    "trouble": NotRequired[str],
    "vehicle": int,  # system id
    "wanted": bool,  # the vehicle is asked for it
})
AutopilotLogs = TypedDict("AutopilotLogs", {
    "folder": str,
    "paused": NotRequired[str],  # why nothing is written
    "paused_s": NotRequired[float],
    "vehicles": List[AutopilotLog],
})
Counts = Dict[str, int]
LinkReceived = TypedDict("LinkReceived", {
    "bytes": int,  # Bytes received.
    "crc_errors": int,  # Packets with a wrong checksum.
    "foreign": int,  # Datagrams from somebody else than the peer.
    "kernel_drops": int,  # Datagrams that the socket's buffer lost.
    "lost": int,  # Gaps in the sequence numbers of senders.
    "no_memory": int,  # Packets that a destination did not get because casd got no memory.
    "not_accepted": int,  # Packets that the link's accept leaves out.
    "packets": int,  # Packets received.
    "signatures": NotRequired[Counts],
    "skipped_bytes": int,  # Bytes that were part of no packet.
    "unknown": int,  # Packets whose message no public dialect has.
    "verdicts": Counts,
})
FutureSignature = TypedDict("FutureSignature", {
    "age_s": float,
    "ahead_s": float,
    "component": int,
    "link_id": int,
    "refused": int,
    "system": int,
})
LinkSigning = TypedDict("LinkSigning", {
    "future": NotRequired[FutureSignature],
    "time_ahead_s": float,
    "time_file": str,
    "too_far_ahead": bool,
})
Quantiles = TypedDict("Quantiles", {
    "max": float,  # us
    "p50": float,  # us
    "p99": float,  # us
})
LinkSent = TypedDict("LinkSent", {
    "bytes": int,  # Bytes sent.
    "dropped": Counts,  # Packets dropped before sending.
    "forwarding_us": Quantiles,
    "packets": int,  # Packets sent.
    "queue_high_water": int,  # Most packets that ever waited.
    "queued": int,  # Packets that wait for the link.
    "refused": int,  # Packets sent to a UDP destination that refused them, as far as the kernel says.
    "write_calls": int,  # System calls that sent.
})
Link = TypedDict("Link", {
    "added": NotRequired[bool],  # true where it was added at run time
    "baud": NotRequired[int],
    "endpoint": str,  # bound address or device, or why it is down
    "group": NotRequired[str],  # of redundant paths
    "name": str,
    "reconnects": int,  # How often the link came back.
    "remote": NotRequired[str],  # where a udp link sends, as the topology has it
    "rx": LinkReceived,
    "signing": NotRequired[LinkSigning],
    "sniffer": NotRequired[bool],  # gets every packet
    "state": str,  # up, down, opening
    "to_not_hil": NotRequired[str],  # all, or stops_only where what may spin or move a vehicle that is not in HIL is held back; absent where the link only listens
    "tx": LinkSent,
    "type": str,  # udp, udp_server, serial, tcp, tcp_server, tlog
    "uncounted": int,  # Packets that casd_messages_total had no room for.
})
Recording = TypedDict("Recording", {
    "active": bool,
    "awaits_arming": bool,
    "bytes": int,
    "file": str,
    "folder": str,
    "left_out": int,  # packets
    "paused": NotRequired[str],
    "paused_s": NotRequired[float],
    "recorded": int,  # packets
})
Reload = TypedDict("Reload", {
    "accepted": bool,
    "age_s": float,
    "reason": NotRequired[str],
})
Self = TypedDict("Self", {
    "component": int,
    "system": int,
})
Rival = TypedDict("Rival", {
    "component": int,
    "heartbeat_age_s": float,
    "link": str,
})
Vehicle = TypedDict("Vehicle", {
    "armed": bool,
    "arming_checks": str,  # pass, fail, unknown
    "autopilot": str,  # PX4, ArduPilot, other
    "complaints": List[str],  # speaks against flying
    "component": int,
    "heartbeat_age_s": float,
    "hil": bool,
    "landed": str,  # undefined, on_ground, in_air, taking_off, landing
    "link": str,
    "mode": str,
    "position_lacks": NotRequired[str],  # what takeoff by position still needs; left out: nothing
    "rival": NotRequired[Rival],
    "silent_after_s": float,  # an older HEARTBEAT means that it is silent
    "state": str,  # MAV_STATE
    "system": int,
    "type": str,
})
DaemonStatus = TypedDict("DaemonStatus", {
    "allow_not_hil": bool,  # as in the topology
    "autopilot_logs": NotRequired[AutopilotLogs],  # left out: none are taken
    "clients": int,
    "links": List[Link],
    "name": NotRequired[str],
    "program": str,
    "recording": NotRequired[Recording],
    "reload": NotRequired[Reload],
    "schema": int,
    "self": Self,
    "threads": str,  # auto, per_link, single, blocking
    "topology": NotRequired[str],
    "uptime_s": float,
    "vehicles": List[Vehicle],
    "version": str,
})
GainsBefore = TypedDict("GainsBefore", {
    "d": NotRequired[Optional[float]],
    "i": NotRequired[Optional[float]],
    "p": NotRequired[Optional[float]],
})
Gains = TypedDict("Gains", {
    "before": NotRequired[GainsBefore],  # of each that was set
    "d": NotRequired[Optional[float]],
    "i": NotRequired[Optional[float]],
    "loop": str,
    "p": NotRequired[Optional[float]],
    "parameters": Dict[str, Optional[float]],
    "vehicle": int,
})
GainLoopParameters = TypedDict("GainLoopParameters", {
    "d": NotRequired[str],
    "i": NotRequired[str],
    "p": NotRequired[str],
})
GainLoop = TypedDict("GainLoop", {
    "loop": str,
    "parameters": GainLoopParameters,
})
GainLoops = TypedDict("GainLoops", {
    "loops": List[GainLoop],
    "vehicle": int,
})
LinkAddResult = TypedDict("LinkAddResult", {
    "link": str,  # its name
})
DroppedMessage = TypedDict("DroppedMessage", {
    "age_s": float,
    "cause": str,
    "component": int,
    "count": int,
    "hz": float,
    "id": int,
    "link": str,
    "name": str,
    "system": int,
})
Unreadable = TypedDict("Unreadable", {
    "cause": str,  # crc, kernel, foreign, not_accepted, no_memory
    "count": int,
    "link": str,
})
Drops = TypedDict("Drops", {
    "dropped": List[DroppedMessage],
    "unreadable": List[Unreadable],
})
Echo = TypedDict("Echo", {
    "count": int,
    "max": float,  # us
    "p50": float,  # us
    "p99": float,  # us
    "unmatched": int,
    "vehicle": int,
})
RouteLatency = TypedDict("RouteLatency", {
    "count": int,
    "from": str,
    "max": float,  # us
    "p50": float,  # us
    "p99": float,  # us
})
LinkLatency = TypedDict("LinkLatency", {
    "link": str,
    "max": float,  # us
    "p50": float,  # us
    "p99": float,  # us
    "routes": List[RouteLatency],
})
LinkRemoveResult = TypedDict("LinkRemoveResult", {
    "link": str,
})
RateLimit = TypedDict("RateLimit", {
    "every": NotRequired[int],
    "max_hz": NotRequired[float],
    "message": Union[str, int],
})
Route = TypedDict("Route", {
    "allow": NotRequired[List[Union[str, int]]],
    "allow_components": NotRequired[List[int]],
    "allow_systems": NotRequired[List[int]],
    "block": NotRequired[List[Union[str, int]]],
    "block_components": NotRequired[List[int]],
    "block_systems": NotRequired[List[int]],
    "from": str,
    "rates": NotRequired[List[RateLimit]],
    "to": str,
})
LogStatus = TypedDict("LogStatus", {
    "active": bool,
    "awaits_arming": bool,
    "bytes": int,
    "ended": NotRequired[str],  # file of the recording that the call has ended
    "file": str,
    "folder": str,
    "left_out": int,  # packets
    "paused": NotRequired[str],
    "paused_s": NotRequired[float],
    "recorded": int,  # packets
})
MessageCount = TypedDict("MessageCount", {
    "age_s": float,
    "component": int,
    "count": int,
    "direction": str,  # rx, tx or drop.CAUSE
    "hz": float,  # over the last seconds
    "id": int,
    "link": str,
    "name": str,
    "system": int,
})
MessageField = TypedDict("MessageField", {
    "name": str,
    "units": NotRequired[str],
    "value": Any,
})
MessageFields = List[MessageField]
MessageValue = TypedDict("MessageValue", {
    "age_s": NotRequired[float],
    "count": NotRequired[int],  # packets since the look began
    "fields": Optional[MessageFields],  # in the order of the dialect
    "id": int,
    "name": str,
})
Parameter = TypedDict("Parameter", {
    "before": NotRequired[Optional[float]],  # of one that was set
    "name": str,
    "type": str,  # UINT8 to REAL32
    "value": Optional[float],
    "vehicle": int,
})
ListedParameter = TypedDict("ListedParameter", {
    "name": str,
    "type": str,
    "value": Optional[float],
})
Parameters = TypedDict("Parameters", {
    "parameters": List[ListedParameter],
    "vehicle": int,
})
Acknowledgement = TypedDict("Acknowledgement", {
    "at_s": NotRequired[float],  # moment of the answer by casd's clock
    "result": str,  # ACCEPTED, or SENT where nothing acknowledges
    "vehicle": int,  # system id
})
Attitude = TypedDict("Attitude", {
    "age_s": float,
    "p_rad_s": float,
    "pitch_rad": float,
    "q_rad_s": float,
    "r_rad_s": float,
    "roll_rad": float,
    "yaw_rad": float,
})
GlobalPosition = TypedDict("GlobalPosition", {
    "age_s": float,
    "alt_m": float,  # above mean sea level
    "lat_deg": float,
    "lon_deg": float,
    "relative_alt_m": NotRequired[float],  # above home; left out: HIGH_LATENCY2 alone tells of it, and its home is unknown
})
Home = TypedDict("Home", {
    "alt_m": float,  # above mean sea level
    "lat_deg": float,
    "lon_deg": float,
    "x_m": float,  # north in N
    "y_m": float,  # east in N
    "z_m": float,  # down in N
})
Intervention = TypedDict("Intervention", {
    "age_s": float,  # of the newest
    "by": str,  # system/component
    "disarms": bool,  # or may do so
    "link": str,
    "times": int,
    "what": str,  # command 400 (disarm)
})
Interventions = List[Intervention]
PositionN = TypedDict("PositionN", {
    "age_s": float,
    "vx_m_s": float,
    "vy_m_s": float,
    "vz_m_s": float,
    "x_m": float,  # north
    "y_m": float,  # east
    "z_m": float,  # down
})
StatusText = TypedDict("StatusText", {
    "age_s": float,
    "severity": str,  # emergency to debug
    "text": str,
})
VehicleState = TypedDict("VehicleState", {
    "altitude_age_s": NotRequired[float],
    "altitude_m": NotRequired[float],  # above home
    "armed": bool,
    "arming_checks": str,
    "at_s": float,  # by casd's clock
    "attitude": NotRequired[Attitude],
    "autopilot": str,
    "complaints": List[str],
    "component": int,
    "firmware": NotRequired[str],  # its version
    "global": NotRequired[GlobalPosition],
    "heartbeat_age_s": float,
    "hil": bool,
    "home": NotRequired[Home],
    "interventions": NotRequired[Interventions],  # what others than casd had it do, in the order in which each kind first came; left out: nothing
    "landed": str,
    "landed_age_s": NotRequired[float],
    "link": str,
    "mode": str,
    "position_N": NotRequired[PositionN],
    "position_lacks": NotRequired[str],  # what takeoff by position still needs; left out: nothing
    "rival": NotRequired[Rival],
    "silent_after_s": float,
    "state": str,
    "statustexts": List[StatusText],
    "system": int,
    "type": str,
    "vtol": NotRequired[str],  # multicopter, to_plane, plane, to_multicopter; left out: it is no VTOL
})
TelemetryAttitude = TypedDict("TelemetryAttitude", {
    "age_s": Optional[float],
    "pitch_deg": Optional[float],
    "roll_deg": Optional[float],
    "yaw_deg": Optional[float],
})
TelemetryBattery = TypedDict("TelemetryBattery", {
    "age_s": Optional[float],
    "current_a": Optional[float],
    "remaining_percent": Optional[float],
    "voltage_v": Optional[float],
})
TelemetryEstimator = TypedDict("TelemetryEstimator", {
    "accel_error": Optional[bool],
    "age_s": Optional[float],
    "attitude_ok": Optional[bool],
    "gps_glitch": Optional[bool],
    "height_ok": Optional[bool],
    "height_ratio": Optional[float],
    "horizontal_accuracy_m": Optional[float],
    "horizontal_position_ok": Optional[bool],
    "horizontal_position_ratio": Optional[float],
    "horizontal_velocity_ok": Optional[bool],
    "mag_ratio": Optional[float],
    "velocity_ratio": Optional[float],
    "vertical_accuracy_m": Optional[float],
    "vertical_velocity_ok": Optional[bool],
})
TelemetryGlobal = TypedDict("TelemetryGlobal", {
    "age_s": Optional[float],
    "alt_m": Optional[float],  # above mean sea level
    "heading_deg": Optional[float],
    "lat_deg": Optional[float],
    "lon_deg": Optional[float],
    "relative_alt_m": Optional[float],  # above home
})
TelemetryGps = TypedDict("TelemetryGps", {
    "age_s": Optional[float],
    "alt_m": Optional[float],
    "course_deg": Optional[float],
    "fix": Optional[str],
    "hdop": Optional[float],
    "horizontal_accuracy_m": Optional[float],
    "lat_deg": Optional[float],
    "lon_deg": Optional[float],
    "satellites": Optional[int],
    "speed_m_s": Optional[float],
    "vdop": Optional[float],
    "vertical_accuracy_m": Optional[float],
})
TelemetryPosition = TypedDict("TelemetryPosition", {
    "age_s": Optional[float],
    "down_m": Optional[float],
    "east_m": Optional[float],
    "north_m": Optional[float],
})
TelemetryRates = TypedDict("TelemetryRates", {
    "age_s": Optional[float],
    "pitch_deg_s": Optional[float],
    "roll_deg_s": Optional[float],
    "yaw_deg_s": Optional[float],
})
TelemetryRotors = TypedDict("TelemetryRotors", {
    "age_s": Optional[float],
    "output1_us": Optional[float],
    "output2_us": Optional[float],
    "output3_us": Optional[float],
    "output4_us": Optional[float],
    "output5_us": Optional[float],
    "output6_us": Optional[float],
    "output7_us": Optional[float],
    "output8_us": Optional[float],
})
TelemetryState = TypedDict("TelemetryState", {
    "age_s": Optional[float],
    "armed": Optional[bool],
    "landed": Optional[str],
    "mode": Optional[str],
    "system_state": Optional[str],
})
TelemetryVelocity = TypedDict("TelemetryVelocity", {
    "age_s": Optional[float],
    "down_m_s": Optional[float],
    "east_m_s": Optional[float],
    "north_m_s": Optional[float],
})
Telemetry = TypedDict("Telemetry", {
    "attitude": TelemetryAttitude,
    "battery": TelemetryBattery,
    "estimator": TelemetryEstimator,
    "global": TelemetryGlobal,
    "gps": TelemetryGps,
    "position": TelemetryPosition,
    "rates": TelemetryRates,
    "rotors": TelemetryRotors,
    "state": TelemetryState,
    "vehicle": int,
    "velocity": TelemetryVelocity,
})
LinksNotice = TypedDict("LinksNotice", {
    "endpoint": str,
    "link": str,
    "reconnects": int,
    "state": str,
})
ParametersNotice = TypedDict("ParametersNotice", {
    "count": int,
    "received": int,
    "vehicle": int,
})
StatustextNotice = TypedDict("StatustextNotice", {
    "severity": str,  # emergency to debug
    "text": str,
    "vehicle": int,
})

class CasdCalls:
    """casd.*"""

    def __init__(self, call: _Call) -> None:
        self._call = call

    def journal(self) -> Journal:
        """The newest calls of the audit about vehicles and links, the oldest first."""
        return cast(Journal, self._call("casd.journal", _given()))

    def reload(self) -> CasdReloadResult:
        """Reads the topology again."""
        return cast(CasdReloadResult, self._call("casd.reload", _given()))

    def status(self) -> DaemonStatus:
        """Everything at a glance."""
        return cast(DaemonStatus, self._call("casd.status", _given()))


class GainCalls:
    """gain.*"""

    def __init__(self, call: _Call) -> None:
        self._call = call

    def get(self, loop: str, *, vehicle: Optional[int] = None) -> Gains:
        """The gains of a loop in force.

        vehicle: system id
        """
        return cast(Gains, self._call("gain.get", _given(loop=loop, vehicle=vehicle)))

    def list(self, *, vehicle: Optional[int] = None) -> GainLoops:
        """The loops of this vehicle's autopilot.

        vehicle: system id
        """
        return cast(GainLoops, self._call("gain.list", _given(vehicle=vehicle)))

    def set(
        self,
        loop: str,
        *,
        vehicle: Optional[int] = None,
        p: Optional[float] = None,
        i: Optional[float] = None,
        d: Optional[float] = None,
        not_hil: Optional[bool] = None,
    ) -> Gains:
        """Sets gains of a control loop, one at least; those left out stay.

        loop: rollrate, velocity, ...
        vehicle: system id
        not_hil: also of one that does not say that it is in HIL. REAL PROPELLERS MAY SPIN
        """
        return cast(Gains, self._call("gain.set", _given(loop=loop, vehicle=vehicle, p=p, i=i, d=d, not_hil=not_hil)))


class LinkCalls:
    """link.*"""

    def __init__(self, call: _Call) -> None:
        self._call = call

    def add(self, entry: Dict[str, Any], *, routes: Optional[List[Dict[str, Any]]] = None) -> LinkAddResult:
        """Opens one more link, until it is removed or the topology is read again."""
        return cast(LinkAddResult, self._call("link.add", _given(entry=entry, routes=routes)))

    def drops(
        self,
        *,
        link: Optional[str] = None,
        limit: Optional[int] = None,
        offset: Optional[int] = None,
    ) -> Drops:
        """Why packets did not go on.

        link: that one alone
        limit: rows of the answer; left out: 5000
        offset: rows before it
        """
        return cast(Drops, self._call("link.drops", _given(link=link, limit=limit, offset=offset)))

    def echo(self) -> List[Echo]:
        """From a HIL_SENSOR in to the controls that echo its stamp, by vehicle, in us."""
        return cast(List[Echo], self._call("link.echo", _given()))

    def latency(self) -> List[LinkLatency]:
        """Forwarding times by sending link, in us."""
        return cast(List[LinkLatency], self._call("link.latency", _given()))

    def list(self) -> List[Link]:
        """State and counters of each link."""
        return cast(List[Link], self._call("link.list", _given()))

    def remove(self, link: str, *, force: Optional[bool] = None) -> LinkRemoveResult:
        """Closes a link.

        force: also the only link of an armed vehicle
        """
        return cast(LinkRemoveResult, self._call("link.remove", _given(link=link, force=force)))

    def routes(self) -> List[Route]:
        """The rules in force."""
        return cast(List[Route], self._call("link.routes", _given()))


class LogCalls:
    """log.*"""

    def __init__(self, call: _Call) -> None:
        self._call = call

    def start(
        self,
        *,
        file: Optional[str] = None,
        rotate_mib: Optional[float] = None,
        rotate_minutes: Optional[float] = None,
        keep: Optional[int] = None,
    ) -> LogStatus:
        """Records every packet that passes into a new .tlog file.

        file: a name, no path
        rotate_mib: MiB, 0 is off
        rotate_minutes: 0 is off
        keep: files that stay, 0 is all
        """
        return cast(LogStatus, self._call("log.start", _given(file=file, rotate_mib=rotate_mib, rotate_minutes=rotate_minutes, keep=keep)))

    def status(self) -> LogStatus:
        """The recording."""
        return cast(LogStatus, self._call("log.status", _given()))

    def stop(self) -> LogStatus:
        """Ends the recording."""
        return cast(LogStatus, self._call("log.stop", _given()))


class MessageCalls:
    """message.*"""

    def __init__(self, call: _Call) -> None:
        self._call = call

    def list(
        self,
        *,
        link: Optional[str] = None,
        limit: Optional[int] = None,
        offset: Optional[int] = None,
    ) -> List[MessageCount]:
        """Each message of each sender, in the order in which they were first heard.

        link: that one alone
        limit: rows of the answer; left out: 5000
        offset: rows before it
        """
        return cast(List[MessageCount], self._call("message.list", _given(link=link, limit=limit, offset=offset)))

    def value(self, link: str, message: Union[str, int], system: int, component: int) -> MessageValue:
        """The newest packet of one message of one sender on one link, decoded.

        message: name or id
        """
        return cast(MessageValue, self._call("message.value", _given(link=link, message=message, system=system, component=component)))


class ParamCalls:
    """param.*"""

    def __init__(self, call: _Call) -> None:
        self._call = call

    def get(self, name: str, *, vehicle: Optional[int] = None) -> Parameter:
        """One parameter.

        vehicle: system id
        """
        return cast(Parameter, self._call("param.get", _given(name=name, vehicle=vehicle)))

    def list(self, *, vehicle: Optional[int] = None) -> Parameters:
        """All parameters: takes as long as new ones come.

        vehicle: system id
        """
        return cast(Parameters, self._call("param.list", _given(vehicle=vehicle)))

    def set(
        self,
        name: str,
        value: float,
        *,
        vehicle: Optional[int] = None,
        not_hil: Optional[bool] = None,
    ) -> Parameter:
        """Changes a parameter; answered with the value in force.

        vehicle: system id
        not_hil: also one that arms or drives outputs, of a vehicle that does not say that it is in
            HIL. REAL PROPELLERS MAY SPIN
        """
        return cast(Parameter, self._call("param.set", _given(name=name, value=value, vehicle=vehicle, not_hil=not_hil)))


class VehicleCalls:
    """vehicle.*"""

    def __init__(self, call: _Call) -> None:
        self._call = call

    def arm(
        self,
        *,
        vehicle: Optional[int] = None,
        force: Optional[bool] = None,
        not_hil: Optional[bool] = None,
    ) -> Acknowledgement:
        """Arms; answered when the vehicle has acknowledged.

        vehicle: system id
        force: without the vehicle's own checks
        not_hil: also one that does not say that it is in HIL. REAL PROPELLERS MAY SPIN
        """
        return cast(Acknowledgement, self._call("vehicle.arm", _given(vehicle=vehicle, force=force, not_hil=not_hil)))

    def command(
        self,
        command: int,
        *,
        vehicle: Optional[int] = None,
        params: Optional[List[Optional[float]]] = None,
        not_hil: Optional[bool] = None,
    ) -> Acknowledgement:
        """Any MAV_CMD as COMMAND_LONG.

        command: MAV_CMD
        vehicle: system id
        not_hil: also one that does not say that it is in HIL. REAL PROPELLERS MAY SPIN
        """
        return cast(Acknowledgement, self._call("vehicle.command", _given(command=command, vehicle=vehicle, params=params, not_hil=not_hil)))

    def disarm(self, *, vehicle: Optional[int] = None, force: Optional[bool] = None) -> Acknowledgement:
        """Disarms.

        vehicle: system id
        force: in flight, too
        """
        return cast(Acknowledgement, self._call("vehicle.disarm", _given(vehicle=vehicle, force=force)))

    def goto(
        self,
        north_m: float,
        east_m: float,
        down_m: float,
        *,
        vehicle: Optional[int] = None,
        yaw_deg: Optional[float] = None,
        radius_m: Optional[float] = None,
        not_hil: Optional[bool] = None,
    ) -> Acknowledgement:
        """Goes to a position in the local frame N.

        vehicle: system id
        yaw_deg: heading from north, clockwise; left out: it stays
        radius_m: of the circle about it, for a vehicle that flies on its wing; below 0 counter-
            clockwise
        not_hil: also one that does not say that it is in HIL. A REAL VEHICLE MAY MOVE
        """
        return cast(Acknowledgement, self._call("vehicle.goto", _given(north_m=north_m, east_m=east_m, down_m=down_m, vehicle=vehicle, yaw_deg=yaw_deg, radius_m=radius_m, not_hil=not_hil)))

    def hold(self, *, vehicle: Optional[int] = None) -> Acknowledgement:
        """Stays where it is.

        vehicle: system id
        """
        return cast(Acknowledgement, self._call("vehicle.hold", _given(vehicle=vehicle)))

    def land(self, *, vehicle: Optional[int] = None) -> Acknowledgement:
        """Lands where it is.

        vehicle: system id
        """
        return cast(Acknowledgement, self._call("vehicle.land", _given(vehicle=vehicle)))

    def manual_control(
        self,
        *,
        vehicle: Optional[int] = None,
        pitch: Optional[float] = None,
        roll: Optional[float] = None,
        throttle: Optional[float] = None,
        yaw: Optional[float] = None,
        buttons: Optional[int] = None,
        not_hil: Optional[bool] = None,
    ) -> Acknowledgement:
        """Stick positions, once; repeat them at 10 Hz or more.

        vehicle: system id
        pitch: -1 to 1, forward
        roll: -1 to 1, right
        throttle: 0 to 1
        yaw: -1 to 1, clockwise
        buttons: bits
        not_hil: also one that does not say that it is in HIL. REAL PROPELLERS MAY SPIN
        """
        return cast(Acknowledgement, self._call("vehicle.manual_control", _given(vehicle=vehicle, pitch=pitch, roll=roll, throttle=throttle, yaw=yaw, buttons=buttons, not_hil=not_hil)))

    def message_interval(
        self,
        message: Union[str, int],
        *,
        vehicle: Optional[int] = None,
        hz: Optional[float] = None,
    ) -> Acknowledgement:
        """How often the vehicle sends a message.

        message: name or id
        vehicle: system id
        hz: 0 is off; left out: its default
        """
        return cast(Acknowledgement, self._call("vehicle.message_interval", _given(message=message, vehicle=vehicle, hz=hz)))

    def mode(self, mode: str, *, vehicle: Optional[int] = None, not_hil: Optional[bool] = None) -> Acknowledgement:
        """Changes the autopilot's mode, by its word.

        mode: HOLD, POSCTL, GUIDED, ...
        vehicle: system id
        not_hil: also one that does not say that it is in HIL. A REAL VEHICLE MAY MOVE
        """
        return cast(Acknowledgement, self._call("vehicle.mode", _given(mode=mode, vehicle=vehicle, not_hil=not_hil)))

    def reboot(self, *, vehicle: Optional[int] = None, not_hil: Optional[bool] = None) -> Acknowledgement:
        """Restarts the autopilot.

        vehicle: system id
        not_hil: also one that does not say that it is in HIL. A REAL VEHICLE MAY MOVE
        """
        return cast(Acknowledgement, self._call("vehicle.reboot", _given(vehicle=vehicle, not_hil=not_hil)))

    def rtl(self, *, vehicle: Optional[int] = None) -> Acknowledgement:
        """Returns home and lands.

        vehicle: system id
        """
        return cast(Acknowledgement, self._call("vehicle.rtl", _given(vehicle=vehicle)))

    def state(self, *, vehicle: Optional[int] = None) -> VehicleState:
        """What the vehicle has told about itself.

        vehicle: system id
        """
        return cast(VehicleState, self._call("vehicle.state", _given(vehicle=vehicle)))

    def takeoff(
        self,
        altitude_m: float,
        *,
        vehicle: Optional[int] = None,
        not_hil: Optional[bool] = None,
    ) -> Acknowledgement:
        """Takes off.

        altitude_m: above home, above 0, at most 10 000
        vehicle: system id
        not_hil: also one that does not say that it is in HIL. REAL PROPELLERS MAY SPIN
        """
        return cast(Acknowledgement, self._call("vehicle.takeoff", _given(altitude_m=altitude_m, vehicle=vehicle, not_hil=not_hil)))

    def telemetry(self, *, vehicle: Optional[int] = None) -> Telemetry:
        """What the vehicle measures, by topic; what it has not told is null.

        vehicle: system id
        """
        return cast(Telemetry, self._call("vehicle.telemetry", _given(vehicle=vehicle)))


class AsyncCasdCalls:
    """casd.*"""

    def __init__(self, call: _AsyncCall) -> None:
        self._call = call

    async def journal(self) -> Journal:
        """The newest calls of the audit about vehicles and links, the oldest first."""
        return cast(Journal, await self._call("casd.journal", _given()))

    async def reload(self) -> CasdReloadResult:
        """Reads the topology again."""
        return cast(CasdReloadResult, await self._call("casd.reload", _given()))

    async def status(self) -> DaemonStatus:
        """Everything at a glance."""
        return cast(DaemonStatus, await self._call("casd.status", _given()))


class AsyncGainCalls:
    """gain.*"""

    def __init__(self, call: _AsyncCall) -> None:
        self._call = call

    async def get(self, loop: str, *, vehicle: Optional[int] = None) -> Gains:
        """The gains of a loop in force.

        vehicle: system id
        """
        return cast(Gains, await self._call("gain.get", _given(loop=loop, vehicle=vehicle)))

    async def list(self, *, vehicle: Optional[int] = None) -> GainLoops:
        """The loops of this vehicle's autopilot.

        vehicle: system id
        """
        return cast(GainLoops, await self._call("gain.list", _given(vehicle=vehicle)))

    async def set(
        self,
        loop: str,
        *,
        vehicle: Optional[int] = None,
        p: Optional[float] = None,
        i: Optional[float] = None,
        d: Optional[float] = None,
        not_hil: Optional[bool] = None,
    ) -> Gains:
        """Sets gains of a control loop, one at least; those left out stay.

        loop: rollrate, velocity, ...
        vehicle: system id
        not_hil: also of one that does not say that it is in HIL. REAL PROPELLERS MAY SPIN
        """
        return cast(Gains, await self._call("gain.set", _given(loop=loop, vehicle=vehicle, p=p, i=i, d=d, not_hil=not_hil)))


class AsyncLinkCalls:
    """link.*"""

    def __init__(self, call: _AsyncCall) -> None:
        self._call = call

    async def add(self, entry: Dict[str, Any], *, routes: Optional[List[Dict[str, Any]]] = None) -> LinkAddResult:
        """Opens one more link, until it is removed or the topology is read again."""
        return cast(LinkAddResult, await self._call("link.add", _given(entry=entry, routes=routes)))

    async def drops(
        self,
        *,
        link: Optional[str] = None,
        limit: Optional[int] = None,
        offset: Optional[int] = None,
    ) -> Drops:
        """Why packets did not go on.

        link: that one alone
        limit: rows of the answer; left out: 5000
        offset: rows before it
        """
        return cast(Drops, await self._call("link.drops", _given(link=link, limit=limit, offset=offset)))

    async def echo(self) -> List[Echo]:
        """From a HIL_SENSOR in to the controls that echo its stamp, by vehicle, in us."""
        return cast(List[Echo], await self._call("link.echo", _given()))

    async def latency(self) -> List[LinkLatency]:
        """Forwarding times by sending link, in us."""
        return cast(List[LinkLatency], await self._call("link.latency", _given()))

    async def list(self) -> List[Link]:
        """State and counters of each link."""
        return cast(List[Link], await self._call("link.list", _given()))

    async def remove(self, link: str, *, force: Optional[bool] = None) -> LinkRemoveResult:
        """Closes a link.

        force: also the only link of an armed vehicle
        """
        return cast(LinkRemoveResult, await self._call("link.remove", _given(link=link, force=force)))

    async def routes(self) -> List[Route]:
        """The rules in force."""
        return cast(List[Route], await self._call("link.routes", _given()))


class AsyncLogCalls:
    """log.*"""

    def __init__(self, call: _AsyncCall) -> None:
        self._call = call

    async def start(
        self,
        *,
        file: Optional[str] = None,
        rotate_mib: Optional[float] = None,
        rotate_minutes: Optional[float] = None,
        keep: Optional[int] = None,
    ) -> LogStatus:
        """Records every packet that passes into a new .tlog file.

        file: a name, no path
        rotate_mib: MiB, 0 is off
        rotate_minutes: 0 is off
        keep: files that stay, 0 is all
        """
        return cast(LogStatus, await self._call("log.start", _given(file=file, rotate_mib=rotate_mib, rotate_minutes=rotate_minutes, keep=keep)))

    async def status(self) -> LogStatus:
        """The recording."""
        return cast(LogStatus, await self._call("log.status", _given()))

    async def stop(self) -> LogStatus:
        """Ends the recording."""
        return cast(LogStatus, await self._call("log.stop", _given()))


class AsyncMessageCalls:
    """message.*"""

    def __init__(self, call: _AsyncCall) -> None:
        self._call = call

    async def list(
        self,
        *,
        link: Optional[str] = None,
        limit: Optional[int] = None,
        offset: Optional[int] = None,
    ) -> List[MessageCount]:
        """Each message of each sender, in the order in which they were first heard.

        link: that one alone
        limit: rows of the answer; left out: 5000
        offset: rows before it
        """
        return cast(List[MessageCount], await self._call("message.list", _given(link=link, limit=limit, offset=offset)))

    async def value(self, link: str, message: Union[str, int], system: int, component: int) -> MessageValue:
        """The newest packet of one message of one sender on one link, decoded.

        message: name or id
        """
        return cast(MessageValue, await self._call("message.value", _given(link=link, message=message, system=system, component=component)))


class AsyncParamCalls:
    """param.*"""

    def __init__(self, call: _AsyncCall) -> None:
        self._call = call

    async def get(self, name: str, *, vehicle: Optional[int] = None) -> Parameter:
        """One parameter.

        vehicle: system id
        """
        return cast(Parameter, await self._call("param.get", _given(name=name, vehicle=vehicle)))

    async def list(self, *, vehicle: Optional[int] = None) -> Parameters:
        """All parameters: takes as long as new ones come.

        vehicle: system id
        """
        return cast(Parameters, await self._call("param.list", _given(vehicle=vehicle)))

    async def set(
        self,
        name: str,
        value: float,
        *,
        vehicle: Optional[int] = None,
        not_hil: Optional[bool] = None,
    ) -> Parameter:
        """Changes a parameter; answered with the value in force.

        vehicle: system id
        not_hil: also one that arms or drives outputs, of a vehicle that does not say that it is in
            HIL. REAL PROPELLERS MAY SPIN
        """
        return cast(Parameter, await self._call("param.set", _given(name=name, value=value, vehicle=vehicle, not_hil=not_hil)))


class AsyncVehicleCalls:
    """vehicle.*"""

    def __init__(self, call: _AsyncCall) -> None:
        self._call = call

    async def arm(
        self,
        *,
        vehicle: Optional[int] = None,
        force: Optional[bool] = None,
        not_hil: Optional[bool] = None,
    ) -> Acknowledgement:
        """Arms; answered when the vehicle has acknowledged.

        vehicle: system id
        force: without the vehicle's own checks
        not_hil: also one that does not say that it is in HIL. REAL PROPELLERS MAY SPIN
        """
        return cast(Acknowledgement, await self._call("vehicle.arm", _given(vehicle=vehicle, force=force, not_hil=not_hil)))

    async def command(
        self,
        command: int,
        *,
        vehicle: Optional[int] = None,
        params: Optional[List[Optional[float]]] = None,
        not_hil: Optional[bool] = None,
    ) -> Acknowledgement:
        """Any MAV_CMD as COMMAND_LONG.

        command: MAV_CMD
        vehicle: system id
        not_hil: also one that does not say that it is in HIL. REAL PROPELLERS MAY SPIN
        """
        return cast(Acknowledgement, await self._call("vehicle.command", _given(command=command, vehicle=vehicle, params=params, not_hil=not_hil)))

    async def disarm(self, *, vehicle: Optional[int] = None, force: Optional[bool] = None) -> Acknowledgement:
        """Disarms.

        vehicle: system id
        force: in flight, too
        """
        return cast(Acknowledgement, await self._call("vehicle.disarm", _given(vehicle=vehicle, force=force)))

    async def goto(
        self,
        north_m: float,
        east_m: float,
        down_m: float,
        *,
        vehicle: Optional[int] = None,
        yaw_deg: Optional[float] = None,
        radius_m: Optional[float] = None,
        not_hil: Optional[bool] = None,
    ) -> Acknowledgement:
        """Goes to a position in the local frame N.

        vehicle: system id
        yaw_deg: heading from north, clockwise; left out: it stays
        radius_m: of the circle about it, for a vehicle that flies on its wing; below 0 counter-
            clockwise
        not_hil: also one that does not say that it is in HIL. A REAL VEHICLE MAY MOVE
        """
        return cast(Acknowledgement, await self._call("vehicle.goto", _given(north_m=north_m, east_m=east_m, down_m=down_m, vehicle=vehicle, yaw_deg=yaw_deg, radius_m=radius_m, not_hil=not_hil)))

    async def hold(self, *, vehicle: Optional[int] = None) -> Acknowledgement:
        """Stays where it is.

        vehicle: system id
        """
        return cast(Acknowledgement, await self._call("vehicle.hold", _given(vehicle=vehicle)))

    async def land(self, *, vehicle: Optional[int] = None) -> Acknowledgement:
        """Lands where it is.

        vehicle: system id
        """
        return cast(Acknowledgement, await self._call("vehicle.land", _given(vehicle=vehicle)))

    async def manual_control(
        self,
        *,
        vehicle: Optional[int] = None,
        pitch: Optional[float] = None,
        roll: Optional[float] = None,
        throttle: Optional[float] = None,
        yaw: Optional[float] = None,
        buttons: Optional[int] = None,
        not_hil: Optional[bool] = None,
    ) -> Acknowledgement:
        """Stick positions, once; repeat them at 10 Hz or more.

        vehicle: system id
        pitch: -1 to 1, forward
        roll: -1 to 1, right
        throttle: 0 to 1
        yaw: -1 to 1, clockwise
        buttons: bits
        not_hil: also one that does not say that it is in HIL. REAL PROPELLERS MAY SPIN
        """
        return cast(Acknowledgement, await self._call("vehicle.manual_control", _given(vehicle=vehicle, pitch=pitch, roll=roll, throttle=throttle, yaw=yaw, buttons=buttons, not_hil=not_hil)))

    async def message_interval(
        self,
        message: Union[str, int],
        *,
        vehicle: Optional[int] = None,
        hz: Optional[float] = None,
    ) -> Acknowledgement:
        """How often the vehicle sends a message.

        message: name or id
        vehicle: system id
        hz: 0 is off; left out: its default
        """
        return cast(Acknowledgement, await self._call("vehicle.message_interval", _given(message=message, vehicle=vehicle, hz=hz)))

    async def mode(
        self,
        mode: str,
        *,
        vehicle: Optional[int] = None,
        not_hil: Optional[bool] = None,
    ) -> Acknowledgement:
        """Changes the autopilot's mode, by its word.

        mode: HOLD, POSCTL, GUIDED, ...
        vehicle: system id
        not_hil: also one that does not say that it is in HIL. A REAL VEHICLE MAY MOVE
        """
        return cast(Acknowledgement, await self._call("vehicle.mode", _given(mode=mode, vehicle=vehicle, not_hil=not_hil)))

    async def reboot(self, *, vehicle: Optional[int] = None, not_hil: Optional[bool] = None) -> Acknowledgement:
        """Restarts the autopilot.

        vehicle: system id
        not_hil: also one that does not say that it is in HIL. A REAL VEHICLE MAY MOVE
        """
        return cast(Acknowledgement, await self._call("vehicle.reboot", _given(vehicle=vehicle, not_hil=not_hil)))

    async def rtl(self, *, vehicle: Optional[int] = None) -> Acknowledgement:
        """Returns home and lands.

        vehicle: system id
        """
        return cast(Acknowledgement, await self._call("vehicle.rtl", _given(vehicle=vehicle)))

    async def state(self, *, vehicle: Optional[int] = None) -> VehicleState:
        """What the vehicle has told about itself.

        vehicle: system id
        """
        return cast(VehicleState, await self._call("vehicle.state", _given(vehicle=vehicle)))

    async def takeoff(
        self,
        altitude_m: float,
        *,
        vehicle: Optional[int] = None,
        not_hil: Optional[bool] = None,
    ) -> Acknowledgement:
        """Takes off.

        altitude_m: above home, above 0, at most 10 000
        vehicle: system id
        not_hil: also one that does not say that it is in HIL. REAL PROPELLERS MAY SPIN
        """
        return cast(Acknowledgement, await self._call("vehicle.takeoff", _given(altitude_m=altitude_m, vehicle=vehicle, not_hil=not_hil)))

    async def telemetry(self, *, vehicle: Optional[int] = None) -> Telemetry:
        """What the vehicle measures, by topic; what it has not told is null.

        vehicle: system id
        """
        return cast(Telemetry, await self._call("vehicle.telemetry", _given(vehicle=vehicle)))


class Topics:
    """What may be subscribed to."""

    def __init__(self, subscribe: _Subscribe) -> None:
        self._subscribe = subscribe

    def drops(self) -> Subscription[Drops]:
        """Once a second in which packets were dropped, as link.drops answers, the first 2000."""
        return self._subscribe("drops")

    def links(self) -> Subscription[LinksNotice]:
        """A link changes its state."""
        return self._subscribe("links")

    def messages(self) -> Subscription[List[MessageCount]]:
        """Once a second, as message.list answers, the first 2000."""
        return self._subscribe("messages")

    def parameters(self) -> Subscription[ParametersNotice]:
        """Once a second while param.list is under way; a count of 0 is not known yet."""
        return self._subscribe("parameters")

    def statustext(self) -> Subscription[StatustextNotice]:
        """A vehicle says something."""
        return self._subscribe("statustext")


class AsyncTopics:
    """What may be subscribed to."""

    def __init__(self, subscribe: _AsyncSubscribe) -> None:
        self._subscribe = subscribe

    async def drops(self) -> AsyncSubscription[Drops]:
        """Once a second in which packets were dropped, as link.drops answers, the first 2000."""
        return await self._subscribe("drops")

    async def links(self) -> AsyncSubscription[LinksNotice]:
        """A link changes its state."""
        return await self._subscribe("links")

    async def messages(self) -> AsyncSubscription[List[MessageCount]]:
        """Once a second, as message.list answers, the first 2000."""
        return await self._subscribe("messages")

    async def parameters(self) -> AsyncSubscription[ParametersNotice]:
        """Once a second while param.list is under way; a count of 0 is not known yet."""
        return await self._subscribe("parameters")

    async def statustext(self) -> AsyncSubscription[StatustextNotice]:
        """A vehicle says something."""
        return await self._subscribe("statustext")
