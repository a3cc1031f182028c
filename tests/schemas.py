#!/usr/bin/env python3
"""Holds what the command writes for editors, shells and CI servers against programs that are not ours:
tests/schemas.py RIG.

With jsonschema (draft 7) every shipped plan and board is valid, every plan of the tests that the reader refuses for
its form is not, and single slips are refused at the right place. With Taplo, the tool of the editors, the same plans
lint. So does a new project, whose jobs are held against the schemas of GitLab and GitHub; bash and groff read completions
and pages of the manual. Prints what failed, then `N passed, M failed`; the exit code is 0 only without failures.
"""

import datetime
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib

import jsonschema

from tally import check, finish

ROOT = pathlib.Path(__file__).resolve().parent.parent

# What the tables of keys decide. All else depends on other keys, other files or the rules of the language.
FORM = {
    "P0101": "unknown key",
    "P0102": "missing key",
    "P0103": "wrong type",
    "P0104": "unreadable text",
    "P0105": "format",
    "P0201": "verb",
    "P0502": "verb",
    "B0004": "unknown key",
    "B0005": "missing key",
    "B0006": "wrong type",
}

# What JSON cannot say: it has no NaN, and 100.0 is a whole number to it; and what stands in files that are included.
BEYOND_JSON = {"float-count", "included-unread", "nan"}


def is_plan(document):
    """A board file has a table `board` or none; a plan says what it claims."""
    return not isinstance(document.get("board"), dict) and bool({"expect", "measure", "refused", "warned"} & set(document))


def kind_of(path, document):
    """Plans claim something, boards bind or wire; what has neither is there to be included."""
    if path.name == "suite.toml":
        return "suite"
    if is_plan(document):
        return "plan"
    return "included" if "group" in document else "board"


def faults(validator, document):
    """What the validator says, as `place: message`."""
    found = []
    for error in validator.iter_errors(document):
        found.append(f"{'/'.join(map(str, error.absolute_path))}: {error.message[:160]}")
    return found


def refused_for_its_form(document):
    """Whether a shipped plan is there to be refused by the reader of plans."""
    claims = [document[key] for key in ("refused", "warned") if isinstance(document.get(key), dict)]
    return any(claim.get("code", "").startswith("P") for claim in claims)


def library(schemas):
    """Every shipped file is valid."""
    counts = dict.fromkeys(schemas, 0)
    for path in sorted((ROOT / "plans/library").rglob("*.toml")):
        document = tomllib.loads(path.read_text())
        kind = kind_of(path, document)
        if "format" not in document or refused_for_its_form(document):
            continue
        counts[kind] += 1
        found = faults(schemas[kind], document)
        check(f"{path.relative_to(ROOT)} is valid", not found, found[:2])
    check("the library has plans and boards", counts["plan"] > 300 and counts["board"] > 4 and min(counts["suite"], counts["included"]) > 0, counts)
    print(f"valid: {counts}")


def broken(schemas, kind, folder, least):
    """The files of the readers' tests say in their first line which codes they are refused with."""
    refused = passed_over = 0
    for path in sorted(folder.glob("*.toml")):
        text = path.read_text()
        codes = re.findall(r"[PB]\d{4}", text.splitlines()[0])
        try:
            document = tomllib.loads(text)
        except tomllib.TOMLDecodeError:
            continue
        of_form = [code for code in codes if FORM.get(code) and FORM[code] != "unreadable text"]
        if not of_form or path.stem in BEYOND_JSON:
            passed_over += 1
            continue
        found = faults(schemas[kind], document)
        check(f"{path.relative_to(ROOT)} is refused ({', '.join(of_form)})", bool(found))
        refused += bool(found)
    check(f"broken files of {folder.parent.parent.name} that a schema can refuse", refused >= least, refused)
    print(f"refused: {refused} broken {kind}s; {passed_over} that only the reader can refuse")


def instrument(rig):
    """The file of the manual is valid, and slips in it are not."""
    text = subprocess.run([rig, "schema", "instrument"], capture_output=True, text=True, check=True).stdout
    jsonschema.Draft7Validator.check_schema(json.loads(text))
    schema = jsonschema.Draft7Validator(json.loads(text))
    manual = (ROOT / "docs/terminal.md").read_text()
    file = re.search(r"```toml\n(format = 1\ntitle = \"Oscilloscope.*?)```", manual, re.S).group(1)
    found = faults(schema, tomllib.loads(file))
    check("the instrument file of the manual is valid", not found, found[:2])
    for old, new in [("error", "eror"), ("resolution = \"10 ns\"", "resolution = 10"), ("plus", "of-range")]:
        check(f"an instrument file with {new} is refused", bool(faults(schema, tomllib.loads(file.replace(old, new, 1)))))


PLAN = {
    "format": 1,
    "program": "lamp.st",
    "signals": {"button": "%IX0.0", "lamp": "%QX0.4"},
    "steps": [{"id": "press", "at": "start + 1 s", "set": {"signal": "button", "value": True}}],
    "expect": [{"rises": {"signal": "lamp", "from": "press", "within": "500 ms .. 550 ms"}}],
}
STEP = PLAN["steps"][0]
RISES = PLAN["expect"][0]["rises"]

# A part of the plan that is replaced, and the place at which the schema must refuse it, or None where it must not.
SLIPS = [
    ({}, None),
    ({"format": 2}, "format"),
    ({"formt": 1}, ""),
    ({"program": ["a.st", "b.st"]}, None),
    ({"program": 5}, "program"),
    ({"program": "$program"}, None),
    ({"ends": "10 s"}, "ends"),
    ({"ends": "press + 10 s"}, None),
    ({"ends": "press + $wait"}, None),
    ({"timeout": "10"}, "timeout"),
    ({"timeout": "1 min 30 s"}, None),
    ({"timeout": 10}, "timeout"),
    ({"profiles": "$profiles"}, None),
    ({"signals": {"a": {"image": "%IX0.0"}}}, None),
    ({"signals": {"a": {"imag": "%IX0.0"}}}, "signals/a"),
    ({"settings": {"initial": "runing"}}, "settings/initial"),
    ({"settings": {"initial": "$initial"}}, None),
    ({"settings": {"mast": {"priority": 32}}}, "settings/mast/priority"),
    ({"settings": {"mast": {"priority": "$priority"}}}, None),
    ({"settings": {"filter": "4 ms"}}, None),
    ({"settings": {"filter": {"%IX0.0": "4 ms"}}}, None),
    ({"settings": {"tasks": {"FAST": {"interval": "1 ms", "prioritt": 1}}}}, "settings/tasks/FAST"),
    ({"parameters": {"wait": "200 ms", "long": {"default": 5, "doc": "x"}}}, None),
    ({"parameters": {"long": {"doc": "x"}}}, "parameters/long"),
    ({"sweep": {"shift": {"from": "0 ms", "to": "20 ms", "step": "5 ms"}}}, None),
    ({"sweep": {"shift": {"from": "0 ms", "til": "20 ms"}}}, "sweep/shift"),
    ({"rows": {"over": {"cycle": "101 ms", "n": [1, 2]}}}, None),
    ({"steps": [STEP | {"pulse": {"signal": "button", "width": "1 s"}}]}, "steps/0"),
    ({"steps": [{"id": "a", "at": "start"}]}, "steps/0"),
    ({"steps": [{"id": "a", "when": {"signal": "lamp", "becomes": True, "within": "1 s"}}]}, None),
    ({"steps": [{"at": "start", "mark": {}}]}, "steps/0"),
    ({"steps": [STEP | {"set": [{"signal": "a", "value": 1}, {"signal": "b", "value": 2}]}]}, None),
    ({"steps": [STEP | {"set": []}]}, "steps/0/set"),
    ({"steps": [STEP | {"set": {"signal": {"path": "MAIN.n"}, "value": "16#10"}}]}, None),
    ({"steps": [STEP | {"set": {"signal": "a"}}]}, "steps/0/set"),
    ({"steps": {"id": "a"}}, "steps"),
    ({"expect": [{"rises": RISES | {"within": "soon"}}]}, "expect/0/rises/within"),
    ({"expect": [{"rises": RISES | {"within": ".. 5 ms"}}]}, None),
    ({"expect": [{"rises": RISES | {"within": "100 ms ± 1 ms"}}]}, None),
    ({"expect": [{"rises": RISES | {"form": "press"}}]}, "expect/0/rises"),
    ({"expect": [{"raises": RISES}]}, "expect/0"),
    ({"expect": [{"rises": RISES, "falls": RISES}]}, "expect/0"),
    ({"expect": [{"rises": RISES, "rows": ["over"], "name": "lit"}]}, None),
    ({"measure": [{"name": "m", "from": "press", "to": {"signal": "lamp", "edge": "rises"}}]}, None),
    ({"measure": [{"name": "m", "from": "press", "to": "press.done"}]}, None),
    ({"measure": [{"from": "press", "to": "press.done"}]}, "measure/0"),
    ({"measure": [{"name": "m", "from": "press", "to": {"signal": "lamp", "edge": "up"}}]}, "measure/0/to"),
    ({"title": datetime.time(7, 30)}, "title"),
]


def slips(schema):
    """Slips that somebody makes are refused where they are; what only looks like one is not."""
    for part, place in SLIPS:
        errors = list(schema.iter_errors(PLAN | part))
        places = {"/".join(map(str, error.absolute_path)) for error in errors}
        if place is None:
            check(f"{part} is valid", not errors, places)
        else:
            check(f"{part} is refused at {place or 'the root'}", places == {place}, places)


def taplo(rig, folder):
    """Taplo finds the schema by the directive in the file, as editors do, and says the same."""
    tool = shutil.which("taplo", path=str(pathlib.Path(sys.executable).parent)) or shutil.which("taplo")
    check("taplo is installed", tool is not None)
    if tool is None:
        return
    for kind in ("plan", "board", "suite", "included"):
        (folder / f"{kind}.schema.json").write_text(subprocess.run([rig, "schema", kind], capture_output=True, text=True, check=True).stdout)

    def lint(*names):
        ran = subprocess.run([tool, "lint", *names], cwd=folder, capture_output=True, text=True)
        return ran.returncode, ran.stdout + ran.stderr

    directive = "#:schema ./plan.schema.json\n"
    good = []
    for path in sorted((ROOT / "plans/library").rglob("*.toml")):
        text = path.read_text()
        document = tomllib.loads(text)
        if path.name != "suite.toml" and is_plan(document) and not refused_for_its_form(document):
            name = str(path.relative_to(ROOT / "plans/library")).replace("/", "-")
            (folder / name).write_text(directive + text)
            good.append(name)
    code, said = lint(*good)
    check(f"taplo: {len(good)} shipped plans are valid", code == 0, said[-600:])
    for name, old, new in [
        ("key", "title = ", "titel = "),
        ("step", "at = \"start + 1 s\"", "at = \"1 s\""),
        ("verb", "set = ", "sett = "),
        ("range", "within = \"500 ms .. 550 ms\"", "within = \"500 .. 550 msec,\""),
    ]:
        text = (ROOT / "README.md").read_text()
        plan = re.search(r"```toml\n(format = 1.*?)```", text, re.S).group(1)
        check(f"taplo: README has {old}", old in plan)
        (folder / "slip.toml").write_text(directive + plan)
        check("taplo: the plan of the README is valid", lint("slip.toml")[0] == 0)
        (folder / "slip.toml").write_text(directive + plan.replace(old, new, 1))
        code, said = lint("slip.toml")
        check(f"taplo: a slip in a {name} is refused", code != 0, said[-300:])


def project(rig, folder):
    """A new project: Taplo finds the schemas by its configuration, and the jobs are what the CI servers read."""
    subprocess.run([rig, "new", "site"], cwd=folder, check=True, capture_output=True)
    site = folder / "site"
    bin = pathlib.Path(sys.executable).parent
    tool = lambda name, *args: subprocess.run([str(bin / name), *args], cwd=site, capture_output=True, text=True)
    ran = tool("taplo", "lint")
    check("project: taplo lint", ran.returncode == 0, ran.stderr[-300:])
    plan = site / "plans/start-stop.toml"
    # Without the line for editors that look at one file alone.
    plan.write_text(plan.read_text().split("\n", 1)[1].replace("until = ", "untill = "))
    check("project: taplo refuses a slip", tool("taplo", "lint").returncode != 0)
    for schema, job in [("vendor.gitlab-ci", ".gitlab-ci.yml"), ("vendor.github-workflows", ".github/workflows/rig.yml")]:
        ran = tool("check-jsonschema", "--builtin-schema", schema, job)
        check(f"project: {job}", ran.returncode == 0, ran.stdout[-300:])


def shells(rig, folder):
    """bash takes its completions and answers with them; groff sets the pages of the manual without a complaint."""
    script = folder / "rig.bash"
    script.write_text(subprocess.run([rig, "completions", "bash"], capture_output=True, text=True, check=True).stdout)
    ask = f"source {script}; COMP_WORDS=(rig plans ex); COMP_CWORD=2; _rig rig ex plans; echo ${{COMPREPLY[@]}}"
    said = subprocess.run(["bash", "-c", ask], capture_output=True, text=True)
    check("bash completes `rig plans ex`", said.stdout.split() == ["export"], said.stdout + said.stderr)
    subprocess.run([rig, "man", "man"], cwd=folder, check=True)
    pages = sorted((folder / "man").glob("*.1"))
    check("there are pages for man", len(pages) > 10, len(pages))
    if shutil.which("groff") is None:
        print("groff is not there: the pages for man are not set")
        return
    for page in pages:
        ran = subprocess.run(["groff", "-man", "-Tutf8", "-ww", "-z", str(page)], capture_output=True, text=True)
        check(f"{page.name} sets", ran.returncode == 0 and not ran.stderr, ran.stderr[:200])


def main():
    rig = str(pathlib.Path(sys.argv[1]).resolve())
    schemas = {}
    for kind in ("plan", "board", "suite", "included"):
        text = subprocess.run([rig, "schema", kind], capture_output=True, text=True, check=True).stdout
        schema = json.loads(text)
        jsonschema.Draft7Validator.check_schema(schema)
        schemas[kind] = jsonschema.Draft7Validator(schema)
    library(schemas)
    instrument(rig)
    broken(schemas, "plan", ROOT / "plans/tests/broken", 8)
    broken(schemas, "board", ROOT / "drivers/tests/broken", 3)
    slips(schemas["plan"])
    with tempfile.TemporaryDirectory() as folder:
        taplo(rig, pathlib.Path(folder))
    with tempfile.TemporaryDirectory() as folder:
        project(rig, pathlib.Path(folder))
        shells(rig, pathlib.Path(folder))
    finish()


if __name__ == "__main__":
    main()
