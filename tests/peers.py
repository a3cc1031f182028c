#!/usr/bin/env python3
"""Reads a report with programs that are not ours: tests/peers.py DIR (what `rig test --report DIR` wrote).

junit.xml with junitparser and by Jenkins' schema, ctrf.json by its schema, the tables with Python's csv, every
traces/*.vcd with vcdvcd and one of them with sigrok-cli, each compared with record.json. Prints what failed, then `N passed, M failed`; the exit code is 0 only without failures.
"""

import csv
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

import jsonschema
import junitparser
from lxml import etree
from vcdvcd import VCDVCD

from tally import check, finish

# Reading value by value is slow in Python: larger files are left out, never all of them.
LARGEST = 2_000_000
LEAST_TRACES = 10

MILLISECOND = 1_000_000

# What other people's programs take: GitLab reads no JUnit file above 30 MB, GitHub no longer comment.
LARGEST_JUNIT = 30_000_000
LONGEST_SUMMARY = 65_536

SCHEMAS = pathlib.Path(__file__).parent / "schemas"


def load(folder):
    """The record, with what it leaves out because it is empty."""
    record = json.loads((folder / "record.json").read_text())
    for case in record["cases"]:
        for name in ["proves", "claims", "measurements", "steps", "lanes"]:
            case.setdefault(name, [])
        for name in ["start_ns", "end_ns", "duration_ns"]:
            case.setdefault(name, 0)
        for step in case["steps"]:
            step.setdefault("at_ns", None)
        for lane in case["lanes"]:
            # An instant that is known exactly is written once.
            points = lane.setdefault("points", [])
            lane["points"] = [point if len(point) == 3 else [point[0], *point] for point in points]
    return record


def outcome(case):
    """What JUnit must say of a case of the record."""
    if case["status"]["is"] != "judged" or case["verdict"] == "none":
        return "skipped"
    return {"pass": "success", "fail": "failure", "inconclusive": "failure", "error": "error"}[case["verdict"]]


def read_junit(folder, record):
    path = folder / "junit.xml"
    check("junit: size", path.stat().st_size <= LARGEST_JUNIT, path.stat().st_size)
    schema = etree.XMLSchema(etree.parse(str(SCHEMAS / "jenkins-junit-4.xsd")))
    check("junit: schema of Jenkins", schema.validate(etree.parse(str(path))), schema.error_log.last_error)
    xml = junitparser.JUnitXml.fromfile(str(folder / "junit.xml"))
    cases = [case for suite in xml for case in suite]
    totals = record["totals"]
    check("junit: number of cases", len(cases) == len(record["cases"]), len(cases))
    for name, said, counted in [
        ("tests", xml.tests, len(record["cases"])),
        ("failures", xml.failures, totals["failed"] + totals["inconclusive"]),
        ("errors", xml.errors, totals["errors"]),
    ]:
        check(f"junit: {name}", said == counted, f"{said} in place of {counted}")
    suites = {suite.name: suite for suite in xml}
    for name, suite in suites.items():
        check(f"junit: tests of {name}", suite.tests == len(list(suite)), suite.tests)

    found = {}
    for suite in xml:
        for case in suite:
            # Class and name together are the case's own name: `watchdog` and `fallback[over]`.
            prefix = "" if case.classname == "plans" and suite.name == "plans" else suite.name + "/"
            check("junit: class follows the suite", case.classname == suite.name.replace("/", "."), case.classname)
            found[prefix + case.name] = case
    kinds = {junitparser.Failure: "failure", junitparser.Error: "error", junitparser.Skipped: "skipped"}
    for case in record["cases"]:
        peer = found.get(case["name"])
        if peer is None:
            check(f"junit: {case['name']} is there", False)
            continue
        said = [kinds[type(result)] for result in peer.result if type(result) in kinds] or ["success"]
        check(f"junit: {case['name']}", said == [outcome(case)], said)
        proves = re.findall(r"^\[\[PROPERTY\|requirement=(.*)\]\]$", peer.system_out or "", re.MULTILINE)
        check(f"junit: requirements of {case['name']}", proves == case["proves"], proves)


def read_ctrf(folder, record):
    report = json.loads((folder / "ctrf.json").read_text())
    schema = json.loads((SCHEMAS / "ctrf-0.0.json").read_text())
    faults = jsonschema.Draft7Validator(schema, format_checker=jsonschema.FormatChecker()).iter_errors(report)
    fault = next(faults, None)
    check("ctrf: schema", fault is None, fault and f"{fault.message[:200]} at {list(fault.absolute_path)}")
    tests = report["results"]["tests"]
    check("ctrf: tests", [test["name"] for test in tests] == [case["name"] for case in record["cases"]])
    words = {"success": "passed", "failure": "failed", "error": "failed", "skipped": "skipped"}
    for test, case in zip(tests, record["cases"]):
        nothing = case["status"]["is"] == "judged" and case["verdict"] == "none"
        wanted = "other" if nothing else words[outcome(case)]
        check(f"ctrf: {case['name']}", test["status"] == wanted, test["status"])
        steps = len(case["claims"]) + len(case["measurements"])
        check(f"ctrf: steps of {case['name']}", len(test.get("steps", [])) == steps, len(test.get("steps", [])))
        for attachment in test.get("attachments", []):
            check(f"ctrf: {attachment['path']}", (folder / attachment["path"]).is_file())
    summary = report["results"]["summary"]
    counted = [sum(test["status"] == status for test in tests) for status in ["passed", "failed", "skipped", "other"]]
    said = [summary[name] for name in ["passed", "failed", "skipped", "other"]]
    check("ctrf: summary", said == counted and summary["tests"] == len(tests), said)


def read_tables(folder, record):
    judged = [case for case in record["cases"] if case["status"]["is"] == "judged"]
    for name, part in [("measurements.csv", "measurements"), ("claims.csv", "claims")]:
        with open(folder / name, newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file, strict=True))
        wanted = [(case["name"], entry) for case in judged for entry in case[part]]
        check(f"{name}: rows", len(rows) == len(wanted), f"{len(rows)} for {len(wanted)}")
        for row, (case, entry) in zip(rows, wanted):
            check(f"{name}: {case}", row["case"] == case and row["verdict"] == entry["verdict"], row)
            # Numbers that are not finite are words in the record, which Python reads, too.
            margin = float(entry["margin"].get("value", 0)) if "margin" in entry else None
            check(f"{name}: margin in {case}", field(row["margin"]) == margin, row["margin"])
            if part == "measurements":
                low = float(entry["value"][0]) if "value" in entry else None
                check(f"{name}: value in {case}", field(row["low"]) == low, row["low"])
                check(f"{name}: coverage in {case}", row["coverage"] == entry.get("coverage", ""), row["coverage"])
                check(f"{name}: a value says what it covers in {case}", low is None or row["coverage"], row)


def field(text):
    """A number of a table; None where there is none."""
    return float(text) if text else None


def read_summary(folder, record):
    text = (folder / "summary.md").read_text()
    check("summary: length", len(text) <= LONGEST_SUMMARY, len(text))
    for name in ["passed", "failed", "inconclusive"]:
        count = record["totals"][name]
        check(f"summary: {name}", not count or f"**{count}** {name}" in text)
    failed = [case for case in record["cases"] if case["status"]["is"] == "judged" and case["verdict"] == "fail"]
    for case in failed[:10]:
        check(f"summary: {case['name']}", case["name"].replace("|", "\\|") in text)


def value(raw, kind):
    """A value of a VCD file as a number; None where it is not driven or not known."""
    if raw is None:
        return None
    if kind == "real":
        # A real of VCD has no x and no z: what is not known is no number.
        number = float(raw)
        return None if number != number else number
    return None if set(raw.lower()) & {"x", "z"} else int(raw, 2)


def signals_of(wave):
    """The signals by their names, without the scope."""
    return {name.split(".", 1)[1]: wave[name] for name in wave.signals}


def plain(name):
    """A name of the trace as VCD can have it: without blanks and brackets."""
    return re.sub(r"[^!-~]|[$\[\]]", "_", name)


def read_waves(path, case):
    wave = VCDVCD(str(path))
    signals = signals_of(wave)
    label = f"vcd: {case['name']}"
    check(f"{label}: nanoseconds", wave.timescale["unit"] == "ns" and int(wave.timescale["magnitude"]) == 1)
    marks = {name: [at for at, raw in signal.tv if value(raw, signal.var_type)] for name, signal in signals.items()
             if name.startswith("step:")}
    # The anchors and the steps of the record are where the waves have their marks. On the host's clock an instant is
    # known only to within an interval.
    for name, at in [("start", case["start_ns"]), ("end", case["end_ns"])]:
        check(f"{label}: {name}", marks.get(f"step:{name}") == [at], f"{marks.get(f'step:{name}')} and not {at}")
    for step in case["steps"]:
        if step["id"] in ("start", "end"):
            continue
        seen = marks.get(plain(f"step:{step['id']}"), [])
        if step["at_ns"] is None:
            check(f"{label}: step {step['id']} never came", not seen, seen)
        else:
            low, high = step["at_ns"]
            check(f"{label}: step {step['id']}", any(low <= at <= high for at in seen), f"{seen} {step['at_ns']}")
    times = [at for signal in signals.values() for at, _ in signal.tv]
    check(f"{label}: nothing after the end", max(times) <= case["duration_ns"], max(times))
    # The edges that the record's excerpts show are in the waves, each at its instant and with its value.
    for lane in case["lanes"]:
        signal = signals.get(plain(lane["signal"]))
        if signal is None:
            check(f"{label}: {lane['signal']} is there", False)
            continue
        edges = {}
        for at, raw in signal.tv:
            edges.setdefault(at, []).append(value(raw, signal.var_type))
        missing = [
            point
            for point in lane["points"]
            if point[0] == point[1] and not any(same(point[2], number, signal) for number in edges.get(point[0], []))
        ]
        check(f"{label}: edges of {lane['signal']}", not missing, f"{missing[:3]} of {len(lane['points'])}")


def same(point, number, signal):
    """Whether a point of an excerpt has the value of the waves."""
    if point in ("z", "x"):
        return number is None
    if number is None:
        return False
    if isinstance(point, str):
        # A whole number beyond 53 bits is a text of its digits.
        point = int(point)
    if signal.var_type != "real" and point < 0:
        # Negative numbers are written as their two's complement.
        point += 1 << int(signal.size)
    return abs(float(point) - number) < 1e-9 * max(1.0, abs(number))


def read_with_sigrok(path, work):
    """sigrok-cli opens the file and samples its lines every millisecond; vcdvcd says what it must have seen."""
    if shutil.which("sigrok-cli") is None:
        print("sigrok-cli is not installed: left out")
        return
    signals = {name: signal for name, signal in signals_of(VCDVCD(str(path))).items() if signal.size == "1"}
    shown = sigrok(path, "--show")
    for name in signals:
        check(f"sigrok: {path.name} shows {name}", f"- {name}: logic" in shown, shown[:300])
    # libsigrok 0.5 stops at the first value of more than one bit: it samples a copy without them.
    lines = []
    for line in path.read_text().splitlines(keepends=True):
        words = line.split()
        if words[:1] == ["$var"] and words[2] != "1" or len(words) == 2 and line[0] in "bBrR":
            continue
        lines.append(line)
    copy = work / "lines.vcd"
    copy.write_text("".join(lines))
    rows = [line for line in sigrok(copy, "-O", "csv").splitlines() if re.fullmatch(r"[01](,[01])*", line)]
    check(f"sigrok: samples {path.name}", len(rows) > 100, len(rows))
    for column, (name, signal) in enumerate(signals.items()):
        changes = [(at // MILLISECOND, int(value(raw, "wire") or 0)) for at, raw in signal.tv]
        level, seen, wanted = 0, [], []
        for instant, row in enumerate(rows):
            while changes and changes[0][0] <= instant:
                level = changes.pop(0)[1]
            wanted.append(level)
            seen.append(int(row.split(",")[column]))
        wrong = [instant for instant in range(len(rows)) if seen[instant] != wanted[instant]]
        check(f"sigrok: levels of {name} in {path.name}", not wrong, f"{len(wrong)} of {len(rows)}, first at {wrong[:1]} ms")
        check(f"sigrok: {name} in {path.name} has edges", len(set(seen)) == 2)


def sigrok(path, *arguments):
    """What sigrok-cli prints of a VCD file; the file has an instant for every nanosecond, which is sampled down."""
    command = ["sigrok-cli", "-I", f"vcd:downsample={MILLISECOND}", "-i", str(path), *arguments]
    ran = subprocess.run(command, capture_output=True, text=True, timeout=120)
    check(f"sigrok: opens {path.name}", ran.returncode == 0, ran.stderr.strip()[:300])
    return ran.stdout


def edges_of_lines(path):
    """How many changes the least busy line of a file has; none where samples of a millisecond would miss some."""
    signals = signals_of(VCDVCD(str(path))).values()
    lines = [[at for at, raw in signal.tv if raw in "01"] for signal in signals if signal.size == "1"]
    if any(later - sooner < 2 * MILLISECOND for line in lines for sooner, later in zip(line, line[1:])):
        return 0
    return min(map(len, lines), default=0)


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    folder = pathlib.Path(sys.argv[1])
    record = load(folder)
    read_junit(folder, record)
    read_ctrf(folder, record)
    read_tables(folder, record)
    read_summary(folder, record)
    cases = {case["trace_file"]: case for case in record["cases"] if case.get("trace_file")}
    files = sorted(folder.glob("traces/*.vcd"))
    check("vcd: a file for each trace", len(files) == len(cases), f"{len(files)} for {len(cases)}")
    small = [path for path in files if path.stat().st_size <= LARGEST]
    check(f"vcd: at least {LEAST_TRACES} to read", len(small) >= min(LEAST_TRACES, len(files)), len(small))
    for path in small:
        case = cases.get(f"traces/{path.stem}.trace")
        if case is None:
            check(f"vcd: {path.name} belongs to a case", False)
        else:
            read_waves(path, case)
    if small:
        with tempfile.TemporaryDirectory() as work:
            read_with_sigrok(max(small, key=edges_of_lines), pathlib.Path(work))
    finish()


if __name__ == "__main__":
    main()
