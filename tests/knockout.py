"""Looks for cases that prove nothing: knockout.py RIG REPORT.

Every shipped plan that proves something runs once more with its stimuli taken out: each step keeps its name and its instant
and does nothing. A case that still passes would pass with a controller that does nothing of what the plan is about. And
two rows of one plan with different settings, equal claims and equal traces say the same thing twice: nothing looks at the
setting, unless it makes a difference between two other rows of the plan. REPORT is a run of the whole library as it is.

What is found and may stay is in knockout.toml, each with its reason; what is new there or here without need fails.
"""

import collections
import datetime
import itertools
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tomllib

HERE = pathlib.Path(__file__).resolve().parent
LIBRARY = HERE.parent / "plans" / "library"
EXCEPTIONS = HERE / "knockout.toml"
WORK = HERE.parent / "target" / "knockout"
# What says when a step comes, and nothing of what it does. `refused` goes with what is refused.
INSTANT = {"id", "at", "when", "rows", "phase", "every"}
# What a plan claims and says of itself.
CLAIMS = {"expect", "measure", "refused", "warned", "title", "description", "proves", "rows", "tags"}
# Steps that run others: what those do is taken out where they stand.
CALLS = {"run"}


class Number(str):
    """A number with a point, as it is written."""


def toml(value):
    """A value in one line."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, Number | int):
        return str(value)
    if isinstance(value, str):
        return json.dumps(value).replace("\x7f", "\\u007f")
    if isinstance(value, datetime.date | datetime.time):
        return value.isoformat()
    if isinstance(value, list):
        return f"[{', '.join(map(toml, value))}]"
    return f"{{ {', '.join(f'{json.dumps(key)} = {toml(inner)}' for key, inner in value.items())} }}"


def does_something(step):
    """Whether a step is more than an instant."""
    return not set(step) <= INSTANT | CALLS | {"mark"}


def knocked_out(step):
    """The step without what it does."""
    if not does_something(step):
        return step
    kept = {key: value for key, value in step.items() if key in INSTANT}
    return kept if "when" in kept else kept | {"mark": {}}


def step_lists(plan):
    """Every list of steps, with its owner and key, but the teardown, after which nothing is claimed."""
    owners = [plan, *plan.get("group", {}).values()]
    return [(owner, key) for owner in owners for key in ("setup", "steps") if key in owner]


def steps_of_row(plan, row):
    """The steps that a row has."""
    steps = [step for owner, key in step_lists(plan) for step in owner[key]]
    return [step for step in steps if row is None or row in step.get("rows", [row])]


def run(rig, arguments):
    return subprocess.run([rig, *arguments], cwd=WORK, capture_output=True, text=True)


def verdicts_without_stimuli(rig, plans):
    """The verdicts of the cases of these plans without their stimuli, by name. What the check refuses then is not among
    them: a claim that counts the pulses of a train, say, is nothing without it."""
    shutil.rmtree(WORK, ignore_errors=True)
    shutil.copytree(LIBRARY, WORK / "library")
    for path, plan in plans.items():
        for owner, key in step_lists(plan):
            owner[key] = [knocked_out(step) for step in owner[key]]
        text = "".join(f"{json.dumps(key)} = {toml(value)}\n" for key, value in plan.items())
        (WORK / "library" / path).write_text(text)
    names = [f"library/{path}" for path in plans]
    checked = run(rig, ["check", *names])
    refused = set(re.findall(r"^error.*\n *--> (library/\S+?\.toml):", checked.stderr + checked.stdout, re.MULTILINE))
    if checked.returncode not in (0, 2):
        sys.exit(f"rig check ended with {checked.returncode}: {checked.stderr[-2000:]}")
    done = run(rig, ["test", "--report", "report", *(name for name in names if name not in refused)])
    if done.returncode not in (0, 1, 3, 4):
        sys.exit(f"rig test ended with {done.returncode}: {done.stderr[-2000:]}")
    record = json.loads((WORK / "report" / "record.json").read_text())
    print(f"{len(refused)} of {len(plans)} plans are refused without their stimuli, {len(record['cases'])} cases ran")
    return {case["name"].removeprefix("library/"): case["verdict"] for case in record["cases"]}


def row_name(case):
    """Plan and row of a case: what an exception is about."""
    return case["plan"].removesuffix(".toml") + (f"[{case['row']}]" if case.get("row") else "")


def names_of(entry):
    """The rows that an exception is about."""
    return [f"{entry['plan']}[{row}]" for row in entry["rows"]] or [entry["plan"]]


def still_passing(rig, cases, plans):
    """Rows that pass without what their steps do."""
    plans = {path: plan for path, plan in plans.items() if any(does_something(step) for step in steps_of_row(plan, None))}
    # The steps of the plans are changed below.
    looked_at = []
    for case in cases:
        steps = steps_of_row(plans[case["plan"]], case.get("row")) if case["plan"] in plans else []
        # That something is refused is a claim of the step itself, which is taken out with it. A case that is refused never
        # runs: it has no trace.
        if case.get("trace_sha256") and any(map(does_something, steps)) and not any(step.get("refused") for step in steps):
            looked_at.append(case)
    verdicts = verdicts_without_stimuli(rig, plans)
    passing = collections.defaultdict(list)
    for case in looked_at:
        if verdicts.get(case["name"]) == "pass":
            passing[row_name(case)].append(case["name"])
    print(f"{len(passing)} rows of {len({row_name(case) for case in looked_at})} pass without their stimuli")
    return set(passing)


def columns(*tables):
    """The columns of rows that these tables of a plan refer to."""
    return set(re.findall(r"\$([A-Za-z_][\w-]*)", json.dumps(tables)))


def equal_neighbours(cases, plans):
    """Settings that distinguish two rows of equal claims and traces, and no two rows of which the traces differ, or one
    is refused."""
    groups = collections.defaultdict(list)
    for case in cases:
        groups[case["plan"], case["profile"]].append(case)
    found = set()
    for (path, _), group in groups.items():
        plan = plans[path]
        # Rows of other hardware are there to show that it makes no difference.
        settings = columns(plan.get("settings", {})) - {"reference"}
        # What a row claims, or says of itself, makes no difference to what happens.
        causes = columns({key: value for key, value in plan.items() if key not in CLAIMS})
        names = columns(plan.get("signals", {}))
        seen, equal = set(), set()
        for one, other in itertools.combinations(group, 2):
            given = [{value["name"]: value.get("value", "") for value in case.get("parameters", [])} for case in (one, other)]
            different = {name for name in causes if given[0].get(name) != given[1].get(name)}
            if different & names:
                # They look at something else by the same name.
                continue
            claims = [[claim["expected"] for claim in case.get("claims", [])] for case in (one, other)]
            if one.get("trace_sha256") != other.get("trace_sha256"):
                seen |= different if len(different) == 1 else set()
            elif one.get("trace_sha256") and claims[0] == claims[1] and one.get("row") != other.get("row"):
                equal |= different & settings
        found |= {f"{path.removesuffix('.toml')}: {name}" for name in equal - seen}
    print(f"{len(found)} settings make no difference between rows of equal claims")
    return found


def held_against(kind, found, reasons):
    """Prints what is new and what is here without need; whether there was some."""
    wrong = False
    for name in sorted(found - set(reasons)):
        wrong = True
        print(f"{kind}: {name} is new: let the plan claim what it is about, or give the reason in tests/knockout.toml")
    for name in sorted(set(reasons) - found):
        wrong = True
        print(f"{kind}: {name} is found no more: take it off tests/knockout.toml")
    return wrong


def main(rig, report):
    record = json.loads((pathlib.Path(report) / "record.json").read_text())
    cases = [case for case in record["cases"] if case.get("proves") and case["verdict"] == "pass"]
    plans = {path: tomllib.loads((LIBRARY / path).read_text(), parse_float=Number) for path in sorted({case["plan"] for case in cases})}
    exceptions = tomllib.loads(EXCEPTIONS.read_text())
    known = {name: entry["reason"] for entry in exceptions["knocked-out"] for name in names_of(entry)}
    neighbours = equal_neighbours(cases, plans)
    passing = still_passing(str(pathlib.Path(rig).resolve()), cases, plans)
    wrong = [
        held_against("neighbours", neighbours, exceptions["neighbours"]),
        held_against("knocked-out", passing, known),
    ]
    return 1 if any(wrong) else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:3]))
