# SPDX-License-Identifier: BSD-3-Clause
"""The command port of casd (docs/develop/protocol.md)."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Mapping, Optional

from .casd_calls import (AsyncCasdCalls, AsyncGainCalls, AsyncLinkCalls, AsyncLogCalls, AsyncMessageCalls,
                         AsyncParamCalls, AsyncTopics, AsyncVehicleCalls, CasdCalls, GainCalls, LinkCalls, LogCalls,
                         MessageCalls, ParamCalls, Topics, VehicleCalls)
from .places import the_casd, token_of
from .rpc import Address, AsyncClient, AsyncSubscription, Client, Subscription, is_unix, refuse_stranger

START = ("start casd with `casd topologies/bench_pty.yaml`, the service with `systemctl start casd`, or a whole bench "
         "with `with cas.Bench() as bench:`")

#: Longest that a call may take, s; a vehicle that reports progress makes a command last.
PATIENCE_S = 30.0
_PATIENCE_OF = {"param.list": 1200.0}


def _token(address: Address, token: Optional[str]) -> Optional[str]:
    if token is not None or is_unix(address):
        return token
    found = token_of()
    if found is None:
        refuse_stranger(address)  # nothing can be proved
    return found


class Casd(CasdCalls):
    """A connection to casd, blocking; calls may come from several threads.

        with cas.Casd() as casd:
            casd.vehicle.arm()
            casd.vehicle.takeoff(2.5)
            for text in casd.topics.statustext():
                print(text["text"])

    Without an address it finds the one casd that runs on this machine. `address` is the path of a Unix
    socket or HOST:PORT; over TCP the token of this user's runtime folder is taken, or `token`. Names have
    their units; positions are in the vehicle's local frame N: x north, y east, z down. What changes the
    vehicle returns when the vehicle has acknowledged; Refused, NoAcknowledgement, NoSuchVehicle and
    Interlock say why it has not.
    """

    def __init__(self, address: Optional[Address] = None, *, token: Optional[str] = None, prove: bool = True,
                 timeout_s: float = PATIENCE_S) -> None:
        where: Address = the_casd() if address is None else address
        self.client = Client(where, token=_token(where, token), prove=prove, timeout_s=timeout_s, start=START)
        super().__init__(self._call_any)
        self.link = LinkCalls(self._call_any)
        self.message = MessageCalls(self._call_any)
        self.vehicle = VehicleCalls(self._call_any)
        self.gain = GainCalls(self._call_any)
        self.param = ParamCalls(self._call_any)
        self.log = LogCalls(self._call_any)
        self.topics = Topics(self.subscribe)

    def _call_any(self, method: str, params: Mapping[str, Any]) -> Any:
        return self.client.call(method, params, _PATIENCE_OF.get(method))

    def call(self, method: str, params: Optional[Mapping[str, Any]] = None,
             timeout_s: Optional[float] = None) -> Any:
        """A method by its name, for methods newer than this package."""
        return self.client.call(method, params, timeout_s)

    def subscribe(self, topic: str) -> Subscription[Any]:
        """A topic by its name; `topics` has them typed."""
        return self.client.subscribe(topic)

    def describe(self) -> dict[str, Any]:
        """The port's own description: an OpenRPC document."""
        return self.client.describe()

    def close(self) -> None:
        """Ends the connection; casd goes on."""
        self.client.close()

    def __enter__(self) -> "Casd":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class AsyncCasd(AsyncCasdCalls):
    """As Casd, for asyncio: `async with await cas.AsyncCasd.connect() as casd: await casd.vehicle.arm()`."""

    def __init__(self, client: AsyncClient) -> None:
        self.client = client
        super().__init__(self._call_any)
        self.link = AsyncLinkCalls(self._call_any)
        self.message = AsyncMessageCalls(self._call_any)
        self.vehicle = AsyncVehicleCalls(self._call_any)
        self.gain = AsyncGainCalls(self._call_any)
        self.param = AsyncParamCalls(self._call_any)
        self.log = AsyncLogCalls(self._call_any)
        self.topics = AsyncTopics(self.subscribe)

    @classmethod
    async def connect(cls, address: Optional[Address] = None, *, token: Optional[str] = None,
                      timeout_s: float = PATIENCE_S) -> "AsyncCasd":
        """Connects; the arguments are those of Casd."""
        where: Address = Path(the_casd()) if address is None else address
        client = await AsyncClient.connect(where, token=_token(where, token), timeout_s=timeout_s, start=START)
        return cls(client)

    async def _call_any(self, method: str, params: Mapping[str, Any]) -> Any:
        return await self.client.call(method, params, _PATIENCE_OF.get(method))

    async def subscribe(self, topic: str) -> AsyncSubscription[Any]:
        """A topic by its name; `topics` has them typed."""
        return await self.client.subscribe(topic)

    async def close(self) -> None:
        """Ends the connection; casd goes on."""
        await self.client.close()

    async def __aenter__(self) -> "AsyncCasd":
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()
