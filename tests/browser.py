#!/usr/bin/env python3
"""Drives the page of a report in headless Chromium: tests/browser.py LIBRARY VERDICTS PAGES

LIBRARY and VERDICTS are folders that `rig test --report` wrote, of the shipped library and of tests/verdicts; PAGES holds
pages of `cargo run -p scanrig-reports --example page`: html, hostile, extreme, repeated. Each is opened from its file.
Screenshots are left in PAGES. Prints what failed, then `N passed, M failed`; the exit code is 0 only without failures.
"""

import base64
import io
import json
import pathlib
import re
import shutil
import sys
import time
import urllib.parse

import pypdf
from selenium import webdriver
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

from tally import check, finish

LARGEST = 3_000_000
SECONDS = 20


def same(what, found, wanted):
    check(what, found == wanted, f"{found!r} and not {wanted!r}")


class Facts(dict):
    """A table of the record: what is left out there is empty."""

    def __missing__(self, key):
        lists = {"claims", "measurements", "steps", "lanes", "proves", "tags", "parameters", "requirements", "clauses"}
        return [] if key in lists else 0 if key.endswith("_ns") else ""


class Browser:
    """Chromium with one page."""

    def __init__(self, width=1280, height=900, dark=False, script=True):
        options = webdriver.ChromeOptions()
        for path in ["chromium", "chromium-headless-shell", "google-chrome"]:
            if shutil.which(path):
                options.binary_location = shutil.which(path)
                break
        # Without a sandbox, because tests run as root in a container; the network does not exist for it.
        for word in ["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--proxy-server=127.0.0.1:9",
                     f"--window-size={width},{height}"]:
            options.add_argument(word)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        service = webdriver.ChromeService(executable_path=shutil.which("chromedriver"))
        self.driver = webdriver.Chrome(options=options, service=service)
        self.run = self.driver.execute_script
        self.cdp = self.driver.execute_cdp_cmd
        self.cdp("Emulation.setDeviceMetricsOverride", {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False})
        if dark:
            self.cdp("Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": "dark"}]})
        if not script:
            self.cdp("Emulation.setScriptExecutionDisabled", {"value": True})

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.driver.quit()

    def open(self, path, state=None, script=True):
        """Opens a page, at a state of its address, and waits until it is drawn."""
        self.driver.get("about:blank")
        state = urllib.parse.urlencode(state or {})
        self.driver.get(pathlib.Path(path).resolve().as_uri() + (f"#{state}" if state else ""))
        if script:
            self.wait(f"{path} is drawn", "return document.documentElement.dataset.ready === 'yes'")

    def wait(self, what, script, *arguments):
        """Waits until a script returns something, and returns it."""
        until = time.monotonic() + SECONDS
        while time.monotonic() < until:
            found = self.run(script, *arguments)
            if found:
                return found
            time.sleep(0.02)
        check(what, False, f"not within {SECONDS} s")
        return None

    def settle(self):
        """Waits until what is pending has been drawn."""
        self.driver.execute_async_script("const done = arguments[0]; requestAnimationFrame(() => requestAnimationFrame(() => done()));")

    def one(self, selector):
        return self.driver.find_element(By.CSS_SELECTOR, selector)

    def all(self, selector):
        return self.driver.find_elements(By.CSS_SELECTOR, selector)

    def texts(self, selector):
        return self.run("return [...document.querySelectorAll(arguments[0])].map((node) => node.textContent)", selector)

    def keys(self, *keys):
        for key in keys:
            ActionChains(self.driver).send_keys(key).perform()
        self.settle()

    def quiet(self, what):
        """No message of the console, nothing fetched."""
        messages = [entry["message"] for entry in self.driver.get_log("browser")]
        check(f"{what}: console", not messages, messages[:3])
        fetched = self.run("return performance.getEntriesByType('resource').map((entry) => entry.name)")
        check(f"{what}: nothing is fetched", not fetched, fetched)

    def shot(self, path):
        self.settle()
        self.driver.save_screenshot(str(path))


# The diagram of the case that is open: where the ticks are, in nanoseconds from start; where an instant is drawn.
SCOPE = """
const stage = document.querySelector("details.case[open] .stage");
const svg = stage.querySelector("svg.diagram");
const units = { ns: 1, us: 1e3, ms: 1e6, s: 1e9 };
const frame = svg.getBoundingClientRect();
const factor = frame.width / svg.viewBox.baseVal.width;
const ticks = [...svg.querySelectorAll("text.small.mid")].map((text) => /^(-?[0-9.]+) (ns|us|ms|s)$/.exec(text.textContent) && ({
  t: Number(/^-?[0-9.]+/.exec(text.textContent)[0]) * units[text.textContent.split(" ")[1]],
  x: frame.left + Number(text.getAttribute("x")) * factor,
})).filter(Boolean);
"""


def scale(browser):
    """Nanoseconds of a pixel, and the instant (from start) at a place of the window; of an unbroken axis."""
    ticks = browser.run(SCOPE + "return ticks")
    (a, b) = (ticks[0], ticks[-1])
    per_pixel = (b["t"] - a["t"]) / (b["x"] - a["x"])
    return per_pixel, lambda x: a["t"] + (x - a["x"]) * per_pixel, lambda t: a["x"] + (t - a["t"]) / per_pixel


def point(browser, x, down=None):
    """The pointer at a place of the diagram."""
    top = browser.run(SCOPE + "return frame.top + frame.height / 2")
    actions = ActionChains(browser.driver, duration=0)
    actions.w3c_actions.pointer_action.move_to_location(round(x), round(top))
    return actions


def summary(folder, browser):
    record = json.loads((folder / "record.json").read_text(), object_hook=Facts)
    cases = record["cases"]
    browser.open(folder / "index.html")
    totals = record["totals"]
    word = browser.one("header").get_attribute("class").removeprefix("v-")
    order = [("error", "errors"), ("fail", "failed"), ("inconclusive", "inconclusive"), ("pass", "passed")]
    same(f"{folder.name}: verdict", word, next(name for name, key in order if totals[key]))
    executed = browser.one(".executed").text
    judged = sum(totals[key] for _, key in order) + totals["none"]
    check(f"{folder.name}: planned and executed", f"{len(cases)} planned, {judged} executed" in executed, executed)
    check(f"{folder.name}: tab of the cases", browser.one("#tab-cases").text == f"Cases {len(cases)}", browser.one("#tab-cases").text)
    rows = {row.text.split("\n")[0].split(" ", 2)[-1] for row in browser.all(".attention a")}
    attention = {case["name"] for case in cases if case["status"]["is"] == "judged" and case["verdict"] != "pass"}
    same(f"{folder.name}: what needs attention", rows, attention)
    browser.quiet(folder.name)
    return record


def filters(folder, record, browser):
    """The numbers that the filter shows are those of the record."""
    cases = record["cases"]

    def shown():
        browser.settle()
        return browser.one(".filter .shown").text

    def want(what, wanted):
        same(f"{folder.name}: filter by {what}", shown(), f"{len(wanted)} of {len(cases)} cases shown")
        # What is listed is what was wanted, as far as rows are made.
        names = set(browser.run("return [...document.querySelectorAll('.folder:not([hidden])[open] details.case')].map((c) => c.dataset.name)"))
        check(f"{folder.name}: rows of {what}", names and names <= {case["name"] for case in wanted}, sorted(names)[:3])

    def folder_of(name):
        return name[: max(name.split("[")[0].rfind("/"), 0)]

    browser.open(folder / "index.html", {"view": "cases"})
    check(f"{folder.name}: the whole library is not unfolded at once", len(browser.all("details.case")) < len(cases))
    text = browser.one(".filter input[type=search]")
    text.send_keys("watchdog")
    words = lambda case: "\n".join([case["name"], case["title"], case["plan"], case["reason"], *case["proves"], *case.get("tags", []), *(f"{p['name']} = {p['value']}" for p in case["parameters"])])
    want("text", [case for case in cases if "watchdog" in words(case).lower()])
    address = browser.driver.current_url
    check("the filter is in the address", "text=watchdog" in address, address)
    browser.one(".filter .reset").click()
    same("reset", shown(), "")
    wanted = [case for case in cases if folder_of(case["name"]) == "watchdog"]
    browser.run("const s = document.querySelector('select[name=folder]'); s.value = 'watchdog'; s.dispatchEvent(new Event('input', {bubbles: true}))")
    want("folder", wanted)
    browser.one(".filter .reset").click()
    one = next(id for case in cases for id in case["proves"] if "#" not in id)
    browser.run("const s = document.querySelector('select[name=requirement]'); s.value = arguments[0]; s.dispatchEvent(new Event('input', {bubbles: true}))", one)
    want("requirement", [case for case in cases if any(id.split("#")[0] == one for id in case["proves"])])
    # A link with a filter leads to the same cases; one to a case opens it.
    browser.open(folder / "index.html", {"view": "cases", "folder": "watchdog"})
    want("a link", wanted)
    browser.open(folder / "index.html", {"case": cases[-1]["name"]})
    same("a link to a case", browser.run("return document.querySelector('details.case[open]').dataset.name"), cases[-1]["name"])
    browser.quiet(f"{folder.name}: filter")


def requirements(folder, record, browser):
    browser.open(folder / "index.html", {"view": "requirements"})
    cited = {id.split("#")[0] for case in record["cases"] for id in case["proves"]}
    rows = browser.run("return [...document.querySelectorAll('.matrix tr[data-id]:not(.clause)')].map((row) => row.dataset.id)")
    same("requirements: rows", set(rows), cited)
    asks = browser.run("return [...document.querySelectorAll('.matrix tr[data-id]:not(.clause)')].filter((row) => row.children[2].textContent).length")
    same("requirements: each says what it asks", asks, len(rows))
    clauses = {f"{fact['id']}#{clause['id']}" for fact in record["requirements"] for clause in fact.get("clauses", [])}
    shown = set(browser.run("return [...document.querySelectorAll('.matrix tr.clause')].map((row) => row.dataset.id)"))
    same("requirements: clauses", shown, clauses | {id for case in record["cases"] for id in case["proves"] if "#" in id})
    said = browser.run("return [...document.querySelectorAll('.matrix tr[data-id]')].map((row) => [row.dataset.id, row.children[3].textContent])")
    known = {fact["id"]: fact for fact in record["requirements"]}
    known |= {f"{fact['id']}#{clause['id']}": clause for fact in record["requirements"] for clause in fact.get("clauses", [])}
    wanted = {id: ": ".join(filter(None, [fact["status"], fact.get("note")])) for id, fact in known.items()}
    same("requirements: how far they are proven", {id: text for id, text in said if text}, wanted)
    browser.one(".matrix .proofs a").click()
    browser.settle()
    check("requirements: a row leads to its cases", browser.run("return !document.getElementById('view-cases').hidden"))
    browser.quiet("requirements")


def verdicts(folder, record, browser):
    """What a case says, by verdict; and the filter by verdict."""
    browser.open(folder / "index.html", {"view": "cases"})
    browser.one("input[name=verdict][value=pass]").click()
    browser.settle()
    left = browser.run("return [...document.querySelectorAll('.folder:not([hidden]) details.case')].map((c) => c.dataset.verdict)")
    check("filter by verdict", left and "pass" not in left, left)
    for case in record["cases"]:
        browser.open(folder / "index.html", {"case": case["name"]})
        rows = browser.run("return [...document.querySelectorAll('details.case[open] .claims tbody tr')].map((row) => [...row.cells].map((cell) => cell.textContent))")
        same(f"{case['name']}: claims", len(rows), len(case["claims"]))
        for row, claim in zip(rows, case["claims"]):
            for said in [claim["observed"], claim["reason"], claim["nearest_miss"], claim["last_writer"]]:
                check(f"{case['name']}: {said}", not said or said in row[3], row[3])
    browser.quiet("verdicts")


def static(folder, record, shots):
    """Without the script the summary and every failure are there, with the same figures."""
    with Browser(script=False) as browser:
        browser.open(folder / "index.html", script=False)
        browser.driver.save_screenshot(str(shots / "without-script.png"))
        text = browser.one("main").text
        for case in record["cases"]:
            if case["status"]["is"] != "judged" or case["verdict"] == "pass":
                continue
            check(f"static: {case['name']}", case["name"] in text)
            for claim in case["claims"]:
                if claim["verdict"] in ("fail", "inconclusive"):
                    check(f"static: {claim['observed']}", claim["observed"] in text)
        margins = [cell.text for cell in browser.all(".static td.n")]
        check("static: the hint", "does not run" in text, text[:200])
    with Browser() as browser:
        # Figures are written twice, in Rust and in the script: they have to be the same.
        seen = []
        for name in [case["name"] for verdict in ("error", "fail", "inconclusive") for case in record["cases"] if case["verdict"] == verdict]:
            browser.open(folder / "index.html", {"case": name})
            seen += browser.run("return [...document.querySelectorAll('details.case[open] :is(.claims, .measurements) tbody tr')].filter((row) => /fail|inconclusive/.test(row.querySelector('.badge').className)).map((row) => (row.closest('.claims') ? row.cells[4] : row.cells[5]).textContent)")
        same("static and drawn margins", seen, margins)


def zoom(folder, record, browser):
    """Buttons, keys and wheel change the scale as they should; dragging moves."""
    case = next(case for case in record["cases"] if case["verdict"] == "fail")
    browser.open(folder / "index.html", {"case": case["name"]})
    press = lambda name: browser.one("details.case[open] .tools").find_element(By.XPATH, f".//button[@aria-label='{name}' or text()='{name}']").click()
    browser.run("document.querySelector('details.case[open] .scope').scrollIntoView({block: 'center'})")
    press("Whole case")
    browser.settle()
    whole, _, _ = scale(browser)
    seen = browser.run(SCOPE + "return [ticks[0].t, ticks.at(-1).t]")
    check("whole case: all of it is seen", seen[0] <= 0 and seen[1] >= 0.7 * (case["end_ns"] - case["start_ns"]), seen)
    press("Zoom in")
    browser.settle()
    half, _, _ = scale(browser)
    check("zoom in: half as many nanoseconds a pixel", abs(half / whole - 0.5) < 0.01, half / whole)
    browser.one("details.case[open] .stage").send_keys("+")
    browser.settle()
    quarter, at, _ = scale(browser)
    check("zoom by key", abs(quarter / whole - 0.25) < 0.01, quarter / whole)
    # The wheel alone belongs to the page; with Ctrl it zooms about the pointer.
    x = browser.run(SCOPE + "return frame.left + frame.width * 0.6")
    before = at(x)
    wheel = "const e = new WheelEvent('wheel', {deltaY: -400, ctrlKey: arguments[0], clientX: arguments[1], clientY: frame.top + 60, bubbles: true, cancelable: true}); svg.dispatchEvent(e); return e.defaultPrevented"
    check("the wheel alone scrolls the page", not browser.run(SCOPE + wheel, False, x))
    check("Ctrl and wheel zoom", browser.run(SCOPE + wheel, True, x))
    browser.settle()
    finer, at, _ = scale(browser)
    check("wheel: finer", finer < quarter * 0.7, finer / quarter)
    check("wheel: what is under the pointer stays", abs(at(x) - before) < 2 * quarter, at(x) - before)
    point(browser, x).perform()
    actions = ActionChains(browser.driver, duration=50)
    top = browser.run(SCOPE + "return frame.top + frame.height / 2")
    pointer = actions.w3c_actions.pointer_action
    pointer.move_to_location(round(x), round(top))
    pointer.pointer_down()
    pointer.move_to_location(round(x) - 40, round(top))
    pointer.move_to_location(round(x) - 120, round(top))
    pointer.pointer_up()
    held = at(x)
    actions.perform()
    browser.settle()
    _, at, _ = scale(browser)
    check("dragging pans", abs(at(x - 120) - held) < 3 * finer, (at(x - 120) - held) / finer)
    check("a drag sets no cursor", not browser.all("details.case[open] .cursors .handle"))
    press("Claims")
    browser.quiet("zoom")


def cursors(folder, record, browser, shots):
    """Two clicks near edges measure between the edges, as well as both are known."""
    for verdict, wanted in [("fail", "520.035 ms"), ("inconclusive", "540.035 ms .. 567.982643 ms")]:
        case = next(case for case in record["cases"] if case["verdict"] == verdict)
        browser.open(folder / "index.html", {"case": case["name"]})
        browser.run("document.querySelector('details.case[open] .scope').scrollIntoView({block: 'center'})")
        browser.one("details.case[open] .stage").send_keys("0")
        browser.settle()
        _, _, place = scale(browser)
        press = next(step for step in case["steps"] if step["id"] == "press")["at_ns"][0] - case["start_ns"]
        claim = next(claim for claim in case["claims"] if claim["verdict"] == verdict)
        edge = sum(claim["deciding_ns"]) / 2 - case["start_ns"]
        check(f"{verdict}: the record says the same", wanted in claim["observed"], claim["observed"])
        wheel = "svg.dispatchEvent(new WheelEvent('wheel', {deltaY: -400, ctrlKey: true, clientX: arguments[0], clientY: frame.top + 60, bubbles: true, cancelable: true}))"
        for t, aside in [(press, -3), (edge, 3)]:
            actions = point(browser, place(t) + aside)
            actions.w3c_actions.pointer_action.click()
            actions.perform()
            # The edge and the limit that it misses are a pixel apart: what one does then is to zoom.
            for _ in range(5 if t == press else 0):
                browser.settle()
                browser.run(SCOPE + wheel, place(edge))
            browser.settle()
            _, _, place = scale(browser)
        reading = browser.texts("details.case[open] .reading .cell .code")
        same(f"{verdict}: A, B and the distance", reading[2:], [wanted])
        browser.shot(shots / f"cursors-{verdict}.png")
        browser.one("details.case[open] .stage").send_keys("0")
        browser.settle()
        _, _, place = scale(browser)
        # A cursor is taken hold of and moved to the edge where the button is let go.
        drag = point(browser, place(edge))
        pointer = drag.w3c_actions.pointer_action
        top = round(browser.run(SCOPE + "return frame.top + frame.height / 2"))
        pointer.pointer_down()
        pointer.move_to_location(round(place(press)) + 30, top)
        pointer.move_to_location(round(place(press)) - 2, top)
        pointer.pointer_up()
        drag.perform()
        browser.settle()
        same(f"{verdict}: dragged onto the same edge", browser.texts("details.case[open] .reading .cell .code")[2:], ["0 s"])
        browser.one("details.case[open] .stage").send_keys(Keys.ESCAPE)
        same(f"{verdict}: cleared", browser.texts("details.case[open] .reading .cell"), [])
    browser.quiet("cursors")


def keyboard(folder, record, browser):
    """From the top of the page to a distance between two edges without a mouse."""
    case = next(case for case in record["cases"] if case["verdict"] == "fail")
    browser.open(folder / "index.html")

    def focused(script):
        return browser.run(f"const f = document.activeElement; return {script}")

    def tab(what, script, most=80):
        for _ in range(most):
            browser.keys(Keys.TAB)
            if focused(script):
                return
        check(f"keyboard: Tab reaches {what}", False, focused("f.outerHTML.slice(0, 80)"))

    tab("the tabs", "f.id === 'tab-overview'")
    browser.keys(Keys.ARROW_RIGHT)
    check("keyboard: an arrow shows the cases", browser.run("return !document.getElementById('view-cases').hidden"))
    check("keyboard: and stays on the tabs", focused("f.id === 'tab-cases'"))
    tab("a case", f"f.tagName === 'SUMMARY' && f.parentElement.dataset.name === {json.dumps(case['name'])}")
    check("keyboard: the focus is seen", focused("getComputedStyle(f).outlineStyle !== 'none'"))
    browser.keys(Keys.ENTER)
    browser.wait("the case opens", "return document.querySelector('details.case[open] .stage')")
    tab("the diagram", "f.classList.contains('stage')")
    # Only edges of the lamp; A on the button's press is the first edge of all, so choose the signal by its name.
    names = [lane["signal"] for lane in case["lanes"]]
    for _ in range(names.index("button") + 1):
        browser.keys(Keys.ARROW_DOWN)
    browser.keys(Keys.ARROW_RIGHT, "b")
    for _ in range(names.index("lamp") - names.index("button")):
        browser.keys(Keys.ARROW_DOWN)
    browser.keys(Keys.ARROW_RIGHT)
    cells = browser.texts("details.case[open] .reading .cell")
    check("keyboard: A, B and the distance", len(cells) == 3 and "520.035 ms" in cells[2], cells)
    spoken = browser.texts("details.case[open] [role=status]")
    check("keyboard: what is read aloud", "button rises" in spoken[0] and "lamp rises" in spoken[0] and "520.035 ms" in spoken[0], spoken)
    ActionChains(browser.driver).key_down(Keys.SHIFT).send_keys(Keys.ARROW_RIGHT).key_up(Keys.SHIFT).perform()
    browser.settle()
    check("keyboard: Shift moves off the edge", "lamp rises" not in browser.texts("details.case[open] [role=status]")[0])
    browser.keys(Keys.TAB)
    check("keyboard: Tab leaves the diagram", not focused("f.classList.contains('stage')"))
    browser.quiet("keyboard")


def reachable(path, browser):
    """Names for everything that can be pressed or seen, IDs once, words for pictures, contrast."""
    browser.open(path, {"view": "cases"})
    browser.run("document.querySelectorAll('details').forEach((d) => { d.open = true; })")
    browser.wait("all is drawn", "return document.querySelectorAll('details.case[open] .body').length === document.querySelectorAll('details.case').length")
    nameless = browser.run("return [...document.querySelectorAll('button, input, select, [role=img], [role=application], a')].filter((n) => !(n.getAttribute('aria-label') || n.textContent.trim() || n.closest('label'))).map((n) => n.outerHTML.slice(0, 90))")
    check("everything has a name", not nameless, nameless[:3])
    twice = browser.run("const ids = [...document.querySelectorAll('[id]')].map((n) => n.id); return ids.filter((id, at) => ids.indexOf(id) !== at)")
    check("every ID is there once", not twice, twice[:3])
    broken = browser.run("return [...document.querySelectorAll('[aria-describedby], [aria-controls], [aria-labelledby]')].flatMap((n) => ['aria-describedby', 'aria-controls', 'aria-labelledby'].map((a) => n.getAttribute(a))).filter((id) => id && !document.getElementById(id))")
    check("references lead somewhere", not broken, broken[:3])


def contrast(path):
    """Text and verdicts stand out from the ground as WCAG AA asks, 4.5 to 1, in both schemes."""

    def luminance(colour):
        parts = [int(colour[at:at + 2], 16) / 255 for at in (1, 3, 5)]
        r, g, b = [part / 12.92 if part <= 0.03928 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
        return 0.2126 * r + 0.7152 * g + 0.0722 * b

    for dark in (False, True):
        with Browser(dark=dark) as browser:
            browser.open(path)
            colour = lambda name: browser.run("return getComputedStyle(document.documentElement).getPropertyValue(arguments[0]).trim()", f"--{name}")
            for ground in ("ground", "panel"):
                for ink in ("ink", "soft", "link", "pass", "fail", "inconclusive", "error", "quiet"):
                    a, b = sorted([luminance(colour(ink)), luminance(colour(ground))], reverse=True)
                    ratio = (a + 0.05) / (b + 0.05)
                    check(f"contrast of {ink} on {ground}, {'dark' if dark else 'light'}", ratio >= 4.5, round(ratio, 2))


def tags(pages, browser):
    browser.open(pages / "html.html", {"view": "cases", "tag": "power"})
    names = browser.run("return [...document.querySelectorAll('.folder:not([hidden]) details.case')].map((c) => c.dataset.name)")
    check("filter by tag", names and all(name.startswith("memory/") for name in names), names)
    # Limits of values are drawn in the lane of an analog signal.
    browser.run("document.querySelector('details.case').open = true")
    browser.wait("the case opens", "return document.querySelector('details.case[open] svg.diagram .bound')")
    browser.quiet("tags")


def hostile(pages, browser):
    browser.open(pages / "hostile.html", {"view": "cases"})
    browser.run("document.querySelectorAll('details').forEach((d) => { d.open = true; })")
    browser.settle()
    same("hostile: scripts of the page", len(browser.all("script")), 2)
    check("hostile: names are shown", any("<script>alert(1)</script>" in text for text in browser.texts("summary b")))
    text = browser.run("return document.body.textContent")
    check("hostile: nothing invisible acts", not re.search("[\u0000-\u0008\u001b\u202e]", text))
    outside = browser.run("return [...document.querySelectorAll('a[href]')].map((a) => a.getAttribute('href')).filter((href) => !href.startsWith('#') && !href.startsWith('traces/'))")
    check("hostile: links stay here", not outside, outside[:3])
    browser.quiet("hostile")


def extreme(pages, browser):
    """Cases that no rig would write are drawn, and nothing in the drawings is no number."""
    browser.open(pages / "extreme.html", {"view": "cases"})
    browser.run("document.querySelectorAll('details').forEach((d) => { d.open = true; })")
    browser.wait("all is drawn", "return document.querySelectorAll('details.case[open] .body').length === document.querySelectorAll('details.case').length")
    same("extreme: diagrams", len(browser.all("svg.diagram")), 60)
    for button in ["Whole case", "Claims"]:
        browser.run("document.querySelectorAll('.tools button').forEach((b) => { if (b.textContent === arguments[0]) b.click(); })", button)
        browser.settle()
        odd = browser.run("return [...document.querySelectorAll('svg *')].filter((n) => [...n.attributes].some((a) => /NaN|Infinity|undefined/.test(a.value))).map((n) => n.outerHTML.slice(0, 120))")
        check(f"extreme: {button}", not odd, odd[:3])
    for key in ["+", "+", Keys.ARROW_RIGHT, "b", Keys.ARROW_LEFT, "-", Keys.PAGE_DOWN]:
        for stage in browser.all(".stage")[:20]:
            stage.send_keys(key)
    browser.settle()
    browser.quiet("extreme")


def repeats(pages, browser, shots):
    browser.open(pages / "repeated.html", {"view": "repeats"})
    rows = browser.run("return [...document.querySelectorAll('.repeats tbody tr')].map((row) => [...row.cells].map((cell) => cell.textContent))")
    check("repeats: figures", rows and rows[0][:2] == ["fall", "10"] and rows[0][2] == "100.2 ms", rows[:1])
    check("repeats: a dot for each turn", browser.run("return document.querySelector('.strip').querySelectorAll('circle').length") == 10)
    browser.shot(shots / "repeats.png")
    browser.quiet("repeats")


def paper(folder, record, browser, shots):
    """A print to PDF has the summary, the environment and every failure with its diagram and claims."""
    browser.open(folder / "index.html")
    pdf = base64.b64decode(browser.cdp("Page.printToPDF", {"printBackground": True})["data"])
    (shots / "print.pdf").write_bytes(pdf)
    text = "\n".join(page.extract_text() for page in pypdf.PdfReader(io.BytesIO(pdf)).pages)
    plain = re.sub(r"\s+", "", text)
    wanted = ["Environment", "time from start", "Margin"]
    for case in record["cases"]:
        if case["verdict"] in ("fail", "inconclusive", "error"):
            wanted += [case["name"], *(claim["observed"] for claim in case["claims"])]
    for words in wanted:
        check(f"print: {words}", re.sub(r"\s+", "", words) in plain)
    browser.settle()
    check("print: closed again", not browser.all("details.case[open]"))
    browser.quiet("print")


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    library, some, pages = map(pathlib.Path, sys.argv[1:])
    size = (library / "index.html").stat().st_size
    check("the library's page is under 3 MB", size < LARGEST, size)
    print(f"the library's page has {size} bytes")
    with Browser() as browser:
        record = summary(library, browser)
        browser.shot(pages / "library.png")
        filters(library, record, browser)
        requirements(library, record, browser)
        browser.shot(pages / "requirements.png")
        record = summary(some, browser)
        browser.shot(pages / "verdicts.png")
        verdicts(some, record, browser)
        zoom(some, record, browser)
        cursors(some, record, browser, pages)
        keyboard(some, record, browser)
        paper(some, record, browser, pages)
        for name in ["html", "repeated"]:
            reachable(pages / f"{name}.html", browser)
        browser.quiet("every case open")
        repeats(pages, browser, pages)
        tags(pages, browser)
        hostile(pages, browser)
        extreme(pages, browser)
    static(some, record, pages)
    contrast(pages / "html.html")
    for name, size in {"narrow": {"width": 400}, "dark": {"dark": True}}.items():
        with Browser(**size) as browser:
            browser.open(pages / "html.html", {"case": "watchdog/fallback[over]"})
            browser.shot(pages / f"{name}.png")
            wide = browser.run("return document.documentElement.scrollWidth - innerWidth")
            check(f"{name}: nothing sticks out", wide <= 0, wide)
            browser.quiet(name)
    finish()


if __name__ == "__main__":
    main()
