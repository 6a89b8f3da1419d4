"""Groups of tests in programs of their own, two at once: a browser waits much. For view_test.py."""

import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor


def in_programs(script, names, more):
    """Runs a script with the options `more` for each group, and prints the output of each group as a whole. Returns what is wrong, as pairs
    of a group and a sentence."""
    def run(name):
        command = [sys.executable, script, "--only", name, *more]
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        failed = re.compile(rf"^FAILED {name}: (.*)\n?", re.MULTILINE)
        print(failed.sub("", done.stdout), end="", flush=True)
        wrong = failed.findall(done.stdout) or [f"the program ends with {done.returncode}"] * bool(done.returncode)
        return [(name, what) for what in wrong]

    with ThreadPoolExecutor(2) as pool:
        return [failure for failures in pool.map(run, names) for failure in failures]
