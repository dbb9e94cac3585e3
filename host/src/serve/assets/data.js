"use strict";
// The records: roles by clicking, ranges brushed out, undo, effect files.
const ROLES = [["fit", "fit"], ["validation", "validation"], ["out", "out"]];

function showData({ entries, can_undo }) {
  $("undo").disabled = !can_undo;
  $("entries").tBodies[0].replaceChildren(...entries.map((e, k) => {
    const role = ([value, word]) => element("label", {}, element("input", { type: "radio", name: "role-" + k, value, checked: e.role === value, onchange: guard(() => changed({ change: "role", entry: k, role: value })) }), " " + word);
    const whole = element("button", { type: "button", textContent: "use all", ariaLabel: `Use all of ${e.name} again`, onclick: guard(() => changed({ change: "whole", entry: k })) });
    const cuts = e.cuts.map(([a, b]) => `${short(a)} … ${short(b)}`).join(", ");
    const columns = element("button", { type: "button", className: "columns", textContent: "columns", ariaLabel: `columns of ${e.name}: change how they are read`, onclick: guard(() => openAgain(k)) });
    return element("tr", { className: "role-" + e.role }, Object.assign(element("th", {}, ...breakable(e.name), ...(e.file === null ? [] : [" ", columns])), { scope: "row" }), element("td", {}, element("fieldset", { className: "roles" }, element("legend", { className: "hidden", textContent: "Role of " + e.name }), ...ROLES.map(role))),
      element("td", { textContent: short(e.seconds) }), element("td", { textContent: e.samples }), element("td", {}, cuts, ...(cuts ? [" ", whole] : [])));
  }));
  showReadAs({ entries });
  offerCut();
}
async function changed(change) {
  try { await ask("/api/data", change); } catch (error) { showData(state.data); throw error; }
}

// A record is an entry, or a piece of the one whose name it has before its part.
function entryOf(name) {
  const whole = state.data.entries.findIndex((e) => e.name === name);
  return whole >= 0 ? whole : state.data.entries.findIndex((e) => e.name === name.replace(/ \(part \d+\)$/, ""));
}
const entryShown = () => entryOf(state.records[chosen()].name);
function offerCut() {
  $("cut-from").value = part ? part[0].toFixed(3) : "";
  $("cut-to").value = part ? part[1].toFixed(3) : "";
}
const cut = (from, to) => changed({ change: "cut", entry: entryShown(), from, to });
$("cut").addEventListener("click", guard(async () => {
  if ($("cut-from").value === "" || $("cut-to").value === "") throw { why: "no range is chosen", remedy: "type where it begins and ends, zoom to it, or press Brush out and drag over the plot" };
  await cut(Number($("cut-from").value), Number($("cut-to").value));
}));
$("brush").addEventListener("click", () => {
  const on = $("brush").getAttribute("aria-pressed") !== "true";
  $("brush").setAttribute("aria-pressed", on);
  $("record-plot").classList.toggle("brushing", on);
});
// While one brushes, a drag leaves the range out instead of zooming.
function brushed(range) {
  if ($("brush").getAttribute("aria-pressed") !== "true" || !range) return false;
  $("brush").click();
  guard(() => cut(range[0], range[1]))();
  return true;
}
$("undo").addEventListener("click", guard(() => changed({ change: "undo" })));
addEventListener("keydown", (event) => {
  const typing = event.target.matches("input:not([type=radio]):not([type=range]), select, textarea");
  if ((event.ctrlKey || event.metaKey) && event.key === "z" && !typing && !$("undo").disabled) { event.preventDefault(); $("undo").click(); }
});

async function offerEffect(file) {
  const reply = await fetch(`/api/effect?${new URLSearchParams({ name: file.name })}`, { method: "POST", headers: { "content-type": "text/plain" }, body: await file.text() });
  const answer = await reply.json();
  if (!reply.ok) throw answer;
  await showGlossary();
  $("status").textContent = `The effect ${answer.effect} is among those that are tried.`;
  await refresh();
}
$("effect-file").addEventListener("change", guard(async (event) => { const [file] = event.target.files; event.target.value = ""; if (file) await offerEffect(file); }));
