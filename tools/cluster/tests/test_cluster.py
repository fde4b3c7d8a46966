"""Bakes small tiles in shards, while workers are killed, commands fail and runs are interrupted.

Needs Linux or macOS, and `enfilade` on PATH or its path in ENFILADE.
"""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest
from collections import Counter
from contextlib import suppress
from pathlib import Path

import psutil
from distributed import Client

PACKAGE = Path(__file__).resolve().parents[1]
# As the installed script does, so that the module has its name.
RUN = f"import sys; sys.path.append({str(PACKAGE)!r}); import enfilade_cluster; sys.exit(enfilade_cluster.main())"
SHARDS = 4
TILES = 7
SECONDS = 120
"""Longest time of a test."""

# In place of enfilade. Notes each start. The first run of shard 1/4 says its process id, and then waits for a gate that
# nobody opens, so that what happens to it happens while it runs. Only a process that lives holds `alive` open.
WAITING = """#!/bin/sh
echo "$*" >> "$TEST_FOLDER/starts"
case "$*" in *"--shard 1/4")
    if mkdir "$TEST_FOLDER/waits" 2> /dev/null; then
        exec 3> "$TEST_FOLDER/alive"
        echo $$ >&3
        read line < "$TEST_FOLDER/gate"
    fi
esac
exec "$REAL_ENFILADE" "$@"
"""


def program() -> str:
    found = os.environ.get("ENFILADE") or shutil.which("enfilade")
    if not found or not shutil.which(found):
        sys.exit(f"error: no program {found or 'enfilade'}: set ENFILADE to the path of enfilade")
    return os.path.abspath(found)


def write_tile(path: Path, number: int) -> None:
    """Writes a field of small pyramids, `number` units beside the first tile."""
    lines: list[str] = []
    for row in range(8):
        for column in range(8):
            x, z, height = number * 10 + column, row, 1 + (row * column + number) % 5
            corners = [(x, 0, z), (x, 0, z + 1), (x + 1, 0, z + 1), (x + 1, 0, z), (x + 0.5, height, z + 0.5)]
            lines += [f"v {x} {y} {z}" for x, y, z in corners]
            lines += [f"f {-5 + side} {-5 + (side + 1) % 4} -1" for side in range(4)]
    path.write_text("\n".join(lines) + "\n")


def end(process: psutil.Process) -> None:
    with suppress(psutil.NoSuchProcess):
        process.kill()


def too_long(*_: object) -> None:
    raise TimeoutError(f"the test takes longer than {SECONDS} s")


class Cluster(unittest.TestCase):
    def setUp(self) -> None:
        signal.signal(signal.SIGALRM, too_long)
        # Shells start processes in the background with SIGINT ignored, which children would inherit.
        signal.signal(signal.SIGINT, signal.default_int_handler)
        signal.alarm(SECONDS)
        self.addCleanup(signal.alarm, 0)
        self.folder = Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        (self.folder / "parts").mkdir()
        self.tiles = [f"tile-{number}.obj" for number in range(TILES)]
        for number, tile in enumerate(self.tiles):
            write_tile(self.folder / tile, number)
        self.environment = os.environ | {"ENFILADE": program(), "REAL_ENFILADE": program(), "TEST_FOLDER": str(self.folder)}

    def use_program(self, script: str) -> None:
        """Makes the shell script what runs in place of enfilade."""
        path = self.folder / "program"
        path.write_text(script)
        path.chmod(0o755)
        self.environment["ENFILADE"] = str(path)

    def start(self, *words: str) -> subprocess.Popen[str]:
        """Starts a process that ends with the test."""
        process = subprocess.Popen(
            [sys.executable, *words],
            cwd=self.folder,
            env=self.environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        return process

    def start_run(self, *options: str, command: list[str] | None = None) -> subprocess.Popen[str]:
        command = command or ["enfilade", "bake", *self.tiles, "--parts", "parts", "-o", "town.enf"]
        return self.start("-c", RUN, *options, "--shards", str(SHARDS), "--", *command)

    def start_cluster(self, workers: int) -> tuple[Client, dict[int, subprocess.Popen[str]]]:
        """Starts a scheduler and workers, each a process of its own. Returns a client, and the workers by process id."""
        file = str(self.folder / "scheduler.json")
        scheduler = ["--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--dashboard-address", ":0"]
        self.start("-m", "dask", "scheduler", "--scheduler-file", file, *scheduler)
        worker = ["--host", "127.0.0.1", "--no-nanny", "--nthreads", "1", "--no-dashboard"]
        started = [self.start("-m", "dask", "worker", "--scheduler-file", file, *worker) for _ in range(workers)]
        client = Client(scheduler_file=file)
        self.addCleanup(client.close)
        client.wait_for_workers(workers, timeout=SECONDS)
        return client, {worker.pid: worker for worker in started}

    def wait_for_shard(self) -> psutil.Process:
        """Returns the process of shard 1/4, which runs and waits."""
        # Opening a pipe waits for the other end.
        self.alive = (self.folder / "alive").open()
        self.addCleanup(self.alive.close)
        shard = psutil.Process(int(self.alive.readline()))
        self.addCleanup(end, shard)
        return shard

    def wait_for_end_of_shard(self) -> None:
        """Waits until the system has closed what the process of shard 1/4 held open."""
        self.assertEqual(self.alive.read(), "")

    def use_waiting_program(self) -> None:
        self.use_program(WAITING)
        os.mkfifo(self.folder / "alive")
        os.mkfifo(self.folder / "gate")

    def starts(self) -> Counter[str]:
        """Returns how many times each shard, and the merge, was started."""
        lines = (self.folder / "starts").read_text().splitlines()
        return Counter(line.split()[-1] for line in lines)

    def assert_same_as_one_run(self) -> None:
        one_run = [program(), "bake", *self.tiles, "-o", "town.enf"]
        merged = (self.folder / "town.enf").read_bytes()
        subprocess.run(one_run, cwd=self.folder, check=True, capture_output=True)
        self.assertEqual(merged, (self.folder / "town.enf").read_bytes())

    def lose_a_worker(self, ends_by: signal.Signals) -> None:
        self.use_waiting_program()
        client, workers = self.start_cluster(2)
        # The loss of a worker is no failure of the shard.
        run = self.start_run("--scheduler", client.scheduler.address, "--retries", "0")
        shard = self.wait_for_shard()
        [worker] = {parent.pid for parent in shard.parents()} & workers.keys()
        os.kill(worker, ends_by)
        self.wait_for_end_of_shard()
        workers[worker].communicate()

        _, report = run.communicate()
        self.assertEqual(run.returncode, 0, report)
        self.assertIn(f"{SHARDS} of {SHARDS} done", report)
        self.assertEqual(self.starts(), {"0/4": 1, "1/4": 2, "2/4": 1, "3/4": 1, "--merge": 1})
        self.assertEqual(len(client.scheduler_info()["workers"]), 1)
        self.assert_same_as_one_run()

    def test_a_killed_worker_takes_its_shard_along_and_another_runs_it_again(self) -> None:
        self.lose_a_worker(signal.SIGKILL)

    def test_a_worker_that_is_asked_to_stop_does_so_too(self) -> None:
        self.lose_a_worker(signal.SIGTERM)

    def interrupt(self, how: signal.Signals) -> None:
        self.use_waiting_program()
        client, _ = self.start_cluster(2)
        run = self.start_run("--scheduler", str(self.folder / "scheduler.json"))
        self.wait_for_shard()
        run.send_signal(how)
        self.wait_for_end_of_shard()
        _, report = run.communicate()
        self.assertEqual(run.returncode, 130, report)
        self.assertEqual(len(client.scheduler_info()["workers"]), 2)
        self.assertNotIn("--merge", self.starts())

        again = self.start_run("--scheduler", client.scheduler.address)
        _, report = again.communicate()
        self.assertEqual(again.returncode, 0, report)
        self.assert_same_as_one_run()

    def test_an_interrupted_run_stops_its_shards_and_can_go_on(self) -> None:
        self.interrupt(signal.SIGINT)

    def test_a_run_that_is_asked_to_stop_does_so_too(self) -> None:
        self.interrupt(signal.SIGTERM)

    def test_a_local_cluster_bakes_the_same_bytes(self) -> None:
        run = self.start_run("--local-workers", "2")
        output, report = run.communicate()
        self.assertEqual(run.returncode, 0, report)
        self.assertIn("town.enf: 1 room", output)
        self.assert_same_as_one_run()

    def test_a_shard_that_fails_is_run_again_and_then_shown(self) -> None:
        self.use_waiting_program()
        (self.folder / "waits").mkdir()
        (self.folder / "tile-1.obj").unlink()
        run = self.start_run("--local-workers", "1", "--retries", "2")
        _, report = run.communicate()
        self.assertEqual(run.returncode, 2, report)
        self.assertIn("error: shard 1/4 failed, after 2 retries: exit status 2", report)
        self.assertIn("tile-1.obj", report)
        self.assertIn("--parts parts --shard 1/4", report)
        self.assertEqual([self.starts()["1/4"], self.starts()["--merge"]], [3, 0])

    def test_a_failed_check_is_no_failed_run(self) -> None:
        self.use_program('#!/bin/sh\necho "$*" >> "$TEST_FOLDER/starts"\necho "1 false cull" >&2\nexit 1\n')
        command = ["enfilade", "look", "a.glb", "--survey", "4", "--check", "--parts", "parts", "--json", "all.json"]
        run = self.start_run("--local-workers", "1", command=command)
        _, report = run.communicate()
        self.assertEqual(run.returncode, 1, report)
        self.assertIn("1 false cull", report)
        lines = (self.folder / "starts").read_text().splitlines()
        shards = [f"look a.glb --survey 4 --check --parts parts --shard {index}/4" for index in range(SHARDS)]
        self.assertEqual(sorted(lines[:-1]), shards)
        self.assertEqual(lines[-1], "look a.glb --parts parts --json all.json --merge")

    def test_shards_and_merge_get_the_options_that_they_take(self) -> None:
        sys.path.append(str(PACKAGE))
        from enfilade_cluster import merge_command, shard_command

        cases = [
            ("e bake a b --parts p -o c", "e bake a b --parts p --shard 1/2", "e bake a b --parts p -o c --merge"),
            ("e bake a -oc --parts=p --json=j", "e bake a --parts=p --shard 1/2", "e bake a -oc --parts=p --json=j --merge"),
            (
                "e vis a --resume --check=9 --compare b --output c --parts p",
                "e vis a --resume --parts p --shard 1/2",
                "e vis a --resume --check=9 --compare b --output c --parts p --merge",
            ),
            (
                "e look a --parts p --check=4 --survey-hard 9 --method=all --json j --size 9x9",
                "e look a --parts p --check=4 --survey-hard 9 --method=all --size 9x9 --shard 1/2",
                "e look a --parts p --json j --size 9x9 --merge",
            ),
        ]
        for command, shard, merge in cases:
            with self.subTest(command):
                self.assertEqual(shard_command(command.split(), "1/2"), shard.split())
                self.assertEqual(merge_command(command.split()), merge.split())

    def test_wrong_arguments_are_explained(self) -> None:
        bake = ["--", "enfilade", "bake", "a.glb", "--parts", "parts", "-o", "a.enf"]
        local = ["--local-workers", "1", "--shards", "2"]
        cases = [
            ([*local], "no command"),
            ([*local, "--"], "no command"),
            (["--shards", "2", *bake], "--scheduler --local-workers is required"),
            (["--local-workers", "1", *bake], "required: --shards"),
            (["--local-workers", "1", "--shards", "0", *bake], "--shards: expected a number from 1"),
            ([*local, "--retries", "-1", *bake], "--retries: expected a number from 0"),
            ([*local, "--scheduler", "tcp://a:1", *bake], "not allowed with"),
            ([*local, *bake, "--shard=0/2"], "--shard is added"),
            ([*local, *bake, "--merge"], "--merge is added"),
            ([*local, *bake[:4], "-o", "a.enf"], "no --parts FOLDER"),
            ([*local, "--", "./missing", *bake[2:]], "missing: install it, or set ENFILADE"),
            (["--scheduler", "no-file.json", "--shards", "2", *bake], "cannot connect to no-file.json"),
        ]
        for words, message in cases:
            with self.subTest(words):
                run = self.start("-c", RUN, *words)
                _, report = run.communicate()
                self.assertEqual(run.returncode, 2)
                self.assertIn(message, report)


if __name__ == "__main__":
    unittest.main()
