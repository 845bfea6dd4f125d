"""The machine, and how busy others keep it."""
import os
import platform
import time
from pathlib import Path

TICK = os.sysconf("SC_CLK_TCK")


def text_of(path):
    try:
        return Path(path).read_text(encoding="utf-8", errors="replace").strip()
    except OSError:
        return ""


def describe():
    model = next((line.partition(":")[2].strip() for line in text_of("/proc/cpuinfo").splitlines()
                  if line.startswith("model name")), platform.machine())
    kibibytes = next((int(line.split()[1]) for line in text_of("/proc/meminfo").splitlines()
                      if line.startswith("MemTotal")), 0)
    return {"processor": model, "cores": os.cpu_count() or 1, "memory": f"{kibibytes / 2**20:.0f} GiB",
            "governor": text_of("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor") or "not shown by this machine",
            "system": text_of("/etc/os-release").partition('PRETTY_NAME="')[2].partition('"')[0] or platform.system(),
            "kernel": platform.release()}


def load():
    return os.getloadavg()[0]


def busy_seconds():
    """Processor time of all processes since the start, with what a hypervisor took. Interrupts belong to no process: those
    that a command causes would count as work of others."""
    user, nice, system, _, _, _, _, steal = map(int, text_of("/proc/stat").split("\n")[0].split()[1:9])
    return (user + nice + system + steal) / TICK


def seconds_of(pid):
    """Processor time of a process with its threads, 0 once it has ended."""
    fields = text_of(f"/proc/{pid}/stat").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICK if len(fields) > 12 else 0.0


def settle(quiet=0.02, interval=0.3, limit=10.0):
    """Waits until nothing uses the machine: the kernel frees memory and writes files after a process has ended."""
    end = time.monotonic() + limit
    while time.monotonic() < end:
        before = busy_seconds()
        time.sleep(interval)
        if busy_seconds() - before <= quiet * interval * (os.cpu_count() or 1):
            return


class Others:
    """What neither this command nor the peers that it notes use of the machine, from its making on."""

    def __init__(self):
        self.begin, self.busy, self.own, self.noted = time.monotonic(), busy_seconds(), sum(os.times()[:4]), 0.0

    def note(self, pid):
        """Counts a child once, at its end. Children that have ended count as this command's own."""
        self.noted += seconds_of(pid)

    def share(self):
        used = self.noted + sum(os.times()[:4]) - self.own
        return max(0.0, busy_seconds() - self.busy - used) / ((time.monotonic() - self.begin) * (os.cpu_count() or 1))


def memory_of(pid, key="VmHWM"):
    """MiB; VmHWM is the peak so far, VmRSS the present value."""
    for line in text_of(f"/proc/{pid}/status").splitlines():
        if line.startswith(key + ":"):
            return int(line.split()[1]) / 1024
    return 0.0
