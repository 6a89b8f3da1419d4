"""Runs a command and writes its wall and CPU seconds and its peak memory as the last line of standard error, as JSON.

    python3 -S scripts/timed.py PROGRAM ARGUMENT...

It is a small separate process, because the peak memory of a child includes the memory of its parent at the start."""

import json
import resource
import subprocess
import sys
import time

start = time.perf_counter()
done = subprocess.run(sys.argv[1:])
wall = time.perf_counter() - start
usage = resource.getrusage(resource.RUSAGE_CHILDREN)
figures = {"ok": done.returncode in (0, 3), "code": done.returncode, "wall": wall, "mb": usage.ru_maxrss / 1024}
print(json.dumps(figures | {"cpu": usage.ru_utime + usage.ru_stime}), file=sys.stderr)
