// The first view: what needs attention, what came nearest to its limits, the folders, the environment.
const MOST_ROWS = 100;
const NEAREST = 12;

const heading = (level, text) => h(level, {}, text);

// Why a case did not pass, in a line: an exception that failed it, else the first claim or measurement of its verdict.
const cause = (record) => {
  if (record.exception && record.verdict === "fail") return record.exception;
  const claim = record.claims.find((c) => c.verdict === record.verdict);
  if (claim) return `${claim.name}: ${claim.observed || claim.reason}`;
  const m = record.measurements.find((c) => c.verdict === record.verdict);
  return m ? `${m.name}: ${measured(m)} (limits ${limits(m)})` : record.why;
};

const attention = (run) => {
  const list = run.cases.filter((record) => record.status.is === "judged" && record.word !== "pass");
  if (!list.length) return null;
  const sorted = [...list].sort((a, b) => ORDER.indexOf(b.word) - ORDER.indexOf(a.word) || a.place - b.place);
  const rows = sorted.slice(0, MOST_ROWS).map((record) => {
    const claim = record.claims.find((c) => c.verdict === record.verdict);
    return h(
      "li",
      {},
      h("a", { href: link({ case: record.name }) }, badge(record.word), " ", h("b", {}, record.name)),
      h("span", { class: "why" }, cause(record)),
      claim?.nearest_miss && h("span", { class: "why" }, h("b", {}, "Nearest miss "), claim.nearest_miss),
    );
  });
  const rest = list.length - rows.length;
  return h("section", {}, heading("h2", "Needs attention"), h("ul", { class: "attention" }, rows), rest > 0 && h("p", {}, h("a", { href: link({ view: "cases", verdict: "error,fail,inconclusive,none" }) }, `${rest} more`)));
};

const nearestTable = (run) => {
  const list = run.cases
    .flatMap((record) => record.checks.map((check) => ({ record, check, near: nearness(check) })))
    .filter(({ near, check }) => near !== null && Number.isFinite(near) && near >= 0 && check.verdict === "pass")
    .sort((a, b) => a.near - b.near || a.record.place - b.record.place);
  if (!list.length) return null;
  // A plan once: its rows, profiles and turns are alike.
  const plans = new Set();
  const first = list.filter(({ record }) => !plans.has(record.plan) && plans.add(record.plan)).slice(0, NEAREST);
  const rows = first.map(({ record, check, near }) =>
    h(
      "tr",
      {},
      h("td", {}, h("a", { href: link({ case: record.name }) }, record.name)),
      h("td", {}, check.name),
      h("td", { class: "n" }, shown(check.margin)),
      h("td", { class: "n" }, `${Number((near * 100).toPrecision(2))} %`),
      h("td", { class: "n" }, "window" in check ? claimGauge(check, record) : measureGauge(check)),
    ),
  );
  return h("section", {}, heading("h2", "Nearest to their limits"), h("p", { class: "lead" }, "What passed with the least headroom, one row per plan: 0 % is at the limit, 100 % in the middle between both limits."), table("nearest", [["Case"], ["Claim or measurement"], ["Margin", true], ["Headroom", true], ["", true]], rows));
};

const folderTable = (run) => {
  const folders = new Map();
  for (const record of run.cases) {
    const counts = folders.get(record.folder) ?? {};
    counts[record.word] = (counts[record.word] ?? 0) + 1;
    counts.host = (counts.host ?? 0) + record.host_ms;
    folders.set(record.folder, counts);
  }
  if (folders.size < 2) return null;
  const words = ORDER.filter((word) => run.cases.some((record) => record.word === word)).reverse();
  const most = Math.max(...[...folders.values()].map((counts) => words.reduce((sum, word) => sum + (counts[word] ?? 0), 0)));
  const rows = [...folders].map(([name, counts]) => {
    const bars = [];
    let x = 0;
    for (const word of words) {
      const width = (200 * (counts[word] ?? 0)) / most;
      if (width > 0) bars.push(box(`fill v-${word}`, x, 3, Math.max(width - 1, 1), 10));
      x += width;
    }
    const worstWord = worst(words.filter((word) => counts[word]));
    return h(
      "tr",
      {},
      h("td", {}, h("a", { href: link({ view: "cases", folder: name }) }, name || "Plans")),
      h("td", {}, badge(worstWord)),
      words.map((word) => h("td", { class: "n" }, counts[word] ? String(counts[word]) : h("span", { class: "soft" }, "·"))),
      h("td", {}, s("svg", { class: "bars", viewBox: "0 0 200 16", width: 200, height: 16, "aria-hidden": "true" }, bars)),
    );
  });
  return h("section", {}, heading("h2", "Folders"), table("folders", [["Folder"], ["Verdict"], ...words.map((word) => [WORDS[word] ?? word, true]), [""]], rows));
};

// How well the rig kept time over all cases; nothing in virtual time, where it does not count.
const quality = (run) => {
  const total = { late_max_ns: 0, overruns: 0, dropped: 0, horizon_ns: 0, late: 0 };
  for (const { timing } of run.cases) {
    if (!timing) continue;
    total.late_max_ns = Math.max(total.late_max_ns, timing.late_max_ns);
    total.horizon_ns = Math.max(total.horizon_ns, timing.horizon_ns);
    total.overruns += timing.overruns;
    total.dropped += timing.dropped;
    total.late += timing.overruns > 0 || timing.dropped > 0 ? 1 : 0;
  }
  return total;
};

const environment = (run) => {
  const p = run.provenance;
  const total = quality(run);
  const boards = [...new Set(run.cases.map((record) => record.board).filter(Boolean))];
  const references = [...new Set(run.cases.map((record) => record.reference).filter(Boolean))];
  const real = p.clock === "real";
  const modelled = run.cases.reduce((sum, record) => sum + record.duration_ns, 0);
  const host = run.cases.reduce((sum, record) => sum + record.host_ms, 0);
  const whole = run.host_ms > 0 ? `${rounded(run.host_ms * 1e6, 4)}, ` : "";
  const rows = [
    ["Clock", p.clock === "real" ? "real: the host's monotonic clock" : "virtual: modelled time, from event to event"],
    ["Timing quality", real ? `${timingWords(total) || "no deadline missed"}; ${plural(total.late, "case")} with rig faults` : "exact: no figure depends on how fast the host was"],
    ["Modelled time", rounded(modelled, 6)],
    ["Host time", `${whole}${rounded(host * 1e6, 4)} over all cases`],
    ...(p.environment ?? []),
    ["Kernel", p.kernel],
    ["Processor", p.host_cpu],
    ["rig", run.rig_version],
    ["rig SHA-256", p.binary_sha256],
    ["Seed", String(p.seed)],
    ["Profiles", (p.profiles ?? []).join(", ")],
    ["References", references.join(", ")],
    ["Boards", boards.join(", ")],
    ["Started", p.started],
    ["Command", p.arguments?.length ? `rig ${p.arguments.join(" ")}` : ""],
  ];
  const trouble = real && (total.overruns > 0 || total.dropped > 0);
  return h(
    "section",
    {},
    heading("h2", "Environment"),
    trouble && h("p", { class: "reason v-error" }, `The rig missed ${plural(total.overruns, "deadline")} of its own and lost ${plural(total.dropped, "event")}: figures of those cases say nothing about the controller.`),
    h("div", { class: "scroll" }, h("table", { class: "environment" }, h("tbody", {}, rows.filter(([, text]) => text).map(([name, text]) => h("tr", {}, h("th", { scope: "row" }, name), h("td", {}, text)))))),
  );
};

const guide = () =>
  h(
    "section",
    { class: "legend" },
    heading("h2", "How to read a diagram"),
    h("p", {}, "Time runs from the plan's start. A number in a box is the claim of that row in the table; its tint is the window in which the claim looks, the stronger tint with lines at its ends what it allows. A vertical line with a box is the instant that decided a claim without a pass. Hatched edges happened somewhere within the hatched interval; widely hatched stretches are unknown; a dashed middle line is high impedance; a comb is many changes too close together to be distinguished. Where time is left out the axis is broken; zoom in to see it."),
    h("p", {}, "Cursors snap to edges. A distance to an edge that is known only to within an interval is itself an interval."),
    h("p", {}, "A claim passes if it holds for every placement of the events inside their intervals, fails if it holds for none, and is inconclusive otherwise. An error is a fault of the rig itself and says nothing about the controller. A margin is the distance to the nearest limit in the worst placement."),
    h(
      "table",
      { class: "plain keys" },
      h("thead", {}, h("tr", {}, h("th", { scope: "col" }, "Key in a diagram"), h("th", { scope: "col" }, "Does"))),
      h(
        "tbody",
        {},
        [
          ["← →", "active cursor to the previous or next edge; with Shift by a pixel"],
          ["↑ ↓", "choose the signal whose edges count, or all"],
          ["A B", "choose the cursor that moves"],
          ["Esc", "clear both cursors"],
          ["+ −", "zoom, around the active cursor where it is seen"],
          ["Page Up, Page Down", "pan by half"],
          ["0", "the whole case"],
          ["C", "what the claims speak of"],
        ].map(([key, does]) => h("tr", {}, h("td", { class: "code" }, key), h("td", {}, does))),
      ),
    ),
  );

const overview = (run) => h("div", {}, attention(run), nearestTable(run), folderTable(run), environment(run), guide());
