#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""LIDARD_LOCK_MEMORY=1 locks the daemon's memory; where that is refused the log names the remedy and the daemon runs on. Off by
default."""
import contextlib
import os
import pathlib
import re
import resource
import socket
import subprocess
import sys

from harness import LIDARD, SCANNER_CONFIG, SKIP, expect, folder, free_port, kernel_port_is_open, process, use_master_at, wait_for


@contextlib.contextmanager
def daemon(tmp, wish, before=()):
    """Locked and resident kB of a running daemon, and its log."""
    port = free_port(socket.SOCK_DGRAM)
    (tmp / "c.yaml").write_text(SCANNER_CONFIG.format(port=port))
    log = tmp / "log"
    with log.open("w") as sink, process([*before, LIDARD, "run", "-c", tmp / "c.yaml"], stdout=sink, stderr=subprocess.STDOUT,
                                        env={**os.environ, "LIDARD_LOCK_MEMORY": wish}) as child:
        wait_for(lambda: kernel_port_is_open(port), 10, "the daemon listens")
        status = pathlib.Path(f"/proc/{child.pid}/status").read_text()
        yield (*(int(re.search(rf"{key}:\s+(\d+) kB", status)[1]) for key in ("VmLck", "VmRSS")), log.read_text())


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
