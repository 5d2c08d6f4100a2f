"""Waits after wrong passwords: by login and by address, with any cookie or none.

They are counted in the database, so that several processes and later ones count together.
After some free tries each wrong password doubles the wait, up to a quarter of an hour. Logins
that nobody has are counted as well: a wait doesn't show which logins there are.
"""

from __future__ import annotations

import hashlib
import hmac
import ipaddress

from sqlalchemy import delete, select, update
from sqlalchemy.orm import Session

from annotation_app.store.database import dialect_of, inserting
from annotation_app.store.installation import installation
from annotation_app.store.models import FailedSignIn

FREE_BY_LOGIN, FREE_BY_ADDRESS = 5, 20
"""A class may sit behind one address, and each of them mistype."""
LONGEST_WAIT_S = 900.0
"""Longest time for which somebody else can keep a login waiting, in seconds."""
FORGOTTEN_S = 86_400.0


def begin(session: Session, login: str, address: str, *, now: float) -> float:
    """Count an attempt before its password is looked at, or say how many seconds to wait instead.

    Attempts at the same time are counted one after the other, and one that must wait makes
    the wait no longer. 0 is given if the password may be tried now.
    """
    free = {_of_login(login): FREE_BY_LOGIN, _of_address(address): FREE_BY_ADDRESS}
    keys = sorted(free)
    add = inserting(dialect_of(session), FailedSignIn).on_conflict_do_nothing()
    session.execute(add, [{"whose": key, "count": 0, "last_at": now} for key in keys])
    rows = session.scalars(
        select(FailedSignIn)
        .where(FailedSignIn.whose.in_(keys))
        .order_by(FailedSignIn.whose)
        .with_for_update()
        .execution_options(populate_existing=True)
    ).all()
    wait_s = max(_wait_s(row, free[row.whose], now) for row in rows)
    if wait_s > 0:
        return wait_s
    for row in rows:
        # Who comes back after a day begins anew. A clock that was set back makes nobody wait.
        row.count = 1 if abs(now - row.last_at) > FORGOTTEN_S else row.count + 1
        row.last_at = now
    session.flush()
    old = (
        select(FailedSignIn.whose)
        .where(FailedSignIn.last_at < now - FORGOTTEN_S)
        .with_for_update(skip_locked=True)
    )
    session.execute(delete(FailedSignIn).where(FailedSignIn.whose.in_(old)))
    return 0.0


def succeeded(session: Session, login: str, address: str) -> None:
    """Forget the login's count after a correct attempt, and only this one of the address's."""
    forget(session, login)
    session.execute(
        update(FailedSignIn)
        .where(FailedSignIn.whose == _of_address(address), FailedSignIn.count > 0)
        .values(count=FailedSignIn.count - 1)
    )


def forget(session: Session, login: str) -> None:
    """Let nobody wait who knows a login's password."""
    session.execute(delete(FailedSignIn).where(FailedSignIn.whose == _of_login(login)))


def _wait_s(row: FailedSignIn, free: int, now: float) -> float:
    if row.count < free:
        return 0.0
    whole = min(2.0 ** min(row.count - free, 20), LONGEST_WAIT_S)
    return max(0.0, whole - abs(now - row.last_at))


def _of_login(login: str) -> str:
    return _hashed("login", login.strip().casefold())


def _of_address(address: str) -> str:
    """Return an address; of IPv6 the network, as a customer has a whole one."""
    try:
        found = ipaddress.ip_address(address.partition("%")[0])
    except ValueError:
        return _hashed("address", address)
    if isinstance(found, ipaddress.IPv4Address):
        return _hashed("address", str(found))
    network = ipaddress.ip_network((found, 64), strict=False)
    return _hashed("address", str(found.ipv4_mapped or network))


def _hashed(kind: str, value: str) -> str:
    # Keyed, so that neither addresses nor logins can be read from the table.
    key = installation().config.secret_key
    return hmac.new(key, f"failed sign-in\0{kind}\0{value}".encode(), hashlib.sha256).hexdigest()
