"""Who may open the WebSocket, and who may command."""

import hmac
import ipaddress
import socket
from urllib.parse import urlsplit


def host_of(netloc: str) -> str:
    """The host of "host:port", in small letters; empty where there is none."""
    try:
        return (urlsplit(f"//{netloc}").hostname or "").lower()
    except ValueError:
        return ""


def _is_address(host: str) -> bool:
    try:
        ipaddress.ip_address(host)
    except ValueError:
        return False
    return True


class Access:
    """Checks origins and the token of commands.

    A page of another site, opened in the same browser, could open a WebSocket to this server too. Its Origin header has
    to name this server, and by an address, by localhost or by this machine's name: another name may have been made to
    resolve to this machine (DNS rebinding).
    """

    def __init__(self, host: str, token: str | None) -> None:
        self._names = {"localhost", socket.gethostname().lower(), host.lower()} - {""}
        self._token = token

    def is_own_origin(self, origin: str, host_header: str) -> bool:
        try:
            parts = urlsplit(origin)
            name = (parts.hostname or "").lower()
        except ValueError:
            return False
        return (
            parts.scheme in ("http", "https")
            and parts.netloc.lower() == host_header.lower()
            and (name in self._names or _is_address(name))
        )

    def is_own_host(self, host_header: str) -> bool:
        name = host_of(host_header)
        return name in self._names or _is_address(name)

    def may_command(self, token: object) -> bool:
        """Compares in constant time. Without --allow-command there is no token, and none is right."""
        if self._token is None or not isinstance(token, str):
            return False
        given, right = (text.encode("utf-8", "surrogatepass") for text in (token, self._token))
        return hmac.compare_digest(given, right)
