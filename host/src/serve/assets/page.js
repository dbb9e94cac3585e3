"use strict";
// The live page: asks the server, shows the answers. All computing is the server's.
const $ = (id) => document.getElementById(id);
let state = null, window_ = null, history_ = [];

async function ask(path, body) {
  const reply = await fetch(path, body === undefined ? {} : { method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(body) });
  const answer = await reply.json();
  if (!reply.ok) throw answer;
  return answer;
}
function words(error) {
  const e = error.error || error;
  const place = [e.file, e.line && "line " + e.line, e.column && "column " + e.column].filter(Boolean).join(", ");
  return (place ? place + ": " : "") + (e.why || e.message || String(e)) + (e.remedy ? "\nTo do: " + e.remedy : "");
}
function alarm(error) { $("alarm").textContent = error ? words(error) : ""; $("alarm").hidden = !error; }
const guard = (work) => async (event) => { alarm(null); try { await work(event); } catch (error) { alarm(error); } };
function element(name, properties = {}, ...children) {
  const e = Object.assign(document.createElement(name), properties);
  e.append(...children);
  return e;
}
const named = (unit) => (unit === "1" ? "" : " " + unit);
const short = (x) => Number(x.toPrecision(4)).toString();
function size(x, unit) {
  if (unit.startsWith("rad") && Math.abs(x) < 0.1 && x !== 0) return short(x * 1e3) + " m" + unit;
  return short(x) + " " + unit;
}

// 1 Compare
async function showRecord() {
  const part = window_ ? `?from=${window_[0]}&to=${window_[1]}` : "";
  const figure = await ask(`/api/record/${$("record").value || 0}${part}`);
  if (window_) figure.layout.xaxis.range = window_;
  $("record-title").textContent = figure.title;
  $("record-reading").textContent = figure.reading;
  const plot = $("record-plot");
  await Plots.show(plot, figure);
  if (!plot.dataset.listening && plot.on) {
    plot.dataset.listening = "yes";
    plot.on("plotly_relayout", (change) => {
      const from = change["xaxis.range[0]"], to = change["xaxis.range[1]"];
      if (from !== undefined) window_ = [from, to];
      else if (change["xaxis.autorange"]) window_ = null;
      else return;
      showRecord().catch(alarm);
    });
  }
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
    input.addEventListener("change", () => { if (!window_) Plotly.relayout($("record-plot"), { "yaxis.autorange": true, "yaxis2.autorange": true, "yaxis3.autorange": true }); });
    return element("label", {}, p.name + " ", output, input);
  }));
}
let sliding = false, slidAgain = false;
async function slide() {
  if (sliding) { slidAgain = true; return; }
  sliding = true;
  const begun = performance.now();
  try {
    const values = [...$("ranges").querySelectorAll("input")].map((i) => i.value_);
    const answer = await ask("/api/slide", { record: Number($("record").value || 0), values });
    const plot = $("record-plot");
    const of = (name) => plot.data.findIndex((t) => t.meta && t.meta.slide === name);
    const places = answer.curves.map((c) => of(c.slide));
    // Only the model's lines are drawn again; the axes follow when the slider is let go.
    const still = { transition: { duration: 0 }, frame: { duration: 0, redraw: false }, mode: "immediate" };
    await Plotly.animate(plot, { data: answer.curves.map(({ x, y }) => ({ x, y })), traces: places }, still);
    $("slid").textContent = "Error " + size(answer.error, answer.unit) + (answer.unseen_error === null ? "" : ", unseen " + size(answer.unseen_error, answer.unit));
    plot.dataset.slideMs = (performance.now() - begun).toFixed(1);
  } catch (error) { alarm(error); }
  sliding = false;
  if (slidAgain) { slidAgain = false; slide(); }
}
$("sliders").addEventListener("reset", () => { slidersOf(state.parameters); showError(); showRecord().catch(alarm); });
function showError() {
  const last = state.ladder[state.ladder.length - 1];
  $("slid").textContent = "Error " + size(last.train.rmse, state.unit) + (last.validation ? ", unseen " + size(last.validation.rmse, state.unit) : "");
}

// 2, 3, 5
function figureElement(f, level = "h3") {
  const plot = element("div", { className: "plot" });
  const figure = element("figure", {}, element(level, { textContent: f.title }), plot, element("figcaption", { textContent: f.reading }));
  Plots.show(plot, f);
  return figure;
}
async function showFails() { $("fails-figures").replaceChildren(...(await ask("/api/figures/fails")).figures.map((f) => figureElement(f))); }
async function showMissing() {
  const { cards, figures, faults, diagnosed } = await ask("/api/figures/missing");
  const all = cards.map((c) => {
    const add = element("button", { type: "button", className: "main add", textContent: "Add " + c.effect, onclick: guard(() => ask("/api/add", { effect: c.effect })) });
    const card = element("article", { className: "card" }, element("h3", { textContent: c.title }),
      element("p", {}, element("code", { textContent: c.effect }), Object.assign(element("meter", { min: 0, max: 100, value: c.gain_percent }), { ariaLabel: "share of the error taken away" }), ` ${c.gain_percent} %`),
      element("p", { textContent: c.evidence + "." }), element("p", { className: "quiet", textContent: `Look for: ${c.signature}. Law: ${c.equation}.` }));
    if (c.rivals.length) card.append(element("p", { textContent: "These records cannot tell it from " + c.rivals.join(", ") + "." }));
    card.append(element("p", {}, add));
    const figure = figures.find((f) => f.id === c.figure);
    if (figure) card.append(figureElement(figure, "h4"));
    return card;
  });
  if (diagnosed) all.push(element("article", { className: "card" }, element("h3", { textContent: "Nothing missing" }), element("p", { textContent: "If no effect above lowers the error clearly, on the records fitted and on those kept out, nothing of the library is missing." })));
  for (const f of faults) all.push(element("article", { className: "card fault" }, element("h3", { textContent: "Data fault" }), element("p", { textContent: f.fault }), element("p", { className: "quiet", textContent: f.where }), element("p", { textContent: "To do: " + f.fix })));
  $("cards").replaceChildren(...all);
}
function rows(target, list, cells, mark) {
  $(target).replaceChildren(...list.map((item) => {
    const [first, ...others] = cells(item);
    const row = element("tr", { className: mark ? mark(item) : "" }, Object.assign(element("th", { textContent: first }), { scope: "row" }));
    row.append(...others.map((c) => element("td", { textContent: c })));
    return row;
  }));
}
async function showFalls() {
  const answer = await ask("/api/figures/falls");
  $("falls-figures").replaceChildren(...answer.figures.map((f) => figureElement(f)));
  $("falls").dataset.lastOverFloor = answer.figures[0].layout.meta.last_over_floor;
  $("summary").textContent = answer.summary;
  const cells = (e) => [e.name, e.value, e.interval, e.unit, e.identifiable];
  rows("parameters", answer.parameters, cells);
  rows("combinations", answer.combinations, cells);
}

// 4 Add
function showStep(step) {
  history_.push([step.round, step.error]);
  $("convergence-reading").textContent = `Step ${step.round}: error ${short(step.error)} times the noise of one reading.`;
  Plots.show($("convergence"), { id: "convergence", title: "Convergence", reading: "Error after each step", height: 300,
    data: [{ type: "scatter", mode: "lines+markers", name: "error", x: history_.map((h) => h[0]), y: history_.map((h) => h[1]), meta: { role: "model" } }],
    layout: { xaxis: { title: { text: "Step of the search (1)" } }, yaxis: { title: { text: "Error (noise units)" }, type: "log" }, showlegend: false } });
  rows("moving", step.parameters, ([name, unit, before, now]) => [name, short(before), short(now), unit], ([, , before, now]) => Math.abs(now - before) > 0.005 * Math.abs(before) ? "moved" : "");
}
function busy(what) {
  $("running").hidden = !what;
  $("doing").textContent = what || "";
  if (!what) $("progress").removeAttribute("value");
  for (const b of document.querySelectorAll("#diagnose, #add-effect, .add, #puzzle, .chip button")) b.disabled = Boolean(what);
}
async function refresh() {
  state = await ask("/api/state");
  $("title").textContent = state.title;
  const chosen = Math.min(Number($("record").value || 0), state.records.length - 1);
  $("record").replaceChildren(...state.records.map((r, k) => element("option", { value: k, textContent: `${r.name} (${r.unseen ? "unseen" : "training"})` })));
  $("record").value = chosen;
  const has = state.effects.filter((e) => e.added);
  $("effect").replaceChildren(...state.effects.filter((e) => !e.added).map((e) => element("option", { value: e.name, textContent: `${e.name}: ${e.title}` })));
  $("in-model").replaceChildren(...has.map((e) => element("span", { className: "chip" }, e.name, Object.assign(element("button", { type: "button", textContent: "✕", onclick: guard(() => ask("/api/remove", { effect: e.name })) }), { ariaLabel: "Remove " + e.name }))));
  $("reveal").hidden = !state.puzzle;
  if (!state.puzzle || !state.puzzle.revealed) $("answer").hidden = true;
  slidersOf(state.parameters);
  showError();
  await showRecord();
  document.body.dataset.painted = performance.now().toFixed(0);
  await Promise.all([showFalls(), showFails(), showMissing()]);
  busy(state.running ? $("doing").textContent || "Working" : null);
}

// A log
let dropped = null;
const CANONICAL = { time_s: "time:s", voltage_v: "voltage:V", angle_rad: "angle:rad", speed_rad_s: "speed:rad/s", current_a: "current:A", supply_v: "supply:V" };
const KINDS = ["", "time:s", "time:ms", "time:us", "voltage:V", "voltage:mV", "angle:rad", "angle:deg", "angle:rev", "angle:counts", "speed:rad/s", "speed:deg/s", "speed:rpm", "current:A", "current:mA", "supply:V", "supply:mV"];
async function open_(file) {
  if (!file) return;
  dropped = file;
  $("log-name").textContent = file.name;
  $("log-fault").hidden = true;
  const lines = (await file.slice(0, 20000).text()).split(/\r?\n/).filter((l) => l.trim() && !l.startsWith("#"));
  const head = lines[0] || "";
  const cut = [",", ";", "\t"].sort((a, b) => head.split(b).length - head.split(a).length)[0];
  const names = head.split(cut).map((n) => n.trim().replace(/^"|"$/g, ""));
  const choose = element("tr", {}, ...names.map((name, k) => {
    const select = element("select", { className: "column" }, ...KINDS.map((kind) => element("option", { value: kind, textContent: kind ? kind.replace(":", " in ") : "not used" })));
    select.value = CANONICAL[name] || "";
    select.setAttribute("aria-label", `Column ${k + 1}, ${name}`);
    return element("td", {}, select);
  }));
  const header = element("tr", {}, ...names.map((n) => element("th", { textContent: n, scope: "col" })));
  const body = lines.slice(1, 6).map((l) => element("tr", {}, ...l.split(cut).slice(0, names.length).map((c) => element("td", { textContent: c }))));
  $("preview").replaceChildren(header, choose, ...body);
  $("dialog").showModal();
}
$("mapping").addEventListener("submit", async (event) => {
  event.preventDefault();
  const header = [...$("preview").querySelectorAll("th")].map((th) => th.textContent);
  const chosen = [...$("preview").querySelectorAll("select")].map((s) => s.value);
  const canonical = chosen.every((c, k) => c === (CANONICAL[header[k]] || ""));
  const map = canonical ? "" : chosen.map((c, k) => c && `${c.split(":")[0]}=${k}:${c.split(":")[1]}`).filter(Boolean).join(",");
  const role = new FormData($("mapping")).get("role");
  try {
    const reply = await fetch(`/api/upload?${new URLSearchParams({ name: dropped.name, role, map })}`, { method: "POST", body: dropped });
    const answer = await reply.json();
    if (!reply.ok) throw answer;
    $("dialog").close();
  } catch (error) { $("log-fault").textContent = words(error); $("log-fault").hidden = false; }
});
$("cancel").addEventListener("click", () => $("dialog").close());
$("file").addEventListener("change", guard(async (event) => { await open_(event.target.files[0]); event.target.value = ""; }));
addEventListener("dragover", (event) => { event.preventDefault(); document.body.classList.add("dropping"); });
addEventListener("dragleave", () => document.body.classList.remove("dropping"));
addEventListener("drop", guard(async (event) => { event.preventDefault(); document.body.classList.remove("dropping"); await open_(event.dataTransfer.files[0]); }));

$("record").addEventListener("change", guard(async () => { window_ = null; await showRecord(); }));
$("diagnose").addEventListener("click", guard(() => ask("/api/diagnose", {})));
$("add-effect").addEventListener("click", guard(() => ask("/api/add", { effect: $("effect").value })));
$("stop").addEventListener("click", guard(() => ask("/api/stop", {})));
$("puzzle").addEventListener("click", guard(() => ask("/api/puzzle", {})));
$("reveal").addEventListener("click", guard(async () => {
  const { answer, found } = await ask("/api/reveal", {});
  const hidden = answer.effects.length ? answer.sizes.join(" and ") : "nothing";
  const right = answer.effects.length === found.length && answer.effects.every((e) => found.includes(e));
  $("answer").textContent = `Hidden: ${hidden}. Your model has ${found.length ? found.join(" and ") : "no effect"}${right ? ": right!" : "."}`;
  $("answer").hidden = false;
}));

const events = new EventSource("/api/events");
events.onmessage = (message) => {
  const e = JSON.parse(message.data);
  if (e.type === "started") { history_ = []; busy(e.what); $("status").textContent = e.what + " …"; }
  else if (e.type === "trying") { $("progress").max = e.of; $("progress").value = e.done; $("doing").textContent = `Trying ${e.effect} (${e.done} of ${e.of})`; }
  else if (e.type === "step") showStep(e.step);
  else {
    busy(null);
    $("status").textContent = e.type === "done" ? e.message : e.type === "stopped" ? "Stopped. The model is as it was." : "";
    if (e.type === "failed") alarm(e.error);
    if (e.type !== "stopped") { window_ = null; refresh().catch(alarm); }
  }
};
refresh().catch(alarm);
