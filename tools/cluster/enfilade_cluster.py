"""Runs the shards of an `enfilade` command on a Dask cluster, then the merge on this machine.

    enfilade-cluster --local-workers 2 --shards 8 -- enfilade bake tiles/*.glb --parts parts -o town.enf

runs `enfilade bake tiles/*.glb --parts parts --shard 0/8` to `7/8` on the workers, and then the whole command with
`--merge`. Shards write to the folder named by --parts, so the workers and this machine need a shared file system.
"""

from __future__ import annotations

import argparse
import logging
import os
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import uuid
from collections.abc import Mapping, Sequence
from contextlib import suppress

import cloudpickle
import dask
from distributed import Client, KilledWorker, Reschedule, as_completed, get_worker

# What tasks use of this module is sent with them.
cloudpickle.register_pickle_by_value(sys.modules[__name__])

CHECK_FAILED = 1
"""Exit status of an `enfilade` that ran to its end and found a false cull or a wrong pixel."""

FAILED = 2
INTERRUPTED = 130

OF_MERGE = {"-o": 1, "--output": 1, "--json": 1}
"""Options that only the merge takes, because it writes the result, and the number of words after each."""

OF_MERGE_OF_VERB = {"vis": {"--check": 0, "--compare": 1}, "hints": {"--check": 1}}
OF_SHARDS_OF_VERB = {
    "look": {"--check": 0, "--method": 1}
    | dict.fromkeys(("--eye", "--toward", "--camera", "--path", "--survey", "--survey-hard"), 1)
}
"""Options that only the merge of a verb takes, and those that only its shards take."""

GUARD = """
import os, signal, subprocess, sys, threading
def kill_with_worker():
    os.read(0, 1)
    os.killpg(0, signal.SIGKILL)
threading.Thread(target=kill_with_worker, daemon=True).start()
status = subprocess.run(sys.argv[1:], stdin=subprocess.DEVNULL).returncode
os._exit(status if status >= 0 else 128 - status)
"""
"""Runs a command, and kills it and its children when standard input is closed. The worker holds the other end, which the
system closes even if the worker is killed. Leads a process group."""


def parse(arguments: Sequence[str]) -> tuple[argparse.Namespace, list[str]]:
    """Returns the options and the command. Exits if they are wrong."""
    parser = argparse.ArgumentParser(
        prog="enfilade-cluster",
        usage="%(prog)s (--scheduler ADDRESS | --local-workers N) --shards N [--retries N] -- COMMAND",
        description="Run the shards of an enfilade command on a Dask cluster, then its merge on this machine.",
        epilog="COMMAND is that of one run, with --parts FOLDER and without --shard and --merge. ENFILADE is the path of "
        "the program `enfilade` if it is not on PATH. Exits with the status of the merge, or with 2 if a shard fails.",
    )
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument("--scheduler", metavar="ADDRESS", help="tcp://HOST:PORT of a Dask scheduler, or its scheduler file")
    where.add_argument("--local-workers", metavar="N", type=positive, help="start N workers on this machine")
    parser.add_argument("--shards", metavar="N", type=positive, required=True, help="number of shares of the work")
    parser.add_argument(
        "--retries", metavar="N", type=int, default=3, help="times that a failed shard is run again [default: 3]"
    )
    own, command = list(arguments), []
    if "--" in own:
        split = own.index("--")
        own, command = own[:split], own[split + 1 :]
    options = parser.parse_args(own)
    if not command:
        parser.error("no command: write it after --, as in -- enfilade bake tiles/*.glb --parts parts -o town.enf")
    if options.retries < 0:
        parser.error("--retries: expected a number from 0")
    names = {word.split("=")[0] for word in command}
    for option in ("--shard", "--merge"):
        if option in names:
            parser.error(f"{option} is added to the command for each run: leave it out")
    if "--parts" not in names:
        parser.error("no --parts FOLDER in the command: the shards write there, and the merge reads it")
    if command[0] == "enfilade":
        command[0] = os.environ.get("ENFILADE") or command[0]
    if os.path.dirname(command[0]):
        command[0] = os.path.abspath(command[0])
    if shutil.which(command[0]) is None:
        parser.error(f"no program {command[0]}: install it, or set ENFILADE to the path of enfilade")
    return options, command


def positive(text: str) -> int:
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError("expected a number from 1")
    return number


def shard_command(command: Sequence[str], shard: str) -> list[str]:
    """Returns the command of a shard, such as "0/8"."""
    return [*without(OF_MERGE | of_verb(OF_MERGE_OF_VERB, command), command), "--shard", shard]


def merge_command(command: Sequence[str]) -> list[str]:
    return [*without(of_verb(OF_SHARDS_OF_VERB, command), command), "--merge"]


def of_verb(options: Mapping[str, dict[str, int]], command: Sequence[str]) -> dict[str, int]:
    return next((options[word] for word in command if word in options), {})


def without(options: Mapping[str, int], command: Sequence[str]) -> list[str]:
    """Leaves out options, with their values: `-o FILE`, `-oFILE`, `--json FILE` or `--json=FILE`."""
    words: list[str] = []
    rest = iter(command)
    for word in rest:
        name = word.split("=")[0] if word.startswith("--") else word[:2]
        if name not in options:
            words.append(word)
        elif word == name:
            for _ in range(options[name]):
                next(rest, None)
    return words


def run_shard(command: list[str], folder: str) -> tuple[str, float, str]:
    """Runs the command of a shard in `folder`. A task: runs on a worker.

    Returns the worker, the seconds and what was written to standard error.
    """
    worker = get_worker()
    key = worker.get_current_task()
    for path, is_there in ((folder, os.path.isdir(folder)), (command[0], shutil.which(command[0]))):
        if not is_there:
            raise RuntimeError(f"{worker.address} has no {path}: workers need the files and programs of this machine")

    def is_wanted() -> bool:
        task = worker.state.tasks.get(key)
        is_open = worker.status.name not in ("closing", "closed", "failed")
        return is_open and task is not None and task.state != "cancelled"

    start = time.monotonic()
    with tempfile.TemporaryFile() as errors:
        guarded = [sys.executable, "-I", "-c", GUARD, *command]
        with subprocess.Popen(
            guarded,
            cwd=folder,
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=errors,
            start_new_session=True,
        ) as guard:
            while guard.returncode is None and is_wanted():
                with suppress(subprocess.TimeoutExpired):
                    guard.wait(timeout=0.2)
            is_killed = guard.poll() is None
        errors.seek(max(0, errors.seek(0, os.SEEK_END) - 10_000))
        text = errors.read().decode(errors="replace").strip()
    if is_killed:
        raise Reschedule
    if guard.returncode not in (0, CHECK_FAILED):
        raise RuntimeError(f"exit status {guard.returncode} on {worker.address}\n{text}")
    return worker.address, time.monotonic() - start, text


def run_shards(client: Client, command: list[str], count: int, retries: int) -> bool:
    """Runs all shards, and reports each. Returns `False` as soon as one fails. Closing the client cancels the others."""
    run = uuid.uuid4().hex
    commands = [shard_command(command, f"{index}/{count}") for index in range(count)]
    futures = {}

    # A nested function is sent with all that it calls, so workers need `distributed` alone.
    def task(words: list[str], folder: str) -> tuple[str, float, str]:
        return run_shard(words, folder)

    for words in commands:
        key = f"enfilade-{words[-1]}-{run}"
        future = client.submit(task, words, os.getcwd(), key=key, pure=False, retries=retries)
        futures[future] = words
    for done, future in enumerate(as_completed(list(futures)), 1):
        words = futures[future]
        try:
            worker, seconds, text = future.result()
        except KilledWorker as why:
            tell(f"error: shard {words[-1]}: {why.allowed_failures + 1} workers died while they ran it; out of memory?")
            tell(f"  {shlex.join(words)}")
            return False
        except Exception as why:
            if future.cancelled():
                tell("error: the connection to the scheduler is lost; run the same command again to go on")
                return False
            tell(f"error: shard {words[-1]} failed, after {retries} retries: {why}\n  {shlex.join(words)}")
            return False
        tell(f"shard {words[-1]}: {seconds:.1f} s on {worker}, {done} of {count} done")
        if text:
            tell(text)
    return True


def tell(text: str) -> None:
    """Prints to standard error: standard output is that of the merge."""
    print(text, file=sys.stderr, flush=True)


def connect(options: argparse.Namespace) -> Client:
    """Connects to the scheduler, or starts one with its workers."""
    if options.scheduler is None:
        dask.config.set({"distributed.scheduler.allowed-failures": options.retries})
        return Client(
            n_workers=options.local_workers,
            threads_per_worker=1,
            # A shard is a process of its own, which Dask would not count.
            memory_limit=0,
            dashboard_address=None,
            silence_logs=logging.CRITICAL,
        )
    if os.path.isfile(options.scheduler):
        return Client(scheduler_file=options.scheduler)
    return Client(options.scheduler)


def main(arguments: Sequence[str] | None = None) -> int:
    options, command = parse(sys.argv[1:] if arguments is None else arguments)
    # Its messages, with tracebacks, repeat what is told here.
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)
    # As Ctrl-C: schedulers of clusters end jobs so.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        try:
            client = connect(options)
        except (OSError, ValueError) as why:
            tell(f"error: cannot connect to {options.scheduler}: {why}")
            return FAILED
        with client:
            if not client.scheduler_info()["workers"]:
                tell("waiting for a worker")
            if not run_shards(client, command, options.shards, options.retries):
                return FAILED
        merge = merge_command(command)
        tell(shlex.join(merge))
        return subprocess.run(merge).returncode
    except KeyboardInterrupt:
        tell("interrupted: run the same command again to go on")
        return INTERRUPTED


if __name__ == "__main__":
    sys.exit(main())
