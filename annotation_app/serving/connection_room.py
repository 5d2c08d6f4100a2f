"""Limits on open connections, so that nobody shuts others out.

A connection on which no whole request comes is free for the client, but the room is limited. One
without the head of a request is closed after a while. An address may have half of the room in that
state, so that a class behind one address fits in. Then its oldest is closed. Where no room is left,
the address with the most connections gives one back. Connections with a request in progress are
never closed. Times are monotonic, even if the clock is set.
"""

from __future__ import annotations

import logging
import socket
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from ipaddress import IPv6Network
from time import monotonic

from waitress.channel import HTTPChannel

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
