"""The processes of a sweep or study take orders from us alone: another user of this machine gets no word from them."""

from __future__ import annotations

import asyncio
import urllib.error
import urllib.request
from collections.abc import Iterator
from typing import Any

import psutil
import pytest
from distributed import Client, Security
from distributed.core import rpc

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


async def _identity(address: str, security: Security | None) -> Any:
    arguments = security.get_connection_args("client") if security else {}
    async with rpc(address, timeout=3.0, connection_args=arguments) as there:
        return await asyncio.wait_for(there.identity(), 3.0)


def test_we_are_answered(client: Client) -> None:
    assert client.submit(pow, 2, 10).result() == 1024
    own = client.security
    assert asyncio.run(_identity(client.scheduler.address, own))["type"] == "Scheduler"


@pytest.mark.parametrize("certificate", [False, True])
def test_who_has_not_our_certificate_is_not(listening: list[tuple[str, int]], certificate: bool) -> None:
    """Neither without any nor with one of his own, at any of the ports."""
    for host, port in listening:
        security = Security.temporary() if certificate else None
        with pytest.raises((OSError, TimeoutError)):
            asyncio.run(_identity(f"{'tls' if certificate else 'tcp'}://{host}:{port}", security))


def test_all_ports_are_of_this_machine_alone(listening: list[tuple[str, int]]) -> None:
    assert {host for host, _ in listening} == {"127.0.0.1"}


def test_no_port_serves_pages(listening: list[tuple[str, int]]) -> None:
    for host, port in listening:
        for path in ("/", "/info/main/workers.html", "/health", "/metrics", "/json/counts.json"):
            with pytest.raises((urllib.error.HTTPError, OSError)) as refused:
                urllib.request.urlopen(f"http://{host}:{port}{path}", timeout=3.0)
            assert getattr(refused.value, "code", 404) == 404


def test_the_dashboard_of_dask_is_not_opened(listening: list[tuple[str, int]]) -> None:
    assert 8787 not in {port for _, port in listening}
