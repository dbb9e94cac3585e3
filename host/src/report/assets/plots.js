"use strict";
// Draws figures in the colours of the page: a trace names its role, the style sheet its colour.
const Plots = (() => {
  const known = new Map();
  const colour = (role) => getComputedStyle(document.documentElement).getPropertyValue("--" + role).trim();
  const fade = (hex, alpha) => hex + Math.round(alpha * 255).toString(16).padStart(2, "0");

  function dress(figure, narrow) {
    const trace = (given) => {
      const role = given.meta && given.meta.role;
      const paint = role ? colour(role) : undefined;
      const width = role === "measured" ? 2.4 : 1.5;
      const t = { ...given };
      if (t.type === "bar") t.marker = { color: paint, ...t.marker };
      else {
        t.line = { color: paint, width, ...t.line };
        t.marker = { color: paint, size: 5, ...t.marker };
        if (t.fill) t.fillcolor = fade(paint, 0.16);
      }
      return t;
    };
    const axis = (given) => ({
      ...given, gridcolor: colour("line"), zerolinecolor: colour("quiet"), linecolor: colour("quiet"), automargin: true,
      title: { ...given.title, standoff: 8, font: { size: narrow ? 12 : 14 } },
    });
    const layout = {
      ...figure.layout, paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", height: figure.height,
      font: { family: "system-ui, sans-serif", size: narrow ? 11 : 13, color: colour("ink") },
      margin: { l: narrow ? 44 : 60, r: 12, t: 44, b: 40 }, dragmode: "zoom",
      modebar: { bgcolor: "rgba(0,0,0,0)", color: colour("quiet"), activecolor: colour("accent") },
      hoverlabel: { bgcolor: colour("surface"), font: { color: colour("ink") }, bordercolor: colour("line") },
      legend: { orientation: "h", y: 1.02, yanchor: "bottom", x: 0, ...figure.layout.legend },
    };
    for (const key of Object.keys(layout)) if (/^[xy]axis/.test(key)) layout[key] = axis(layout[key]);
    layout.shapes = (figure.layout.shapes || []).map((shape) => ({
      ...shape, layer: "below", line: { color: colour(shape.role), width: shape.type === "line" ? 2 : 0, dash: "dash" },
      fillcolor: fade(colour(shape.role), 0.18),
    }));
    return { data: figure.data.map(trace), layout };
  }

  function draw(div) {
    const figure = known.get(div.dataset.figure);
    if (!figure || div.closest("[hidden]")) return Promise.resolve();
    const narrow = div.clientWidth < 480;
    const { data, layout } = dress(figure, narrow);
    div.style.height = figure.height + "px";
    div.dataset.drawn = "yes";
    return Plotly.react(div, data, layout, { responsive: true, displaylogo: false, displayModeBar: narrow ? false : "hover", modeBarButtonsToRemove: ["select2d", "lasso2d"] });
  }

  // Only what is on the screen, or nearly, is drawn.
  const seen = new IntersectionObserver((entries) => {
    for (const entry of entries) {
      entry.target.dataset.near = entry.isIntersecting ? "yes" : "";
      if (entry.isIntersecting && !entry.target.dataset.drawn) draw(entry.target);
    }
  }, { rootMargin: "300px" });

  function show(div, figure) {
    known.set(figure.id, figure);
    div.dataset.figure = figure.id;
    div.dataset.drawn = "";
    div.setAttribute("role", "img");
    div.setAttribute("aria-label", figure.title + ". " + figure.reading);
    div.style.height = figure.height + "px";
    if (div.dataset.near === "yes") return draw(div);
    seen.observe(div);
    return Promise.resolve();
  }

  function fill(root, figures) {
    const byName = new Map(figures.map((figure) => [figure.id, figure]));
    for (const div of root.querySelectorAll(".plot[data-figure]")) {
      const figure = byName.get(div.dataset.figure);
      if (figure) show(div, figure);
    }
  }

  function again() {
    for (const div of document.querySelectorAll(".plot[data-figure]")) {
      div.dataset.drawn = "";
      if (div.dataset.near === "yes") draw(div);
    }
  }
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", again);
  addEventListener("beforeprint", () => { for (const div of document.querySelectorAll(".plot[data-figure]")) draw(div); });
  return { show, fill, draw, colour };
})();
