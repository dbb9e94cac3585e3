"use strict";
// Logs dropped on the page: what are their columns? Guessed, shown, remembered.
let queue = [], dropped = null, sent = [];
// The file that was read without asking, as one of the same columns; and files of which the page was wrong to think so.
let readAs = null;
const unsure = new Set();
const KINDS = ["", "time:s", "time:ms", "time:us", "time:ns", "time+:ns", "interval:s", "interval:ms", "interval:us", "voltage:V", "voltage:mV", "duty:1", "duty:100", "duty:255", "duty:400", "duty:1000", "duty:1023", "duty:4095", "duty:32767", "duty:1500..2000", "duty-:", "voltage-:", "direction:sign", "direction:sign*-1", "target:rad", "target:deg", "angle:rad", "angle:deg", "angle:rev", "angle:counts", "angle:m", "angle:mm", "speed:rad/s", "speed:deg/s", "speed:rev/s", "speed:rpm", "speed:counts/s", "speed:m/s", "speed:mm/s", "current:A", "current:mA", "supply:V", "supply:mV"];

// Texts whose layout only the reader knows are not shown as tables.
const TABLE = /\.(csv|txt|tsv|log|dat|json)$/i;
// The server takes no more at once, bytes.
const LARGEST = 200000000;
const tooLarge = (file) => ({ file: file.name, why: "the page takes files up to 200 MB, and this is larger", remedy: "give the file on the command line, motorlens serve FILE, or export the minutes that show the motor" });
const NOTHING = { names: [], rows: [], kinds: [], motors: [], asked: [] };
// What is no text has zero bytes near its beginning; UTF-16 has them too, and says first that it is a text.
async function isBinary(file) {
  const start = new Uint8Array(await file.slice(0, 4096).arrayBuffer()), mark = start[0] + 256 * start[1];
  return start.includes(0) && mark !== 0xfeff && mark !== 0xfffe;
}
// The server looks at the file, of a text at its beginning: the same guess that the command line proposes.
async function looked(file) {
  const binary = await isBinary(file);
  if (!binary && !TABLE.test(file.name)) return NOTHING;
  if (binary && file.size > LARGEST) return { ...NOTHING, fault: tooLarge(file) };
  const reply = await fetch(`/api/guess?${new URLSearchParams({ name: file.name })}`, { method: "POST", body: binary ? file : file.slice(0, 4000000) });
  return reply.ok ? reply.json() : { ...NOTHING, fault: await reply.json() };
}
// What a person said of columns with these names is said again.
const memoryOf = (names) => "columns " + names.join("|");
function remembered(names) { try { return JSON.parse(localStorage.getItem(memoryOf(names))); } catch { return null; } }
function remember(names, value) { try { localStorage.setItem(memoryOf(names), JSON.stringify(value)); } catch { /* a browser may keep nothing */ } }

// What a log must tell.
const NEEDED = [[/^(time|interval):/, "the time"], [/^(voltage|duty|target):/, "the voltage or duty"], [/^(angle|speed):/, "the angle or speed"]];

function guessed({ names, kinds, canonical, proposal, asked }) {
  if (canonical) return { kinds, words: "The columns have the names that motorlens knows." };
  const before = remembered(names);
  if (before) return { ...before, words: "As you mapped columns of these names before." };
  const lacking = NEEDED.filter(([of]) => !kinds.some((kind) => of.test(kind))).map(([, what]) => what);
  if (!proposal) return { kinds, asked, words: `${lacking.length ? `Not recognised: ${listed(lacking)}. ` : ""}Say what each column is. Angles and speeds are of the output shaft.` };
  const rig = Object.fromEntries(FIELDS.map(({ name }) => [name, proposal[name]]));
  if (rig.counts_per_rev && state && state.counts_per_rev) rig.counts_per_rev = state.counts_per_rev;
  const assumed = Object.values(rig).some((value) => value) ? " Put your own figures in the place of those assumed below." : "";
  return { kinds, rig, asked, words: "Guessed from names and values; look whether it is right. Angles and speeds are of the output shaft." + assumed };
}

// A unit that is not in the list, as --map writes it: the dialogue asks for it.
const OTHER = "other";
function chooseKind({ target }) {
  if (target.value === OTHER) {
    const kind = (prompt("What does the column hold? Write quantity:unit, such as duty:800 for its full duty, speed:rpm*0.1 for a scale, angle:rev/4096.") || "").trim();
    const known = /^[a-z]+[+-]?:\S+$/.test(kind);
    if (known && ![...target.options].some((o) => o.value === kind)) target.add(element("option", { value: kind, textContent: kindWords(kind) }), target.options[target.length - 1]);
    target.value = known ? kind : target.dataset.kind;
  }
  target.dataset.kind = target.value;
  showRaw();
}

async function openAll(files) {
  queue = [...files];
  sent = [];
  readAs = null;
  // What is folded away is not taken from a log to another unseen.
  for (const field of FIELDS.filter(isRare)) field.value = "";
  await ask("/api/use", { replace: false, forget: true });
  await openNext();
}
async function openNext() {
  dropped = queue.shift();
  if (!dropped) return;
  const table = dropped.table = await looked(dropped);
  let fault = null;
  if (table.like && !unsure.has(dropped.name)) {
    try { await sendLike(table); } catch (error) { fault = error; }
    if (!fault) return queue.length ? openNext() : takeIn();
  }
  $("log-alike").hidden = !queue.length;
  $("log-records").hidden = sent.some((s) => s.asked);
  if (!sent.some((s) => s.asked)) $("mapping").elements.keep.value = sent.length ? "join" : "replace";
  const like = table.like && { ...table.like, words: `As ${table.like.file}, which has the same columns.` };
  showMapping(dropped.name, like || (table.names.length ? guessed(table) : { kinds: [], words: table.fault ? words(table.fault) : table.told || "This format tells itself what its columns are." }));
  if (fault) tell(fault);
}
// How the file of a record that is here is read, to be changed as `advice` says.
async function openAgain(entry, advice = []) {
  const { table, in_use, others } = await ask(`/api/mapping/${entry}`);
  queue = [];
  dropped = { name: in_use.file, table, entry };
  $("log-alike").hidden = !others;
  $("log-all").checked = true;
  $("log-records").hidden = true;
  // What was open in the guess is open still where it was taken as it was.
  const asked = String(in_use.kinds) === String(table.kinds) ? table.asked || [] : [];
  showMapping(in_use.file, { ...in_use, asked: [...asked, ...advice], words: table.names.length ? "As it is read now. Angles and speeds are of the output shaft." : table.told || "This format tells itself what its columns are." });
}
// The dialogue, filled with what was guessed, remembered, or is in use.
function showMapping(name, guess) {
  const { table } = dropped, again = dropped.entry !== undefined;
  $("log-verb").textContent = again ? "Columns of" : "Open";
  $("log-name").textContent = name;
  $("log-fault").hidden = true;
  $("log-role").hidden = again;
  $("log-motors").hidden = !table.motors.length;
  $("log-motor").replaceChildren(...table.motors.map((motor) => element("option", { value: motor, textContent: motor })));
  if (guess.motor) $("log-motor").value = guess.motor;
  $("log-words").textContent = guess.words;
  $("log-asked").replaceChildren(...(guess.asked || []).map((question) => element("li", { textContent: askedOnPage(question, table.names) })));
  $("log-asked").hidden = !$("log-asked").childElementCount;
  const rig = guess.rig || {}, inUse = guess.file !== undefined;
  // What is in use is shown as it is; else what was typed for the file before holds on.
  for (const field of FIELDS) field.value = rig[field.name] || (inUse ? "" : field.value) || "";
  $("log-more").open = namesRare($("log-asked").textContent) || FIELDS.some((field) => isRare(field) && field.value);
  $("log-turned").checked = Boolean(guess.turned);
  const choose = element("tr", {}, ...table.names.map((name, k) => {
    const kind = guess.kinds[k] || "", kinds = KINDS.includes(kind) ? KINDS : [...KINDS, kind];
    const select = element("select", { className: "column", onchange: chooseKind }, ...kinds.map((value) => element("option", { value, textContent: kindWords(value) })), element("option", { value: OTHER, textContent: "another unit …" }));
    select.dataset.kind = select.value = kind;
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

// Of so many columns some of those in use are beyond the edge of the table.
const MANY = 7;
// The columns as they stand in the file, before anything is made of them.
function showRaw() {
  const { names, rows } = dropped.table, kinds = kindsChosen();
  const used = names.map((name, k) => kinds[k] && `${name} is ${kindWords(kinds[k])}`).filter(Boolean);
  $("log-used").hidden = names.length < MANY;
  $("log-used").textContent = `In use: ${used.join("; ") || "no column yet"}.`;
  const every = Math.max(1, Math.ceil(rows.length / 800)), kept = rows.filter((_, k) => k % every === 0);
  const column = (k) => kept.map((row) => { const x = Number(String(row[k] ?? "").replace(",", ".")); return !row[k] || Number.isNaN(x) ? null : x; });
  const time = kinds.findIndex((kind) => kind.startsWith("time")), place = time < 0 ? kept.map((_, k) => k * every) : column(time);
  const good = place.every((x, k) => x !== null && (k === 0 || x > place[k - 1]));
  const shown = names.map((_, k) => k).filter((k) => k !== time && column(k).some((x) => x !== null)).sort((a, b) => !kinds[a] - !kinds[b]).slice(0, 6);
  const x = good ? place : kept.map((_, k) => k * every);
  $("raw").hidden = !shown.length || kept.length < 2;
  if ($("raw").hidden) return;
  Plots.show($("raw"), { id: "raw", title: "Raw columns", reading: "The first rows as they stand in the file.", x: { title: good && time >= 0 ? `${names[time]} (as in the file)` : "Row (1)", log: false }, columns: [x],
    panels: shown.map((k, n) => ({ y: { title: kinds[k] ? kinds[k].split(":")[0] : "–", log: false }, height: 74, curves: [{ role: kinds[k] ? "p" + (n % 6) : "voltage", name: names[k], on: 0, draw: "line", y: column(k) }] })) });
  Plots.draw($("raw"));
}

function mapOf({ kinds: before, canonical, motors }, kinds, turned = $("log-turned").checked, motor = $("log-motor").value) {
  if (motors.length) return `voltage=voltage-${motor}:V`;
  if (turned) kinds = kinds.map((kind) => (/^(angle|speed):/.test(kind) ? kind + "*-1" : kind).replace("*-1*-1", ""));
  if (canonical && kinds.every((kind, k) => kind === before[k])) return "";
  const parts = kinds.map((kind, k) => [kind.slice(0, kind.indexOf(":")), k, kind.slice(kind.indexOf(":") + 1)]).filter(([quantity]) => quantity);
  // The fraction of a time in two columns has the unit of both; of a bridge, what is taken off has that of the first.
  const second = (sign) => parts.find(([quantity]) => quantity.endsWith(sign));
  const written = ([quantity, k, unit]) => {
    const [plus, minus] = [second(quantity + "+"), second(quantity + "-")];
    return plus ? `${quantity}=${k}+${plus[1]}:${plus[2]}` : `${quantity}=${k}${minus ? "-" + minus[1] : ""}:${unit}`;
  };
  return parts.filter(([quantity]) => !/[+-]$/.test(quantity)).map(written).join(",");
}
async function send(file, map, rig, role, asked) {
  if (file.size > LARGEST) throw tooLarge(file);
  const reply = await fetch(`/api/upload?${new URLSearchParams({ name: file.name, role, map, ...rig })}`, { method: "POST", body: file });
  const answer = await reply.json();
  if (!reply.ok) throw answer;
  sent.push({ name: file.name, asked });
}
// Reads a file as one that is here and has the same columns, and keeps in mind what to say of it.
async function sendLike(table) {
  const { file, kinds, rig, turned, motor } = table.like;
  const told = Object.fromEntries(Object.entries(rig).filter(([, value]) => value));
  await send(dropped, mapOf(table, kinds, turned, motor), told, "fit", false);
  const columns = kinds.map((kind, k) => kind && `${table.names[k]} is ${kindWords(kind)}`).filter(Boolean);
  const known = FIELDS.filter((field) => told[field.name]).map((field) => `${labelOf(field).split(",")[0]} ${shownIn(field, told[field.name])}`);
  const names = sent.filter((s) => !s.asked).map((s) => s.name);
  readAs = { file: dropped.name, words: `${listed(names)} ${names.length > 1 ? "are" : "is"} read as ${file}: ${[...columns, ...(turned ? ["turned round"] : []), ...known].join("; ")}.` };
}
async function takeIn() {
  const replace = sent.some((s) => s.asked) && new FormData($("mapping")).get("keep") === "replace";
  await ask("/api/use", { replace, ...rigChosen() });
  $("dialog").close();
}
// What the server could not use is asked about the next time.
function readFailed() { for (const { name } of sent) unsure.add(name); if (sent.length) readAs = null; readEnded(); }
function readWell() { for (const { name } of sent) unsure.delete(name); readEnded(); }
// While files are asked about, another work may end.
function readEnded() { if (!$("dialog").open) sent = []; }
// Says in one line which file was read without asking, and lets one change it.
function showReadAs({ entries }) {
  const there = readAs && entries.some((e) => e.file === readAs.file);
  $("read-as").hidden = !there;
  $("read-as-words").textContent = there ? readAs.words : "";
}
$("read-as-change").addEventListener("click", guard(() => openAgain(state.data.entries.findIndex((e) => e.file === readAs.file))));
// What is wrong; a field that it names is seen.
function tell(error) {
  const told = words(error);
  $("log-fault").textContent = told;
  $("log-fault").hidden = false;
  if (namesRare(told)) $("log-more").open = true;
  $("log-fault").scrollIntoView({ block: "nearest" });
}
// What the browser takes for no number, or for one below the least, is told as the server tells what it refuses, where the field is folded away too.
$("mapping").addEventListener("invalid", (event) => {
  const field = event.target;
  event.preventDefault();
  if (field !== FIELDS.find((one) => !one.validity.valid)) return;
  tell({ why: `"${labelOf(field)}" is ${field.value === "" ? "no number" : `"${field.value}"`}`, remedy: `give a ${field.min === "0" ? "number of 0 or more" : "positive number"}, or leave it empty` });
  field.focus();
}, true);
$("mapping").addEventListener("submit", async (event) => {
  event.preventDefault();
  const { table, entry } = dropped, kinds = kindsChosen(), map = mapOf(table, kinds), rig = rigChosen();
  const keep = () => { if (kinds.length && map) remember(table.names, { kinds, rig, turned: $("log-turned").checked }); };
  try {
    if (entry !== undefined) {
      await ask("/api/map", { entry, alike: !$("log-alike").hidden && $("log-all").checked, map, ...rig });
      keep();
      $("dialog").close();
      return;
    }
    const role = new FormData($("mapping")).get("role");
    await send(dropped, map, rig, role, true);
    keep();
    if ($("log-all").checked) {
      while (queue.length) {
        dropped = queue.shift();
        dropped.table = { ...table, rows: [] };
        $("log-name").textContent = dropped.name;
        await send(dropped, map, rig, role, true);
      }
    }
    await (queue.length ? openNext() : takeIn());
  } catch (error) { tell(error); }
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
