"""`python -m isomend.fleet IN… -o OUT/`: fills the holes of many meshes."""

from __future__ import annotations

import argparse
import sys
import time

from isomend._errors import IsomendError, ParameterError
from isomend.fleet import State, run

EPILOG = """\
All other options are passed to `isomend fill` for every mesh, such as --max-diameter 20.

IN is a file, a folder, a pattern such as 'scans/**/*.ply', or @FILE, a list of paths, one a line.
OUT/.fleet/manifest.jsonl has a line for each mesh: to continue a run that was stopped, use the same command again.

Exit codes: 0 done; 1 the run or at least one mesh failed; 2 wrong usage; 3 a hole of some mesh is still open; 130 stopped."""
FAILURES = ("failed", "timeout", "memory", "crashed")


def arguments() -> tuple[argparse.Namespace, list[str]]:
    """Parses the command line: the fleet's own options, and the options to pass to `isomend fill`."""
    parser = argparse.ArgumentParser(
        prog="python -m isomend.fleet", description="Fills the holes of many meshes, on many cores or machines.",
        epilog=EPILOG, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False,
    )  # fmt: skip
    parser.add_argument("inputs", nargs="+", metavar="IN", help="meshes")
    parser.add_argument("-o", "--output", required=True, metavar="OUT", help="the folder of the results")
    parser.add_argument("--to", metavar="FORMAT", help="format of the results [default: the format of each input]")
    parser.add_argument("--workers", type=int, metavar="N", help="number of meshes processed at a time [default: one for each core]")
    parser.add_argument("--address", metavar="ray://HOST:PORT", help="a Ray cluster [default: this machine]")
    parser.add_argument("--threads", type=int, default=1, metavar="N", help="threads of each mesh [default: 1]")
    parser.add_argument("--timeout", type=float, metavar="SECONDS", help="stop the work on a mesh after this time")
    parser.add_argument("--memory", type=float, metavar="GB", help="stop the work on a mesh that needs more memory")
    parser.add_argument("--shard", type=shard, metavar="I/N", help="process the I-th of N parts of the meshes, without Ray, as a job of an array")
    parser.add_argument("--retry", action="store_true", help="process meshes again that failed, crashed, or exceeded a limit")
    parser.add_argument("-q", "--quiet", action="store_true", help="print nothing but errors")
    own, others = parser.parse_known_args()
    for name in ("workers", "threads", "timeout", "memory"):
        value = getattr(own, name)
        if value is not None and not value > 0:
            parser.error(f"--{name} must be positive")
    return own, others


def shard(text: str) -> tuple[int, int]:
    """A shard, such as 3/16."""
    number, _, parts = text.partition("/")
    try:
        return int(number), int(parts)
    except ValueError:
        raise argparse.ArgumentTypeError(f"a shard is a number from 1 and the number of shards, such as 3/16, but is {text!r}") from None


def words(seconds: float) -> str:
    """A duration in hours, minutes and seconds."""
    whole = round(seconds)
    if whole < 90:
        return f"{whole} s"
    if whole < 5400:
        return f"{whole // 60} min {whole % 60} s"
    return f"{whole // 3600} h {whole % 3600 // 60} min"


class ProgressPrinter:
    """Prints the progress: on a terminal in one line that is updated, else a line every ten seconds."""

    def __init__(self) -> None:
        self._next = 0.0

    def __call__(self, state: State) -> None:
        counts = ", ".join(f"{count} {name.replace('_', ' ')}" for name, count in state.outcomes.most_common())
        left = "" if state.seconds_left is None else f"; about {words(state.seconds_left)} left"
        earlier = f"{state.earlier} earlier, " if state.earlier else ""
        line = f"{state.done} of {state.all} meshes: {earlier}{counts or 'none yet'}{left if state.done < state.all else ''}"
        if sys.stderr.isatty():
            print(f"\r\033[K{line}", end="\n" if state.done == state.all else "", file=sys.stderr, flush=True)
        elif time.monotonic() >= self._next or state.done == state.all:
            self._next = time.monotonic() + 10
            print(line, file=sys.stderr, flush=True)


def main() -> int:
    """Runs the fleet; returns the exit code."""
    own, others = arguments()
    try:
        state = run(
            own.inputs, own.output, workers=own.workers, address=own.address, threads=own.threads, timeout=own.timeout,
            memory=own.memory, to=own.to, retry=own.retry, shard=own.shard, progress=None if own.quiet else ProgressPrinter(),
            arguments=others,
        )  # fmt: skip
    except ParameterError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except (IsomendError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("stopped; run the same command again to continue", file=sys.stderr)
        return 130
    if any(state.outcomes[name] for name in FAILURES):
        return 1
    return 3 if state.outcomes["in_part"] else 0


if __name__ == "__main__":
    sys.exit(main())
