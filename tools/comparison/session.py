"""A peer's process: starts it, asks it to run, and ends it. docs/benchmark.md and docs/benchmark-physics.md have the
protocol.
"""
import os
import select
import subprocess
import time
from pathlib import Path

from . import machine


class Failed(Exception):
    """What a peer did instead of breaking the mesh."""


class Session:
    DONE = "done MILLISECONDS PIECES"  # the answer to a run

    def __init__(self, peer, threads, inputs, limit, log):
        """`inputs`: the files of the case, which the adapter gets before the threads and its own words."""
        self.peer, self.threads, self.limit, self.log = peer, threads, limit, Path(log)
        self.version = peer.name
        self.samples, self.pieces, self.memory, self.memory_ready, self.failure = [], 0, 0.0, 0.0, ""
        self.buffer = b""
        words = [*peer.command, *inputs, str(threads), *peer.words]
        with open(self.log, "wb") as errors:
            try:
                self.process = subprocess.Popen([str(word) for word in words], stdin=subprocess.PIPE,
                                                stdout=subprocess.PIPE, stderr=errors, cwd=peer.folder)
            except OSError as error:
                self.process = None
                raise Failed(f"cannot be started: {error.strerror}") from error
        try:
            self.version = self.answer("ready", limit).partition(" ")[2] or peer.name
        except Failed:
            self.end()
            raise
        self.memory_ready = machine.memory_of(self.process.pid, "VmRSS")

    def answer(self, word, seconds):
        """The next line of the process that begins with the word. Other lines are its own affair."""
        deadline = time.monotonic() + seconds
        while True:
            line, found, rest = self.buffer.partition(b"\n")
            if found:
                self.buffer = rest
                text = line.decode(errors="replace").strip()
                if text.split(" ")[0] == word:
                    return text
                if text.startswith("failed"):
                    raise Failed(text[7:] or "failed without a reason")
                continue
            left = deadline - time.monotonic()
            if left <= 0:
                raise Failed(f"no end within {seconds:.0f} s")
            if select.select([self.process.stdout], [], [], left)[0]:
                data = os.read(self.process.stdout.fileno(), 1 << 16)
                if not data:
                    raise Failed(self.how_it_ended())
                self.buffer += data

    def how_it_ended(self):
        try:
            code = self.process.wait(5)
        except subprocess.TimeoutExpired:
            return "closed its output"
        last = self.log.read_text(errors="replace").strip().splitlines()[-1:]
        how = f"ended by signal {-code}" if code < 0 else f"ended with exit code {code}"
        return how + (f": {last[0][:160]}" if last else "")

    def ask(self, request, word, seconds):
        try:
            self.process.stdin.write((request + "\n").encode())
            self.process.stdin.flush()
        except OSError as error:
            raise Failed(self.how_it_ended()) from error
        return self.answer(word, seconds)

    def take(self, values):
        """The words after `done`."""
        self.samples.append(float(values[0]))
        self.pieces = int(values[1])

    def run(self):
        """One repetition."""
        words = self.ask("run", "done", self.limit).split()
        try:
            self.take(words[1:])
        except (IndexError, ValueError) as error:
            raise Failed(f"answers '{' '.join(words)}' instead of '{self.DONE}'") from error
        self.memory = max(self.memory, machine.memory_of(self.process.pid))

    def write(self, name):
        self.ask(f"write {name}", "written", self.limit)

    def kill(self):
        if self.process is not None:
            self.process.kill()
            self.end()

    def end(self):
        if self.process is None:
            return
        try:
            self.process.stdin.close()
        except OSError:
            pass  # it has ended
        try:
            self.process.wait(2)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self.process.stdout.close()
        self.process = None
