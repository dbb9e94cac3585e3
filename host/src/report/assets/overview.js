"use strict";
// The whole record, small, below its plots: a window shows which part is looked at, and is dragged to another one.
const Overview = (() => {
  // The strip of one record: an element with a canvas and, for the window, a slider.
  function on(strip) {
    const frame = strip.querySelector("[role=slider]");
    let whole = [0, 1], range = null, looked = () => {}, points = [[], []], busy = false, wanted = null;
    function paint() {
      const canvas = strip.querySelector("canvas"), [x, y] = points;
      const [width, height] = [strip.clientWidth * devicePixelRatio, strip.clientHeight * devicePixelRatio];
      if (!width || !x.length) return;
      Object.assign(canvas, { width, height });
      const [low, high] = [Math.min(...y), Math.max(...y)], c = canvas.getContext("2d");
      c.strokeStyle = getComputedStyle(document.documentElement).getPropertyValue("--measured").trim();
      c.lineWidth = devicePixelRatio;
      c.beginPath();
      x.forEach((t, k) => c.lineTo((t - whole[0]) / (whole[1] - whole[0]) * width, height - 3 - (y[k] - low) / (high - low || 1) * (height - 6)));
      c.stroke();
    }
    function place(part) {
      range = part;
      const [a, b] = part || whole, span = whole[1] - whole[0];
      Object.assign(frame.style, { left: 100 * (a - whole[0]) / span + "%", width: Math.max(100 * (b - a) / span, 1) + "%" });
      frame.setAttribute("aria-valuemin", whole[0].toPrecision(4));
      frame.setAttribute("aria-valuemax", whole[1].toPrecision(4));
      frame.setAttribute("aria-valuenow", a.toPrecision(4));
      frame.setAttribute("aria-valuetext", `${a.toFixed(2)} to ${b.toFixed(2)} s of ${whole[1].toFixed(2)} s`);
    }
    // Moves the window to begin at `from`; while one answer is on its way only the last wish is kept.
    async function move(from) {
      const [a, b] = range || whole, span = b - a;
      const low = Math.max(whole[0], Math.min(from, whole[1] - span));
      place([low, low + span]);
      wanted = range;
      if (busy) return;
      busy = true;
      try { while (wanted) { const part = wanted; wanted = null; await looked(part); } } finally { busy = false; }
    }
    function keys(event) {
      const [a, b] = range || whole, span = b - a;
      const to = { ArrowLeft: a - span / 4, ArrowDown: a - span / 4, ArrowRight: a + span / 4, ArrowUp: a + span / 4, PageDown: a - span, PageUp: a + span, Home: whole[0], End: whole[1] - span }[event.key];
      if (to === undefined) return;
      event.preventDefault();
      move(to);
    }
    function drag(event) {
      const box = strip.getBoundingClientRect(), [a, b] = range || whole;
      const time = (e) => whole[0] + (e.clientX - box.left) / box.width * (whole[1] - whole[0]);
      // Beside the window the window comes to the pointer; on it, it is held where it was taken.
      const inside = time(event) >= a && time(event) <= b, held = inside ? time(event) - a : (b - a) / 2;
      if (!inside) move(time(event) - held);
      const drawn = (e) => move(time(e) - held);
      strip.setPointerCapture(event.pointerId);
      strip.addEventListener("pointermove", drawn);
      strip.addEventListener("pointerup", () => strip.removeEventListener("pointermove", drawn), { once: true });
    }
    // Takes the figure of a whole record; `look` shows a part of it.
    function show(figure, look) {
      const curve = figure.panels[0].curves[0], x = figure.columns[curve.on];
      points = [x, curve.y];
      whole = x.length > 1 ? [x[0], x[x.length - 1]] : [0, 1];
      looked = look;
      strip.hidden = true;
      place(null);
    }
    // Tells which part is shown; null is all of it, and needs no strip unless the record is dense.
    function at(part) {
      place(part);
      const shut = strip.hidden;
      if (part) strip.hidden = false;
      if (shut && !strip.hidden) paint();
    }
    strip.addEventListener("pointerdown", drag);
    frame.addEventListener("keydown", keys);
    new ResizeObserver(paint).observe(strip);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", paint);
    return { show, at };
  }
  return { on };
})();
