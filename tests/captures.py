#!/usr/bin/env python3
"""Captures that sigrok-cli writes, judged by the rig: tests/captures.py RIG.

A case is run by the rig. sigrok-cli takes its lines at 10 kHz, as a logic analyser would, and writes what it saw as
session, value change dump and table. `rig judge` must come to one verdict on all of them, the right one.
"""

import pathlib
import shutil
import subprocess
import sys
import tempfile

from vcdvcd import VCDVCD

RATE = 10_000
PROGRAM = """PROGRAM MAIN
VAR
    button AT %IX0.0 : BOOL;
    lamp AT %QX0.4 : BOOL;
    delay : TON;
END_VAR
delay(IN := button, PT := T#500ms);
lamp := delay.Q;
END_PROGRAM
"""
PLAN = """format = 1
title = "The lamp lights half a second after the button"
program = "lamp.st"
signals = {{ button = "%IX0.0", lamp = "%QX0.4" }}
steps = [{{ id = "press", at = "start + 1 s", set = {{ signal = "button", value = true }} }}]
expect = [{{ rises = {{ signal = "lamp", from = "press", within = "{within}", pulses-longer-than = "20 ms" }} }}]
"""
# What the plan allows, and what a lamp that lights 520.035 ms after the button comes to. A sampled edge of the last
# plan may lie on either side of its limit.
PLANS = {"pass": ("500 ms .. 550 ms", 0), "fail": ("490 ms .. 510 ms", 1), "open": ("500 ms .. 520.035 ms", 3)}


def run(*command, code=0, cwd=None):
    ran = subprocess.run([str(part) for part in command], capture_output=True, text=True, cwd=cwd, timeout=60)
    if ran.returncode != code:
        sys.exit(f"{command} gave {ran.returncode}, not {code}\n{ran.stdout}{ran.stderr}")
    return ran.stdout


def level(signal, at):
    """What a line is at an instant, 0 where it is not driven."""
    seen = "0"
    for when, raw in signal.tv:
        if when > at:
            break
        seen = raw
    return 1 if seen == "1" else 0


def sample(dump, work):
    """The lines of a dump as sigrok's raw samples: one byte each, the button in bit 0, the lamp in bit 1."""
    wave = VCDVCD(str(dump))
    button, lamp = wave["rig.button"], wave["rig.lamp"]
    last = max(when for signal in (button, lamp) for when, _ in signal.tv)
    count = last * RATE // 1_000_000_000 + RATE // 2
    period = 1_000_000_000 // RATE
    raw = bytes(level(button, n * period) | level(lamp, n * period) << 1 for n in range(count))
    (work / "lines.bin").write_bytes(raw)
    sigrok = ["sigrok-cli", "-I", f"binary:numchannels=2:samplerate={RATE}", "-i", work / "lines.bin"]
    run(*sigrok, "-o", work / "lines.sr")
    run("sigrok-cli", "-i", work / "lines.sr", "-O", "vcd", "-o", work / "lines.vcd")
    run("sigrok-cli", "-i", work / "lines.sr", "-O", "csv:time=true", "-o", work / "lines.csv")


def main():
    rig = pathlib.Path(sys.argv[1]).resolve()
    if shutil.which("sigrok-cli") is None:
        print("sigrok-cli is not installed: left out")
        return
    with tempfile.TemporaryDirectory() as folder:
        work = pathlib.Path(folder)
        (work / "lamp.st").write_text(PROGRAM)
        for name, (within, _) in PLANS.items():
            (work / f"{name}.toml").write_text(PLAN.format(within=within))
        run(rig, "test", "pass.toml", "--report", "out", cwd=work)
        sample(work / "out/traces/pass.vcd", work)
        judged = 0
        for name, (_, code) in PLANS.items():
            traces = {}
            for ending in ["sr", "vcd", "csv"]:
                words = ["--map", "0=button", "--map", "1=lamp", "--at", "press=button rises"]
                told = run(rig, "judge", f"{name}.toml", f"lines.{ending}", *words, code=code, cwd=work)
                traces[ending] = told.splitlines()[-1]
                judged += 1
            if traces["sr"] != traces["vcd"]:
                sys.exit(f"{name}: session and dump make two traces")
        print(f"{judged} captures judged")


main()
