// An Arduino Uno that runs the compiled sketch, wired to a driver, a motor and its encoder. Its serial line is a TCP
// port: `node uno.js sketch.hex [fault]` prints the port. Time goes as fast as the emulator runs (but see patience.js).
//
// Faults: jam (the shaft sticks after 2 s of the first run), emergency (the contact opens there), fast (an encoder of
// 14 times the lines, too fast for interrupts), tell (none; there it prints a line), crank:SECONDS (somebody turns the shaft for so long
// after the host's first word; two seconds later it prints a line).
"use strict";
const fs = require("fs");
const net = require("net");
const avr = require("avr8js");
const { Motor } = require("./motor.js");
const { Patience } = require("./patience.js");

const HZ = 16e6;
const [hex, injury = "none"] = process.argv.slice(2);
const [fault, cranked] = injury.split(":");

function program(text) {
  const bytes = new Uint8Array(0x8000);
  for (const line of text.split("\n")) {
    const field = (from, length) => parseInt(line.slice(from, from + length), 16);
    if (line[0] !== ":" || field(7, 2) !== 0) continue;
    for (let i = 0; i < field(1, 2); i++) bytes[field(3, 4) + i] = field(9 + 2 * i, 2);
  }
  return new Uint16Array(bytes.buffer);
}

const cpu = new avr.CPU(program(fs.readFileSync(hex, "latin1")));
const b = new avr.AVRIOPort(cpu, avr.portBConfig);
const d = new avr.AVRIOPort(cpu, avr.portDConfig);
for (const config of [avr.timer0Config, avr.timer1Config, avr.timer2Config]) new avr.AVRTimer(cpu, config);
new avr.AVRADC(cpu, avr.adcConfig);
new avr.AVRWatchdog(cpu, avr.watchdogConfig, new avr.AVRClock(cpu, HZ));
const usart = new avr.AVRUSART(cpu, avr.usart0Config, HZ);
const motor = new Motor({ scale: fault === "fast" ? 14 : 1 });

// The driver: IN1 and IN2 choose the direction; both low lets the motor float. It brakes in the off part of the PWM,
// which is taken as its mean.
function volts() {
  const high = (port, pin) => port.pinState(pin) === avr.PinState.High;
  const [forward, backward] = [high(d, 7), high(b, 0)];
  if (forward === backward) return null;
  const pwm = cpu.data[0x80] & 0x80; // COM1A1: the timer has the pin
  const duty = pwm ? cpu.data[0x88] / 255 : high(b, 1) ? 1 : 0;
  return (forward ? 1 : -1) * duty * motor.supply;
}

let socket = null;
let sending = [];
const receiving = [];
usart.onByteTransmit = (byte) => sending.push(byte);
usart.onRxComplete = feed;
function feed() {
  if (receiving.length && usart.writeByte(receiving[0])) receiving.shift();
}

let count = 0;
let driven = 0; // s since the motor was first driven
let told = false;
let asked = null; // the host's first word, s
d.setPin(4, false); // the jumper of the emergency input
function show() {
  const [aa, bb] = Motor.lines(count);
  d.setPin(2, aa);
  d.setPin(3, bb);
}
show();

// Two rad/s, as long as it lasts.
function crank(since) {
  if (since < Number(cranked)) motor.angle += 50e-6;
  else if (!told && since > Number(cranked) + 2) (told = true), console.log("rested for 2 s");
}

// Steps of 25 us: the encoder's edges within one are spread over it, so that they come one by one as on a shaft.
const STEP = HZ * 25e-6;
function advance(end) {
  while (cpu.cycles < end) {
    const applied = volts();
    if (applied !== null) driven += 25e-6;
    if (fault === "tell" && !told && driven > 2) (told = true), console.log("driven for 2 s");
    if (fault === "jam" && driven > 2) motor.jammed = true;
    if (fault === "emergency" && driven > 2) d.setPin(4, true);
    motor.advance(25e-6, applied);
    if (fault === "crank" && asked !== null) crank(cpu.cycles / HZ - asked);
    const edges = Math.abs(motor.count() - count);
    const from = cpu.cycles;
    for (let i = 1; i <= Math.max(edges, 1); i++) {
      if (edges) (count += Math.sign(motor.count() - count)), show();
      while (cpu.cycles < from + (i * STEP) / Math.max(edges, 1)) {
        avr.avrInstruction(cpu);
        cpu.tick();
      }
    }
  }
}

// A turn of 20 ms of the board's time, then the sockets get theirs.
const patience = new Patience(() => cpu.cycles / HZ);
function turn() {
  if (patience.waits(volts() !== null)) return setTimeout(turn, 1);
  if (socket) {
    advance(cpu.cycles + HZ * 0.02);
    feed();
    if (sending.length) socket.write(Buffer.from(sending));
    sending = [];
  }
  setImmediate(turn);
}

const server = net.createServer((client) => {
  socket = client;
  client.setNoDelay(true);
  client.on("data", (bytes) => ((asked ??= cpu.cycles / HZ), receiving.push(...bytes), patience.heard(), feed()));
  client.on("error", () => {});
  client.on("close", () => {
    console.log(`closed: driver ${volts() === null ? "off" : "driven"}`);
    process.exit(0);
  });
});
server.listen(0, "127.0.0.1", () => console.log(`port ${server.address().port}`));
setImmediate(turn);
