"""What the command is asked, and what it answers: records, value change dumps, the text of `rig judge`."""

import json
import pathlib
import re
import subprocess
from fractions import Fraction

from figures import INTEGERS, shown

# How long a call may take, many times what it does on a busy machine, and the code of one that takes longer.
PATIENCE, HANGS = 60, -1
FINDING = re.compile(r"^error\[(\w+)\]: (.*)\n +--> (?:.*/)?([\w-]+)\.toml:(\d+)", re.M)


class Answer:
    """What became of a claim or a measurement."""

    def __init__(self, verdict, reason="", value=None, margin=None, uncertainty=None, text=""):
        self.verdict, self.reason, self.value, self.margin = verdict, reason, value, margin
        self.uncertainty, self.text = uncertainty, text


def run(rig, folder, *arguments):
    try:
        return subprocess.run([rig, *arguments], cwd=folder, capture_output=True, text=True, timeout=PATIENCE)
    except subprocess.TimeoutExpired as late:
        return subprocess.CompletedProcess(late.cmd, HANGS, "", f"rig {' '.join(arguments)} takes more than {PATIENCE} s")


def check(rig, folder):
    """The errors that the check finds in the plans of a folder: (code, message, name of the plan, line)."""
    ran = run(rig, folder, "check", ".")
    return [(code, message, plan, int(line)) for code, message, plan, line in FINDING.findall(ran.stderr + ran.stdout)]


def test(rig, folder):
    """The record of a run of all plans of a folder, its cases by their names."""
    ran = run(rig, folder, "test", ".", "--report", "report", "--jobs", "1", "--status-level", "none")
    record = pathlib.Path(folder, "report", "record.json")
    if not record.exists():
        raise SystemExit(f"no record\n{ran.stdout}{ran.stderr}")
    cases = json.loads(record.read_text(), parse_float=Fraction)["cases"]
    return {case["name"].split("/")[-1].split("@")[0]: case for case in cases}


def answers(case):
    """The answers of a case of a record, by the names of claims and measurements."""
    found = {}
    for claim in case.get("claims", []) + case.get("measurements", []):
        value = claim.get("value") and [figure(end) for end in claim["value"]]
        margin = claim.get("margin")
        found[claim["name"]] = Answer(claim["verdict"], claim.get("reason", ""), value,
                                      None if margin is None else figure(margin.get("value", 0)), claim.get("uncertainty"),
                                      claim.get("observed", ""))
    return found


def figure(written):
    """A figure of a record, a number or a text, which may be infinite."""
    if isinstance(written, str) and "inf" in written:
        return float(written)
    exact = Fraction(written)
    # Of a large float the record writes the shortest digits that are read as it.
    return exact if isinstance(written, str) or abs(exact) < 1 << 53 else Fraction(float(exact))


def judge(rig, folder, plan, capture, names, *arguments):
    """The answers of `rig judge`. It says nothing of what passed, and of what has no verdict."""
    ran = run(rig, folder, "judge", plan, capture, *arguments)
    found = {name: Answer("pass") for name in names}
    if ran.returncode not in (0, 1, 3):
        return None, ran.stdout + ran.stderr
    name = None
    for line in ran.stdout.splitlines():
        head = re.match(r"^  ([✗?!]) (.+)$", line)
        if head:
            name = head[2] if head[2] in found else None
        if head and name:
            found[name].verdict = {"✗": "fail", "?": "inconclusive", "!": "error"}[head[1]]
        elif name and line.startswith("      why"):
            found[name].reason = line[10:].strip()
        elif name and line.startswith(("      measured", "      observed")):
            found[name].text = line[15:].strip()
    return found, ran.stdout


def dump(path, kinds):
    """The changes of every signal in a value change dump of the rig, in the order in which they stand there: lists of
    (time, rank, value); None is a value that is not known. `kinds` says what a number is."""
    names, tracks = {}, {}
    time, rank = 0, 1
    header = True
    for line in pathlib.Path(path).read_text().splitlines():
        if header:
            declared = re.match(r"^\$var (\w+) \d+ (\S+) (\S+) \$end", line)
            if declared:
                names[declared[2]] = declared[3]
                tracks[declared[3]] = []
            header = not line.startswith("$enddefinitions")
            continue
        if line.startswith("#"):
            time = int(line[1:])
        elif line[:1] in "01xz" and line[1:] in names and line[:1]:
            name, value = names[line[1:]], {"0": False, "1": True}.get(line[0])
            if line[0] == "z":
                value = "Z"
            tracks[name].append((time, rank, value))
        elif line[:1] in "br":
            digits, code = line.split(" ")
            name = names[code]
            tracks[name].append((time, rank, number(digits, kinds.get(name, "LINT"))))
        else:
            continue
        rank += 1
    return tracks


def number(digits, kind):
    if digits[0] == "r":
        return None if digits == "rNaN" else shown(float(digits[1:]))
    if "x" in digits or "z" in digits:
        return None
    value = int(digits[1:], 2)
    bits, signed = INTEGERS.get(kind, (64, True))
    if len(digits) == 65 and value >= 1 << 63 and signed:
        value -= 1 << 64
    return Fraction(value)
