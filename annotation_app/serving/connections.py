"""Waiting for many open connections at the cost of the active ones.

At each event, waitress queries all connections for the events that they wait for, and passes
them to the kernel. Here the kernel gets each once, and only those are queried whose state may have
changed.
"""

from __future__ import annotations

import logging
import socket
import threading
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from ipaddress import IPv6Network
from selectors import EVENT_READ, EVENT_WRITE, DefaultSelector
from time import monotonic
from typing import Any

from waitress import wasyncore
from waitress.channel import HTTPChannel
from waitress.trigger import trigger

ASK_ALL_S = 1.0
"""Interval between checks of each connection, which close silent ones, in seconds."""
HEADS_S = 1.0
"""Longest time for the head of a request while the server ends, in seconds."""
LOOK_S = 0.1
"""Interval between checks whether all is finished, while the server ends, in seconds."""


log = logging.getLogger(__name__)

CONNECTIONS = 1000
"""Largest number of connections."""
HEAD_S = 10.0
"""Longest time for the head of a request, from the connection on or from its first byte, in
seconds."""
IDLE_S = 120.0
"""Longest silence of a connection, in seconds."""
TELL_S = 60.0
"""Interval between entries in the log about a lack of room, in seconds."""


class Room:
    """Account of connections; the one thread that reads from them all uses it.

    There are `most` at most, but for those that are being answered.
    """

    def __init__(
        self,
        most: int = CONNECTIONS,
        *,
        head_s: float = HEAD_S,
        idle_s: float = IDLE_S,
        clock: Callable[[], float] = monotonic,
    ) -> None:
        self.most = most
        self.most_headless = max(1, most // 2)
        self.head_s = head_s
        self.idle_s = idle_s
        self._clock = clock
        self._guests: dict[HTTPChannel, _Guest] = {}
        self._headless: dict[str, dict[HTTPChannel, float]] = {}
        self._told_at = -TELL_S

    def come(self, channel: HTTPChannel) -> None:
        """Take somebody in who has connected, and send others away if they are too many."""
        if channel in self._guests:
            return
        now = self._clock()
        guest = self._guests[channel] = _Guest(network_of(str(channel.addr[0])), now)
        headless = self._headless.setdefault(guest.address, {})
        headless[channel] = now
        if len(headless) > self.most_headless:
            oldest = next((c for c in headless if c is not channel and self._waits(c)), None)
            if oldest is not None:
                oldest.handle_close()
        if len(self._guests) > self.most:
            self._make_room(channel)

    def heard(self, channel: HTTPChannel) -> None:
        """Note that something has come from a client, or was sent to it."""
        guest = self._guests.get(channel)
        if guest is None:
            return
        guest.heard_at = self._clock()
        request = channel.request
        if request is None or request.headers_finished or channel.requests:
            self._has_head(guest.address, channel)
        else:
            self._headless.setdefault(guest.address, {}).setdefault(channel, guest.heard_at)

    def leave(self, channel: HTTPChannel) -> None:
        """Note that a connection is closed."""
        guest = self._guests.pop(channel, None)
        if guest is not None:
            self._has_head(guest.address, channel)

    def send_away(self) -> None:
        """Close connections on which nothing has come for too long; to be called each second."""
        now = self._clock()
        for channel, guest in list(self._guests.items()):
            unsent = channel.total_outbufs_len
            guest.is_stuck = unsent > 0 and unsent == guest.unsent
            guest.unsent = unsent
        late = [
            channel
            for headless in list(self._headless.values())
            for channel, since in list(headless.items())
            if now - since >= self.head_s
        ]
        silent = [
            c for c, guest in list(self._guests.items()) if now - guest.heard_at >= self.idle_s
        ]
        for channel in (*late, *silent):
            if self._waits(channel):
                channel.handle_close()

    def _has_head(self, address: str, channel: HTTPChannel) -> None:
        headless = self._headless.get(address)
        if headless is not None:
            headless.pop(channel, None)
            if not headless:
                self._headless.pop(address, None)

    def _make_room(self, newest: HTTPChannel) -> None:
        """Close the connection that was silent for longest, of the address with the most."""
        counts = Counter(guest.address for guest in self._guests.values())
        waiting = [
            (-counts[guest.address], guest.heard_at, number, channel)
            for number, (channel, guest) in enumerate(self._guests.items())
            if channel is not newest
        ]
        waiting.sort()
        found = next((entry for entry in waiting if self._waits(entry[-1])), None)
        if found is None:
            return
        count, *_, oldest = found
        now = self._clock()
        if now - self._told_at >= TELL_S:
            self._told_at = now
            log.warning(
                "all %d connections are in use, %d of them by one address; "
                "those that wait for longest are closed",
                self.most,
                -count,
            )
        oldest.handle_close()

    def _waits(self, channel: HTTPChannel) -> bool:
        """Check that nothing is being answered or sent, and no unread data has come."""
        guest = self._guests.get(channel)
        if guest is None or channel.requests or (channel.total_outbufs_len and not guest.is_stuck):
            return False
        try:
            return not channel.socket.recv(1, socket.MSG_PEEK)
        except OSError:  # nothing is there, or the connection is broken
            return True


@dataclass(slots=True)
class _Guest:
    """A connection: its address, and the time of its last traffic."""

    address: str
    heard_at: float
    unsent: int = 0
    is_stuck: bool = False
    """True if the client hasn't taken anything of an answer for a second."""


def network_of(host: str) -> str:
    """Return an address; of IPv6 the network, of which each customer has one or more."""
    if ":" not in host:
        return host
    return str(IPv6Network((host.partition("%")[0], 64), strict=False))


class Connections(dict[int, Any]):
    """Objects that waitress waits for, by file descriptor: connections, listeners, its bell.

    One that is ready to read and has nothing to write is settled until something comes on it.
    Others wait until the bell rings, which threads do that have answered a request.
    """

    def __init__(self, room: Room | None = None) -> None:
        super().__init__()
        self._room = room or Room()
        self._selector = DefaultSelector()
        self._watched: dict[int, int] = {}
        self._changed: set[Any] = set()
        self._unsettled: set[Any] = set()
        self._ask_all_at = 0.0
        self._is_ending = False
        # Threads that answer requests may close connections.
        self._lock = threading.Lock()

    def __setitem__(self, descriptor: int, connection: Any) -> None:
        with self._lock:
            super().__setitem__(descriptor, connection)
            self._changed.add(connection)

    def __delitem__(self, descriptor: int) -> None:
        with self._lock:
            self._watch(descriptor, None, 0)
            connection = super().pop(descriptor)
            if isinstance(connection, HTTPChannel):
                self._room.leave(connection)
            # There may be room again for others to come in.
            self._changed |= self._unsettled

    def wait(self, timeout_s: float) -> None:
        """Wait until something comes or can be sent, and have it read or sent."""
        self._ask()
        for key, events in self._selector.select(timeout_s):
            connection = key.data
            self._changed.add(connection)
            if isinstance(connection, trigger):
                self._changed |= self._unsettled
            if events & EVENT_READ and self._has(connection):
                if self._is_ending and _is_idle(connection):
                    connection.handle_close()
                elif connection.readable():
                    wasyncore.read(connection)
                else:
                    self._ignore(connection, EVENT_READ)
            if events & EVENT_WRITE and self._has(connection) and connection.writable():
                to_send = connection.total_outbufs_len
                wasyncore.write(connection)
                if connection.total_outbufs_len == to_send:  # a thread is just sending it
                    self._ignore(connection, EVENT_WRITE)
            if isinstance(connection, HTTPChannel) and self._has(connection):
                self._room.heard(connection)

    def ring(self) -> None:
        """Wake the waiting thread to look again; a signal may do so."""
        bell = next((c for c in list(self.values()) if isinstance(c, trigger)), None)
        if bell is not None:
            bell.pull_trigger()

    def finish(self, within_s: float) -> bool:
        """Let nobody in, finish what was begun, close all; whether it was done in time."""
        begin = monotonic()
        for connection in list(self.values()):
            if connection.accepting:
                self._let_in_who_waits(connection)
                wasyncore.dispatcher.close(connection)  # a server's own would close its bell too
        self.wait(0)  # what has come already was sent before the end
        self._is_ending = True
        while (begun := self._close_idle()) and monotonic() < begin + within_s:
            self.wait(LOOK_S)
            if monotonic() > begin + HEADS_S:
                self._close_headless()
        for connection in begun:
            connection.handle_close()
        return not begun

    def _close_headless(self) -> None:
        """Close connections on which not even the head of a request has come."""
        for connection in self._people():
            request = connection.request
            is_begun = connection.requests or connection.total_outbufs_len
            if request is not None and not request.headers_finished and not is_begun:
                connection.handle_close()

    def _people(self) -> list[HTTPChannel]:
        return [c for c in list(self.values()) if isinstance(c, HTTPChannel)]

    def _close_idle(self) -> list[HTTPChannel]:
        """Close idle connections, and return the others."""
        begun = []
        for connection in self._people():
            if _is_idle(connection):
                connection.handle_close()
            else:
                begun.append(connection)
        return begun

    def _let_in_who_waits(self, listening: Any) -> None:
        """Accept connections that the kernel hasn't reported yet."""
        before = -1
        while before < len(self):
            before = len(self)
            listening.handle_accept()

    def _ask(self) -> None:
        """Query the events that changed connections wait for."""
        with self._lock:
            changed, self._changed = self._changed, set()
            if is_time := monotonic() >= self._ask_all_at:
                changed.update(self.values())
                self._ask_all_at = monotonic() + ASK_ALL_S
        for connection in changed:
            if isinstance(connection, HTTPChannel) and self._has(connection):
                self._room.come(connection)
            self._settle(connection)
        if is_time:
            self._room.send_away()

    def _has(self, connection: Any) -> bool:
        return self.get(connection._fileno) is connection

    def _ignore(self, connection: Any, events: int) -> None:
        """Watch for something no longer, until the bell rings."""
        with self._lock:
            if self._has(connection):
                descriptor = connection._fileno
                self._watch(descriptor, connection, self._watched.get(descriptor, 0) & ~events)
                self._unsettled.add(connection)
                self._changed.discard(connection)

    def _settle(self, connection: Any) -> None:
        """Watch what a connection waits for.

        While a request is answered nothing may be read, but hardly ever comes anything: to stop
        watching and start again would cost more.
        """
        with self._lock:
            self._unsettled.discard(connection)
            if not self._has(connection):
                return
            wanted = EVENT_READ if connection.readable() else 0
            if connection.writable() and not connection.accepting:
                wanted |= EVENT_WRITE
            if wanted != EVENT_READ:
                self._unsettled.add(connection)
            descriptor = connection._fileno
            watched = self._watched.get(descriptor, 0)
            self._watch(descriptor, connection, wanted | watched & EVENT_READ)

    def _watch(self, descriptor: int, connection: Any, events: int) -> None:
        watched = self._watched.pop(descriptor, 0)
        if events:
            self._watched[descriptor] = events
        if events and not watched:
            self._selector.register(descriptor, events, connection)
        elif events and events != watched:
            self._selector.modify(descriptor, events, connection)
        elif watched and not events:
            self._selector.unregister(descriptor)


def _is_idle(connection: Any) -> bool:
    """Check that no request is being received or answered, and no answer sent."""
    return isinstance(connection, HTTPChannel) and not (
        connection.requests or connection.request is not None or connection.total_outbufs_len
    )
