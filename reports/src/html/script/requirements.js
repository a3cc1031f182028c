// Which requirement is proved by which cases, clause by clause.
const NAMED = 6; // cases that a row names; the others are counted

const natural = (a, b) => a.localeCompare(b, "en", { numeric: true });

// How far the run proves it, with what it lacks or why: as the record says, nothing where it does not.
const proofOf = (fact) => [fact.status, fact.note].filter(Boolean).join(": ");

// Every requirement that a case of the run names, and every clause of it that the register knows, with what the run
// says of each: the greatest verdict of the judged cases.
const matrix = (run) => {
  const rows = new Map();
  const entry = (id) => {
    if (!rows.has(id)) rows.set(id, { id, asks: "", proof: "", records: new Set(), clauses: new Map() });
    return rows.get(id);
  };
  for (const known of run.requirements ?? []) {
    const row = entry(known.id);
    row.asks = known.asks ?? "";
    row.proof = proofOf(known);
    for (const clause of known.clauses ?? []) {
      row.clauses.set(clause.id, { id: clause.id, asks: clause.asks, proof: proofOf(clause), records: new Set() });
    }
  }
  for (const record of run.cases) {
    for (const cited of record.proves) {
      const [id, clause] = cited.split("#");
      const row = entry(id);
      row.records.add(record);
      if (clause === undefined) continue;
      if (!row.clauses.has(clause)) row.clauses.set(clause, { id: clause, asks: "", proof: "", records: new Set() });
      row.clauses.get(clause).records.add(record);
    }
  }
  const judged = (records) => worst([...records].map((record) => (record.status.is === "judged" ? record.verdict : "none")));
  const list = [...rows.values()].sort((a, b) => natural(a.id, b.id));
  for (const row of list) {
    row.word = judged(row.records);
    for (const clause of row.clauses.values()) clause.word = clause.records.size ? judged(clause.records) : "none";
  }
  return list;
};

const casesOf = (records, id) => {
  const list = [...records].sort((a, b) => ORDER.indexOf(b.word) - ORDER.indexOf(a.word) || a.place - b.place);
  const named = list.length > NAMED ? list.filter((record) => record.word !== "pass").slice(0, NAMED) : list;
  const all = h("a", { href: link({ view: "cases", requirement: id }) }, named.length ? `${list.length - named.length} more` : plural(list.length, "case"));
  return [named.map((record) => h("a", { class: "proof", href: link({ case: record.name }) }, h("span", { class: `mark v-${record.word}` }, SIGNS[record.word]), " ", record.name)), list.length > named.length && all];
};

const clauseRow = (row, clause) =>
  h(
    "tr",
    { class: "clause", "data-verdict": clause.word, "data-id": `${row.id}#${clause.id}` },
    h("th", { scope: "row", class: "code" }, `#${clause.id}`),
    h("td", {}, badge(clause.word, clause.records.size ? (clause.word === "none" ? "not judged" : null) : "not proved here")),
    h("td", {}, clause.asks),
    h("td", {}, clause.proof),
    h("td", { class: "proofs" }, clause.records.size > 0 && casesOf(clause.records, `${row.id}#${clause.id}`)),
  );

class Requirements {
  constructor(run, changed) {
    this.list = matrix(run);
    this.changed = changed;
    this.text = h("input", { type: "search", "aria-label": "Text to look for in the requirements", placeholder: "ID or text of a requirement" });
    this.output = h("output", { class: "shown" });
    this.body = h("tbody", {});
    const form = h("form", { class: "filter", role: "search", "aria-label": "Filter the requirements" }, this.text, this.output);
    form.addEventListener("input", () => {
      this.apply();
      changed({ requirement: this.text.value.trim() });
    });
    form.addEventListener("submit", (event) => event.preventDefault());
    this.element = h("section", {}, heading("h2", "Requirements"), form, h("div", { class: "scroll" }, h("table", { class: "matrix" }, h("thead", {}, h("tr", {}, ["Requirement", "Verdict", "What it asks", "How far it is proven", "Cases"].map((text) => h("th", { scope: "col" }, text)))), this.body)));
  }

  set(state) {
    this.text.value = state.requirement ?? "";
    this.apply();
  }

  apply() {
    const text = this.text.value.trim().toLowerCase();
    const wanted = this.list.filter((row) => [row.id, row.asks, row.proof, ...[...row.clauses.values()].flatMap((clause) => [`${row.id}#${clause.id}`, clause.asks, clause.proof])].join("\n").toLowerCase().includes(text));
    const rows = wanted.flatMap((row) => [
      h("tr", { "data-verdict": row.word, "data-id": row.id }, h("th", { scope: "row", class: "code" }, row.id), h("td", {}, badge(row.word, row.word === "none" ? "not judged" : null)), h("td", {}, row.asks), h("td", {}, row.proof), h("td", { class: "proofs" }, casesOf(row.records, row.id))),
      ...[...row.clauses.values()].map((clause) => clauseRow(row, clause)),
    ]);
    this.body.replaceChildren(...rows);
    this.output.value = `${text ? `${wanted.length} of ` : ""}${plural(this.list.length, "requirement")}`;
  }
}
