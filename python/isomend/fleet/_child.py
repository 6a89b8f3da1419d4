"""The process that works on one mesh: the command line of isomend, within bounds."""

from __future__ import annotations

import os
import resource
import sys
import threading
import time

from isomend import _isomend


def end_with_parent(parent: int) -> None:
    """Ends this process once its parent is another: the worker died."""
    while os.getppid() == parent:
        time.sleep(0.2)
    os._exit(1)


def peak_of(process: str) -> int:
    """The most memory that a process had, in bytes; 0 where that is not told. What is counted when it ends counts its parent's too."""
    try:
        with open(f"/proc/{process}/status") as status:
            lines = [line for line in status if line.startswith("VmHWM:")]
        return int(lines[0].split()[1]) * 1024
    except (OSError, IndexError):
        return 0


def main() -> None:
    """``PARENT MOST PEAK ARGUMENTS…``: the worker's process, most bytes of address space or 0, a file for the most memory that was
    used, the command line."""
    parent, most, told = int(sys.argv[1]), int(sys.argv[2]), sys.argv[3]
    threading.Thread(target=end_with_parent, args=(parent,), daemon=True).start()
    if most:
        resource.setrlimit(resource.RLIMIT_AS, (most, most))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    code = _isomend.main(["isomend", *sys.argv[4:]])
    with open(told, "w") as file:
        file.write(str(peak_of("self")))
    sys.exit(code)


if __name__ == "__main__":
    main()
