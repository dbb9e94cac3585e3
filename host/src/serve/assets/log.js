"use strict";
// Logs dropped on the page: what are their columns? Guessed, shown, remembered.
let queue = [], dropped = null, sent = [];
const CANONICAL = { time_s: "time:s", voltage_v: "voltage:V", angle_rad: "angle:rad", speed_rad_s: "speed:rad/s", current_a: "current:A", supply_v: "supply:V" };
const KINDS = ["", "time:s", "time:ms", "time:us", "time:ns", "voltage:V", "voltage:mV", "duty:1", "duty:100", "duty:255", "duty:400", "duty:1000", "duty:1023", "duty:4095", "duty:32767", "angle:rad", "angle:deg", "angle:rev", "angle:counts", "speed:rad/s", "speed:deg/s", "speed:rev/s", "speed:rpm", "speed:counts/s", "current:A", "current:mA", "supply:V", "supply:mV"];
const kindWords = (kind) => (kind ? kind.replace(":", kind.startsWith("duty") ? " of " : " in ") : "not used");

// Files whose layout only the reader knows are not shown as tables.
const TABLE = /\.(csv|txt|tsv|log|dat)$/i;
async function parsed(file) {
  const lines = (await file.slice(0, 200000).text()).split(/\r?\n/).filter((l) => l.trim() && !l.startsWith("#"));
  const head = lines[0] || "";
  const cut = [",", ";", "\t"].sort((a, b) => head.split(b).length - head.split(a).length)[0];
  const split = (l) => l.split(cut).map((n) => n.trim().replace(/^"|"$/g, ""));
  return { names: split(head), rows: lines.slice(1, -1).map(split) };
}
// What a person said of columns with these names is said again.
const memoryOf = (names) => "columns " + names.join("|");
function remembered(names) { try { return JSON.parse(localStorage.getItem(memoryOf(names))); } catch { return null; } }
function remember(names, value) { try { localStorage.setItem(memoryOf(names), JSON.stringify(value)); } catch { /* a browser may keep nothing */ } }

async function guessed({ names, rows }) {
  if (names.some((n) => CANONICAL[n] === "voltage:V")) return { kinds: names.map((n) => CANONICAL[n] || ""), words: "The columns have the names that motorlens knows." };
  const before = remembered(names);
  if (before) return { ...before, words: "As you mapped columns of these names before." };
  const answer = await ask("/api/guess", { names, rows: rows.slice(0, 1000) }).catch(() => null);
  if (!answer || !answer.kinds) return { kinds: names.map((n) => CANONICAL[n] || ""), words: "Say what each column is. Angles and speeds are of the output shaft." };
  return { ...answer, words: "Guessed from names and values; look whether it is right. Angles and speeds are of the output shaft." };
}

async function openAll(files) {
  queue = [...files];
  sent = [];
  await ask("/api/use", { replace: false, forget: true });
  await openNext();
}
async function openNext() {
  dropped = queue.shift();
  if (!dropped) return;
  $("log-name").textContent = dropped.name;
  $("log-fault").hidden = true;
  $("log-alike").hidden = !queue.length;
  $("log-records").hidden = sent.length > 0;
  const table = TABLE.test(dropped.name) ? await parsed(dropped) : { names: [], rows: [] };
  dropped.table = table;
  const guess = table.names.length ? await guessed(table) : { kinds: [], words: "This format tells itself what its columns are." };
  $("log-words").textContent = guess.words;
  const rig = guess.rig || {};
  $("log-gear").value = rig.gear_ratio || $("log-gear").value || "";
  $("log-counts").value = rig.counts_per_rev || $("log-counts").value || "";
  $("log-supply").value = rig.supply_v || $("log-supply").value || "";
  if (rig.encoder_shaft !== undefined) $("log-shaft").value = rig.encoder_shaft;
  const choose = element("tr", {}, ...table.names.map((name, k) => {
    const kind = guess.kinds[k] || "", kinds = KINDS.includes(kind) ? KINDS : [...KINDS, kind];
    const select = element("select", { className: "column", onchange: showRaw }, ...kinds.map((value) => element("option", { value, textContent: kindWords(value) })));
    select.value = kind;
    select.setAttribute("aria-label", `Column ${k + 1}, ${name}`);
    return element("td", {}, select);
  }));
  const header = element("tr", {}, ...table.names.map((n) => element("th", { textContent: n, scope: "col" })));
  const body = table.rows.slice(0, 5).map((row) => element("tr", {}, ...table.names.map((_, k) => element("td", { textContent: row[k] }))));
  $("preview").replaceChildren(header, choose, ...body);
  if (!$("dialog").open) $("dialog").showModal();
  showRaw();
}
const kindsChosen = () => [...$("preview").querySelectorAll("select")].map((s) => s.value);

// The columns as they stand in the file, before anything is made of them.
function showRaw() {
  const { names, rows } = dropped.table, kinds = kindsChosen();
  const every = Math.max(1, Math.ceil(rows.length / 800)), kept = rows.filter((_, k) => k % every === 0);
  const column = (k) => kept.map((row) => { const x = Number(row[k]); return row[k] === "" || Number.isNaN(x) ? null : x; });
  const time = kinds.findIndex((kind) => kind.startsWith("time")), place = time < 0 ? kept.map((_, k) => k * every) : column(time);
  const good = place.every((x, k) => x !== null && (k === 0 || x > place[k - 1]));
  const shown = names.map((_, k) => k).filter((k) => k !== time && column(k).some((x) => x !== null)).slice(0, 6);
  const x = good ? place : kept.map((_, k) => k * every);
  $("raw").hidden = !shown.length || kept.length < 2;
  if ($("raw").hidden) return;
  Plots.show($("raw"), { id: "raw", title: "Raw columns", reading: "The first rows as they stand in the file.", x: { title: good && time >= 0 ? `${names[time]} (as in the file)` : "Row (1)", log: false }, columns: [x],
    panels: shown.map((k, n) => ({ y: { title: kinds[k] ? kinds[k].split(":")[0] : "–", log: false }, height: 74, curves: [{ role: kinds[k] ? "p" + (n % 6) : "voltage", name: names[k], on: 0, draw: "line", y: column(k) }] })) });
  Plots.draw($("raw"));
}

const rigChosen = () => Object.fromEntries([["supply_v", "log-supply"], ["counts_per_rev", "log-counts"], ["gear_ratio", "log-gear"], ["encoder_shaft", "log-shaft"]].map(([key, id]) => [key, $(id).value]).filter(([, value]) => value));
function mapOf(names, kinds) {
  if (kinds.every((kind, k) => kind === (CANONICAL[names[k]] || ""))) return "";
  return kinds.map((kind, k) => kind && `${kind.slice(0, kind.indexOf(":"))}=${k}:${kind.slice(kind.indexOf(":") + 1)}`).filter(Boolean).join(",");
}
async function send(file, names, kinds) {
  const asked = { name: file.name, role: new FormData($("mapping")).get("role"), map: mapOf(names, kinds), ...rigChosen() };
  const reply = await fetch(`/api/upload?${new URLSearchParams(asked)}`, { method: "POST", body: file });
  const answer = await reply.json();
  if (!reply.ok) throw answer;
  sent.push(file.name);
}
$("mapping").addEventListener("submit", async (event) => {
  event.preventDefault();
  const { names } = dropped.table, kinds = kindsChosen();
  try {
    await send(dropped, names, kinds);
    if (kinds.length && mapOf(names, kinds)) remember(names, { kinds, rig: rigChosen() });
    if ($("log-all").checked) {
      while (queue.length) {
        dropped = queue.shift();
        dropped.table = { names, rows: [] };
        $("log-name").textContent = dropped.name;
        await send(dropped, names, kinds);
      }
    }
    if (queue.length) return await openNext();
    await ask("/api/use", { replace: new FormData($("mapping")).get("keep") === "replace", ...rigChosen() });
    $("dialog").close();
  } catch (error) { $("log-fault").textContent = words(error); $("log-fault").hidden = false; }
});
$("cancel").addEventListener("click", () => { queue = []; $("dialog").close(); });
$("file").addEventListener("change", guard(async (event) => { const files = [...event.target.files]; event.target.value = ""; await openAll(files); }));
addEventListener("dragover", (event) => { event.preventDefault(); document.body.classList.add("dropping"); });
addEventListener("dragleave", () => document.body.classList.remove("dropping"));
addEventListener("drop", guard(async (event) => {
  event.preventDefault();
  document.body.classList.remove("dropping");
  const files = [...event.dataTransfer.files], effects = files.filter((f) => f.name.endsWith(".toml"));
  for (const file of effects) await offerEffect(file);
  if (files.length > effects.length) await openAll(files.filter((f) => !effects.includes(f)));
}));
