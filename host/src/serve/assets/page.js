"use strict";
// The live page: asks the server, shows the answers. All computing is the server's.
const $ = (id) => document.getElementById(id);
let state = null, part = null;

async function ask(path, body) {
  const reply = await fetch(path, body === undefined ? {} : { method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(body) });
  const answer = await reply.json();
  if (!reply.ok) throw answer;
  return answer;
}
function words(error) {
  const e = error.error || error;
  const place = [e.file, e.line && "line " + e.line, e.column && "column " + e.column].filter(Boolean).join(", ");
  return (place ? place + ": " : "") + toldOnPage(e.why || e.message || String(e)) + (e.remedy ? "\nTo do: " + onPage(e.remedy) : "");
}
function alarm(error) { $("alarm").textContent = error ? words(error) : ""; $("alarm").hidden = !error; }
const guard = (work) => async (event) => { alarm(null); try { await work(event); } catch (error) { alarm(error); } };
function element(name, properties = {}, ...children) {
  const e = Object.assign(document.createElement(name), properties);
  e.append(...children);
  return e;
}
// A long name may break behind its dots and underscores, and not within a word.
const breakable = (name) => (name.match(/[^._]+[._]?|[._]/g) || []).flatMap((piece) => [piece, element("wbr")]);
const listed = (names, last = "and") => (names.length < 2 ? names.join() : `${names.slice(0, -1).join(", ")} ${last} ${names[names.length - 1]}`);
const named = (unit) => (unit === "1" ? "" : " " + unit);
const short = (x) => Number(x.toPrecision(4)).toString();
function size(x, unit) {
  const [scale, prefix] = x === 0 || Math.abs(x) >= 0.1 ? [1, ""] : Math.abs(x) >= 1e-4 ? [1e3, "m"] : [1e6, "µ"];
  return short(x * scale) + " " + prefix + unit;
}

// 1 Compare
const chosen = () => Number($("record").value || 0);
let asked = 0;
const overview = Overview.on($("record-overview"));
async function showRecord(fresh = true) {
  const mine = ++asked, window = part ? `?from=${part[0]}&to=${part[1]}` : "";
  const figure = await ask(`/api/record/${chosen()}${window}`);
  if (mine !== asked) return;
  $("record-title").textContent = figure.title.replace(/ \((validation|fit)\)$/, "");
  $("record-role").className = "tag " + ($("record-role").textContent = figure.title.endsWith("(validation)") ? "validation" : "fit");
  $("record-reading").textContent = figure.reading;
  const plot = $("record-plot");
  if (!fresh) return Plots.update(plot, figure);
  Plots.show(plot, figure, (range) => { if (!brushed(range)) lookAt(range); });
  Plots.draw(plot);
  overview.show(figure, lookAt);
  // A dense record begins with a part in which its turns are seen apart, and stays where it was looked at.
  const x = figure.columns[0], here = [figure.title, x[0], x[x.length - 1]].join();
  if (lookedAt.here !== here) lookedAt = { here, part: figure.first ?? null };
  if (lookedAt.part) await lookAt(lookedAt.part);
}
let lookedAt = { here: "", part: null };
// Shows a part of the record with all that can be seen there; null is all of it.
async function lookAt(range) {
  const plot = $("record-plot");
  part = lookedAt.part = range;
  plot.dataset.detail = "";
  offerCut();
  overview.at(range);
  try { await showRecord(false); plot.dataset.detail = "yes"; } catch (error) { alarm(error); }
}
function place(p, value) { return p.log ? Math.log(value / p.low) / Math.log(p.high / p.low) : (value - p.low) / (p.high - p.low); }
// Around the fitted value, so that a pixel is a small change: a factor of 4 either way, or the bounds.
function reach(p) {
  if (p.log) return { ...p, low: Math.max(p.low, p.value / 4), high: Math.min(p.high, p.value * 4) };
  const span = Math.max(Math.abs(p.value) * 2, (p.high - p.low) * 0.02);
  return { ...p, low: Math.max(p.low, p.value - span), high: Math.min(p.high, p.value + span) };
}
function slidersOf(parameters) {
  $("ranges").replaceChildren(...parameters.map((given, k) => {
    const p = reach(given);
    const input = element("input", { type: "range", min: 0, max: 1, step: 0.001, value: place(p, p.value), id: "slider-" + k });
    const output = element("output", { textContent: short(p.value) + named(p.unit) });
    input.value_ = p.value;
    input.setAttribute("aria-valuetext", output.textContent);
    input.addEventListener("input", () => {
      const x = Number(input.value);
      input.value_ = p.log ? p.low * (p.high / p.low) ** x : p.low + x * (p.high - p.low);
      output.textContent = short(input.value_) + named(p.unit);
      input.setAttribute("aria-valuetext", output.textContent);
      slide();
    });
    input.addEventListener("change", () => Plots.slide($("record-plot"), {}, false));
    const caption = element("small", { textContent: captionOf(p.name) });
    return element("label", { title: meaningOf(p.name) }, p.name + " ", output, caption, input);
  }));
}
let sliding = false, slidAgain = false;
async function slide() {
  if (sliding) { slidAgain = true; return; }
  sliding = true;
  const begun = performance.now(), plot = $("record-plot");
  try {
    const values = [...$("ranges").querySelectorAll("input")].map((i) => i.value_);
    const answer = await ask("/api/slide", { record: chosen(), values, window: part });
    Plots.slide(plot, answer.curves, true);
    showError(answer.error, answer.unseen_error);
    // The next frame shows it.
    await Plots.frame();
    plot.dataset.slideMs = (performance.now() - begun).toFixed(1);
  } catch (error) { alarm(error); }
  sliding = false;
  if (slidAgain) { slidAgain = false; slide(); }
}
$("sliders").addEventListener("reset", () => { slidersOf(state.parameters); showFitted(); showRecord().catch(alarm); });
function showError(error, unseen) {
  $("slid").textContent = "Error " + size(error, state.unit) + (unseen === null || unseen === undefined ? "" : ", validation " + size(unseen, state.unit));
}
function showFitted() {
  const last = state.ladder[state.ladder.length - 1];
  showError(last.train.rmse, last.validation && last.validation.rmse);
  $("slid-floor").textContent = state.noise + ".";
}

// What had the keyboard's focus before the page was drawn anew, and gets it back: who works by keys would begin at the top again.
let held = null;
function holdFocus() {
  const at = document.activeElement;
  // Where the focus is now counts, also where a search began at another button: it may have moved on since.
  if (at && at !== document.body) held = { at, label: at.getAttribute("aria-label") };
}
function giveFocusBack() {
  if (held && (!document.activeElement || document.activeElement === document.body)) {
    const alike = (e) => held.label && e.getAttribute("aria-label") === held.label;
    const same = held.at.isConnected ? held.at : [...document.querySelectorAll(held.at.tagName)].find(alike);
    (same && !same.disabled && same.getClientRects().length ? same : $("headline")).focus({ preventScroll: true });
  }
  held = null;
}
function busy(what) {
  if (what) holdFocus();
  $("running").hidden = !what;
  $("doing").textContent = what || "";
  if (!what) $("progress").removeAttribute("value");
  for (const b of document.querySelectorAll("#next, #also, #diagnose, #add-effect, .add, .run-next, #puzzle, .chip button, #run, #connect button, #entries input, #entries button, #cut, #brush, #undo, #read-as-change")) b.disabled = Boolean(what);
  if (state && !state.data.can_undo) $("undo").disabled = true;
  if (!what) giveFocusBack();
}
async function refresh() {
  holdFocus();
  const record = showRecord(), known = ask("/api/state");
  state = await known;
  $("title").textContent = state.title;
  const number = Math.min(chosen(), state.records.length - 1);
  $("record").replaceChildren(...state.records.map((r, k) => element("option", { value: k, textContent: `${r.name} (${r.unseen ? "validation" : "fit"})` })));
  $("record").value = number;
  const has = state.effects.filter((e) => e.added);
  $("effect").replaceChildren(...state.effects.filter((e) => !e.added).map((e) => element("option", { value: e.name, textContent: `${e.name}: ${e.title}` })));
  $("in-model").replaceChildren(...has.map((e) => element("span", { className: "chip" }, e.name, Object.assign(element("button", { type: "button", textContent: "✕", onclick: guard(() => ask("/api/remove", { effect: e.name })) }), { ariaLabel: "Remove " + e.name }))));
  $("reveal").hidden = !state.puzzle;
  $("against").replaceChildren(...state.models.map((name, k) => element("option", { value: k, textContent: name })));
  $("against").value = state.models.indexOf(state.against);
  showData(state.data);
  if (!state.puzzle || !state.puzzle.revealed) $("answer").hidden = true;
  showFaults(state.faults);
  slidersOf(state.parameters);
  showFitted();
  showDevice(state);
  await record.catch(() => showRecord());
  await Plots.frame();
  document.body.dataset.painted = document.body.dataset.painted || performance.now().toFixed(0);
  await Promise.all([showLadder(), showFails(), showMissing(), showEstimates()]);
  busy(state.running);
  document.body.dataset.fresh = "yes";
}

$("record").addEventListener("change", guard(async () => { part = null; await showRecord(); }));
$("diagnose").addEventListener("click", guard(() => ask("/api/diagnose", {})));
$("add-effect").addEventListener("click", guard(() => ask("/api/add", { effect: $("effect").value })));
$("stop").addEventListener("click", guard(() => ask("/api/stop", {})));
$("puzzle").addEventListener("click", guard(() => ask("/api/puzzle", {})));
$("against").addEventListener("change", guard(async () => { await ask("/api/against", { model: Number($("against").value) }); await Promise.all([showRecord(), showFails()]); }));
// "stribeck=0.44,excess=0.23", as it is typed on the command line: "stribeck (0.44, excess 0.23)".
const spoken = (typed) => typed.replace("=", " (").replaceAll("=", " ").replaceAll(",", ", ") + (typed.includes("=") ? ")" : "");
$("reveal").addEventListener("click", guard(async () => {
  const { answer, found } = await ask("/api/reveal", {});
  const hidden = answer.effects.length ? answer.sizes.map(spoken).join(" and ") : "nothing";
  const missed = answer.effects.filter((e) => !found.includes(e)), wrong = found.filter((e) => !answer.effects.includes(e));
  const right = !missed.length && !wrong.length;
  const parts = [missed.length ? "it misses " + missed.join(" and ") : "", wrong.length ? `${wrong.join(" and ")} ${wrong.length > 1 ? "are" : "is"} not in the motor` : ""].filter(Boolean);
  $("answer").className = "answer " + (right ? "right" : "wrong");
  $("answer").textContent = `${right ? "Right" : "Wrong"}. Hidden: ${hidden}. Your model has ${found.length ? found.join(" and ") : "no effect"}${parts.length ? ": " + parts.join("; ") : ""}.`;
  $("answer").hidden = false;
}));

// The verdict, and the one thing to do next.
const NEXT = {
  diagnose: () => ask("/api/diagnose", {}),
  add: (next) => ask("/api/add", { effect: next.effect }),
  remove: (next) => ask("/api/remove", { effect: next.effect }),
  experiment: () => proposeNext(),
  data: (next) => mendData(next),
  look: () => $("fails").scrollIntoView(),
  export: () => { location.href = "/export/model.json"; },
};
// A data problem is mended where it is: the columns of its record, its bad seconds, or what is said of it.
async function mendData({ mend, where }) {
  const { entries } = state.data, place = (where || "").split(", column ")[0].split(/[\\/]/).pop();
  const by = entries.findIndex((e) => e.file === place), at = by < 0 ? entryOf(place) : by;
  const file = entries[Math.max(at, 0)].file;
  if (mend === "columns" && file !== null) return openAgain(Math.max(at, 0), state.faults.filter((f) => f.where === where).map((f) => f.fix));
  if (mend === "range" && at >= 0) {
    const own = state.records.findIndex((r) => r.name === place);
    const record = own < 0 ? state.records.findIndex((r) => entryOf(r.name) === at) : own;
    if (record >= 0 && record !== chosen()) { $("record").value = record; part = null; await showRecord(); }
    if ($("brush").getAttribute("aria-pressed") !== "true") $("brush").click();
    $("compare").scrollIntoView();
    return $("brush").focus({ preventScroll: true });
  }
  ($("data-faults").hidden ? $("data") : $("data-faults")).scrollIntoView();
}
function showStanding({ verdict, badge, next, also }, [first, beside]) {
  $("verdict").dataset.verdict = badge === "Data problem" ? "bad_data" : verdict || next.action;
  $("badge").textContent = badge;
  // No line begins with the unit of the number before it.
  const said = (text) => onPage(text).replace(/(\d) (?=%|x |[mµ]?[A-Za-z/]+\))/g, "$1\u00a0");
  $("headline").textContent = said(first);
  if (beside) $("headline").append(" ", element("span", { textContent: said(beside) }));
  $("next").textContent = next.action === "export" ? "Save the model" : next.label;
  $("next").title = next.command;
  $("next").hidden = false;
  $("next").onclick = guard(() => NEXT[next.action](next));
  $("also").hidden = !also;
  if (also) {
    $("also").textContent = also.label;
    $("also").onclick = guard(() => NEXT[also.action](also));
  }
}

// What the server tells of its work.
const told = {
  started(e) { history_ = []; busy(e.what); $("status").textContent = e.what + " …"; if (e.device) beginLive(); },
  trying(e) { $("progress").max = e.of; $("progress").value = e.done; $("doing").textContent = `Trying ${e.effect} (${e.done} of ${e.of})`; },
  step(e) { showStep(e.step); },
  playing(e) { nextLive(e); },
  waiting(e) { showWaiting(e); },
  live(e) { showLive(e); },
  done(e) { readWell(); ended(e.message); renew(); },
  stopped(e) { ended(e.message); },
  failed(e) { readFailed(); ended(""); alarm(e.error); renew(); },
  behind() { renew(); },
};
function ended(message) { busy(null); endLive(); $("status").textContent = message; }
function renew() { part = null; document.body.dataset.fresh = ""; refresh().catch(alarm); }
