"use strict";
// A log dropped on the page: what are its columns?
let dropped = null;
const CANONICAL = { time_s: "time:s", voltage_v: "voltage:V", angle_rad: "angle:rad", speed_rad_s: "speed:rad/s", current_a: "current:A", supply_v: "supply:V" };
const KINDS = ["", "time:s", "time:ms", "time:us", "voltage:V", "voltage:mV", "duty:1", "duty:100", "duty:255", "duty:1023", "angle:rad", "angle:deg", "angle:rev", "angle:counts", "speed:rad/s", "speed:deg/s", "speed:rpm", "current:A", "current:mA", "supply:V", "supply:mV"];
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
    const select = element("select", { className: "column" }, ...KINDS.map((kind) => element("option", { value: kind, textContent: kind ? kind.replace(":", kind.startsWith("duty") ? " of " : " in ") : "not used" })));
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
  const asked = { name: dropped.name, role: new FormData($("mapping")).get("role"), map };
  if ($("log-supply").value) asked.supply_v = $("log-supply").value;
  if ($("log-counts").value) asked.counts_per_rev = $("log-counts").value;
  try {
    const reply = await fetch(`/api/upload?${new URLSearchParams(asked)}`, { method: "POST", body: dropped });
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
