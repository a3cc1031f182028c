"""Recordings of the rig itself: scenes that it runs in virtual time, where changes are exact or become known late."""

import collections
import pathlib
import random

import compare
import rig as command
from claims import Maker
from figures import duration
from recording import HELD_BACK, Change, Recording
from origins import RunOrigin, write, write_boards
from scenes import COARSE, VARIABLES, Scene, any_value

PER_CASE = 40
PLACEMENTS = 60


def round_of(rig, folder, way, rng, report, wanted, filters, cases):
    """Some cases of one way, all in one run of the rig."""
    folder.mkdir(parents=True)
    write_boards(folder)
    made = {}
    for number in range(cases):
        own = random.Random(rng.randrange(1 << 62))
        scene = Scene(own, way)
        maker = Maker(scene, own, filters=filters)
        claims = []
        while len(claims) < PER_CASE:
            group, verb = own.choice(wanted)
            claim = maker.make(group, verb)
            if claim is not None:
                claims.append(claim)
            elif len(wanted) < 4 and own.random() < 0.05:
                break
        made[f"c{number}"] = (scene, claims, own)
    refused(rig, folder, made, report)
    records = command.test(rig, folder)
    for name, (scene, claims, own) in made.items():
        if name not in records:
            report.broken(way, "the case did not run", name, RunOrigin(scene, name))
            continue
        judged(rig, folder, name, scene, claims, own, records[name], report)
    again(rig, folder, "c0", *made["c0"][:2], records.get("c0"), report)


def refused(rig, folder, made, report):
    """Claims that the check refuses: they are left out, and are counted."""
    places = {name: write(folder, name, scene, claims) for name, (scene, claims, _) in made.items()}
    while True:
        found = command.check(rig, folder)
        if not found:
            return
        gone = {}
        for code, message, name, line in found:
            index = places[name].get(line)
            if index is None:
                raise SystemExit(f"the check refuses {name}.toml:{line}: {code} {message}\n{(folder / (name + '.toml')).read_text()}")
            if index not in gone.setdefault(name, set()):
                gone[name].add(index)
                scene, claims, _ = made[name]
                report.refused(claims[index], code, message, RunOrigin(scene, name, claims[index]))
        for name, indices in gone.items():
            scene, claims, own = made[name]
            claims[:] = [claim for index, claim in enumerate(claims) if index not in indices]
            if not claims:
                claims.append(Maker(scene, own).make("expect", "value"))
            places[name] = write(folder, name, scene, claims)


def judged(rig, folder, name, scene, claims, rng, case, report):
    """One case, claim by claim."""
    if case["verdict"] == "error" or "claims" not in case and "measurements" not in case:
        report.broken(scene.way, "the case is an error", case.get("reason", ""), RunOrigin(scene, name))
        return
    recording = recorded(folder, name, scene, case, rng)
    as_asked(scene, recording, report, name)
    awaited(scene, recording, report, name)
    answers = command.answers(case)
    for index, claim in enumerate(claims):
        answer = answers.get(f"k{index}")
        if answer is None:
            report.broken(scene.way, "no answer", claim.text("k"), RunOrigin(scene, name))
            continue
        found = compare.expected(claim, recording, rng, PLACEMENTS)
        report.compare(scene.way, claim, answer, found, RunOrigin(scene, name, claim))


def again(rig, folder, name, scene, claims, case, report):
    """The trace of a case gives its verdicts once more, and its value change dump none that is another one: it says between
    which instants each change was, if not so closely."""
    if not case or "trace_file" not in case:
        return
    trace = pathlib.Path("report", case["trace_file"])
    names = [f"k{index}" for index in range(len(claims))]
    first = command.answers(case)
    for file in (trace, trace.with_suffix(".vcd")):
        answers, words = command.judge(rig, folder, f"{name}.toml", str(file), names)
        if answers is None:
            report.broken(scene.way, f"its {file.suffix} is not judged", words[:1000], RunOrigin(scene, name))
            continue
        for index, claim in enumerate(claims):
            one, other = first[names[index]].verdict, answers[names[index]].verdict
            # What passes and what has no verdict look alike there.
            same = one == other or (one, other) == ("none", "pass")
            if not same and (file == trace or other != "inconclusive"):
                report.broken(scene.way, f"another verdict by its {file.suffix}", f"{one}, then {other}: {answers[names[index]].reason}",
                              RunOrigin(scene, name, claim))


def recorded(folder, name, scene, case, rng):
    """What the rig knows of each signal: values and their order from its value change dump, intervals from its record."""
    trace = pathlib.Path(folder, "report", case["trace_file"])
    dump = command.dump(trace.with_suffix(".vcd"), VARIABLES)
    lanes = {lane["signal"]: lane["points"] for lane in case["lanes"]}
    tracks, steps = {}, {}
    for signal, changes in dump.items():
        if signal.startswith("step:"):
            came = [(time, rank) for time, rank, value in changes if value is not None]
            if came and not signal.endswith(".done"):
                steps[signal[5:]] = came[0]
            continue
        changes = changes[1:] if changes and changes[0][2] is None else changes
        # Several changes of a signal can have one latest instant: they stand in the same order in both.
        early = collections.defaultdict(list)
        for point in lanes.get(signal, ()):
            early[int(point[-2])].append(int(point[0]))
        tracks[signal] = [Change(early[time].pop(0) if early[time] else time, time, rank, value) for time, rank, value in changes]
    if scene.way == "late":
        with_held_back(scene, tracks, steps["start"][0])
    # A coarse recording says less, and nothing else: what is left out never turns a verdict.
    tracks |= {name: tracks[origin] for name, (origin, _) in COARSE.items()}
    pool = {name: [any_value(rng, kind) for _ in range(4)] for name, kind in VARIABLES.items()}
    for name in scene.changes:
        pool[name] = [change.value for change in tracks[name] if change.value is not None] + [not tracks[name][0].value] \
            if isinstance(tracks[name][0].value, bool) else [change.value for change in tracks[name] if change.value is not None]
        pool[name].append(pool[name][0] if isinstance(pool[name][0], bool) else max(pool[name]) + 1)
    return Recording(tracks, steps, pool=pool)


def with_held_back(scene, tracks, start):
    """Changes that came before the end and become known after it are recorded by nobody, and they are changes."""
    for name, changes in scene.changes.items():
        got = sum(change.late > start for change in tracks[name])
        rank = HELD_BACK
        for time, value in changes[got:]:
            tracks[name].append(Change(start + time, start + time + 3_000_000, rank, value))
            rank += 1


def as_asked(scene, recording, report, name):
    """The rig recorded what it was asked to do: each change once, between the instants that it says."""
    start = recording.steps["start"][0]
    nominal = scene.nominal()
    for signal in (*scene.changes, *scene.writes):
        if signal in [name for name, _, _ in scene.lost]:
            continue
        asked = list(zip(nominal.tracks[signal].at, nominal.tracks[signal].values))[1:]
        got = [change for change in recording.tracks[signal] if change.late > start]
        fits = len(asked) == len(got) and all(
            change.early - start <= at[0] <= change.late - start and change.value == value
            for (at, value), change in zip(asked, got))
        # What is late may not be known before the end; whether it is recorded then is the claims' business.
        if not fits and scene.way == "exact":
            report.broken(scene.way, "not what was asked", f"{signal}: {asked} {[(c.early - start, c.value) for c in got]}", RunOrigin(scene, name))


def awaited(scene, recording, report, name):
    """Each step that waits came, if what it waits for came in time: `within` includes its limit."""
    if scene.way != "exact":
        return
    placement = recording.placement({signal: [(change.early, change.rank, change.value) for change in recording.tracks[signal]]
                                 for signal in scene.changes})
    for step, signal, kind, since, limit in scene.awaited:
        begin = placement.at((since, 0))
        times = placement.edges(signal, kind, begin, placement.at(("end", 0)))
        due = bool(times) and times[0] - begin[0] <= limit
        came = step in recording.steps
        if due != came:
            report.broken(scene.way, "a step that waits " + ("came, not due" if came else "did not come"),
                          f"{step} waits from {since} for {duration(limit)} until {signal} {kind}; "
                          f"it does so {[duration(time - begin[0]) for time in times[:2]]} after that", RunOrigin(scene, name))
        elif came and recording.steps[step][0] != times[0]:
            report.broken(scene.way, "a step that waits came at another instant", f"{step} {recording.steps[step]} {times}", RunOrigin(scene, name))
