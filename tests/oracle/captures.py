"""Recordings of other instruments: what a scene does, as a logic analyser samples it and as a recorder stamps it.

The same plan is judged by `rig judge`; its steps lie where it has them. Of a sampled signal only the samples are known. Of a
stamped one each change lies within the timescale before or after its stamp, and nothing else happened.
"""

import random

import compare
import rig as command
from claims import Maker
from figures import MS, duration, text
from placement import LAST
from recording import Change, Recording
from origins import CaptureOrigin, write_boards
from runs import refused
from scenes import CHANNELS, LINES, VARIABLES, Scene, any_value

PER_CAPTURE = 45
PLACEMENTS = 60
# What was there when the capture began has been so since any time before; it is no edge.
BEFORE = -30 * MS
SIGNALS = [*LINES, *CHANNELS, "count", "copy", "v_int", "v_lint"]


def round_of(rig, folder, way, rng, report, wanted, filters):
    """One scene and its capture."""
    folder.mkdir(parents=True)
    write_boards(folder)
    own = random.Random(rng.randrange(1 << 62))
    scene = Scene(own, "late")
    step = own.choice((250_000, 500_000, MS, 2 * MS) if way == "sampled" else (1000, 10_000, 100_000, MS))
    # Lines that are TRUE at first are TRUE when the capture begins, which may be at the start itself.
    scene.flipped = {name for name in LINES if own.random() < 0.4}
    start = own.choice((0, 10 * MS))
    maker = Maker(scene, own, only=SIGNALS, unseen=step if way == "sampled" else 0, filters=filters)
    able = [(group, verb) for group, verb in wanted if verb not in ("frames", "led", "log", "task", "state")]
    claims = []
    while able and len(claims) < PER_CAPTURE:
        claim = maker.make(*own.choice(able))
        # Without limits there is no verdict, and no word of it.
        if claim is not None and (claim.group == "expect" or "limits" in claim.keys) and set(claim.names) <= set(SIGNALS):
            claims.append(claim)
        elif len(able) < 4 and own.random() < 0.05:
            # A scene may have nothing for so few verbs.
            break
    if not claims:
        return
    made = {"c0": (scene, claims, own)}
    refused(rig, folder, made, report)
    ends = scene.end + own.choice((5 * MS, 5 * MS, 5 * MS, -15 * MS))
    steps = {"start": (start, 0)} | {name: (start + time, 0) for name, time in scene.marks.items()}
    steps["end"] = (start + scene.end, 0)
    options = ["--start", f"{duration(start)}"]
    if way == "sampled":
        capture = "c0-capture.csv"
        content, tracks, samples = sampled(scene, step, ends, start)
    else:
        capture = "c0-capture.vcd"
        content, tracks, samples = stamped(scene, step, ends, start)
    (folder / capture).write_text(content)
    pool = {name: [any_value(own, VARIABLES.get(name, "BOOL" if name in LINES else "LREAL")) for _ in range(4)]
            + [change.value for change in tracks[name] if change.value is not None] for name in SIGNALS}
    recording = Recording(tracks, steps, samples, pool, scene.awaited)
    answers, words = command.judge(rig, folder, "c0.toml", capture, [f"k{index}" for index in range(len(claims))], *options)
    if answers is None:
        report.broken(way, "the capture is not judged", words[:2000], CaptureOrigin(scene, None, capture, content, options))
        return
    for index, claim in enumerate(claims):
        found = compare.expected(claim, recording, own, PLACEMENTS)
        report.compare(way, claim, answers[f"k{index}"], found, CaptureOrigin(scene, claim, capture, content, options))


def field(value):
    return str(int(value)) if isinstance(value, bool) else text(value)


def sampled(scene, period, ends, start):
    """A table of samples, and what can be known from it."""
    placement = scene.nominal().tracks
    times = list(range(0, start + ends + 1, period))
    rows = ["time [ns]," + ",".join(SIGNALS)]
    tracks = {name: [] for name in SIGNALS}
    for time in times:
        values = [placement[name].value((max(time - start, -1), LAST)) for name in SIGNALS]
        rows.append(f"{time}," + ",".join(field(value) for value in values))
        for name, value in zip(SIGNALS, values):
            if not tracks[name] or tracks[name][-1].value != value:
                known = (time - period + 1, time) if tracks[name] else (BEFORE, -1)
                tracks[name].append(Change(*known, 1, value))
    unknown_after(tracks, times[-1], start + scene.end)
    return "\n".join(rows) + "\n", tracks, times


def unknown_after(tracks, last, end):
    """What comes after the capture is not known."""
    if last < end:
        for changes in tracks.values():
            changes.append(Change(last + 1, last + 1, 2, None))


def stamped(scene, scale, ends, start):
    """A value change dump with a coarse timescale. Changes of one signal with one stamp are one, or none."""
    placement = scene.nominal()
    codes = {name: chr(33 + index) for index, name in enumerate(SIGNALS)}
    kinds = {name: "wire 1" if name in LINES else "real 64" if name in CHANNELS else "wire 64" for name in SIGNALS}
    lines = [f"$timescale {scale // 1000} us $end", "$scope module bench $end"]
    lines += [f"$var {kinds[name]} {codes[name]} {name} $end" for name in SIGNALS]
    lines += ["$upscope $end", "$enddefinitions $end"]
    changes, tracks = {}, {name: [] for name in SIGNALS}
    for name in SIGNALS:
        track = placement.tracks[name]
        stamps = {}
        for (time, _), value in zip(track.at, track.values):
            stamps[-(-(time + start) // scale) if time >= 0 else 0] = value
        last = None
        for stamp, value in sorted(stamps.items()):
            if stamp * scale > start + ends or value == last:
                continue
            known = ((stamp - 1) * scale, (stamp + 1) * scale) if tracks[name] else (BEFORE, -1)
            tracks[name].append(Change(*known, 1, value))
            changes.setdefault(stamp, []).append((name, value))
            last = value
    for stamp in sorted(changes):
        lines.append(f"#{stamp}")
        for name, value in changes[stamp]:
            if name in LINES:
                lines.append(f"{int(value)}{codes[name]}")
            elif name in CHANNELS:
                lines.append(f"r{float(value)!r} {codes[name]}")
            else:
                lines.append(f"b{int(value) & (1 << 64) - 1:064b} {codes[name]}")
    last = (start + ends) // scale
    lines.append(f"#{last}")
    unknown_after(tracks, last * scale, start + scene.end)
    return "\n".join(lines) + "\n", tracks, None
