#!/usr/bin/env python3
"""Decisions of tools/compare --guard on samples whose truth is known: test_guard.py"""
import random
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "tools"))
sys.dont_write_bytecode = True
from comparison import guard  # noqa: E402

PHASE = ("case", "phase")


def samples(slower, seed, noise=0.05, spell=0.0, turns=20, lucky=None):
    """Turns of two programs. Noise only slows, by turn and program; a spell slows one of them in half of the turns."""
    chance = random.Random(seed)
    before = [10.0 * (1.0 + noise * chance.random() + (spell if turn % 2 else 0.0)) for turn in range(turns)]
    now = [10.0 * slower * (1.0 + noise * chance.random()) for _ in range(turns)]
    if lucky is not None:
        before[turns // 2] = lucky
    return {PHASE: (before, now)}


def decide(first, again):
    return guard.confirmed(guard.suspects(first, guard.THRESHOLD), first, again, guard.THRESHOLD)


def main():
    wrong = []

    def expect(what, found, expected):
        if found != expected:
            wrong.append(f"{what}: {found} instead of {expected}")

    for seed in range(50):
        expect("equal programs", guard.suspects(samples(1.0, seed), guard.THRESHOLD), [])
        expect("a slowdown of 15 %", decide(samples(1.15, seed), samples(1.15, seed + 99)), [PHASE])
        # The medians of the first measurement are equal: 10.2 * 1.15 beside the mean of 10.2 and 13.2.
        expect("a slowdown of 15 % in a spell of noise",
               decide(samples(1.15, seed, spell=0.3), samples(1.15, seed + 99)), [PHASE])
        expect("one lucky run before", decide(samples(1.0, seed, lucky=8.0), samples(1.0, seed + 99)), [])
        expect("a slowdown of 5 %", decide(samples(1.05, seed), samples(1.05, seed + 99)), [])
        expect("a phase that is too short",
               guard.suspects({PHASE: ([0.1] * 9, [0.2] * 9)}, guard.THRESHOLD), [])
    # A drift of the machine that is as large as the slowdown meets both programs of a turn.
    drift = [10.0 + 0.1 * turn for turn in range(40)]
    expect("the ratio of turns in a drift", round(guard.ratios(drift, [1.2 * x for x in drift])[0], 9), 1.2)
    sys.exit("\n".join(wrong) or 0)


if __name__ == "__main__":
    main()
