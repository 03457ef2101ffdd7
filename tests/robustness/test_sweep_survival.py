"""Sweeps that are stopped, killed, or run out of disk, and Dask clusters, in real processes."""

import os
import signal
import subprocess
import sys
import time
from concurrent.futures import BrokenExecutor, Executor, Future
from contextlib import contextmanager

import pytest
from distributed import Client, LocalCluster

import gallop_fmu as gf
from gallop_fmu.sweeps.cases import cases
from gallop_fmu.sweeps.journal import journal_of
from gallop_fmu.sweeps.pool import Workers, WorkersLostError
from gallop_fmu.sweeps.runner import compute
from support.sweeps import same

WINDS = [4.0 + 0.1 * k for k in range(16)]
CHANGES = {"numerics.elements": 4, "numerics.time_step": 0.02, "run.record_every": 5}
STOP_TIME = 250.0

needs_posix = pytest.mark.skipif(os.name == "nt", reason="signals and limits of POSIX")


def _scene():
    return gf.load_scene("example3").with_values(CHANGES)


def _command(out):
    words = [
        "sweep",
        "example3",
        "--over",
        "wind.speed=4:5.5:0.1",
        "--stop-time",
        str(STOP_TIME),
        "--workers",
        "1",
        "--out",
        str(out),
    ]
    for key, value in CHANGES.items():
        words += ["--set", f"{key}={value}"]
    return [sys.executable, "-P", "-c", "from gallop_fmu.cli.main import main; main()", *words]


def _begun(begin, out, rows):
    """The command as a process, once so many rows are there."""
    process = begin(_command(out), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    journal = journal_of(out)
    until = time.monotonic() + 120.0
    while journal.read_bytes().count(b"\n") < 1 + rows:
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < until
        time.sleep(0.02)
    return process


@contextmanager
def _cluster(folder):
    """The address of a scheduler and its two workers, processes started by Dask's own command."""
    command = [
        sys.executable,
        "-m",
        "distributed.cli.dask_worker",
        "--no-nanny",
        "--nthreads",
        "1",
        "--no-dashboard",
    ]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    scheduler = LocalCluster(
        n_workers=0, host="127.0.0.1", protocol="tcp", processes=False, dashboard_address=None
    )
    with scheduler:
        started = [
            subprocess.Popen([*command, scheduler.scheduler_address], cwd=folder, **quiet)
            for _ in range(2)
        ]
        try:
            with Client(scheduler.scheduler_address, set_as_default=False) as client:
                client.wait_for_workers(2, timeout=60.0)
            yield scheduler.scheduler_address, started
        finally:
            for process in started:
                process.kill()
                process.wait()


@pytest.fixture(scope="module")
def complete():
    """The sweep without interruption."""
    winds = [round(wind, 12) for wind in WINDS]
    return gf.sweep(_scene(), {"wind.speed": winds}, stop_time=STOP_TIME)


@needs_posix
def test_a_sweep_resumes_after_every_kind_of_stop(tmp_path, begin, complete):
    """A full disk, a kill and Ctrl-C, each in a process that resumes the previous one."""
    out = tmp_path / "runs.nc"
    kept = _disk_full(out)
    kept = _killed(begin, out, kept)
    kept = _interrupted(begin, out, kept)
    calls, winds = [], complete.dataset["wind.speed"].values
    runs = gf.sweep(
        _scene(),
        {"wind.speed": winds},
        stop_time=STOP_TIME,
        out=out,
        progress=lambda *n: calls.append(n),
    )
    assert calls[0] == (kept, 0, 16)
    assert same(runs, complete)
    assert same(gf.read_runs(out), complete)
    assert sorted(file.name for file in tmp_path.iterdir()) == ["runs.nc", "runs.nc.journal"]


def _disk_full(out):
    """File sizes are limited: the journal has some rows and a part of one, the results none."""
    import resource

    limit = 10_000

    def limited():
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

    done = subprocess.run(
        _command(out),
        capture_output=True,
        text=True,
        preexec_fn=limited,
        timeout=120,
        check=False,
    )
    assert done.returncode == 1
    assert journal_of(out).stat().st_size == limit
    kept = gf.read_runs(out).done
    assert 2 <= kept < 12
    assert (
        f"{out} cannot be written (File too large). {kept} of 16 runs are done and kept in"
        f" {journal_of(out)}. " in done.stderr
    )
    assert "Traceback" not in done.stderr
    assert [file.name for file in out.parent.iterdir()] == ["runs.nc.journal"]
    return kept


def _killed(begin, out, before):
    process = _begun(begin, out, before + 2)
    process.kill()
    process.communicate()
    assert process.returncode == -signal.SIGKILL
    kept = gf.read_runs(out).done
    assert before + 2 <= kept < 16
    journal_of(out).write_bytes(
        journal_of(out).read_bytes() + b'{"run": 23, "wind.sp'
    )  # it may end within a line
    return kept


def _interrupted(begin, out, before):
    process = _begun(begin, out, before + 2)
    process.send_signal(signal.SIGINT)
    printed, messages = process.communicate(timeout=60)
    assert process.returncode == 1, messages
    kept = gf.read_runs(out).done
    assert before + 2 <= kept < 16
    assert (
        f"gallop-fmu: stopped on request. {kept} of 16 runs are done and kept in {out}. "
        "The same call again computes the rest." in messages
    )
    assert "Traceback" not in messages
    assert out.exists()
    assert f"wrote {out}: {kept} of 16 runs" in printed
    return kept


def test_dask_cluster_gives_the_same(tmp_path, complete, monkeypatch):
    """A real scheduler and two worker processes, which are killed at the end."""
    winds = complete.dataset["wind.speed"].values
    calls = []
    with _cluster(tmp_path) as (address, started):
        runs = gf.sweep(
            _scene(),
            {"wind.speed": winds},
            stop_time=STOP_TIME,
            out=tmp_path / "runs.nc",
            cluster=address,
            progress=lambda *n: calls.append(n),
        )
        assert same(runs, complete)
        assert calls[-1] == (16, 0, 16)
        # Failures come back too: one scene that is not allowed, one that leaves its curve, and one
        # summary that raises.
        table = [
            {"wind.speed": 151.0},
            {"aerodynamics.valid_to_deg": 180.5, "initial.seed_vertical": 0.3},
        ]
        failed = gf.sweep(_scene(), table=table, stop_time=20.0, cluster=address)
        assert failed.dataset.outcome.values.tolist() == ["invalid_scene", "angle_out_of_range"]

        def failing(result):
            raise ZeroDivisionError("for a test")

        failed = gf.sweep(
            _scene(), {"wind.speed": [4.0]}, stop_time=1.0, summary=failing, cluster=address
        )
        assert failed.dataset.message.values.tolist() == ["ZeroDivisionError: for a test"]

        # A scheduler without workers would never answer its clients.
        monkeypatch.setattr("gallop_fmu.sweeps.pool.LOST_TIMEOUT", 0.2)

        def kill(done, *_):
            for process in started if done else ():
                process.kill()

        lost = (
            rf"the cluster has had no workers for 0.2 s; start dask worker {address}. \d+ of 16"
            r" runs are done and kept"
        )
        with pytest.raises(gf.RunsStoppedError, match=lost):
            gf.sweep(_scene(), {"wind.speed": winds}, stop_time=1.0, cluster=address, progress=kill)
    assert len(runs.dataset.run) == 16


@pytest.mark.parametrize(
    ("address", "fragment"),
    [
        (
            "tls://localhost:8786",
            r"tls needs certificates; name them in Dask's configuration \(distributed.comm.tls\)",
        ),
        (
            "http://localhost:8786",
            "must be the address of a Dask scheduler with its port, such as tcp://localhost:8786",
        ),
        ("inproc://1/2/3:8786", "must be the address"),
        ("tcp://localhost:99999", "must be the address"),
        ("tcp://:8786", "must be the address"),
        ("localhost", "must be the address"),
    ],
)
def test_addresses_of_no_cluster(address, fragment):
    """In some of these cases Dask waits for two minutes and then raises its own error."""
    with pytest.raises(gf.SceneError, match=fragment):
        gf.sweep(_scene(), {"wind.speed": [4.0]}, stop_time=1.0, cluster=address)


def test_cluster_that_is_not_there(monkeypatch):
    monkeypatch.setattr("gallop_fmu.sweeps.pool.CONNECTION_TIMEOUT", 0.5)
    with pytest.raises(
        gf.SceneError, match=r"cluster = 'tcp://127.0.0.1:1': no Dask scheduler answers"
    ):
        gf.sweep(_scene(), {"wind.speed": [4.0]}, stop_time=1.0, cluster="tcp://127.0.0.1:1")


def test_worker_process_that_dies(tmp_path):
    """Its runs are missing; the rows of other workers are kept."""

    class Deadly:  # local, so that it travels whole to a process that cannot import this file
        kind = "processes"
        columns = property(lambda self: {})

        def __call__(self, scenes, carry_on):
            if scenes[0].wind.speed == 5.0:
                while journal.read_bytes().count(b"\n") < 2:  # header, and the other row
                    time.sleep(0.02)
                os._exit(1)
            return [{"outcome": "completed", "message": "", "seconds": 0.0}]

    out = tmp_path / "runs.nc"
    journal = journal_of(out)
    work = cases(_scene(), {"wind.speed": [4.0, 5.0]})
    with pytest.raises(
        gf.RunsStoppedError,
        match=r"a worker process was killed.* 1 of 2 runs are done and kept",
    ):
        compute(work, Deadly(), out=out, count=2)
    assert gf.read_runs(out).dataset["wind.speed"].values.tolist() == [4.0]


def test_answers_that_came_before_the_loss_was_seen():
    class Losing(Executor):
        def submit(self, function, item):
            if item == 2:
                raise BrokenExecutor
            answer = Future()
            answer.set_result(function(item))
            return answer

    answers = Workers(Losing(), 1, has_shared_memory=False).answers(
        lambda item: 10 * item, [1, 2, 3]
    )
    assert next(answers) == (1, 10)
    with pytest.raises(WorkersLostError):
        next(answers)


def test_task_that_a_worker_process_cannot_load():
    class Foreign:
        kind = "processes"
        columns = property(lambda self: {})

        def __reduce__(self):
            return int, ("a module that is only here",)

    with pytest.raises(
        gf.RunsStoppedError,
        match=r"the worker processes failed: A task has failed .*\(ValueError: invalid literal",
    ):
        compute(cases(_scene(), {"wind.speed": [4.0]}), Foreign(), count=2)
