"""The child process that fills one mesh: runs isomend's command line with a limit of its address space, and records its peak memory."""

from __future__ import annotations

import os
import resource
import sys
import threading
import time

from isomend import _isomend


def end_with_parent(parent: int) -> None:
    """Ends this process when its parent changes, which means that the worker died."""
    while os.getppid() == parent:
        time.sleep(0.2)
    os._exit(1)


def peak_of(process: str) -> int:
    """Peak resident memory of a process in bytes; 0 if the system does not report it. Not taken from the usage reported at its end, which
    includes memory of its parent from before the child's program was loaded."""
    try:
        with open(f"/proc/{process}/status") as status:
            lines = [line for line in status if line.startswith("VmHWM:")]
        return int(lines[0].split()[1]) * 1024
    except (OSError, IndexError):
        return 0


def main() -> None:
    """Runs ``PARENT LIMIT PEAK ARGUMENTS…``: the worker's process number, the limit of address space in bytes (0 for none), the file to
    write the peak memory to, the command line."""
    parent, limit, peak = int(sys.argv[1]), int(sys.argv[2]), sys.argv[3]
    threading.Thread(target=end_with_parent, args=(parent,), daemon=True).start()
    if limit:
        resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    code = _isomend.main(["isomend", *sys.argv[4:]])
    with open(peak, "w") as file:
        file.write(str(peak_of("self")))
    sys.exit(code)


if __name__ == "__main__":
    main()
