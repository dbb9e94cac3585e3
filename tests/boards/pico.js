// A Raspberry Pi Pico that runs the unmodified image from its UF2 file, wired to a driver, a motor and its encoder. What
// goes over USB is a TCP port: `node pico.js image.uf2 [fault [lines [driver [counts.json]]]]` prints the port. It ends when so many have
// called and gone, one unless more are said; between them time stands still. The driver is `brake` (PWM and directions, shorted in the off
// part), `coast` (floating there) or `in-in` (two PWMs and no enable). The shaft's count at each interrupt of the sampling timer goes to
// counts.json.
//
// Faults come 0.3 s after the motor is first driven: emergency (the contact opens), fault (the hard fault's
// handler is entered, for the emulated core raises none), hang (interrupts are off and the program runs in a circle), circle (it
// does so with interrupts on),
// bounce (the contact opens for 20 us), dead (the sampling timer's alarm is lost), pumped (the supply rises to 19 V),
// crystal (it stops: timer and watchdog stand, and the PLL, which the core and the PWM hang on, swings on by itself),
// crystal-back (it does so, and swings again after 0.1 s: timer and watchdog count on),
// short (8 A more at the current's amplifier), silent (nothing of the host arrives for a second), panic:ADDRESS (the control, to which the
// variable at this address points, looks borrowed, over which the program panics).
// What the pins do then is printed. Where the watchdog starts the board anew it comes back on the bus, and the caller's line stays.
//
// What this does not show: the boot ROM and the second boot stage (the image is entered at its vector table), the bus
// of a real USB host, the ring of the supply, and cycles to the last one (rp2040js counts instructions). The PIO is run
// for two turns of its program after each edge of the encoder and before each read of it, not in every cycle: between
// edges its turns change nothing.
"use strict";
const fs = require("fs");
const net = require("net");
const { Simulator, USBCDC, GPIOPinState, ConsoleLogger, LogLevel } = require("rp2040js");
const { Motor } = require("./motor.js");
const { Patience } = require("./patience.js");

const FLASH = 0x10000000;
const VECTORS = FLASH + 0x100; // behind the second boot stage
const TIMER = 0x40054;
const NANOS = 8; // a cycle at 125 MHz
const TURNS = 24; // cycles of the PIO: two turns
const [image, injury = "none", lines = "1", driver = "brake", countsFile] = process.argv.slice(2);
const [fault, address] = injury.split(":");

const simulator = new Simulator();
const { rp2040, clock } = simulator;
rp2040.logger = new ConsoleLogger(LogLevel.Error); // not what is left out of the bus's registers
const pio = rp2040.pio[0];
pio.run = () => {}; // by this file, not by the wall clock
const turn = () => { for (let i = 0; i < TURNS; i++) pio.step(); };
const read = pio.readUint32.bind(pio);
pio.readUint32 = (offset) => (turn(), read(offset));

// The emulator keeps the mask of interrupts that go to the core's NMI, but does not send them there.
const { core } = rp2040;
const setInterrupt = core.setInterrupt.bind(core);
core.setInterrupt = (irq, value) => {
  if (value && (core.interruptNMIMask >>> irq) & 1) [core.pendingNMI, core.interruptsUpdated] = [true, true];
  setInterrupt(irq, value);
};

function load(file) {
  for (let at = 0; at < file.length; at += 512) {
    if (file.readUInt32LE(at) !== 0x0a324655 || file.readUInt32LE(at + 28) !== 0xe48bff56) throw "not for this chip";
    rp2040.flash.set(file.subarray(at + 32, at + 32 + file.readUInt32LE(at + 16)), file.readUInt32LE(at + 12) - FLASH);
  }
}
load(fs.readFileSync(image));

// What a reset of the chip does to what matters here; RAM stays, as on the chip.
function start() {
  for (const pin of rp2040.gpio) pin.ctrl = 0x1f;
  [rp2040.sio.gpioValue, rp2040.sio.gpioOutputEnable] = [0, 0];
  const timer = rp2040.peripherals[TIMER];
  [timer.intRaw, timer.intEnable, rp2040.core.interruptNMIMask] = [0, 0, 0];
  for (const alarm of timer.alarms) timer.disarmAlarm(alarm);
  // The emulated core's own reset begins at the vector alone: whatever it was handling, it handles no longer.
  Object.assign(core, { PM: false, SPSEL: 0, nPRIV: false, currentMode: 0, IPSR: 0, waiting: false, eventRegistered: false });
  Object.assign(core, { enabledInterrupts: 0, pendingInterrupts: 0, interruptsUpdated: false });
  Object.assign(core, { pendingNMI: false, pendingPendSV: false, pendingSVCall: false, pendingSystick: false });
  rp2040.ppb.reset(); // SysTick
  core.VTOR = VECTORS;
  core.reset();
}
start();

// The host's side of the bus. The device offers to take a packet before the host has read which end it takes it on, so
// packets are handed over here: one where the device waits for it and there is something to say.
const usb = rp2040.usbCtrl;
let sending = [];
const receiving = [];
let offered = null;
let connected = false;
function plug() {
  const cdc = new USBCDC(usb);
  [offered, connected] = [null, false];
  cdc.onSerialData = (bytes) => sending.push(...bytes);
  cdc.onDeviceConnected = () => {
    connected = true;
    // Terminal ready, said to the interface as the class asks; the emulator says it to the device.
    usb.sendSetupPacket(Uint8Array.of(0x21, 0x22, 3, 0, 0, 0, 0, 0));
  };
  usb.onEndpointRead = (endpoint, size) => endpoint !== 0 && (offered = { endpoint, size });
}
plug();
// A reset takes the device off the bus: what was under way is lost, and the host greets it anew when it is back.
function unplug() {
  [usb.sieStatus, usb.buffStatus, usb.intRaw, usb.intEnable] = [0, 0, 0, 0];
  for (const { buffers } of [...usb.endpointReadAlarms, ...usb.endpointWriteAlarms]) buffers.length = 0;
  rp2040.usbDPRAM.fill(0);
  sending = [];
  receiving.length = 0;
  plug();
}
function hand() {
  if (fault === "silent" && since !== null && since < 1) receiving.length = 0;
  if (!connected || !offered || !receiving.length) return;
  const { endpoint, size } = offered;
  offered = null;
  usb.endpointReadDone(endpoint, Uint8Array.from(receiving.splice(0, size)));
}

const high = (pin) => rp2040.gpio[pin].value === GPIOPinState.High;
const motor = new Motor();

// The driver: enabled by GP9, direction by GP8 and GP11, or one with two inputs and no enable. What the PWM makes of it is taken as its
// mean; null where the motor is let go.
function volts() {
  const { top, cc } = rp2040.pwm.channels[3];
  const share = (pin, compare) => {
    const { functionSelect, outputOverride } = rp2040.gpio[pin];
    return functionSelect === 4 && outputOverride === 0 ? Math.min(compare / (top + 1), 1) : 0;
  };
  const [first, second] = [share(6, cc & 0xffff), share(7, cc >>> 16)];
  if (driver === "in-in") return first || second ? (first - second) * motor.supply : null;
  if (!high(9) || high(8) === high(11)) return null;
  return (high(8) ? 1 : -1) * first * motor.supply;
}

// A driver that lets go in the off part: while the current lasts, it flows through the diodes against the supply. Steps of 2 us.
function coast(mean) {
  const period = (rp2040.pwm.channels[3].top + 1) * NANOS;
  const share = Math.abs(mean) / motor.supply;
  for (let part = 0; part < 10; part++) {
    const on = ((clock.nanos + part * STEP * 1e8) / period) % 1 < share;
    const diodes = Math.abs(motor.current) < 0.015 ? null : -Math.sign(motor.current) * motor.supply;
    motor.advance(STEP / 10, on ? Math.sign(mean) * motor.supply : diodes);
  }
}

// The converter's inputs: the supply over a divider by 11, with a saw-tooth of the PWM's frequency on it, and the current at 165 mV/A from
// half of 3.3 V. The emulator's round robin never leaves input 0: which is next is put
// right here.
const adc = rp2040.peripherals[0x4004c];
Object.defineProperty(adc, "activeChannel", {
  get: () => (adc.cs >>> 12) & 7,
  set: (next) => (adc.cs = (adc.cs & ~(7 << 12)) | (next << 12)),
});
const RIPPLE = 0.6; // V
let pumped = 0; // V
let short = 0; // A
adc.onADCRead = (channel) => {
  const { top } = rp2040.pwm.channels[3];
  const phase = (clock.nanos / NANOS / (top + 1)) % 1;
  const pin = channel === 0 ? (motor.supply + pumped + RIPPLE * (phase - 0.5)) / 11 : 1.65 + 0.165 * (motor.current + short);
  adc.channelValues[channel] = Math.max(0, Math.min(4095, Math.floor((pin / 3.3) * 4095)));
  adc.currentChannel = channel;
  adc.sampleAlarm.schedule(adc.sampleTime * 1000);
};

let count = 0;
function show() {
  const [a, b] = Motor.lines(count);
  rp2040.gpio[2].setInputValue(a);
  rp2040.gpio[3].setInputValue(b);
}
show();
rp2040.gpio[10].setInputValue(false); // the jumper

// The sampling timer's interrupt takes its flag back, and reads the count right after.
const sampled = [];
const timer = rp2040.peripherals[TIMER];
const writeTimer = timer.writeUint32.bind(timer);
timer.writeUint32 = (offset, value) => {
  if (offset === 0x34 && value & 1) sampled.push(count); // INTR
  writeTimer(offset, value);
};

let driven = 0; // s
let since = null; // s since the fault
let off = null; // when the pins were off after it
let resets = 0;
const watchdog = rp2040.peripherals[0x40058];
watchdog.onWatchdogTrigger = () => {
  resets++;
  watchdog.writeUint32(0, 0); // it stands until the program starts it
  unplug();
  start();
};

// Without the crystal the timer's count, its alarms and the watchdog stand; what is noted in the watchdog's scratch registers is noted, for
// registers have the core's clock. What is returned lets the crystal swing again.
function stopCrystal() {
  const stands = new Map([0x24, 0x28, 0x08, 0x0c].map((offset) => [offset, timer.readUint32(offset)])); // TIMERAWH, -L, TIMEHR, -LR
  const [read, write, writeWatchdog] = [timer.readUint32, timer.writeUint32, watchdog.writeUint32];
  for (const alarm of timer.alarms) timer.disarmAlarm(alarm);
  watchdog.writeUint32(0, 0);
  timer.readUint32 = (offset) => stands.get(offset) ?? read.call(timer, offset);
  timer.writeUint32 = () => {};
  watchdog.writeUint32 = (offset, value) => {
    if (offset >= 0x0c && offset < 0x2c) writeWatchdog.call(watchdog, offset, value); // SCRATCH0 to SCRATCH7
  };
  return () => {
    [timer.readUint32, timer.writeUint32, watchdog.writeUint32] = [read, write, writeWatchdog];
    watchdog.writeUint32(0, 1 << 30); // ENABLE
  };
}

const UNLOCKED = new Set(["circle", "panic", "dead", "crystal", "crystal-back"]);
let swingAgain = null;
function injure() {
  if (since !== null || fault === "none" || driven < 0.3) return;
  // Not in a handler, nor within a critical section: a loop that circles there keeps what it borrowed from the interrupts, a borrow that is
  // made up is written over where one ends, an alarm that is taken away is set again, and what is written while the timer stands is lost.
  if (UNLOCKED.has(fault) && (core.IPSR || core.PM)) return;
  since = 0;
  if (fault === "emergency") rp2040.gpio[10].setInputValue(true);
  if (fault === "bounce") rp2040.gpio[10].setInputValue(true);
  if (fault === "pumped") pumped = 7;
  if (fault === "short") short = 8;
  if (fault === "panic") rp2040.writeUint32(rp2040.readUint32(Number(address)), 1);
  if (fault === "dead") rp2040.peripherals[TIMER].writeUint32Atomic(0x20, 1, 0); // ARMED: a 1 takes the alarm back
  if (fault.startsWith("crystal")) swingAgain = stopCrystal();
  if (fault === "fault") {
    core.PM = true; // as in the handler, to which nothing but the NMI comes
    core.PC = rp2040.readUint32(VECTORS + 12) & ~1;
  }
  if (fault === "hang" || fault === "circle") {
    core.PM = fault === "hang";
    rp2040.sramView.setUint16(0x3ff00, 0xe7fe, true); // b .
    rp2040.core.PC = 0x2003ff00;
  }
}

// Steps of 20 us, the edges within one spread over it.
const STEP = 20e-6;
function advance() {
  const applied = volts();
  if (applied) driven += STEP;
  injure();
  if (since !== null) {
    since += STEP;
    if (fault === "bounce" && since > 1.5 * STEP) rp2040.gpio[10].setInputValue(false);
    if (fault === "crystal-back" && since > 0.1 && swingAgain) (swingAgain(), (swingAgain = null));
    if (applied === null && off === null) off = since;
    if (applied !== null) off = null;
  }
  if (driver === "coast" && applied !== null) coast(applied);
  else motor.advance(STEP, applied);
  const edges = Math.abs(motor.count() - count);
  const from = clock.nanos;
  for (let i = 1; i <= Math.max(edges, 1); i++) {
    if (edges) (count += Math.sign(motor.count() - count)), show(), turn();
    const until = from + (i * STEP * 1e9) / Math.max(edges, 1);
    while (clock.nanos < until) {
      if (rp2040.core.waiting) clock.tick(Math.min(clock.nanosToNextAlarm || NANOS, until - clock.nanos) || NANOS);
      else clock.tick(rp2040.core.executeInstruction() * NANOS);
    }
  }
}

let socket = null;
let callers = Number(lines);
const patience = new Patience(() => clock.nanos * 1e-9);
function loop() {
  if (patience.waits(volts() !== null)) return setTimeout(loop, 1);
  // The bus is there from the start, the line when somebody is on it.
  if (socket || clock.nanos < 0.2e9) {
    for (let i = 0; i < 250; i++) {
      hand();
      advance();
    }
    if (sending.length && socket) socket.write(Buffer.from(sending));
    sending = [];
  }
  setImmediate(loop);
}

const server = net.createServer((client) => {
  socket = client;
  client.setNoDelay(true);
  client.on("data", (bytes) => (receiving.push(...bytes), patience.heard()));
  client.on("error", () => {});
  client.on("close", () => {
    if (socket === client) socket = null; // the next one may be there before this one is seen to be gone
    if (--callers > 0) return;
    const told = off === null ? "" : `, off ${(off * 1e3).toFixed(2)} ms after the fault`;
    if (countsFile) fs.writeFileSync(countsFile, JSON.stringify(sampled));
    console.log(`closed: driver ${volts() === null ? "off" : "driven"}${told}, ${resets} resets, ${clock.nanos / 1e9} s`);
    process.exit(0);
  });
});
server.listen(0, "127.0.0.1", () => console.log(`port ${server.address().port}`));
setImmediate(loop);
