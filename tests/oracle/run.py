#!/usr/bin/env python3
"""An oracle of intervals: tests/oracle/run.py RIG [--count N] [--seed N] [--verbs a,b] [--keep DIR].

Random claims and measurements of every verb on random recordings, judged by the rig and, from the manual alone, here. A
verdict is contradicted by one placement that the recording allows; then the run fails, as it does if a verb is never tried.
Recordings are exact and late ones of a run in virtual time, sampled and stamped ones of other instruments (`rig judge`).
"""

import argparse
import json
import pathlib
import random
import subprocess
import sys
import tempfile
import time

import captures
import runs
from report import Report


def verbs_of(rig):
    """From the schema of plans: the verbs of the manual, the kinds of measurements, and which of them take
    `pulses-longer-than`."""
    schema = json.loads(subprocess.run([rig, "schema", "plan"], capture_output=True, text=True, check=True).stdout)
    expectation = schema["definitions"]["expectation"]["properties"]
    measure = schema["properties"]["measure"]["items"]["properties"]
    verbs = [verb for verb in expectation if verb not in ("name", "rows")]
    kinds = ["time", "window", *sorted(key[:-3] for key in measure if key.endswith("-of"))]
    filters = {("expect", verb) for verb in verbs if "pulses-longer-than" in expectation[verb].get("properties", {})}
    if "pulses-longer-than" in measure:
        filters |= {("measure", kind) for kind in kinds if kind not in ("time", "value", "speed")}
    return [("expect", verb) for verb in verbs] + [("measure", kind) for kind in kinds], filters


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("rig")
    parser.add_argument("--count", type=int, default=2000)
    parser.add_argument("--seed", type=int)
    parser.add_argument("--verbs")
    parser.add_argument("--ways", default="exact,late,sampled,stamped")
    parser.add_argument("--keep", help="where plans of contradictions are written")
    arguments = parser.parse_args()
    rig = str(pathlib.Path(arguments.rig).resolve())
    seed = random.SystemRandom().randrange(1 << 32) if arguments.seed is None else arguments.seed
    print(f"oracle: seed {seed}")
    wanted, filters = verbs_of(rig)
    if arguments.verbs:
        some = arguments.verbs.split(",")
        wanted = [(group, verb) for group, verb in wanted if verb in some or f"{group}:{verb}" in some]
    keep = pathlib.Path(arguments.keep or tempfile.mkdtemp(prefix="oracle-"))
    report = Report(keep, wanted)
    rng = random.Random(seed)
    begun = time.process_time()
    ways = arguments.ways.split(",")
    while report.compared() < arguments.count:
        before = report.compared()
        left = arguments.count - before
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            for way in ("exact", "late"):
                if way in ways:
                    runs.round_of(rig, folder / way, way, rng, report, wanted, filters, min(20, max(2, left // 80)))
            for way in ("sampled", "stamped"):
                if way in ways:
                    for turn in range(min(6, max(1, left // 300))):
                        captures.round_of(rig, folder / f"{way}{turn}", way, rng, report, wanted, filters)
        if report.compared() == before:
            print("oracle: nothing could be compared")
            break
    report.show()
    print(f"oracle: {time.process_time() - begun:.1f} s of the processor here")
    return 1 if report.failed() else 0


if __name__ == "__main__":
    sys.exit(main())
