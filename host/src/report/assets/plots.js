"use strict";
// Draws figures with uPlot in the colours of the page: a curve names its role, the style sheet its colour.
const Plots = (() => {
  const known = new Map();
  const colour = (role) => getComputedStyle(document.documentElement).getPropertyValue("--" + role).trim();
  const fade = (hex, alpha) => hex + Math.round(alpha * 255).toString(16).padStart(2, "0");
  const brief = (v) => (v === null || v === undefined ? "" : String(Number(v.toPrecision(4))));
  // Side by side on paper the wide plots of the screen would be towers; lower than this an axis has no place for its title.
  const heightOf = (panel) => (document.documentElement.dataset.paper ? Math.max(0.55 * panel.height, Math.min(84, panel.height)) : panel.height);
  const frame = () => new Promise((done) => requestAnimationFrame(() => setTimeout(done)));

  // One line of the plot a curve, three where it has a band: the library wants all on one column.
  function lines(figure, panel) {
    return panel.curves.flatMap((curve) => {
      const x = curve.x || figure.columns[curve.on];
      const edge = (sign) => ({ curve, x, edge: true, y: curve.y.map((v, k) => v + sign * curve.spread[k]) });
      return (curve.spread ? [edge(1), edge(-1)] : []).concat({ curve, x, y: curve.y });
    });
  }
  const table = (all) => uPlot.join(all.map((l) => [l.x, l.y]));

  function series({ curve, edge }) {
    const stroke = colour(curve.role);
    if (edge) return { stroke: "#0000", points: { show: false }, class: "silent", label: "", spanGaps: true };
    const s = { label: curve.name, stroke, width: curve.role === "measured" ? 2.4 : 1.6, spanGaps: true, points: { show: false }, value: (u, v) => brief(v) };
    if (curve.draw === "dotted") s.points = { show: true, size: 5, fill: stroke, stroke };
    if (curve.draw === "steps") s.paths = uPlot.paths.stepped({ align: 1 });
    if (curve.draw === "dots") Object.assign(s, { paths: () => null, points: { show: true, size: 5, fill: stroke, stroke } });
    if (curve.draw === "points") Object.assign(s, { paths: () => null, points: { show: true, size: 10, fill: colour("surface"), stroke, width: 2.5 } });
    if (curve.draw === "bars") Object.assign(s, { paths: uPlot.paths.bars({ size: [0.62, 260] }), fill: curve.role === "gone" ? fade(stroke, 0.4) : stroke });
    return s;
  }
  function bands(all) {
    return all.flatMap((line, k) => (line.edge && all[k + 1].edge ? [{ series: [k + 1, k + 2], fill: fade(colour(line.curve.role), 0.16) }] : []));
  }

  // What the library does not know: the band of the noise, and words beside points.
  function floor(u, panel) {
    if (!panel.floor) return;
    const [low, high] = panel.floor.map((v) => u.valToPos(v, "y", true));
    const { left, top, width, height } = u.bbox;
    const clamp = (y) => Math.max(top, Math.min(top + height, y));
    u.ctx.save();
    if (low === high && low === clamp(low)) {
      u.ctx.strokeStyle = colour("floor");
      u.ctx.lineWidth = 2 * devicePixelRatio;
      u.ctx.setLineDash([6 * devicePixelRatio, 4 * devicePixelRatio]);
      u.ctx.beginPath();
      u.ctx.moveTo(left, low);
      u.ctx.lineTo(left + width, low);
      u.ctx.stroke();
    } else {
      u.ctx.fillStyle = fade(colour("floor"), 0.22);
      u.ctx.fillRect(left, clamp(high), width, Math.max(clamp(low) - clamp(high), 1));
    }
    u.ctx.restore();
  }
  // Where words of this size cover the fewest points, lines and other words: above their point, below it, or beside it.
  function room(u, panel, [x, y], [width, height], taken) {
    const at = (curve, k) => [u.valToPos(curve.x ? curve.x[k] : k, "x", true), u.valToPos(curve.y[k], "y", true)];
    const between = ([a, b], [c, d]) => Array.from({ length: 40 }, (_, k) => [a + (k / 40) * (c - a), b + (k / 40) * (d - b)]);
    const marks = panel.curves.flatMap((curve) => {
      const points = curve.y.map((v, k) => (v === null ? null : at(curve, k))).filter(Boolean);
      return points.concat(curve.draw === "points" ? [] : points.slice(1).flatMap((point, k) => between(points[k], point)));
    });
    const { left, top } = u.bbox, [right, bottom] = [left + u.bbox.width, top + u.bbox.height], off = 8 * devicePixelRatio;
    if (panel.floor && panel.floor[0] === panel.floor[1]) marks.push(...between([left, u.valToPos(panel.floor[0], "y", true)], [right, u.valToPos(panel.floor[0], "y", true)]));
    const [aside, apart] = [off + width / 2, off + height / 2];
    const covered = ([cx, cy]) => {
      const near = ([a, b], margin) => Math.abs(a - cx) < width / 2 + margin && Math.abs(b - cy) < height / 2 + margin;
      const beyond = cx - width / 2 < left || cx + width / 2 > right || cy - height / 2 < top - off || cy + height / 2 > bottom;
      const words = taken.filter(([a, b, w, h]) => Math.abs(a - cx) < (width + w) / 2 && Math.abs(b - cy) < (height + h) / 2);
      return marks.filter((mark) => near(mark, off / 4)).length + 100 * (beyond + words.length);
    };
    const places = [[0, -apart], [0, apart], [aside, 0], [-aside, 0], [aside, -apart], [-aside, -apart], [aside, apart], [-aside, apart]].map(([dx, dy]) => [x + dx, y + dy]);
    return places.reduce((best, place) => (covered(place) < covered(best) ? place : best));
  }
  function say(u, panel, size) {
    u.ctx.save();
    u.ctx.font = `600 ${size * devicePixelRatio}px system-ui, sans-serif`;
    u.ctx.fillStyle = colour("ink");
    u.ctx.textAlign = "center";
    u.ctx.textBaseline = "middle";
    u.ctx.strokeStyle = colour("surface");
    u.ctx.lineWidth = 3 * devicePixelRatio;
    u.ctx.lineJoin = "round";
    const taken = [];
    for (const curve of panel.curves) {
      (curve.words || []).forEach((text, k) => {
        const point = [u.valToPos(k, "x", true), u.valToPos(curve.y[k], "y", true)], box = [u.ctx.measureText(text).width, size * devicePixelRatio];
        const at = room(u, panel, point, box, taken);
        taken.push([...at, ...box]);
        u.ctx.strokeText(text, ...at);
        u.ctx.fillText(text, ...at);
      });
    }
    if (panel.floor && panel.floor[0] === panel.floor[1]) {
      u.ctx.textAlign = "right";
      u.ctx.fillStyle = colour("floor");
      const at = [u.bbox.left + u.bbox.width - 4, u.valToPos(panel.floor[0], "y", true) + 12 * devicePixelRatio];
      u.ctx.strokeText("noise level", ...at);
      u.ctx.fillText("noise level", ...at);
    }
    u.ctx.restore();
  }

  // The names of the steps below each other, and on small screens their parts too.
  const broken = (name, narrow) => name.replaceAll(/ (?=[+−])/g, "\n").replaceAll(narrow ? "_" : "\0", "\n");

  // A motor that runs away in the simulation has an error that is endless or no number, and uPlot would draw lines without end up to it.
  const within = (v, other) => (v > 0 ? Math.min(Math.max(v, 1e-9), 1e12) : other);
  const decades = ([low, high]) => { const from = within(low, 1e-9); return [from, Math.max(within(high, 1e12), 10 * from)]; };

  function chart(entry, place) {
    const { figure, root } = entry, panel = figure.panels[place], last = place === figure.panels.length - 1;
    const now = () => entry.figure.panels[place];
    // On paper plots are lower, and so are the letters of their axes' titles.
    const narrow = root.clientWidth < 480, size = document.documentElement.dataset.paper ? 10 : narrow ? 11 : 13, names = figure.x.names || [];
    const font = `${size}px system-ui, sans-serif`, ink = colour("ink"), rule = { stroke: colour("line"), width: 1 };
    const all = lines(figure, panel);
    const axis = { stroke: ink, font, grid: rule, ticks: rule };
    // A title that is longer than its axis is written smaller; letters are about half as wide as high.
    const titled = (title, room) => `${Math.max(8, Math.min(size, Math.floor(room / (0.55 * title.length))))}px system-ui, sans-serif`;
    const across = { ...axis, labelFont: titled(figure.x.title, root.clientWidth - 70), label: last ? figure.x.title : undefined, labelSize: 22, size: last ? 34 : 8 };
    // As far apart as their numbers are long.
    across.space = (u, k, low, high) => Math.max(50, 8 * Math.round(Math.max(Math.abs(low), Math.abs(high))).toLocaleString().length);
    if (figure.x.whole) across.incrs = [1, 2, 5, 10];
    if (!last) across.values = (u, splits) => splits.map(() => "");
    if (names.length) {
      // Names that have no place beside each other stand aslant. A letter is about 0.6 as wide as high.
      const parts = names.map((name) => broken(name, narrow).split("\n")), letters = (words) => Math.max(...words.map((word) => word.length));
      const aslant = names.length * (0.6 * size * letters(parts.flat()) + 8) > root.clientWidth - 70;
      const high = aslant ? 0.45 * size * letters(names) : 1.5 * size * Math.max(...parts.map((part) => part.length));
      Object.assign(across, { splits: () => names.map((_, k) => k), values: (u, splits) => splits.map((k) => (aslant ? names[k] : parts[k].join("\n"))), grid: { show: false }, size: 18 + high, rotate: aslant ? 45 : 0 });
    }
    if (figure.x.step) across.splits = (u, k, low, high) => { const at = []; for (let v = Math.ceil(low / figure.x.step) * figure.x.step; v <= high; v += figure.x.step) at.push(v); return at; };
    const up = { ...axis, labelFont: titled(panel.y.title, heightOf(panel)), label: panel.y.title, labelSize: 20, size: narrow ? 48 : 58, values: (u, splits) => splits.map(brief) };
    if (heightOf(panel) < 150) up.space = 20;
    if (panel.y.log) {
      // Lines and numbers at whole decades only, or at 1, 2, 5 where there are few: nine to each would be all that one sees.
      const round = (v, few) => (few ? [1, 2, 5, 10] : [1, 10]).some((m) => Math.abs(v / 10 ** Math.floor(Math.log10(v)) - m) < 1e-6);
      const filter = (u, splits) => splits.map((v) => (round(v, u.scales.y.max / u.scales.y.min < 300) ? v : null));
      // Our own: uPlot's never ends on an axis that begins a little below a decade (0.97 to 3).
      const splits = (u, place, low, high) => { const at = []; for (let d = Math.floor(Math.log10(low)); 10 ** d <= high; d++) for (let m = 1; m < 10; m++) if (m * 10 ** d >= low && m * 10 ** d <= high) at.push(m * 10 ** d); return at; };
      Object.assign(up, { splits, filter, values: (u, splits) => splits.map(brief), grid: { ...rule, filter }, ticks: { ...rule, filter } });
    }
    const ranged = (u, low, high) => {
      const given = now().y.range;
      if (panel.y.log) return decades(given || [low, high]);
      if (given) return given;
      const wide = low === null || !Number.isFinite(low) ? [0, 1] : uPlot.rangeNum(low, high, 0.08, true);
      // While a slider moves the axis widens but does not jump.
      return entry.still ? [Math.min(wide[0], u.scales.y.min), Math.max(wide[1], u.scales.y.max)] : wide;
    };
    return new uPlot({
      width: Math.max(root.clientWidth, 200), height: heightOf(panel) + (last ? 30 : 0), padding: [10, 12, 0, 0],
      scales: { x: { time: false, range: (u, low, high) => (names.length ? [-0.6, names.length - 0.4] : [low, high]) }, y: { distr: panel.y.log ? 3 : 1, range: ranged } },
      axes: [across, up], bands: bands(all),
      series: [{ label: "at", value: (u, v) => (names.length ? names[v === null ? -1 : Math.round(v)] || "" : brief(v)), class: last ? "place" : "silent" }, ...all.map(series)],
      cursor: {
        drag: { x: !names.length, y: false }, points: { size: 7 },
        sync: { key: entry.key, setSeries: false, filters: { sub: (type) => type === "mousemove" || type === "mouseleave" } },
        bind: { dblclick: () => () => { look(entry, null, true); return null; } },
      },
      hooks: {
        drawClear: [(u) => floor(u, now())], draw: [(u) => say(u, now(), size)],
        setScale: [(u, key) => { if (key === "x" && entry.range && !names.length && !same(entry.range, u.scales.x)) look(entry, [u.scales.x.min, u.scales.x.max], true); }],
      },
    }, table(all), root);
  }

  // The part of the axis that is looked at, the same in all panels.
  function extent(figure) {
    if (figure.x.range) return figure.x.range;
    let [low, high] = [Infinity, -Infinity];
    for (const x of figure.columns) if (x.length) [low, high] = [Math.min(low, x[0]), Math.max(high, x[x.length - 1])];
    return low < high ? [low, high] : [0, 1];
  }
  // A record that never turns back has nothing around its reversals: the words say so, no axes are drawn.
  const empty = (figure) => figure.columns.every((x) => !x.length);
  const same = (range, scale) => Math.abs(range[0] - scale.min) + Math.abs(range[1] - scale.max) < 1e-9 * Math.abs(scale.max - scale.min);
  function look(entry, range, tell) {
    entry.range = range || entry.whole;
    for (const u of entry.charts) u.setScale("x", { min: entry.range[0], max: entry.range[1] });
    if (tell && entry.zoomed) entry.zoomed(range);
  }
  function keys(entry, event) {
    const [low, high] = entry.range || entry.whole, span = high - low;
    const move = (a, b) => look(entry, [Math.max(entry.whole[0], a), Math.min(entry.whole[1], b)], true);
    if (event.key === "+" || event.key === "=") move(low + span / 4, high - span / 4);
    else if (event.key === "-") move(low - span / 2, high + span / 2);
    else if (event.key === "ArrowLeft" && low > entry.whole[0]) move(Math.max(low - span / 4, entry.whole[0]), Math.max(high - span / 4, entry.whole[0] + span));
    else if (event.key === "ArrowRight" && high < entry.whole[1]) move(Math.min(low + span / 4, entry.whole[1] - span), Math.min(high + span / 4, entry.whole[1]));
    else if (event.key === "0" || event.key === "Home") look(entry, null, true);
    else return;
    event.preventDefault();
  }

  function draw(root) {
    const entry = known.get(root);
    if (!entry || root.closest("[hidden]") || !root.clientWidth) return;
    for (const u of entry.charts) u.destroy();
    entry.range = entry.range || extent(entry.figure);
    entry.charts = empty(entry.figure) ? [] : entry.figure.panels.map((_, k) => chart(entry, k));
    for (const th of root.querySelectorAll(".u-series:not(.silent) th")) {
      th.tabIndex = 0;
      th.setAttribute("role", "button");
      th.addEventListener("keydown", (event) => { if (event.key === "Enter" || event.key === " ") { event.preventDefault(); th.click(); } });
    }
    look(entry, entry.range, false);
    root.dataset.drawn = "yes";
  }

  // Only what is on the screen, or nearly, is drawn.
  const seen = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) {
      target.dataset.near = isIntersecting ? "yes" : "";
      if (isIntersecting && !target.dataset.drawn) draw(target);
    }
  }, { rootMargin: "300px" });
  // Whatever else there is comes when there is time: who scrolls or prints finds it drawn.
  const idle = window.requestIdleCallback || ((work) => setTimeout(work, 60));
  let waits = false;
  function later() {
    if (waits) return;
    waits = true;
    idle(() => {
      waits = false;
      const next = [...all()].find((div) => known.has(div) && !div.dataset.drawn && div.clientWidth && !div.closest("[hidden]"));
      if (next) { draw(next); later(); }
    });
  }
  const sizes = new ResizeObserver((entries) => {
    for (const { target } of entries) {
      const entry = known.get(target), others = entry && target.clientWidth ? entry.charts.filter((u) => u.width !== target.clientWidth) : [];
      // Whether names have room beside each other is asked anew.
      if (others.length && (entry.figure.x.names || []).length) draw(target);
      else for (const u of others) u.setSize({ width: target.clientWidth, height: u.height });
    }
  });

  // Shows a figure in an element, from scratch; `zoomed` is told which part is looked at, null for all of it.
  function show(root, figure, zoomed) {
    const old = known.get(root);
    for (const u of old ? old.charts : []) u.destroy();
    known.set(root, { figure, root, zoomed, charts: [], key: "k" + known.size, range: null, whole: extent(figure) });
    root.classList.add("plot");
    root.dataset.drawn = "";
    root.tabIndex = 0;
    root.setAttribute("role", "group");
    root.setAttribute("aria-label", `${figure.title}. ${figure.reading} Plus and minus zoom, arrows move, 0 shows all.`);
    root.style.minHeight = (empty(figure) ? 0 : figure.panels.reduce((sum, panel) => sum + panel.height + 26, 30)) + "px";
    if (!old) {
      root.addEventListener("keydown", (event) => keys(known.get(root), event));
      sizes.observe(root);
      seen.observe(root);
    }
    if (root.dataset.near === "yes") draw(root);
    later();
  }
  // The same figure with other points: only the lines are drawn again.
  function update(root, figure) {
    const entry = known.get(root);
    const shape = (f) => f.panels.map((panel) => [panel.y.log, ...panel.curves.map((curve) => curve.name)]).join();
    if (!entry || !entry.charts.length || shape(entry.figure) !== shape(figure)) { show(root, figure, entry && entry.zoomed); return draw(root); }
    if (!figure.x.range) entry.whole = extent(figure);
    entry.figure = figure;
    entry.range = extent(figure);
    entry.charts.forEach((u, k) => u.batch(() => {
      u.setData(table(lines(figure, figure.panels[k])), false);
      u.setScale("x", { min: entry.range[0], max: entry.range[1] });
    }));
  }
  // Curves that a slider moves; once it stands `still` is over and the axes follow.
  function slide(root, moved, still) {
    const entry = known.get(root);
    if (!entry) return;
    entry.still = still;
    entry.figure.panels.forEach((panel, k) => {
      const curves = panel.curves.filter((curve) => curve.slide in moved);
      for (const curve of curves) [curve.x, curve.y] = moved[curve.slide];
      const u = entry.charts[k];
      if (!u || (still && !curves.length)) return;
      u.batch(() => { u.setData(table(lines(entry.figure, panel)), false); u.redraw(); });
    });
  }
  function fill(root, figures) {
    const byName = new Map(figures.map((figure) => [figure.id, figure]));
    for (const div of root.querySelectorAll(".plot[data-figure]")) {
      const figure = byName.get(div.dataset.figure);
      if (figure) show(div, figure);
    }
  }
  const all = () => document.querySelectorAll(".plot");
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => all().forEach((div) => { if (div.dataset.drawn) draw(div); }));
  // On paper everything is open, every record below the one before, drawn in dark on white and as wide as the page.
  addEventListener("beforeprint", () => {
    document.documentElement.dataset.paper = "yes";
    for (const record of document.querySelectorAll(".record[hidden]")) { record.hidden = false; record.dataset.shut = "yes"; }
    for (const details of document.querySelectorAll("details")) { if (!details.open) { details.dataset.closed = "yes"; details.open = true; } }
    all().forEach(draw);
  });
  addEventListener("afterprint", () => {
    delete document.documentElement.dataset.paper;
    for (const record of document.querySelectorAll(".record[data-shut]")) { record.hidden = true; delete record.dataset.shut; }
    for (const details of document.querySelectorAll("details[data-closed]")) { details.open = false; delete details.dataset.closed; }
    all().forEach((div) => { if (div.dataset.drawn) draw(div); });
  });
  return { show, update, slide, fill, draw, look: (root, range) => look(known.get(root), range, true), frame };
})();
