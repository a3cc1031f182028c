// The list of cases and its filter.
const PAGE = 200; // rows of a folder that are made at once
const FEW = 60; // a run of no more cases has its folders open

const nearest = (record) => {
  const margins = record.checks.map((check) => check.margin).filter(Boolean);
  const spans = margins.filter((m) => m.unit === "ns");
  const list = spans.length ? spans : margins.every((m) => m.unit === margins[0].unit) ? margins : [];
  return list.length ? shown(list.reduce((a, b) => (number(b.value) < number(a.value) ? b : a))) : "";
};

class Case {
  constructor(record) {
    this.record = record;
    const judged = record.status.is === "judged";
    const passed = record.checks.filter((check) => check.verdict === "pass").length;
    const cell = (text) => h("span", { class: "n" }, text);
    this.element = h(
      "details",
      { class: "case", "data-verdict": record.word, "data-name": record.name },
      h(
        "summary",
        {},
        badge(record.word),
        h("span", { class: "what" }, h("b", {}, record.name.slice(record.folder ? record.folder.length + 1 : 0)), h("span", { class: "title" }, record.title), !judged && h("span", { class: "title why" }, record.why)),
        cell(judged ? `${passed}/${record.checks.length}` : ""),
        cell(nearest(record)),
        cell(judged ? span(Math.floor(record.duration_ns / 1e6) * 1e6) : ""),
      ),
    );
    this.element.addEventListener("toggle", () => this.fill());
  }

  fill() {
    if (this.element.open && !this.body) {
      this.body = caseBody(this.record);
      this.element.append(this.body);
    }
  }

  open() {
    this.element.open = true;
    this.fill();
  }
}

// The cases of one folder of plans; its rows are made when it is opened.
class Folder {
  constructor(name, records) {
    [this.name, this.records, this.made] = [name, records, new Map()];
    this.rows = h("div", { class: "rows" });
    this.head = h("summary", {});
    this.element = h("details", { class: "folder" }, this.head, this.rows);
    this.element.addEventListener("toggle", () => this.fill());
  }

  case(record) {
    if (!this.made.has(record)) this.made.set(record, new Case(record));
    return this.made.get(record);
  }

  // What the filter leaves.
  show(records, open) {
    this.shown = records;
    this.most = PAGE;
    this.element.hidden = records.length === 0;
    const words = new Map();
    for (const record of records) words.set(record.word, (words.get(record.word) ?? 0) + 1);
    const counts = ORDER.filter((word) => words.has(word)).map((word) => h("span", { class: `count v-${word}` }, h("span", { "aria-hidden": "true" }, SIGNS[word]), ` ${words.get(word)} ${WORDS[word] ?? word}`));
    const few = records.length < this.records.length && h("span", { class: "count" }, `${records.length} of ${this.records.length} shown`);
    this.head.replaceChildren(...put(h("span"), [h("b", {}, this.name ? `${this.name}/` : "Plans"), counts, few]).childNodes);
    if (open !== null) this.element.open = open;
    this.fill(true);
  }

  fill(again) {
    if (!this.element.open || (this.full && !again)) return;
    this.full = true;
    const rows = this.shown.slice(0, this.most).map((record) => this.case(record).element);
    const left = this.shown.length - rows.length;
    if (left > 0) {
      const text = `Show ${Math.min(left, PAGE)} more of ${left}`;
      rows.push(h("p", { class: "rest" }, button(text, text, () => this.more())));
    }
    this.rows.replaceChildren(...rows);
  }

  more(count = PAGE) {
    this.most += count;
    this.fill(true);
  }

  reveal(record) {
    this.element.open = true;
    if (!this.shown.includes(record)) this.shown = [...this.shown, record];
    this.element.hidden = false;
    this.most = Math.max(this.most, this.shown.indexOf(record) + 1);
    this.fill(true);
    return this.case(record);
  }
}

class Cases {
  constructor(run, changed) {
    this.run = run;
    this.changed = changed;
    const byFolder = new Map();
    for (const record of run.cases) byFolder.set(record.folder, [...(byFolder.get(record.folder) ?? []), record]);
    this.folders = [...byFolder].map(([name, records]) => new Folder(name, records));
    this.of = new Map(this.folders.map((folder) => [folder.name, folder]));
    this.empty = h("p", { class: "empty", hidden: true }, "No case matches the filter.");
    this.element = h(
      "div",
      {},
      this.form(),
      h("div", { class: "columns", "aria-hidden": "true" }, ["Verdict", "Case", "Passed", "Least margin", "Modelled"].map((text, at) => h("span", { class: at > 1 ? "n" : null }, text))),
      this.folders.map((folder) => folder.element),
      this.empty,
    );
    this.apply(true);
  }

  form() {
    const words = ORDER.filter((word) => this.run.cases.some((record) => record.word === word)).reverse();
    const count = (word) => this.run.cases.filter((record) => record.word === word).length;
    this.boxes = words.map((word) => h("input", { type: "checkbox", name: "verdict", value: word, checked: true }));
    const chips = this.boxes.map((made) => h("label", { class: `chip v-${made.value}` }, made, h("span", { "aria-hidden": "true" }, SIGNS[made.value]), ` ${count(made.value)} ${WORDS[made.value] ?? made.value}`));
    this.text = h("input", { type: "search", name: "text", placeholder: "Name, title, reason, parameter", "aria-label": "Text to look for" });
    const names = (list) => [...new Set(list)].filter(Boolean).sort((a, b) => a.localeCompare(b, "en", { numeric: true }));
    const choice = (name, label, list) =>
      list.length > 0 && h("select", { name, "aria-label": label }, h("option", { value: "" }, label), list.map((value) => h("option", { value }, value)));
    this.folder = choice("folder", "Every folder", names(this.folders.map((folder) => folder.name)));
    this.requirement = choice("requirement", "Every requirement", names(this.run.cases.flatMap((record) => record.proves.flatMap((id) => [id, id.split("#")[0]]))));
    this.tag = choice("tag", "Every tag", names(this.run.cases.flatMap((record) => record.tags)));
    this.output = h("output", { class: "shown" });
    const reset = button("Reset", "Reset", () => this.set({}), { class: "reset" });
    const form = h("form", { class: "filter", role: "search", "aria-label": "Filter the cases" }, chips, this.text, this.folder, this.requirement, this.tag, reset, button("Open all shown", "Open all", () => this.openAll()), button("Close all", "Close all", () => this.closeAll()), this.output);
    form.addEventListener("input", () => this.apply());
    form.addEventListener("submit", (event) => event.preventDefault());
    return form;
  }

  // The filter as it stands, without what is as at the beginning.
  state() {
    const off = this.boxes.filter((made) => !made.checked);
    const state = { text: this.text.value.trim() };
    if (off.length) state.verdict = this.boxes.filter((made) => made.checked).map((made) => made.value).join(",") || "-";
    for (const name of ["folder", "requirement", "tag"]) state[name] = this[name] ? this[name].value : "";
    return Object.fromEntries(Object.entries(state).filter(([, value]) => value));
  }

  set(state) {
    const verdicts = state.verdict?.split(",");
    for (const made of this.boxes) made.checked = !verdicts || verdicts.includes(made.value);
    this.text.value = state.text ?? "";
    for (const name of ["folder", "requirement", "tag"]) if (this[name]) this[name].value = state[name] ?? "";
    this.apply();
  }

  apply(first) {
    const state = this.state();
    const verdicts = new Set(this.boxes.filter((made) => made.checked).map((made) => made.value));
    const text = (state.text ?? "").toLowerCase();
    const proves = (record) => record.proves.some((id) => id === state.requirement || id.split("#")[0] === state.requirement);
    const wanted = (record) =>
      verdicts.has(record.word) &&
      record.words.includes(text) &&
      (!state.folder || record.folder === state.folder) &&
      (!state.requirement || proves(record)) &&
      (!state.tag || record.tags.includes(state.tag));
    const filtered = Object.keys(state).length > 0;
    let shown = 0;
    for (const folder of this.folders) {
      const records = folder.records.filter(wanted);
      shown += records.length;
      const open = filtered || this.run.cases.length <= FEW || records.some((record) => bad(record.word));
      folder.show(records, filtered || first ? open : null);
    }
    this.empty.hidden = shown > 0;
    this.output.value = filtered ? `${shown} of ${plural(this.run.cases.length, "case")} shown` : "";
    if (!first) this.changed(state);
  }

  // Opens a case, whatever the filter says; returns its element.
  open(name) {
    const record = this.run.cases.find((c) => c.name === name);
    if (!record) return null;
    const made = this.of.get(record.folder).reveal(record);
    made.open();
    return made.element;
  }

  shownCases() {
    return this.folders.filter((folder) => !folder.element.hidden).flatMap((folder) => folder.shown.map((record) => ({ folder, record })));
  }

  openAll() {
    // A diagram each: no more than a person would look at.
    for (const { folder, record } of this.shownCases().slice(0, PAGE)) folder.reveal(record).open();
  }

  closeAll() {
    for (const folder of this.folders) for (const made of folder.made.values()) made.element.open = false;
  }
}
