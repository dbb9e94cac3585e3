// A board's time goes as fast as its emulator runs, the host's program by the wall clock: on a busy machine that program may get no turn
// for so long that the board, whose driver is on, takes it for gone. The board's time then stands still until the program is heard.
"use strict";

const SILENCE = 0.15; // s of the board's time; the host speaks ten or twenty times a second, and boards wait for half a second or more
const LIMIT = 10e3; // ms of the wall clock, after which the host is gone indeed

class Patience {
  // `now` tells the board's time, s.
  constructor(now) {
    this.now = now;
    this.heard();
  }

  // Something of the host's program arrived, whether or not the board gets to see it.
  heard() {
    [this.spoke, this.since] = [this.now(), null];
  }

  // Whether the board's time has to stand still.
  waits(driven) {
    if (!driven || this.now() - this.spoke < SILENCE) return false;
    this.since ??= Date.now();
    return Date.now() - this.since < LIMIT;
  }
}

module.exports = { Patience };
