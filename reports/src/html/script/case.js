// A case in full: reason, diagram, claims, measurements, steps, tasks, log and evidence.

// A scale of the allowed range with what was found on it; nothing when there is no limit to show it against.
const gauge = (low, high, min, max, word, text) => {
  const ends = [min, max, low, high].filter(given);
  if ((!given(min) && !given(max)) || !ends.every(Number.isFinite)) return null;
  let [left, right] = [Math.min(...ends), Math.max(...ends)];
  // One limit above: the scale begins at 0, so that the distance to the limit means something.
  const fromZero = !given(min) && left >= 0;
  if (fromZero) left = 0;
  const room = Math.max((right - left) * 0.12, Math.abs(right) * 1e-6, 1e-9);
  right += room;
  if (!fromZero) left -= room;
  const x = (n) => 1 + 158 * Math.min(Math.max((n - left) / (right - left), 0), 1);
  const [from, until] = [given(min) ? x(min) : 1, given(max) ? x(max) : 159];
  const marks = [min, max].filter(given).map((n) => line("limitmark", x(n), 2, x(n), 16));
  const [a, b] = [x(low), x(high)];
  const found = b - a >= 3 ? s("rect", { class: `taken v-${word}`, x: px(a), y: 6, width: px(b - a), height: 6 }) : s("circle", { class: `taken v-${word}`, cx: px((a + b) / 2), cy: 9, r: 4 });
  return s("svg", { class: "gauge", viewBox: "0 0 160 18", width: 160, height: 18, role: "img", "aria-label": text }, line("axis", 1, 9, 159, 9), box("allowed", from, 5, Math.max(until - from, 1), 8), marks, found);
};

const claimGauge = (claim, record) => {
  const window = claim.window;
  if (!window || !claim.deciding_ns || !given(window.limit_until_ns)) return null;
  const zero = given(window.limit_from_ns) ? window.limit_from_ns : window.from_ns[0];
  const from = (t) => (given(t) ? t - zero : null);
  return gauge(...claim.deciding_ns.map(from), from(window.limit_from_ns), from(window.limit_until_ns), claim.verdict, `decided ${relative(claim.deciding_ns, record.start_ns)} from start`);
};

const measureGauge = (m) => {
  if (!m.value) return null;
  const [min, max] = bounds(m);
  return gauge(...m.value.map(number), min, max, m.verdict, `${measured(m)} within limits ${limits(m)}`);
};

const note = (name, text, code) => text && h("span", { class: "note" }, name && h("b", {}, name, " "), code ? h("span", { class: "code" }, text) : text);

const table = (kind, heads, rows) =>
  h("div", { class: "scroll" }, h("table", { class: kind }, h("thead", {}, h("tr", {}, heads.map(([text, number]) => h("th", { scope: "col", class: number ? "n" : null }, text)))), h("tbody", {}, rows)));

const placeOf = (check, record) => (check.line ? `${check.place_file ?? record.plan ?? ""}:${check.line}` : check.place_file ?? "");

const claimRow = (claim, n, record, choose) => {
  const title = claim.name === claim.expected ? "" : claim.expected;
  return h(
    "tr",
    { id: `claim-${record.place}-${n}` },
    h("td", {}, button(`Show claim ${n} in the diagram`, String(n), () => choose(claim), { class: `number v-${claim.verdict}`, "aria-pressed": "false" })),
    h("td", {}, badge(claim.verdict)),
    h("td", {}, claim.name, note("", title), note("", claim.guard ? `${claim.verb === "alarm" ? "alarm" : "invariant"} of the ${claim.origin ?? "plan"}` : ""), note("", placeOf(claim, record), true)),
    h(
      "td",
      {},
      claim.observed,
      note("", claim.reason),
      note("Nearest miss", claim.nearest_miss),
      note("Last writer", claim.last_writer, true),
      claim.verdict !== "pass" && claim.deciding_ns && note("Decided", `start ${relative(claim.deciding_ns, record.start_ns)}`),
    ),
    h("td", { class: "n" }, shown(claim.margin), claimGauge(claim, record)),
    h("td", { class: "n" }, shown(claim.uncertainty)),
  );
};

const measureRow = (m, record) =>
  h(
    "tr",
    {},
    h("td", {}, badge(m.verdict, m.verdict === "none" ? "no limits" : null)),
    h("td", {}, m.name, note("", m.reason), note("", placeOf(m, record), true)),
    h("td", { class: "n" }, measured(m), m.value && m.coverage && note("Coverage", m.coverage)),
    h("td", { class: "n" }, measureGauge(m)),
    h("td", {}, limits(m)),
    h("td", { class: "n" }, shown(m.margin)),
  );

const fact = (name, text, code, whole) => text && h("div", {}, h("dt", {}, name), h("dd", { class: code ? "code" : null, title: whole ?? null }, text));
const digest = (name, text) => text && fact(name, text.slice(0, 12), true, text);

const stepTable = (record) => {
  const phases = new Set(record.steps.map((step) => step.phase).filter(Boolean));
  return (
    record.steps.length > 0 &&
    table(
      "plain",
      [["Step"], ...(phases.size ? [["Phase"]] : []), ["From start", true], ["What it did"]],
      record.steps.map((step) =>
        h("tr", {}, h("td", { class: "code" }, step.id), phases.size > 0 && h("td", {}, step.phase), h("td", { class: "n" }, step.at_ns ? relative(step.at_ns, record.start_ns) : "never came"), h("td", {}, step.what)),
      ),
    )
  );
};

const taskTable = (record) =>
  record.tasks.length > 0 &&
  table(
    "plain",
    [["Task"], ["Period", true], ["Cycles", true], ["Shortest", true], ["Mean", true], ["Longest", true], ["Overruns", true], ["Watchdogs", true]],
    record.tasks.map((task) =>
      h(
        "tr",
        {},
        h("td", {}, task.name),
        [task.period_ns > 0 ? span(task.period_ns) : "–", task.cycles, span(task.cycle_min_ns), span(task.cycle_mean_ns), span(task.cycle_max_ns), task.overruns, task.watchdogs].map((text) => h("td", { class: "n" }, String(text))),
      ),
    ),
  );

const timingWords = (timing) =>
  timing && (timing.late_max_ns || timing.overruns || timing.dropped || timing.horizon_ns)
    ? `at most ${span(timing.late_max_ns)} late, ${plural(timing.overruns, "overrun")}, ${plural(timing.dropped, "event")} dropped, horizon ${span(timing.horizon_ns)}`
    : "";

const evidence = (record) => {
  const hashes = record.hashes ?? {};
  // A path of our own making; anything else is not followed.
  const file = (ending) => {
    const path = record.trace_file.replace(/\.trace$/, ending);
    const safe = /^traces\/[^/\\:]+\.(vcd|log)$/.test(path);
    return safe ? h("a", { href: path.split("/").map(encodeURIComponent).join("/") }, path) : record.trace_file;
  };
  const beside = (name, ending, more = "") => h("div", {}, h("dt", {}, name), h("dd", { class: "code" }, file(ending), more));
  return h(
    "dl",
    { class: "facts" },
    fact("Plan", record.plan, true),
    fact("Board", record.board, true),
    fact("Profile", record.profile),
    fact("Model", record.model),
    fact("Reference", record.reference),
    fact("Seed", String(record.seed), true),
    fact("Modelled time", span(record.duration_ns)),
    fact("Host time", `${record.host_ms} ms`),
    fact("Rig timing", timingWords(record.timing)),
    digest("Plan SHA-256", hashes.plan),
    digest("Board SHA-256", hashes.board),
    digest("Program SHA-256", hashes.program),
    digest("Capture SHA-256", hashes.capture),
    digest("Instrument SHA-256", record.instrument?.sha256),
    digest("Trace SHA-256", record.trace_sha256),
    record.trace_file && beside("Waves", ".vcd"),
    record.trace_file && record.frames && beside("CAN frames", ".log", record.frames.more > 0 ? ` (the first ${record.frames.kept}; ${record.frames.more} more found no room)` : ""),
  );
};

const logTable = (record) =>
  record.log.length > 0 && [
    table("plain log", [["From start", true], ["Log"]], record.log.map((entry) => h("tr", {}, h("td", { class: "n" }, offset(entry.at_ns - record.start_ns)), h("td", {}, entry.text)))),
    record.log_dropped > 0 && h("p", { class: "note" }, `${plural(record.log_dropped, "more line")} dropped: the log was full.`),
  ];

// A part that opens on demand.
// What the instrument that recorded the case says of its own errors.
const instrumentTable = (instrument) =>
  h(
    "div",
    {},
    h("p", { class: "meta" }, instrument.title && h("span", {}, instrument.title), h("span", { class: "code" }, instrument.file)),
    table(
      "plain",
      [["Of"], ["Key"], ["States"]],
      (instrument.statements ?? []).map((one) => h("tr", {}, h("td", { class: "code" }, one.of), h("td", { class: "code" }, one.key), h("td", {}, one.value))),
    ),
  );

const part = (name, content, open) => content && h("details", { class: "more", open }, h("summary", {}, name), content);

const caseBody = (record) => {
  const rows = new Map();
  const choose = (claim) => {
    const again = scope?.chosen === claim;
    scope?.fit(again ? null : claim);
    for (const [of, row] of rows) {
      const pressed = of === claim && !again;
      row.classList.toggle("chosen", pressed);
      row.querySelector("button").setAttribute("aria-pressed", String(pressed));
    }
    if (!again) rows.get(claim).scrollIntoView({ block: "nearest" });
  };
  const scope = record.lanes.length ? new Scope(record, choose) : null;
  record.claims.forEach((claim, at) => rows.set(claim, claimRow(claim, at + 1, record, choose)));
  const facts = [
    record.proves.length > 0 && h("span", {}, "Proves ", record.proves.map((id, at) => [at > 0 && ", ", h("a", { class: "code", href: link({ view: "requirements", requirement: id }) }, id)])),
    record.tags.length > 0 && h("span", {}, "Tags ", record.tags.join(", ")),
    record.parameters.length > 0 && h("span", {}, "Parameters ", h("span", { class: "code" }, record.parameters.map((p) => `${p.name} = ${p.value}`).join(", "))),
    h("span", {}, h("a", { href: link({ case: record.name }) }, "Link to this case")),
  ];
  const trouble = record.status.is === "judged" && bad(record.verdict);
  return h(
    "div",
    { class: "body" },
    trouble && record.why && h("p", { class: `reason v-${record.word}` }, record.why),
    h("p", { class: "meta" }, facts),
    scope?.element,
    rows.size > 0 && table("claims", [["#"], ["Verdict"], ["Claim"], ["Observed"], ["Margin", true], ["Uncertainty", true]], [...rows.values()]),
    record.measurements.length > 0 &&
      table("measurements", [["Verdict"], ["Measurement"], ["Value", true], ["Within limits", true], ["Limits"], ["Margin", true]], record.measurements.map((m) => measureRow(m, record))),
    part("Instrument", record.instrument && instrumentTable(record.instrument)),
    part("Steps and tasks", (record.steps.length > 0 || record.tasks.length > 0) && h("div", {}, stepTable(record), taskTable(record))),
    part(`Log, ${plural(record.log.length, "line")}`, record.log.length > 0 && h("div", {}, logTable(record))),
    part("Evidence", evidence(record)),
  );
};
