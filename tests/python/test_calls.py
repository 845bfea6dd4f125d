"""Cancellation, threads and memory."""
import os
import signal
import subprocess
import sys
import threading
import time

import brittle
import pytest


def resident_bytes() -> int:
    with open("/proc/self/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def test_memory_of_ten_thousand_fractures_is_constant():
    cube = brittle.shape("cube")

    def work(count: int) -> None:
        for seed in range(count):
            broken = brittle.fracture(cube, 6, seed=seed, threads=1)
            broken.pieces[0].vertices.sum()
            brittle.Mesh(cube.vertices, cube.faces)

    work(1000)
    before = resident_bytes()
    work(10_000)
    assert resident_bytes() - before < 4 << 20  # a leak of 420 bytes a fracture would be seen


def test_other_threads_run_during_a_fracture(bunny):
    beats, ended = [], threading.Event()

    def beat() -> None:
        while not ended.is_set():
            beats.append(time.perf_counter())
            time.sleep(0.001)

    thread = threading.Thread(target=beat)
    thread.start()
    begin = time.perf_counter()
    brittle.fracture(bunny, 20_000, threads=1)
    end = time.perf_counter()
    ended.set()
    thread.join()
    during = [begin] + [t for t in beats if begin < t < end] + [end]
    longest = max(b - a for a, b in zip(during, during[1:]))
    assert longest < 0.5 * (end - begin)  # with the lock held it would be all of it


def test_threads_break_meshes_at_once(bunny):
    expected = {seed: brittle.fracture(bunny, 40, seed=seed).hash for seed in range(4)}
    found: dict = {}

    def work(seed: int) -> None:
        found[seed] = brittle.fracture(bunny, 40, seed=seed).hash

    threads = [threading.Thread(target=work, args=(seed,)) for seed in expected]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == expected


def test_token_cancels_from_another_thread(bunny):
    token = brittle.CancelToken()
    timer = threading.Timer(0.2, token.cancel)
    timer.start()
    with pytest.raises(brittle.Cancelled):
        brittle.fracture(bunny, 300_000, cancel=token)
    timer.join()
    assert token.cancelled


def test_progress_rises_to_one_and_its_exceptions_come_through(bunny):
    shares: list = []
    brittle.fracture(bunny, 2000, progress=shares.append)
    assert shares == sorted(shares) and shares[-1] == 1.0 and len(shares) > 3

    def fail(_share: float) -> None:
        raise KeyError("from the callback")

    with pytest.raises(KeyError, match="from the callback"):
        brittle.fracture(bunny, 2000, progress=fail)


def test_interrupt_key_ends_a_fracture():
    program = ("import brittle\nmesh = brittle.load('/usr/share/glmark2/models/bunny.obj')\n"
               "sites = brittle.make_sites(mesh, 400_000)\nprint('ready', flush=True)\n"
               "try:\n    brittle.fracture(mesh, sites, threads=1)\n    print('done')\n"
               "except KeyboardInterrupt:\n    print('interrupted')\n"
               "print(brittle.fracture(mesh, 5).certificate.closed)\n")
    process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None and process.stdout.readline() == "ready\n"
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    output, _ = process.communicate(timeout=60)
    assert output == "interrupted\nTrue\n"
