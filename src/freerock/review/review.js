"use strict";
// The desk: the list of runs, one run, its corrections, what they would change, and saving them.

const at = id => document.getElementById(id);
const WORST = {fail: 0, "": 1, warn: 2, ok: 3};
const STILL_MS = 250;  // after the last correction, before it is fitted
const MARGIN_S = 1;  // beside a run

const desk = {
  list: null,  // what the server says of the campaign
  record: null,  // the record that is open, as the CSV has it
  pending: new Map(),  // by test: a correction that is not saved
  tried: new Map(),  // by test: what a correction would make of the record
  sort: {key: "worst", falling: false},
  chosen: null,  // test and run
  shown: new Map(),  // by candidate: whether a person wants it drawn
};
let charts;

// talking to the server; the address holds the token

async function answered(reply) {
  const told = await reply.json().catch(() => ({error: `the server answers ${reply.status}`}));
  if (!reply.ok) throw Object.assign(new Error(told.error), {status: reply.status});
  return told;
}
const ask = async (what, given = {}) => answered(await fetch(`ask/${what}?${new URLSearchParams(given)}`));
const tell = async (what, given = {}) => answered(await fetch(`do/${what}`, {
  method: "POST", headers: {"Content-Type": "application/json"}, body: JSON.stringify(given)}));

function alarm(error) {
  if (error?.status === 410) return;  // something newer was asked for
  at("alert").textContent = error ? (error.message || "the server does not answer: start freerock review again") : "";
  at("alert").hidden = !error;
}

function element(tag, attributes = {}, ...content) {
  const made = Object.assign(document.createElement(tag), attributes);
  made.append(...content);
  return made;
}

/** A name that may be broken after a low line. */
const breakable = name => name.split(/(?<=_)/).flatMap((part, i) => i ? [element("wbr"), part] : [part]);

/** A text of freerock's with its indices below the line. */
const indexed = text => text.split("ε_θ").flatMap((part, i) => i ? ["ε", element("sub", {}, "θ"), part] : [part]);

// the list

function rows() {
  return desk.list.rows
    .filter(row => !desk.tried.has(row.test))
    .concat([...desk.tried].flatMap(([test, tried]) => tried.rows.map(row => ({
      ...row, tried: true, looked: desk.list.rows.find(one => one.test === test && one.run === row.run)?.looked ?? ""}))));
}

function sortKey(row) {
  switch (desk.sort.key) {
    case "worst": return [row.excluded ? 4 : WORST[row.verdict], -(row.epsilon ?? -1)];
    case "test": return [0];
    case "epsilon": return [row.epsilon ?? Infinity];
    case "looked": return [row.looked ? 1 : 0];
    default: return [String(row[desk.sort.key] ?? "")];
  }
}

function ordered() {
  const order = new Map(desk.list.rows.map((row, i) => [row.test, i]).reverse());
  const wanted = at("find").value.trim().toLowerCase();
  const shown = rows().filter(row => !wanted || [row.test, row.reasons, row.model, row.verdict, row.block, row.foundation]
    .some(text => String(text).toLowerCase().includes(wanted)));
  const keyed = shown.map(row => [...sortKey(row), order.get(row.test), row.run ?? 0].map(each => each ?? 0)).map((key, i) => [key, shown[i]]);
  keyed.sort(([a], [b]) => {
    for (let i = 0; i < a.length; i++) {
      if (a[i] === b[i]) continue;
      const less = typeof a[i] === "string" ? a[i].localeCompare(b[i]) : a[i] - b[i];
      return desk.sort.falling && i < a.length - 2 + (desk.sort.key === "test") ? -less : less;
    }
    return 0;
  });
  if (desk.sort.key === "test" && desk.sort.falling) keyed.reverse();
  return keyed.map(([, row]) => row);
}

const percent = epsilon => epsilon === null || epsilon === undefined ? "–" : (100 * epsilon).toPrecision(3).replace(/e.*/, each => `·10^${Number(each.slice(1))}`);

function drawList() {
  const body = at("runs").querySelector("tbody"), shown = ordered();
  const focused = body.contains(document.activeElement);
  body.replaceChildren(...shown.map(row => {
    const mine = row.test === desk.chosen?.test && (row.run === desk.chosen.run);
    const name = element("td", {}, element("span", {className: row.excluded ? "excluded" : ""}, ...breakable(row.run === null ? row.test : `${row.test} · ${row.run}`)));
    if (row.reasons) name.append(element("small", {title: row.reasons}, row.reasons));
    const verdict = desk.pending.has(row.test) ? " ●" : "";
    const line = element("tr", {tabIndex: mine ? 0 : -1},
      element("td", {title: row.looked}, row.looked ? "✓" : ""), name,
      element("td", {}, element("span", {className: row.excluded ? "" : row.verdict}, row.excluded ? "left out" : row.verdict || "–"), verdict),
      element("td", {className: row.explained === false ? "unsure" : "", title: row.explained === false && row.model ? "the nearest: none explains the run" : ""}, row.model || "–"),
      element("td", {}, percent(row.epsilon)));
    if (row.behind) {
      name.firstChild.classList.add("behind");
      name.firstChild.title = "changed since the last snakemake";
    }
    line.dataset.test = row.test;
    line.dataset.run = row.run ?? "";
    line.setAttribute("aria-selected", mine);
    return line;
  }));
  const current = body.querySelector("[aria-selected=true]") ?? body.firstElementChild;
  if (current) current.tabIndex = 0;
  if (focused) current?.focus();
  current?.scrollIntoView({block: "nearest"});
  const seen = shown.filter(row => row.looked).length;
  at("counts").textContent = `${shown.length} ${shown.length === 1 ? "line" : "lines"}, ${seen} looked at`;
  const changed = desk.pending.size;
  at("save").disabled = !changed || !!desk.list.read_only;
  at("undo").disabled = !desk.list.undo;
  at("state").textContent = desk.list.read_only || (changed ? `${changed} ${changed === 1 ? "record" : "records"} not saved` : desk.saved ?? "");
}

function onward(step) {
  const lines = [...at("runs").querySelectorAll("tbody tr")];
  const now = lines.findIndex(line => line.getAttribute("aria-selected") === "true");
  const next = lines[Math.max(0, Math.min(lines.length - 1, now + step))];
  if (next && next !== lines[now]) open(next.dataset.test, next.dataset.run);
}

// one run

async function open(test, run, fit = true) {
  desk.chosen = {test, run: run === "" || run === null ? null : Number(run)};
  drawList();
  alarm(null);
  const asked = desk.asked = Symbol();
  try {
    const record = await ask("record", {test, run: run ?? ""});
    if (asked !== desk.asked) return;
    desk.record = record;
    const other = desk.tried.get(test);
    if (other && other.picture?.run !== desk.chosen.run && desk.chosen.run !== null) {
      const found = await tell("refit", {test, run: desk.chosen.run, near_s: null, correction: other.asked, whole: true});
      if (asked !== desk.asked) return;
      desk.tried.set(test, {...found, asked: other.asked});
    }
  } catch (error) { alarm(error); return; }
  at("run").hidden = false;
  charts ??= new Charts(desk.styles, {
    overTime: at("over-time"), overSpeed: at("over-speed"), asked: samples,
    told: text => { at("cursor").textContent = text; },
    moved: (release, end) => { at("release").value = instant(release); at("end").value = instant(end); correctTimes(); }});
  charts.step = desk.record.step_s;
  const tried = desk.tried.get(test);
  desk.view = tried ?? desk.record;
  drawRun();
  showRun();
  means();
  if (!tried && fit && !desk.record.current && !desk.record.problem) refit(0);
}

const instant = time => time?.toFixed(desk.record.step_s < 1e-4 ? 6 : 4) ?? "";
/** The means of the record's runs, as the CSV has it: told after the first picture. */
async function means() {
  const record = desk.record;
  if (!record.current || !record.picture || record.picture.means) return;
  try {
    Object.assign(record.picture, await ask("means", {test: record.test}));
    if (record === desk.record) drawNumbers();
  } catch (error) { alarm(error); }
}

const correction = () => desk.pending.get(desk.record.test) ?? desk.record.correction;

function drawRun() {
  const {record, view} = desk, picture = view.picture, own = correction();
  if (picture && desk.chosen.run !== picture.run && view === desk.record) desk.chosen.run = picture.run;
  at("name").textContent = picture ? `${record.test}, run ${picture.run} of ${view.runs.length}` : record.test;
  const verdict = picture ? (picture.excluded ? "left out" : picture.verdict) : view.runs[0]?.verdict ?? "";
  at("verdict").textContent = verdict;
  at("verdict").className = picture?.excluded ? "" : verdict;
  at("facts").replaceChildren(...(picture?.facts ?? []).flatMap(([name, text]) => [element("b", {}, name), ` ${text}   `]), record.file);
  const reasons = picture ? picture.reasons : [{verdict: view.runs[0]?.verdict, text: view.failure}];
  if (record.problem) reasons.push({verdict: "fail", text: record.problem});
  at("reasons").replaceChildren(...reasons.filter(each => each.text).map(each => element("li", {className: each.verdict}, ...indexed(each.text))));
  for (const id of ["release", "end", "as-found", "exclude", "looked"]) at(id).disabled = !picture;
  const set = picture && own.overrides.find(each => each.run === picture.run);
  const times = picture ? [set?.release_s ?? picture.release, set?.end_s ?? picture.end] : [null, null];
  if (document.activeElement !== at("release")) at("release").value = instant(times[0]);
  if (document.activeElement !== at("end")) at("end").value = instant(times[1]);
  at("as-found").disabled = !set;
  at("exclude").checked = !!picture && (own.exclude === "record" || own.exclude.includes(picture.run));
  at("exclude").disabled = !picture || own.exclude === "record";
  at("exclude-record").checked = own.exclude === "record";
  at("looked").checked = !!desk.list.rows.find(row => row.test === record.test && row.run === desk.chosen.run)?.looked;
  at("looked").disabled = !!desk.list.read_only;
  for (const id of ["stretches", "bad"]) at(id).disabled = own.exclude === "record";
  if (document.activeElement !== at("stretches")) at("stretches").value = written(own.stretches);
  charts.leave(own.exclude === "record" ? [] : own.stretches);
  for (const id of ["reason", "note"]) if (document.activeElement !== at(id)) at(id).value = own[id];
  at("discard").disabled = !desk.pending.has(record.test);
  charts.place(...times);
  charts.run(picture, view.runs);
  overlay();
  drawShown(picture);
  drawNumbers();
}

/** The record's other runs over this one, each from its own release; none where that is not wanted. */
async function overlay() {
  const {record, view} = desk, picture = view.picture, wanted = desk.overlaid = Symbol();
  const others = at("overlay").checked && picture ? view.runs.filter(each => each.run !== null && each.run !== picture.run) : [];
  const drawn = {t: [], v: []};
  try {
    for (const {release_s, duration_s} of others) {
      const {theta} = await ask("window", {test: record.test, from_s: release_s, to_s: release_s + duration_s});
      if (!theta) continue;
      drawn.t.push(...theta.t.map(each => each - release_s + picture.release), NaN);
      drawn.v.push(...theta.v, null);
    }
    if (wanted === desk.overlaid) charts.sources.overlay.data = floats(drawn);
  } catch (error) { alarm(error); }
}

/** Which candidates are drawn: where one explains the run those that do, else all; a person's choice stays. */
function drawShown(picture) {
  const status = new Map((picture?.fits?.candidates ?? []).map(each => [each.model, each.status]));
  const explained = [...status.values()].includes("selected");
  at("shown").replaceChildren(...Object.keys(picture?.curves ?? {}).map(name => {
    const {color, dash, width, label} = desk.styles[name];
    const shown = desk.shown.get(name) ?? !(explained && status.get(name) === "rejected");
    const box = element("input", {type: "checkbox", checked: shown});
    box.addEventListener("change", () => { desk.shown.set(name, box.checked); charts.only(name, box.checked); charts.scale(picture.fits?.selected); });
    charts.only(name, shown);
    return element("label", {className: "box"}, box, " ", swatch(color, dash, width), ` ${label}`);
  }));
  charts.scale(picture?.fits?.selected);
}

function swatch(color, dash, width) {
  const [drawing, stroke] = ["svg", "path"].map(tag => document.createElementNS("http://www.w3.org/2000/svg", tag));
  for (const [key, value] of Object.entries({d: "M0 5H30", stroke: color, "stroke-width": width, "stroke-dasharray": dash.join(" ") || "none"}))
    stroke.setAttribute(key, value);
  drawing.setAttribute("aria-hidden", "true");
  drawing.append(stroke);
  return drawing;
}

function showRun() {
  const picture = desk.view.picture, [from, to] = desk.record.span;
  if (picture) charts.show(Math.max(from, Math.min(picture.hold_start ?? picture.release, picture.release) - MARGIN_S), Math.min(to, picture.end + MARGIN_S));
  else charts.show(from, to);
  charts.wanted();
}

async function samples(from, to) {
  const {test, problem} = desk.record;
  if (problem) return charts.samples({signals: [], theta: null, flags: []});
  const asked = desk.window = Symbol();
  try {
    const found = await ask("window", {test, from_s: from, to_s: to});
    if (asked === desk.window && test === desk.record.test) charts.samples(found);
  } catch (error) { alarm(error); }
}

// the fits, as the CSV has them and as the correction would make them

function drawNumbers() {
  const {record, view} = desk, tried = view !== record;
  const tables = [["This run", "fits"], ["Mean of the record’s runs", "means"]].flatMap(([head, key]) => {
    const [old, now] = [record.picture?.[key], tried ? view.picture?.[key] : null];
    if (!old && !now) return [];
    const shown = now ?? old;
    const parts = [element("h3", {}, head), fitTable(old, tried ? now : undefined, key === "means")];
    const told = shown.reason && `${shown.reason[0].toUpperCase()}${shown.reason.slice(1)}.`;
    if (told && key === "fits") parts.splice(1, 0, element("p", {}, ...indexed(told)));
    return parts;
  });
  at("numbers").replaceChildren(...tables);
}

function fitTable(old, now, isMean) {
  const compared = now !== undefined;
  const heads = ["Candidate", isMean ? "Of" : "Choice", "", ...(compared ? ["As saved", "As corrected"] : ["Value"]), "Unit", isMean ? "" : "Why"];
  const body = element("tbody");
  const shown = (now ?? old).candidates;
  const before = new Map((old?.candidates ?? []).map(each => [each.model, each]));
  for (const candidate of shown) {
    const then = before.get(candidate.model);
    if (!candidate.parameters.length && !then?.parameters.length) continue;
    const names = [...new Set([...(then?.parameters ?? []), ...candidate.parameters].map(each => each.name))];
    const lines = names.map(name => {
      const [a, b] = [then, candidate].map(each => each?.parameters.find(one => one.name === name));
      return [(b ?? a).symbol, a, now ? b : compared ? undefined : null, (b ?? a).unit, (b ?? a).more];
    });
    const part = text => text === undefined ? undefined : {text, value: text};
    if (candidate.epsilon_text) lines.push(["ε_θ", part(then?.epsilon_text), now ? part(candidate.epsilon_text) : compared ? undefined : null, "%"]);
    lines.forEach(([symbol, a, b, unit, more], i) => {
      const value = (each, kind) => {
        const cell = element("td", {className: `number ${kind}`, title: each?.value && each.text !== each.value ? `${each.value}${each.u ? ` ± ${each.u}` : ""}` : ""}, each?.text ?? "…");
        if (each) Object.assign(cell.dataset, {value: each.value, parameter: symbol, model: candidate.model, of: isMean ? "mean" : "run", as: kind});
        return cell;
      };
      const cells = b === null ? [value(a, "saved")] : [value(a, "saved"), value(b, `corrected${b && a && a.text !== b.text ? " moved" : ""}`)];
      body.append(element("tr", {className: i ? "" : "first"},
        element("td", {className: candidate.status === "selected" ? "named" : ""}, i ? "" : candidate.label),
        element("td", {className: candidate.status === "rejected" ? "unsure" : ""}, i ? "" : candidate.says),
        element("td", {className: "symbol"}, ...indexed(symbol)), ...cells, element("td", {className: "unit"}, unit),
        element("td", {className: "unsure"}, ...indexed(more ?? (i ? "" : candidate.reason)))));
    });
  }
  return element("table", {ariaLabel: isMean ? "Means of the record’s runs" : "Fits of this run"},
    element("thead", {}, element("tr", {}, ...heads.map(head => element("th", {scope: "col"}, head)))), body);
}

// corrections

function correct(change, fits = true) {
  const test = desk.record.test;
  const made = change(structuredClone(correction()));
  if (JSON.stringify(made) === JSON.stringify(desk.record.correction)) desk.pending.delete(test);
  else desk.pending.set(test, made);
  at("discard").disabled = !desk.pending.has(test);
  if (fits) refit(STILL_MS);
  else drawList();
}

function correctTimes() {
  const picture = desk.view.picture, [release, end] = [at("release").valueAsNumber, at("end").valueAsNumber];
  if (!picture || !(release < end)) { if (picture) at("work").textContent = "The release comes before the end."; return; }
  charts.place(release, end);
  correct(own => {
    const then = own.overrides.find(each => each.run === picture.run);
    own.overrides = own.overrides.filter(each => each.run !== picture.run);
    own.overrides.push({run: picture.run, release_s: release, end_s: end, hold_s: then?.hold_s ?? null});
    own.overrides.sort((a, b) => a.run - b.run);
    return own;
  });
}

/** Stretches as the CSV has them, and back; null where the text is not understood. */
const written = stretches => stretches.map(([from, to]) => `${from}:${to}`).join(";");
function stretchesIn(text) {
  const parts = text.split(";").map(each => each.trim()).filter(each => each);
  const found = parts.map(each => each.match(/^(-?\d+\.?\d*)\s*:\s*(-?\d+\.?\d*)$/));
  if (found.some(each => !each || Number(each[1]) >= Number(each[2]))) return null;
  return found.map(([, from, to]) => [Number(from), Number(to)]);
}

function correctStretches(stretches) {
  correct(own => ({...own, stretches: stretches.toSorted((a, b) => a[0] - b[0] || a[1] - b[1])}));
}

/** A stretch; one that is left out already is used again. */
function leaveOut(from, to) {
  const own = correction().stretches, others = own.filter(each => each[0] !== from || each[1] !== to);
  if (correction().exclude === "record") return;
  correctStretches(others.length < own.length ? others : [...own, [from, to]]);
  at("stretches").value = written(correction().stretches);
  charts.leave(correction().stretches);
  if (others.length === own.length) sayWhy();
}

const sayWhy = () => { if (!at("reason").value) at("reason").focus(); };

function refit(after) {
  clearTimeout(desk.timer);
  desk.timer = setTimeout(tryOut, after);
}

async function tryOut() {
  const {test} = desk.record, run = desk.chosen.run, began = performance.now(), asked = desk.trying = Symbol();
  const own = structuredClone(correction());
  const unsaid = (own.exclude.length || own.stretches.length || own.overrides.length) && !own.reason;
  const now = {test, run, near_s: at("release").valueAsNumber || null, correction: {...own, reason: own.reason || "…"}};
  drawList();
  alarm(null);
  for (const whole of [false, true]) {
    at("work").textContent = whole ? `This run: ${took(began)}. Now the other runs, and their mean…` : "Fitting this run…";
    try {
      const found = {...await tell("refit", {...now, whole}), asked: now.correction};
      if (asked !== desk.trying || test !== desk.record.test) return;
      if (desk.pending.has(test)) desk.tried.set(test, found);
      else { desk.tried.delete(test); if (whole) Object.assign(desk.record, found, {current: true}); }
      desk.view = desk.pending.has(test) ? found : Object.assign(desk.record, found);
      if (!whole && !desk.pending.has(test)) desk.record.current = false;
      if (found.picture) desk.chosen.run = found.picture.run;
    } catch (error) { if (asked === desk.trying) { at("work").textContent = ""; alarm(error); } return; }
    drawRun();
    drawList();
  }
  at("work").textContent = `Fitted in ${took(began)}.${unsaid ? " Say why before you save: the reason is empty." : ""}`;
}

const took = began => `${((performance.now() - began) / 1000).toFixed(1)} s`;

function discard() {
  desk.pending.delete(desk.record.test);
  desk.tried.delete(desk.record.test);
  clearTimeout(desk.timer);
  desk.trying = null;
  at("work").textContent = "";
  document.activeElement?.blur();
  open(desk.record.test, desk.chosen.run);
}

// saving

const CELLS = {override: own => own.overrides.map(each => `${each.run}@${each.release_s}:${each.end_s}${each.hold_s ? ` hold ${each.hold_s.join(":")}` : ""}`).join(";"),
  exclude: own => own.exclude === "record" ? "record" : [...own.exclude, ...own.stretches.length ? [written(own.stretches)] : []].join(";"), reason: own => own.reason, note: own => own.note};

async function askToSave() {
  if (at("save").disabled) return;
  const lines = [];
  for (const [test, own] of desk.pending) {
    const saved = test === desk.record.test ? desk.record : await ask("record", {test, run: ""});
    for (const [column, text] of Object.entries(CELLS))
      if (text(own) !== text(saved.correction))
        lines.push(element("tr", {}, ...[test, column, saved.cells[column] || "–", text(own) || "–"].map(each => element("td", {}, each))));
  }
  at("sure").querySelector("tbody").replaceChildren(...lines);
  at("sure-file").textContent = desk.list.csv;
  at("sure-alert").textContent = "";
  at("sure-again").hidden = true;
  at("why").value = "";
  at("why").placeholder = "the reason of the record";
  at("sure").showModal();
  at("why").focus();
}

async function save() {
  try {
    const kept = desk.pending.size;
    desk.list = await tell("keep", {corrections: Object.fromEntries(desk.pending), known: desk.list.digest, why: at("why").value});
    desk.saved = `Saved: ${kept} ${kept === 1 ? "record" : "records"}. snakemake makes the products again.`;
    desk.pending.clear();
    desk.tried.clear();
    at("sure").close();
    open(desk.record.test, desk.chosen.run);
  } catch (error) {
    at("sure-alert").textContent = error.message;
    at("sure-again").hidden = !error.message.includes("someone else");
  }
}

async function again() {
  try {
    desk.list = await ask("again");
    at("sure").close();
    alarm(null);
    await open(desk.record.test, desk.chosen.run, false);
    if (desk.pending.has(desk.record.test)) refit(0);
  } catch (error) { at("sure-alert").textContent = error.message; }
}

async function undo() {
  try {
    desk.list = await tell("undo");
    desk.saved = "Undone.";
    open(desk.record.test, desk.chosen.run);
  } catch (error) { alarm(error); }
}

async function look(seen, on = false) {
  try {
    const {test} = desk.record, run = desk.chosen.run;
    if (on) onward(1);
    desk.list = await tell("look", {test, run, seen});
    drawList();
  } catch (error) { alarm(error); }
}

// what a person does

function whole() {
  const [from, to] = desk.record.span, all = charts.range.start <= from && charts.range.end >= to;
  if (all) showRun(); else charts.show(from, to);
}

const SHORT = {
  j: () => onward(1), k: () => onward(-1), l: () => look(true, true), r: () => at("release").select(), t: () => at("end").select(),
  x: () => at("exclude").click(), d: () => at("discard").disabled || discard(), w: whole, b: () => at("bad").click(), s: askToSave,
};

function listen() {
  at("runs").querySelector("tbody").addEventListener("click", event => {
    const line = event.target.closest("tr");
    if (line) open(line.dataset.test, line.dataset.run);
  });
  at("runs").addEventListener("keydown", event => {
    const step = {ArrowDown: 1, ArrowUp: -1, PageDown: 10, PageUp: -10}[event.key];
    if (step && event.target.closest("tbody")) { event.preventDefault(); onward(step); }
  });
  for (const head of at("runs").querySelectorAll("th"))
    head.querySelector("button").addEventListener("click", () => {
      const key = head.dataset.key;
      desk.sort = {key, falling: desk.sort.key === key && !desk.sort.falling};
      for (const other of at("runs").querySelectorAll("th")) other.removeAttribute("aria-sort");
      head.setAttribute("aria-sort", desk.sort.falling ? "descending" : "ascending");
      drawList();
    });
  at("find").addEventListener("input", drawList);
  for (const id of ["release", "end"]) at(id).addEventListener("input", correctTimes);
  at("as-found").addEventListener("click", () => correct(own => ({...own, overrides: own.overrides.filter(each => each.run !== desk.view.picture.run)})));
  at("exclude").addEventListener("change", () => correct(own => {
    const run = desk.view.picture.run, others = own.exclude === "record" ? [] : own.exclude.filter(each => each !== run);
    return {...own, exclude: at("exclude").checked ? [...others, run].sort((a, b) => a - b) : others};
  }));
  for (const id of ["exclude", "exclude-record"])
    at(id).addEventListener("change", () => { if (at(id).checked) sayWhy(); });
  at("stretches").addEventListener("input", () => {
    const found = stretchesIn(at("stretches").value);
    if (found) correctStretches(found); else at("work").textContent = "Left out: give 12.310:12.450, more after a ;";
  });
  at("bad").addEventListener("click", () => leaveOut(...[charts.range.start, charts.range.end].map(each => Number(each.toFixed(3)))));
  at("overlay").addEventListener("change", overlay);
  at("exclude-record").addEventListener("change", () => correct(own => ({...own, exclude: at("exclude-record").checked ? "record" : []})));
  at("reason").addEventListener("input", () => correct(own => ({...own, reason: at("reason").value.trim()}), false));
  at("note").addEventListener("input", () => correct(own => ({...own, note: at("note").value.trim()}), false));
  at("by-hand").addEventListener("submit", event => event.preventDefault());
  at("looked").addEventListener("change", () => look(at("looked").checked));
  at("discard").addEventListener("click", discard);
  at("whole").addEventListener("click", whole);
  at("save").addEventListener("click", askToSave);
  at("undo").addEventListener("click", undo);
  at("sure-save").addEventListener("click", save);
  at("sure-again").addEventListener("click", again);
  at("sure-not").addEventListener("click", () => at("sure").close());
  at("why").addEventListener("keydown", event => { if (event.key === "Enter") { event.preventDefault(); save(); } });
  at("keys").addEventListener("click", () => {
    at("help").hidden = !at("help").hidden;
    at("keys").setAttribute("aria-expanded", !at("help").hidden);
  });
  addEventListener("keydown", event => {
    if (event.target.matches("input[type=text], input[type=search], input[type=number]")) {
      if (event.key === "Escape") event.target.blur();
      return;
    }
    if (event.ctrlKey || event.altKey || event.metaKey || at("sure").open || !desk.record) return;
    const act = SHORT[event.key];
    if (act) { event.preventDefault(); act(); }
  });
  addEventListener("beforeunload", event => { if (desk.pending.size) event.preventDefault(); });
}

async function begin() {
  listen();
  try {
    [desk.list, desk.styles] = await Promise.all([ask("list"), ask("styles")]);
  } catch (error) { alarm(error); return; }
  document.title = `${desk.list.campaign} – freerock review`;
  at("title").textContent = desk.list.title;
  at("mark").hidden = !desk.list.simulated;
  drawList();
  const first = at("runs").querySelector("tbody tr");
  if (first) open(first.dataset.test, first.dataset.run);
}
begin();
