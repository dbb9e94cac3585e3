"use strict";
// Steps 2 to 5 of the page, and the events that move them.
let history_ = [];

function figureElement(f, level = "h3") {
  const plot = element("div", { className: "plot" });
  const figure = element("figure", {}, element(level, { textContent: f.title }), plot, element("figcaption", { textContent: f.reading }));
  Plots.show(plot, f);
  return figure;
}

// Before any physics: what is wrong with the data.
function showFaults(faults) {
  const card = (f) => element("article", { className: "card fault" }, element("p", { textContent: f.fault + "." }), element("p", { className: "quiet", textContent: f.where }), element("p", { textContent: "To do: " + f.fix + "." }));
  $("data-faults").hidden = !faults.length;
  $("faults").replaceChildren(...faults.map(card));
}

// 2 Where it fails
async function showFails() { $("fails-figures").replaceChildren(...(await ask("/api/figures/fails")).figures.map((f) => figureElement(f))); }

// 3 What is missing
function card(c, figures) {
  const add = element("button", { type: "button", className: "main add", textContent: "Add " + c.effect, onclick: guard(() => ask("/api/add", { effect: c.effect })) });
  const share = Object.assign(element("meter", { min: 0, max: 100, value: c.gain_percent }), { ariaLabel: "share of the error taken away" });
  const all = element("article", { className: "card" }, element("h3", { textContent: c.title }),
    element("p", { className: "gain" }, element("code", { textContent: c.effect }), share, ` ${c.gain_percent} %`),
    element("p", { textContent: c.evidence + "." }), element("p", { className: "quiet", textContent: `Look for: ${c.signature}. Law: ${c.equation}.` }));
  if (c.rivals.length) all.append(element("p", { textContent: "These records cannot tell it from " + c.rivals.join(", ") + "." }));
  all.append(c.added ? element("p", {}, element("span", { className: "tag training", textContent: "in the model" })) : element("p", {}, add));
  all.append(...figures.filter((f) => c.figures.includes(f.id)).map((f) => figureElement(f, "h4")));
  return all;
}
function nextCard(next) {
  const segments = next.programme.segments.map((s) => s.seconds).reduce((a, b) => a + b, 0);
  const run = element("button", { type: "button", className: "run-next", textContent: state.device ? "Run it on the motor" : "Connect a motor to run it", onclick: () => proposeNext() });
  return element("article", { className: "card next" }, element("h3", { textContent: "Next experiment" }), element("p", { textContent: next.why + "." }),
    element("p", { className: "quiet", textContent: `${next.programme.name}, ${short(segments)} s. By hand: motorlens capture --programme programme.json.` }),
    element("p", { className: "tools" }, run, element("a", { className: "button", href: "/export/programme.json", download: "programme.json", textContent: "Save the programme" })));
}
async function showMissing() {
  const { cards, figures, rivals, next, worth, diagnosed } = await ask("/api/figures/missing");
  const nothing = element("article", { className: "card nothing" }, element("h3", { textContent: "Nothing worth adding" }),
    element("p", { textContent: !diagnosed ? "Not sought yet." : worth ? "Not so: the first card lowers the error on the records fitted and on those kept out." : "No effect of the library lowers the error enough, on the records fitted and on those kept out, to be worth its parameters." }));
  const all = cards.map((c) => card(c, figures));
  if (diagnosed && !worth) all.unshift(nothing);
  else if (diagnosed) all.push(nothing);
  for (const set of rivals) all.push(element("article", { className: "card rivals" }, element("h3", { textContent: "Rivals" }), element("p", { textContent: `These records cannot tell ${set.join(", ")} apart: the first of them is as good a name as the others.` })));
  if (next) all.push(nextCard(next));
  $("cards").replaceChildren(...all);
  $("programme").querySelector("[value=next]").disabled = !next;
}

// 4 Add
function showStep(step) {
  history_.push(step);
  const rounds = history_.map((s) => s.round), x = { title: "Step of the search (1)", log: false };
  $("convergence-reading").textContent = `Step ${step.round}: error ${short(step.error)} times the noise of one reading.`;
  Plots.update($("convergence"), { id: "convergence", title: "Convergence", reading: "Error after each step.", x, columns: [rounds],
    panels: [{ y: { title: "Error (noise units)", log: true, range: spanOf(history_.map((s) => s.error)) }, height: 240, curves: [{ role: "model", name: "error", on: 0, draw: "dotted", y: history_.map((s) => s.error) }] }] });
  const old = step.parameters.filter((p) => p.before);
  Plots.update($("giving"), { id: "giving", title: "Old parameters", reading: "Each parameter of the model before, in percent of what it was.", x, columns: [rounds],
    panels: [{ y: { title: "Of the value before (%)", log: false }, height: 200, curves: old.map((p, k) => ({ role: "p" + (k % 6), name: p.name, on: 0, draw: "dotted", y: history_.map((s) => 100 * s.parameters.find((q) => q.name === p.name).now / p.before) })) }] });
  rows("moving", step.parameters, (p) => [p.name, p.before === null ? "new" : short(p.before), short(p.now), p.unit], (p) => p.before !== null && Math.abs(p.now - p.before) > 0.005 * Math.abs(p.before) ? "moved" : "");
}
// Whole decades around the values.
function spanOf(values) {
  const low = Math.floor(Math.log10(Math.min(...values)) + 1e-9), high = Math.ceil(Math.log10(Math.max(...values)) - 1e-9);
  return [10 ** low, 10 ** Math.max(high, low + 1)];
}

// 5 Falls
function rows(target, list, cells, mark) {
  $(target).replaceChildren(...list.map((item) => {
    const [first, ...others] = cells(item);
    const row = element("tr", { className: mark ? mark(item) : "" }, Object.assign(element("th", { textContent: first }), { scope: "row" }));
    row.append(...others.map((c) => element("td", { textContent: c })));
    return row;
  }));
}
async function showLadder() {
  const answer = await ask("/api/figures/falls");
  $("falls-figures").replaceChildren(...answer.figures.map((f) => figureElement(f)));
  $("falls").dataset.lastOverFloor = answer.last_over_floor;
  $("summary").textContent = answer.summary;
}
async function showEstimates() {
  const { parameters, combinations, faults } = await ask("/api/figures/estimates");
  const cells = (e) => [e.name, e.value, e.interval, e.unit, e.identifiable];
  const mark = (e) => e.identifiable;
  rows("parameters", parameters, cells, mark);
  rows("combinations", combinations, cells, mark);
  showFaults(state.faults.concat(faults));
}
