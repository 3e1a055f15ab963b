"""The processes of a sweep or study take orders from us alone: no other user of this machine can reach them."""

from __future__ import annotations

import os

import psutil

from tailslap.campaign import pools


def test_processes_of_this_machine_open_no_port():
    """Neither they nor this process listen to the network; what they say goes through pipes and own sockets."""
    before = {socket.laddr for socket in psutil.Process().net_connections(kind="inet")}
    with pools.local(2) as pool:
        assert pool.submit(pow, 2, 10).result() == 1024
        worker = pool.submit(os.getpid).result()
        here = psutil.Process()
        family = {process.pid: process for process in (here, *here.children(recursive=True))}
        assert worker in family
        sockets = [socket for process in family.values() for socket in process.net_connections(kind="inet")]
        assert {socket.laddr for socket in sockets} == before
    assert not psutil.pid_exists(worker) or psutil.Process(worker).status() == psutil.STATUS_ZOMBIE
