"use strict";
// The plots: a row per quantity, a plot per run, drawn when they come into view and linked in time.
const ROWS = [
  ["gap", "gap [m]", 2],
  ["acceleration", "acceleration [m/s²]", 1],
  ["speed", "speed [m/s]", 1],
];
const WEBGL_FROM = 20; // vehicles; SVG lines are sharper, WebGL lines stay quick

class Plots {
  constructor(data, road) {
    this.data = data;
    this.road = road;
    this.plots = [];
    this.hidden = new Set();
    this.linking = false;
    this.webgl = data.vehicles >= WEBGL_FROM && !!document.createElement("canvas").getContext("webgl");
    this.seen = new IntersectionObserver((entries) => {
      entries.filter((entry) => entry.isIntersecting).forEach((entry) => this.draw(entry.target));
    }, { rootMargin: "200px" });
    this.rows();
    this.together();
    this.chips();
    document.getElementById("same").addEventListener("change", () => this.plots.filter((p) => p.field === "acceleration").forEach((p) => this.rescale(p)));
    window.addEventListener("beforeprint", () => this.plots.forEach((plot) => this.draw(plot.box)));
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.recolour());
  }

  add(parent, plot) {
    plot.box = document.createElement("div");
    plot.box.className = "plot";
    plot.box.innerHTML = "<div class='draw'></div><div class='cursor' hidden></div>";
    plot.div = plot.box.firstChild;
    plot.cursor = plot.box.lastChild;
    parent.append(plot.box);
    this.plots.push(plot);
    this.seen.observe(plot.box);
  }

  rows() {
    for (const [field, label, first] of ROWS) {
      const row = document.createElement("div");
      row.className = "row";
      document.getElementById("plots").append(row);
      for (const run of this.data.runs) {
        this.add(row, { field, label, title: run.name, timed: true, range: this.range(field, run), traces: () => this.vehicles(run[field], first) });
      }
    }
  }

  // Gaps and speeds share one scale; accelerations do where asked.
  range(field, run) {
    const runs = field === "acceleration" && !document.getElementById("same").checked ? [run] : this.data.runs;
    const ends = runs.map((one) => extremes(one[field]));
    const low = Math.min(...ends.map((e) => e[0])), high = Math.max(...ends.map((e) => e[1])), margin = 0.05 * (high - low) || 1;
    return [low - margin, high + margin];
  }

  rescale(plot) {
    plot.range = this.range(plot.field, this.data.runs.find((run) => run.name === plot.title));
    if (plot.drawn) Plotly.relayout(plot.div, { "yaxis.range": plot.range });
  }

  vehicles(table, first) {
    const colours = this.data.palette[dark() ? "dark" : "light"];
    return table.y.map((y, i) => ({
      type: this.webgl ? "scattergl" : "scatter", mode: "lines", x: table.t, y, name: `vehicle ${first + i}`, vehicle: first + i,
      line: { color: colours[first - 1 + i], width: this.data.vehicles > 12 ? 1 : 1.6 }, visible: !this.hidden.has(first + i),
      hovertemplate: "%{y:.3f}<extra>%{fullData.name}</extra>",
    }));
  }

  together() {
    const row = document.createElement("div");
    row.className = "row";
    document.getElementById("shared").append(row);
    const style = ["solid", "dash", "dot", "dashdot"];
    const lines = (list, x, y) => () => list.map((one, k) => ({
      type: "scatter", mode: "lines", x: x(one), y: y(one), name: one.name,
      line: { color: this.data.runPalette[dark() ? "dark" : "light"][k], width: 1.8, dash: style[k % 4] },
      hovertemplate: "%{y:.4g}<extra>%{fullData.name}</extra>",
    }));
    const runs = this.data.runs, periods = [...new Set(runs.map((run) => run.T))];
    this.add(row, { field: "T_max", label: "T_max [s]", title: "Lemma 1's bound, and T", timed: true, log: true, legend: true, levels: periods, traces: lines(runs, (r) => r.T_max.t, (r) => r.T_max.y[0]) });
    this.add(row, { field: "J", label: "J so far [1]", title: "Objective", timed: true, legend: true, traces: lines(runs, (r) => r.J.t, (r) => r.J.y[0]) });
    this.add(row, { field: "V", label: "V [m²/s²]", below: "gap s [m]", title: "Potential", legend: true, traces: lines(this.data.curves, (c) => c.s, (c) => c.V) });
    this.add(row, { field: "slope", label: "V' [m/s²]", below: "gap s [m]", title: "Its slope", legend: true, traces: lines(this.data.curves, (c) => c.s, (c) => c.slope) });
    row.querySelectorAll(".plot").forEach((box) => { box.style.height = "300px"; });
  }

  layout(plot) {
    const axis = { gridcolor: ink("--line"), zerolinecolor: ink("--line"), linecolor: ink("--line"), automargin: true };
    const layout = {
      title: { text: plot.title, font: { size: 13 }, x: 0.02, xanchor: "left", y: 0.98, yanchor: "top" },
      margin: { l: 48, r: 8, t: 26, b: 34 }, paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
      font: { color: ink("--ink"), size: 11 }, showlegend: !!plot.legend, hovermode: plot.timed && this.data.vehicles <= 12 ? "x unified" : "closest",
      hoverlabel: { bgcolor: ink("--panel"), font: { color: ink("--ink") } },
      legend: { orientation: "h", y: -0.22, yanchor: "top", x: 0, font: { size: 10 } },
      xaxis: { ...axis, title: { text: plot.below || "time [s]", standoff: 4 }, ...(plot.timed ? { range: this.window || [0, this.data.duration] } : {}) },
      yaxis: { ...axis, title: { text: plot.label, standoff: 4 }, ...(plot.log ? { type: "log" } : {}), ...(plot.range ? { range: plot.range } : {}) },
      shapes: (plot.levels || []).map((T) => ({ type: "line", xref: "paper", x0: 0, x1: 1, y0: T, y1: T, line: { color: ink("--ink"), width: 1, dash: "dot" } })),
    };
    return layout;
  }

  draw(box) {
    const plot = this.plots.find((one) => one.box === box);
    if (plot.drawn) return;
    plot.drawn = true;
    this.seen.unobserve(box);
    Plotly.newPlot(plot.div, plot.traces(), this.layout(plot), { responsive: true, displaylogo: false, displayModeBar: false });
    if (!plot.timed) return;
    plot.div.on("plotly_relayout", (change) => this.link(plot, change));
    plot.div.on("plotly_click", (event) => this.road.show(Math.max(0, Math.min(this.data.duration, event.points[0].x))));
    plot.div.on("plotly_afterplot", () => this.place(plot));
    this.place(plot);
  }

  link(source, change) {
    if (this.linking) return;
    const auto = change["xaxis.autorange"], low = change["xaxis.range[0]"], range = change["xaxis.range"];
    if (!auto && low === undefined && !range) return;
    this.window = auto ? [0, this.data.duration] : range || [low, change["xaxis.range[1]"]];
    this.linking = true;
    const others = this.plots.filter((plot) => plot.timed && plot.drawn && (auto || plot !== source));
    Promise.all(others.map((plot) => Plotly.relayout(plot.div, { "xaxis.range": this.window }))).finally(() => { this.linking = false; });
  }

  // The line at the animation's time: an element of its own, so that moving it redraws nothing.
  place(plot) {
    if (!plot.drawn || !plot.timed || !plot.div._fullLayout) return;
    const { xaxis, _size } = plot.div._fullLayout;
    const x = xaxis.l2p(this.road.time);
    plot.cursor.hidden = x < 0 || x > xaxis._length;
    plot.cursor.style.left = `${_size.l + x}px`;
    plot.cursor.style.top = `${_size.t}px`;
    plot.cursor.style.height = `${_size.h}px`;
  }

  time() { this.plots.forEach((plot) => this.place(plot)); }

  recolour() {
    this.chips();
    for (const plot of this.plots.filter((one) => one.drawn)) Plotly.react(plot.div, plot.traces(), this.layout(plot));
  }

  toggle(numbers, shown) {
    numbers.forEach((number) => (shown ? this.hidden.delete(number) : this.hidden.add(number)));
    for (const plot of this.plots.filter((one) => one.drawn && ROWS.some(([field]) => field === one.field))) {
      Plotly.restyle(plot.div, { visible: plot.div.data.map((trace) => !this.hidden.has(trace.vehicle)) });
    }
    this.chips();
  }

  chips() {
    const group = document.getElementById("chips"), n = this.data.vehicles, size = Math.ceil(n / 12);
    const colours = this.data.palette[dark() ? "dark" : "light"];
    group.replaceChildren();
    for (let first = 1; first <= n; first += size) {
      const numbers = Array.from({ length: Math.min(size, n - first + 1) }, (_, i) => first + i), chip = document.createElement("button");
      const shown = !this.hidden.has(first), last = numbers[numbers.length - 1];
      chip.className = "chip";
      chip.type = "button";
      chip.setAttribute("aria-pressed", shown);
      chip.innerHTML = `<i style="background:${colours[first - 1]}"></i>${first === 1 && size === 1 ? "vehicle 1, leads" : size === 1 ? "vehicle " + first : `vehicles ${first} to ${last}`}`;
      chip.addEventListener("click", () => this.toggle(numbers, !shown));
      group.append(chip);
    }
  }
}

(async () => {
  if (typeof DecompressionStream === "undefined") { document.getElementById("old").hidden = false; return; }
  const data = JSON.parse(await unpack("data-packed"));
  let plots = null;
  const road = new Road(data, () => plots && plots.time());
  document.getElementById("theme").addEventListener("click", () => {
    document.documentElement.dataset.theme = dark() ? "light" : "dark";
    road.show(road.time);
    if (plots) plots.recolour();
  });
  const script = document.createElement("script");
  script.textContent = await unpack("plotly-packed");
  document.head.append(script);
  plots = new Plots(data, road);
  window.psp = { data, road, plots };
  document.documentElement.dataset.ready = "yes";
})();
