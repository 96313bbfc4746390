# SPDX-License-Identifier: BSD-3-Clause
"""JSON-RPC 2.0, one object a line, over a Unix socket or TCP: blocking and async.

`Client` reads on a thread of its own, so that calls of several threads and subscriptions do not wait for
each other:

    call() --> line --> socket --> server --> reading thread --+--> the call with this id
                                                               +--> subscriptions of this topic
"""

from __future__ import annotations

import asyncio
import hashlib
import hmac
import itertools
import json
import os
import queue
import secrets
import socket
import threading
from pathlib import Path
from typing import Any, AsyncIterator, Callable, Generic, Iterator, Mapping, Optional, TypeVar, Union

from .errors import CallTimeout, ConnectionLost, NotRunning, call_error
from .places import is_own_port

T = TypeVar("T")

Address = Union[str, "os.PathLike[str]"]
"""A path or "unix:PATH" of a Unix socket, or "HOST:PORT"."""

#: Longest that a call waits when nothing else is said, s: casd repeats a command for 3.5 s.
CALL_TIMEOUT_S = 10.0


def is_unix(address: Address) -> bool:
    """Whether `address` names a Unix socket."""
    text = os.fspath(address)
    return isinstance(address, Path) or text.startswith("unix:") or "/" in text


def unix_path(address: Address) -> str:
    """The path of a Unix socket's address."""
    return os.fspath(address).removeprefix("unix:")


def host_and_port(address: Address) -> tuple[str, int]:
    """The parts of HOST:PORT. Raises ValueError."""
    host, colon, port = os.fspath(address).rpartition(":")
    if not colon or not port.isdigit():
        raise ValueError(f"'{os.fspath(address)}' is no address: a path, unix:PATH or HOST:PORT")
    return host.strip("[]"), int(port)


def refuse_stranger(address: Address) -> None:
    """Raises ConnectionLost for a TCP port of this machine whose listener is another user's program: it has not proved
    that it is casd, so it gets no call."""
    host, port = host_and_port(address)
    if (host == "localhost" or host == "::1" or host.startswith("127.")) and not is_own_port(port):
        raise ConnectionLost(f"what listens at {os.fspath(address)} is another user's program and has not proved that it "
                             "is casd: give `token`, or take casd's Unix socket")


def token_proof(token: str, who: str, endpoint: str, client_nonce: str, server_nonce: str) -> str:
    """That one end knows the token, without telling it (docs/develop/protocol.md, Who may call).

    `who` is "server" or "client", `endpoint` the server's end of the connection as it sees it.
    """
    lines = "".join(line + "\n" for line in ("cas", who, endpoint, client_nonce, server_nonce))
    return hmac.new(token.encode(), lines.encode(), hashlib.sha256).hexdigest()


def endpoint_text(peer: tuple[Any, ...]) -> str:
    """ "127.0.0.1:5790" or "[::1]:5790" from the result of getpeername()."""
    host = str(peer[0]).removeprefix("::ffff:")
    return f"[{host}]:{peer[1]}" if ":" in host else f"{host}:{peer[1]}"


def request_line(number: int, method: str, params: Mapping[str, Any]) -> bytes:
    """One request as it goes over the wire."""
    text = json.dumps({"jsonrpc": "2.0", "id": number, "method": method, "params": dict(params)})
    return text.encode() + b"\n"


def _connect_unix(path: str, timeout_s: float) -> socket.socket:
    connection = socket.socket(socket.AF_UNIX)
    try:
        connection.settimeout(timeout_s)
        connection.connect(path)
    except OSError:
        connection.close()
        raise
    return connection


class Subscription(Generic[T]):
    """The notifications of one topic, as an iterator that ends when the connection does.

    Up to 10000 wait for who reads them; what comes beyond is left out and counted in `left_out`.
    Leaving a `with` block, or close(), ends the subscription.
    """

    MOST_WAITING = 10_000

    def __init__(self, topic: str, end: Callable[["Subscription[T]"], None]) -> None:
        self.topic = topic
        self.left_out = 0
        self._end = end
        self._queue: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._closed = False

    def put(self, params: Any) -> None:
        """By the reading thread."""
        if self._queue.qsize() >= self.MOST_WAITING:
            self.left_out += 1
        else:
            self._queue.put((params,))

    def end(self) -> None:
        """By the reading thread: no more will come."""
        self._queue.put(None)

    def next(self, timeout_s: Optional[float] = None) -> T:
        """The next notification. Raises CallTimeout after `timeout_s`, StopIteration at the end."""
        try:
            item = self._queue.get(timeout=timeout_s)
        except queue.Empty:
            raise CallTimeout(f"nothing came on topic '{self.topic}' in {timeout_s:g} s") from None
        if item is None:
            self._queue.put(None)
            raise StopIteration
        value: T = item[0]
        return value

    def __iter__(self) -> Iterator[T]:
        return self

    def __next__(self) -> T:
        return self.next()

    def close(self) -> None:
        """Ends the subscription."""
        if not self._closed:
            self._closed = True
            self._end(self)

    def __enter__(self) -> "Subscription[T]":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class Client:
    """A blocking connection. Calls may come from several threads.

    `token` is needed over TCP where the server asks for one; it is proved, not told, when `prove` is
    true. `start` is the sentence that NotRunning ends with.
    """

    def __init__(self, address: Address, *, token: Optional[str] = None, prove: bool = True,
                 timeout_s: float = CALL_TIMEOUT_S, start: str = "") -> None:
        self.address = os.fspath(address)
        self.timeout_s = timeout_s
        self._numbers = itertools.count(1)
        self._lock = threading.Lock()
        self._sending = threading.Lock()  # a line goes out whole
        self._waiting: dict[int, queue.SimpleQueue[Any]] = {}
        self._subscriptions: dict[str, list[Subscription[Any]]] = {}
        self._lost: Optional[str] = None
        self._socket = self._connect(address, timeout_s, start)
        self._thread = threading.Thread(target=self._read, name="cas-rpc", daemon=True)
        self._thread.start()
        if token is not None and self._socket.family != socket.AF_UNIX:
            try:
                self._authorise(token, prove)
            except BaseException:
                self.close()
                raise

    @staticmethod
    def _connect(address: Address, timeout_s: float, start: str) -> socket.socket:
        try:
            if is_unix(address):
                connection = _connect_unix(unix_path(address), timeout_s)
            else:
                connection = socket.create_connection(host_and_port(address), timeout=timeout_s)
                connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        except OSError as error:
            why = error.strerror or str(error)
            raise NotRunning(f"nothing answers at {os.fspath(address)} ({why}){start and '; ' + start}") from None
        connection.settimeout(None)
        return connection

    def _authorise(self, token: str, prove: bool) -> None:
        if not prove:
            self.call("authorise", {"token": token})
            return
        mine = secrets.token_hex(32)
        answer = self.call("authorise", {"nonce": mine})
        if answer is True:
            refuse_stranger(self.address)  # it asks for no token and proves nothing
            return
        endpoint = endpoint_text(self._socket.getpeername())
        expected = token_proof(token, "server", endpoint, mine, answer["nonce"])
        if not hmac.compare_digest(expected, answer["proof"]):
            raise ConnectionLost(f"{self.address} does not know the token: it is another casd, or none; through a "
                                 "tunnel, where addresses differ, pass prove=False")
        self.call("authorise", {"proof": token_proof(token, "client", endpoint, mine, answer["nonce"])})

    def call(self, method: str, params: Optional[Mapping[str, Any]] = None,
             timeout_s: Optional[float] = None) -> Any:
        """Calls a method and returns its result.

        Raises a CallError, CallTimeout after `timeout_s` (None: the client's), ConnectionLost.
        """
        number = next(self._numbers)
        answers: queue.SimpleQueue[Any] = queue.SimpleQueue()
        patience = self.timeout_s if timeout_s is None else timeout_s
        with self._lock:
            if self._lost is not None:
                raise ConnectionLost(f"{self.address}: {self._lost}")
            self._waiting[number] = answers
        try:
            try:
                with self._sending:
                    self._socket.sendall(request_line(number, method, params or {}))
            except OSError as error:
                raise ConnectionLost(f"{self.address}: {error.strerror or error}") from None
            try:
                answer = answers.get(timeout=patience)
            except queue.Empty:
                raise CallTimeout(f"{self.address} did not answer {method} in {patience:g} s") from None
        finally:
            with self._lock:
                self._waiting.pop(number, None)
        if answer is None:
            raise ConnectionLost(f"{self.address}: {self._lost}")
        if "error" in answer:
            raise call_error(method, answer["error"])
        return answer["result"]

    def subscribe(self, topic: str) -> Subscription[Any]:
        """From now on the notifications of `topic`."""
        subscription: Subscription[Any] = Subscription(topic, self._unsubscribe)
        with self._lock:
            self._subscriptions.setdefault(topic, []).append(subscription)
        try:
            self.call("subscribe", {"topic": topic})
        except BaseException:
            with self._lock:
                self._subscriptions[topic].remove(subscription)
            raise
        return subscription

    def _unsubscribe(self, subscription: Subscription[Any]) -> None:
        with self._lock:
            others = self._subscriptions.get(subscription.topic, [])
            if subscription in others:
                others.remove(subscription)
            last = not others and self._lost is None
        subscription.end()
        if last:
            try:
                self.call("unsubscribe", {"topic": subscription.topic})
            except ConnectionLost:
                pass

    def describe(self) -> dict[str, Any]:
        """The port's own description: an OpenRPC document."""
        document: dict[str, Any] = self.call("rpc.discover")
        return document

    def methods(self) -> list[str]:
        """The names of everything that can be called."""
        names: list[str] = self.call("methods")
        return names

    def close(self) -> None:
        """Ends the connection."""
        try:
            self._socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass
        if threading.current_thread() is not self._thread:
            self._thread.join()
        self._socket.close()

    def __enter__(self: T) -> T:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _read(self) -> None:
        why = "the connection was closed"
        try:
            with self._socket.makefile("rb") as lines:
                for line in lines:
                    self._on_message(json.loads(line))
        except OSError as error:
            why = error.strerror or str(error)
        except (ValueError, TypeError, AttributeError):
            why = "an answer is no JSON: another program listens there"
        with self._lock:
            self._lost = self._lost or why
            for answers in self._waiting.values():
                answers.put(None)
            for subscriptions in self._subscriptions.values():
                for subscription in subscriptions:
                    subscription.end()

    def _on_message(self, message: Any) -> None:
        with self._lock:
            if "method" in message:
                for subscription in self._subscriptions.get(message["method"], []):
                    subscription.put(message.get("params"))
            elif message.get("id") is None:
                self._lost = str(message.get("error", {}).get("message", "refused"))
            elif message["id"] in self._waiting:
                self._waiting[message["id"]].put(message)


class AsyncSubscription(Generic[T]):
    """As Subscription, for `async for` and `async with`."""

    def __init__(self, topic: str, client: "AsyncClient") -> None:
        self.topic = topic
        self.left_out = 0
        self._client = client
        self._queue: asyncio.Queue[Any] = asyncio.Queue()

    def put(self, params: Any) -> None:
        """By the reading task."""
        if self._queue.qsize() >= Subscription.MOST_WAITING:
            self.left_out += 1
        else:
            self._queue.put_nowait((params,))

    def end(self) -> None:
        """No more will come."""
        self._queue.put_nowait(None)

    def __aiter__(self) -> AsyncIterator[T]:
        return self

    async def __anext__(self) -> T:
        item = await self._queue.get()
        if item is None:
            self.end()
            raise StopAsyncIteration
        value: T = item[0]
        return value

    async def close(self) -> None:
        """Ends the subscription."""
        await self._client.unsubscribe(self)

    async def __aenter__(self) -> "AsyncSubscription[T]":
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()


class AsyncClient:
    """As Client, for asyncio: `async with await AsyncClient.connect(address) as client`."""

    def __init__(self, address: str, reader: asyncio.StreamReader, writer: asyncio.StreamWriter,
                 timeout_s: float) -> None:
        self.address = address
        self.timeout_s = timeout_s
        self._reader = reader
        self._writer = writer
        self._numbers = itertools.count(1)
        self._waiting: dict[int, asyncio.Future[Any]] = {}
        self._subscriptions: dict[str, list[AsyncSubscription[Any]]] = {}
        self._lost: Optional[str] = None
        self._task = asyncio.create_task(self._read())

    @classmethod
    async def connect(cls, address: Address, *, token: Optional[str] = None, timeout_s: float = CALL_TIMEOUT_S,
                      start: str = "") -> "AsyncClient":
        """Connects; the arguments are those of Client."""
        most = 64 * 1024 * 1024  # bytes in a line
        try:
            if is_unix(address):
                reader, writer = await asyncio.open_unix_connection(unix_path(address), limit=most)
            else:
                host, port = host_and_port(address)
                reader, writer = await asyncio.open_connection(host, port, limit=most)
        except OSError as error:
            why = error.strerror or str(error)
            raise NotRunning(f"nothing answers at {os.fspath(address)} ({why}){start and '; ' + start}") from None
        client = cls(os.fspath(address), reader, writer, timeout_s)
        if token is not None and not is_unix(address):
            try:
                await client._authorise(token)
            except BaseException:
                await client.close()
                raise
        return client

    async def _authorise(self, token: str) -> None:
        mine = secrets.token_hex(32)
        answer = await self.call("authorise", {"nonce": mine})
        if answer is True:
            refuse_stranger(self.address)  # it asks for no token and proves nothing
            return
        endpoint = endpoint_text(self._writer.get_extra_info("peername"))
        expected = token_proof(token, "server", endpoint, mine, answer["nonce"])
        if not hmac.compare_digest(expected, answer["proof"]):
            raise ConnectionLost(f"{self.address} does not know the token: it is another casd, or none")
        await self.call("authorise", {"proof": token_proof(token, "client", endpoint, mine, answer["nonce"])})

    async def call(self, method: str, params: Optional[Mapping[str, Any]] = None,
                   timeout_s: Optional[float] = None) -> Any:
        """As Client.call."""
        if self._lost is not None:
            raise ConnectionLost(f"{self.address}: {self._lost}")
        number = next(self._numbers)
        patience = self.timeout_s if timeout_s is None else timeout_s
        future: asyncio.Future[Any] = asyncio.get_running_loop().create_future()
        self._waiting[number] = future
        try:
            self._writer.write(request_line(number, method, params or {}))
            answer = await asyncio.wait_for(future, patience)
        except asyncio.TimeoutError:
            raise CallTimeout(f"{self.address} did not answer {method} in {patience:g} s") from None
        finally:
            self._waiting.pop(number, None)
        if answer is None:
            raise ConnectionLost(f"{self.address}: {self._lost}")
        if "error" in answer:
            raise call_error(method, answer["error"])
        return answer["result"]

    async def subscribe(self, topic: str) -> AsyncSubscription[Any]:
        """From now on the notifications of `topic`."""
        subscription: AsyncSubscription[Any] = AsyncSubscription(topic, self)
        self._subscriptions.setdefault(topic, []).append(subscription)
        try:
            await self.call("subscribe", {"topic": topic})
        except BaseException:
            self._subscriptions[topic].remove(subscription)
            raise
        return subscription

    async def unsubscribe(self, subscription: AsyncSubscription[Any]) -> None:
        """As AsyncSubscription.close()."""
        others = self._subscriptions.get(subscription.topic, [])
        if subscription not in others:
            return
        others.remove(subscription)
        subscription.end()
        if not others and self._lost is None:
            await self.call("unsubscribe", {"topic": subscription.topic})

    async def close(self) -> None:
        """Ends the connection."""
        self._writer.close()
        self._task.cancel()
        try:
            await self._task
        except asyncio.CancelledError:
            pass

    async def __aenter__(self: T) -> T:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()

    async def _read(self) -> None:
        why = "the connection was closed"
        try:
            while line := await self._reader.readline():
                self._on_message(json.loads(line))
        except OSError as error:
            why = error.strerror or str(error)
        except (ValueError, TypeError, AttributeError):
            why = "an answer is no JSON: another program listens there"
        finally:
            self._lost = self._lost or why
            for future in self._waiting.values():
                if not future.done():
                    future.set_result(None)
            for subscriptions in self._subscriptions.values():
                for subscription in subscriptions:
                    subscription.end()

    def _on_message(self, message: Any) -> None:
        if "method" in message:
            for subscription in self._subscriptions.get(message["method"], []):
                subscription.put(message.get("params"))
        elif message.get("id") is None:
            self._lost = str(message.get("error", {}).get("message", "refused"))
        elif message["id"] in self._waiting and not self._waiting[message["id"]].done():
            self._waiting[message["id"]].set_result(message)
