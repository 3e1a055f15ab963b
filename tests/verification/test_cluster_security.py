"""The processes of a sweep or study take orders from us alone: another user of this machine gets no word from them."""

from __future__ import annotations

import contextlib
import http.client
import subprocess
import sys
from collections.abc import Iterator

import psutil
import pytest
from distributed import Client

from tailslap.execution.cluster import connected

pytestmark = pytest.mark.verification


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    with connected(None, 1) as client:
        yield client


@pytest.fixture(scope="module")
def listening(client: Client) -> list[tuple[str, int]]:
    """Addresses at which this process and its children listen."""
    here = psutil.Process()
    found = [
        socket.laddr
        for process in (here, *here.children(recursive=True))
        for socket in process.net_connections(kind="inet")
        if socket.status == psutil.CONN_LISTEN
    ]
    assert len(found) > 2  # scheduler, nanny, worker
    return [(address.ip, address.port) for address in found]


STRANGER = """
import asyncio, sys
from distributed import Security
from distributed.core import rpc

async def ask(address, arguments):
    async with rpc(address, timeout=3.0, connection_args=arguments) as there:
        return await asyncio.wait_for(there.identity(), 3.0)

for address in sys.argv[1:]:
    tls = address.startswith("tls")
    try:
        asyncio.run(ask(address, Security.temporary().get_connection_args("client") if tls else {}))
        print("answered")
    except (OSError, TimeoutError):
        print("refused")
"""
"""Another process, whose sockets are its own: it asks without a certificate, or with one that it has made."""


def test_we_are_answered(client: Client) -> None:
    assert client.submit(pow, 2, 10).result() == 1024


@pytest.mark.parametrize("protocol", ["tcp", "tls"])
def test_who_has_not_our_certificate_is_not(listening: list[tuple[str, int]], protocol: str) -> None:
    """At any of the ports."""
    addresses = [f"{protocol}://{host}:{port}" for host, port in listening]
    asked = subprocess.run([sys.executable, "-c", STRANGER, *addresses], capture_output=True, text=True)
    assert asked.stdout.split() == ["refused"] * len(addresses)


def test_all_ports_are_of_this_machine_alone(listening: list[tuple[str, int]]) -> None:
    assert {host for host, _ in listening} == {"127.0.0.1"}


def test_no_port_serves_pages(listening: list[tuple[str, int]]) -> None:
    for host, port in listening:
        for path in ("/", "/info/main/workers.html", "/health", "/metrics", "/json/counts.json"):
            assert _status(host, port, path) in (404, None)


def _status(host: str, port: int, path: str) -> int | None:
    """Of a web page; None where the other side hangs up."""
    with contextlib.closing(http.client.HTTPConnection(host, port, timeout=3.0)) as connection:
        try:
            connection.request("GET", path)
            with connection.getresponse() as response:
                return response.status
        except (OSError, http.client.HTTPException):
            return None


def test_the_dashboard_of_dask_is_not_opened(listening: list[tuple[str, int]]) -> None:
    assert 8787 not in {port for _, port in listening}
