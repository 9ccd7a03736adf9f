#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""LIDARD_LOCK_MEMORY=1 locks the daemon's memory; where that is refused the log names the remedy and the daemon runs on. Off by
default."""
import contextlib
import os
import resource
import socket
import sys

from harness import (LIDARD, SCANNER_CONFIG, SKIP, expect, folder, free_port, kernel_port_is_open, kilobytes, logged, use_master_at,
                     wait_for, write)


@contextlib.contextmanager
def daemon(tmp, wish, before=()):
    """Locked and resident kB of a running daemon, and its log."""
    port = free_port(socket.SOCK_DGRAM)
    config = write(tmp / "c.yaml", SCANNER_CONFIG.format(port=port))
    with logged([*before, LIDARD, "run", "-c", config], tmp / "log", env={**os.environ, "LIDARD_LOCK_MEMORY": wish}) as child:
        wait_for(lambda: kernel_port_is_open(port), 10, "the daemon listens")
        yield kilobytes(child.pid, "VmLck"), kilobytes(child.pid, "VmRSS"), child.said()


def main():
    use_master_at(free_port())
    with folder() as tmp:
        for wish in ("", "0"):
            with daemon(tmp, wish) as (locked, _, log):
                expect(locked == 0 and "LIDARD_LOCK_MEMORY" not in log, f"{wish!r}: {locked} kB are locked:\n{log}")
        if os.geteuid() != 0:
            print("skipped: that memory is locked is shown as root only")
            sys.exit(SKIP)
        with daemon(tmp, "1") as (locked, resident, log):
            print(f"{locked} kB locked, {resident} kB resident")
            expect(locked > 20_000 and "LIDARD_LOCK_MEMORY" not in log, f"{locked} kB are locked:\n{log}")
        resource.setrlimit(resource.RLIMIT_MEMLOCK, (8 << 20, 8 << 20))
        with daemon(tmp, "1", ["setpriv", "--bounding-set", "-ipc_lock", "--inh-caps", "-ipc_lock"]) as (locked, _, log):
            expect(locked == 0 and "set LimitMEMLOCK=infinity" in log, f"{locked} kB are locked:\n{log}")
    print("ok")


if __name__ == "__main__":
    main()
