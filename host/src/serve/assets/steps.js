"use strict";
// Steps 2 to 5 of the page, and the events that move them.
let history_ = [];

function figureElement(f, level = "h3") {
  const plot = element("div", { className: "plot" });
  const title = element(level, { textContent: f.title });
  if (f.share_percent !== undefined) title.append(" ", element("span", { className: "share", textContent: `${f.share_percent} %` }));
  const figure = element("figure", {}, title, plot, element("figcaption", { textContent: f.reading }));
  Plots.show(plot, f);
  return figure;
}

// Before any physics: what is wrong with the data.
function showFaults(faults) {
  const card = (f) => element("article", { className: "card fault" }, element("p", { textContent: toldOnPage(f.fault.replace(/^[a-z_]+: /, (kind) => kind.replaceAll("_", " "))) + "." }), element("p", { className: "quiet", textContent: f.where }), element("p", { textContent: "To do: " + onPage(f.fix) + "." }));
  $("data-faults").hidden = !faults.length;
  $("faults").replaceChildren(...faults.map(card));
}

// 2 Where it fails
async function showFails() {
  const figures = (await ask("/api/figures/fails")).figures, all = figures.map((f) => figureElement(f));
  // A share of nothing to speak of is no largest one.
  if (figures[0].share_percent >= 8) {
    all[0].classList.add("first");
    all[0].querySelector("h3").append(" ", element("span", { className: "mark", textContent: "largest share" }));
  }
  $("fails-figures").replaceChildren(...all);
}

// 3 What is missing
const gain = (c) => [Object.assign(element("meter", { min: 0, max: 100, value: c.gain_percent }), { ariaLabel: "gain of " + c.effect }), ` ${c.gain_percent}\u00a0%`];
function candidateRow(c) {
  const add = c.added ? element("span", { className: "tag fit", textContent: "in the model" }) : element("button", { type: "button", className: "add", textContent: "Add", ariaLabel: "Add " + c.effect, onclick: guard(() => ask("/api/add", { effect: c.effect })) });
  const show = element("a", { href: "#card-" + c.effect, title: c.title, onclick: () => { $("card-" + c.effect).open = true; } }, ...breakable(c.effect));
  return element("tr", { className: c.added ? "added" : "" }, element("td", { textContent: c.added ? "" : c.rank }), Object.assign(element("th", {}, show), { scope: "row" }),
    element("td", {}, ...gain(c)), element("td", { textContent: c.rivals.join(", ") }), element("td", {}, add));
}
function card(c, figures, first) {
  const all = element("details", { className: "card", id: "card-" + c.effect, open: first }, element("summary", {}, element("span", { textContent: c.effect }), ` ${c.title}`),
    element("p", { textContent: c.evidence + "." }), element("p", { className: "quiet", textContent: `Look for: ${c.signature}.` }), element("p", { className: "quiet" }, element("code", { textContent: c.equation })));
  if (c.rivals.length) all.append(element("p", { textContent: "These records cannot tell it from " + listed(c.rivals, "or") + "." }));
  if (c.added) all.append(element("p", {}, element("span", { className: "tag fit", textContent: "in the model" })));
  all.append(...figures.filter((f) => c.figures.includes(f.id)).map((f) => figureElement(f, "h3")));
  all.addEventListener("toggle", () => { if (all.open) all.querySelectorAll(".plot").forEach((p) => Plots.draw(p)); });
  return all;
}
function nextCard(next) {
  const segments = next.programme.segments.map((s) => s.seconds).reduce((a, b) => a + b, 0);
  const run = element("button", { type: "button", className: "run-next", textContent: state.device ? "Run it on the motor" : "Connect a motor to run it", onclick: () => proposeNext() });
  return element("article", { className: "card next" }, element("h3", { textContent: "Next experiment" }), element("p", { textContent: next.why + "." }),
    element("p", { className: "quiet", textContent: `${next.programme.name}, ${short(segments)} s. By hand: motorlens capture --programme programme.json.` }),
    element("p", { className: "tools" }, run, element("a", { className: "button", href: "/export/programme.json", download: "programme.json", textContent: "Save the programme" })));
}
function rivalsCard(set) {
  const [first, ...others] = set, accepted = state.effects.some((e) => e.name === first && e.added);
  const words = accepted ? `${first} is in the model; these records cannot tell it from ${listed(others, "or")}.` : `These records cannot tell ${listed(set)} apart: the first of them is as good a name as the others.`;
  return element("article", { className: "card rivals" }, element("h3", { textContent: "Indistinguishable" }), element("p", { textContent: words }));
}
async function showMissing() {
  const { cards, figures, rivals, next, worth, diagnosed } = await ask("/api/figures/missing");
  const all = [];
  if (diagnosed && !worth) all.push(element("article", { className: "card nothing" }, element("h3", { textContent: "No candidate is worth adding" }), element("p", { textContent: "No effect of the library lowers the error enough, on the records fitted and on blocks held out, to be worth its parameters." })));
  for (const set of rivals) all.push(rivalsCard(set));
  if (next) all.push(nextCard(next));
  all.push(...cards.map((c, k) => card(c, figures, k === 0)));
  $("missing-words").textContent = diagnosed ? "Gain: the share of the error that the effect explains, on the records fitted and on blocks held out. The order is that of the likelihood of blocks held out; what these records cannot tell apart shares a rank." : "Every effect of the library is tried on the model, on records fitted and on blocks held out.";
  $("ranking").hidden = !cards.length;
  $("candidates").replaceChildren(...cards.map(candidateRow));
  $("cards").replaceChildren(...all);
  $("programme").querySelector("[value=next]").disabled = !next;
}

// 4 Add
function showStep(step) {
  history_.push(step);
  const rounds = history_.map((s) => s.round), x = { title: "Step of the search (1)", log: false, whole: true };
  $("convergence-reading").textContent = `Step ${step.round}: weighted error ${short(step.error)}; the search makes it small, time scale by time scale.`;
  Plots.update($("convergence"), { id: "convergence", title: "Convergence", reading: "Error after each step.", x, columns: [rounds],
    panels: [{ y: { title: "Weighted error (1)", log: true, range: spanOf(history_.map((s) => s.error)) }, height: 240, curves: [{ role: "model", name: "error", on: 0, draw: "dotted", y: history_.map((s) => s.error) }] }] });
  const old = step.parameters.filter((p) => p.before);
  $("during").hidden = false;
  Plots.update($("giving"), { id: "giving", title: "Parameters", reading: "Each parameter of the model before, in percent of its value then.", x, columns: [rounds],
    panels: [{ y: { title: "Of the value before (%)", log: false }, height: 200, curves: old.map((p, k) => ({ role: "p" + (k % 6), name: p.name, on: 0, draw: "dotted", y: history_.map((s) => 100 * s.parameters.find((q) => q.name === p.name).now / p.before) })) }] });
  rows("moving", step.parameters, (p) => [p.name, p.before === null ? "new" : short(p.before), short(p.now), p.unit], (p) => p.before !== null && Math.abs(p.now - p.before) > 0.005 * Math.abs(p.before) ? "moved" : "");
}
// Whole decades around the values that are numbers: an error may be endless at first.
function spanOf(all) {
  const values = all.filter((v) => v > 0);
  if (!values.length) return [1, 10];
  const low = Math.floor(Math.log10(Math.min(...values)) + 1e-9), high = Math.ceil(Math.log10(Math.max(...values)) - 1e-9);
  return [10 ** low, 10 ** Math.max(high, low + 1)];
}

// 5 Error
function rows(target, list, cells, mark) {
  $(target).replaceChildren(...list.map((item) => {
    const [first, ...others] = cells(item);
    const row = element("tr", { className: mark ? mark(item) : "" }, Object.assign(element("th", { title: item.meaning || "" }, ...breakable(first)), { scope: "row" }));
    row.append(...others.map((c) => element("td", { textContent: c })));
    return row;
  }));
}
async function showLadder() {
  const answer = await ask("/api/figures/falls");
  $("falls-figures").replaceChildren(...answer.figures.map((f) => figureElement(f)));
  $("falls").dataset.lastOverFloor = answer.last_over_floor;
  $("summary").textContent = answer.summary;
  $("models").closest("table").classList.toggle("judged", answer.rows.some((r) => r.validation));
  rows("models", answer.rows, (r) => [r.step, r.fit, r.validation || "none", r.multiple || "not known", r.rise || ""], (r) => (r.rise ? "rise" : ""));
  showStanding(answer.standing, answer.headline);
}
async function showEstimates() {
  const { parameters, combinations, faults } = await ask("/api/figures/estimates");
  const cells = (e) => [e.name, e.value, e.interval, e.unit];
  const mark = (e) => e.identifiable;
  rows("parameters", parameters, cells, mark);
  rows("combinations", combinations, cells, mark);
  showFaults(state.faults.concat(faults));
}

// Glossary: symbols, units, meanings and equations, for the table and for tooltips.
let terms = [];
const meaningOf = (name) => { const t = terms.find((term) => term.name === name); return t ? `${t.meaning}. ${t.equation}` : ""; };
// The first words of it: who slides a parameter sees what it is without a mouse that waits over it.
const captionOf = (name) => { const t = terms.find((term) => term.name === name); return t ? t.meaning.split(/[:;.,]( |$)/)[0] : ""; };
async function showGlossary() {
  const answer = await ask("/api/glossary");
  terms = answer.terms;
  $("equations").textContent = answer.equations.join("\n");
  $("words").replaceChildren(...answer.words.flatMap(([word, meaning]) => [element("dt", { textContent: word }), element("dd", { textContent: meaning })]));
  rows("terms", terms, (t) => [t.name, t.unit, t.meaning, t.equation]);
}
