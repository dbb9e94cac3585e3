"use strict";
// The bench: connect a board, run a programme, watch it, stop it. Then the page begins.
let playing = null, samples = null, firstShown = false;
const MOST = 3000;

function showDevice({ device, counts_per_rev, gear_ratio }) {
  $("play").hidden = $("disconnect").hidden = !device;
  const measures = device && (device.converter ? "supply and current are measured where you say what is wired" : `supply ${device.measures_supply ? "measured" : "as stated"}, current ${device.measures_current ? "measured" : "not measured"}`);
  $("board").textContent = device ? `Firmware ${device.firmware}, board ${device.unique}; ${measures}.` : "A serial port, or the address of the virtual bench.";
  if (device) $("port").value = device.port;
  for (const id of ["divider", "amplifier", "current"]) $(id).disabled = Boolean(device) && !device.converter;
  if (!$("counts").value && counts_per_rev) $("counts").value = counts_per_rev;
  if (!$("gear").value && gear_ratio) $("gear").value = gear_ratio;
  for (const b of document.querySelectorAll(".run-next")) b.textContent = device ? "Run it on the motor" : "Connect a motor to run it";
}
async function renewDevice(device) { state.device = device; showDevice(state); }
$("device").addEventListener("toggle", guard(async () => {
  if (!$("device").open) return;
  $("ports").replaceChildren(...(await ask("/api/device/ports")).ports.map((value) => element("option", { value })));
}));
$("connect").addEventListener("submit", guard(async (event) => {
  event.preventDefault();
  $("board").textContent = "Asking …";
  await renewDevice(null);
  await renewDevice(await ask("/api/device/connect", { port: $("port").value }));
}));
$("disconnect").addEventListener("click", guard(async () => { await ask("/api/device/disconnect", {}); await renewDevice(null); }));
$("play").addEventListener("submit", guard(async (event) => {
  event.preventDefault();
  const number = (id) => ($(id).value === "" ? null : Number($(id).value));
  const wired = (id) => ($(id).disabled ? 0 : number(id));
  await ask("/api/device/run", {
    programme: $("programme").value, amplitude_v: number("amplitude"), seconds: number("seconds"), supply_v: number("supply"), drive: $("drive").value,
    divider: wired("divider"), amplifier: wired("amplifier"), current_limit_a: wired("current"), counts_per_rev: number("counts"), gear_ratio: number("gear"), join: $("join").checked,
  });
}));
function proposeNext() {
  $("device").open = true;
  $("programme").value = "next";
  $("join").checked = true;
  $("device").scrollIntoView();
  $(state.device ? "run" : "port").focus();
}

// Live
function beginLive() {
  playing = { seconds: 1 };
  $("device").open = true;
  $("live-figure").hidden = false;
  $("running").classList.add("motor");
}
function nextLive(e) {
  playing = e;
  samples = { time: [], voltage: [], angle: [] };
  $("live-title").textContent = `${e.programme}, run ${e.number} of ${e.of}`;
  nameRun();
  $("progress").max = e.seconds;
  $("progress").value = 0;
  firstShown = false;
}
const nameRun = () => { $("doing").textContent = `Running ${playing.programme} (${playing.number} of ${playing.of})`; };
function showWaiting(e) { $("doing").textContent = e.message[0].toUpperCase() + e.message.slice(1); }
function showLive(e) {
  if (!samples) return;
  if (!samples.time.length) nameRun();
  for (const key of ["time", "voltage", "angle"]) samples[key].push(...e[key]);
  const count = samples.time.length, every = Math.ceil(count / MOST), last = samples.time[count - 1];
  const thin = (values) => (every === 1 ? values.slice() : values.filter((_, k) => k % every === 0));
  $("progress").value = last;
  const panel = (title, height, curve) => ({ y: { title, log: false }, height, curves: [{ on: 0, ...curve }] });
  const figure = { id: "live", title: "Live", reading: "Angle and voltage as they come.", x: { title: "Time (s)", log: false, range: [0, playing.seconds] }, columns: [thin(samples.time)], panels: [
    panel("Angle (rad)", 200, { role: "measured", name: "angle", draw: "line", y: thin(samples.angle) }),
    panel("Voltage (V)", 110, { role: "voltage", name: "voltage", draw: "steps", y: thin(samples.voltage) })] };
  if (firstShown) Plots.update($("live"), figure);
  else { Plots.show($("live"), figure); Plots.draw($("live")); firstShown = true; }
  $("live").dataset.samples = count;
}
function endLive() { playing = samples = null; $("running").classList.remove("motor"); }
// One key stops a motor, wherever one is on the page.
addEventListener("keydown", (event) => { if (event.key === "Escape" && playing) ask("/api/stop", {}).catch(alarm); });

const events = new EventSource("/api/events");
events.onmessage = (message) => { const e = JSON.parse(message.data); told[e.type](e); };
showGlossary().catch(alarm).then(refresh).catch(alarm);
