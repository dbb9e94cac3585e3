// A geared DC motor with Coulomb friction and an encoder on its shaft, in small Euler steps. Not the model of the
// fit: nothing is shared with it.
"use strict";

class Motor {
  constructor({ supply = 12, counts = 1320, coulomb = 0.06, scale = 1 } = {}) {
    Object.assign(this, { supply, counts, coulomb, scale, current: 0, speed: 0, angle: 0, jammed: false });
  }

  // Lets `seconds` pass under `volts`, or with the motor open where volts is null.
  advance(seconds, volts) {
    const [resistance, inductance, k, inertia, viscous] = [4, 0.004, 0.5, 0.0045, 0.002];
    const steps = Math.max(1, Math.ceil(seconds / 50e-6));
    const dt = seconds / steps;
    for (let i = 0; i < steps; i++) {
      if (volts === null) this.current = 0;
      else this.current += (dt * (volts - resistance * this.current - k * this.speed)) / inductance;
      const torque = k * this.current - viscous * this.speed;
      if (this.jammed) this.speed = 0;
      else if (this.speed === 0 && Math.abs(torque) <= this.coulomb) this.speed = 0;
      else {
        const against = this.speed !== 0 ? Math.sign(this.speed) : Math.sign(torque);
        const next = this.speed + (dt * (torque - this.coulomb * against)) / inertia;
        this.speed = this.speed * next < 0 ? 0 : next;
      }
      this.angle += dt * this.speed;
    }
  }

  // Counts since the start, every edge.
  count() {
    return Math.floor((this.scale * this.angle * this.counts) / (2 * Math.PI));
  }

  // Levels of the encoder's two lines: A leads B by a quarter while the count rises.
  static lines(count) {
    const quarter = ((count % 4) + 4) % 4;
    return [quarter === 1 || quarter === 2, quarter >= 2];
  }
}

module.exports = { Motor };
