"""Waiting for many open connections at the cost of the active ones.

At each event, waitress queries all connections for the events that they wait for, and passes
them to the kernel. Here the kernel gets each once, and only those are queried whose state may have
changed.
"""

from __future__ import annotations

import threading
from selectors import EVENT_READ, EVENT_WRITE, DefaultSelector
from time import monotonic
from typing import Any

from waitress import wasyncore
from waitress.channel import HTTPChannel
from waitress.trigger import trigger

from annotation_app.serving.connection_room import Room

ASK_ALL_S = 1.0
"""Interval between checks of each connection, which close silent ones, in seconds."""
HEADS_S = 1.0
"""Longest time for the head of a request while the server ends, in seconds."""
LOOK_S = 0.1
"""Interval between checks whether all is finished, while the server ends, in seconds."""


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
