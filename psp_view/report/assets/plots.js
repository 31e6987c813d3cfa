"use strict";
// The plots: a row per quantity, a plot per run, drawn when they come into view and linked in time.
const ROWS = [
  ["spacing", "spacing [m]", 2, "m"],
  ["acceleration", "acceleration [m/s²]", 1, "m/s²"],
  ["speed", "speed [m/s]", 1, "m/s"],
];
const DASHES = [[], [8, 4], [2, 3], [8, 3, 2, 3]];
const BORDERS = ["solid", "dashed", "dotted", "dashed"];

class Plots {
  constructor(data, road) {
    this.data = data;
    this.road = road;
    this.plots = [];
    this.hidden = new Set();
    this.window = [0, data.duration];
    this.linking = false;
    this.seen = new IntersectionObserver((entries) => {
      entries.filter((entry) => entry.isIntersecting).forEach((entry) => this.draw(this.plots.find((plot) => plot.box === entry.target)));
    }, { rootMargin: "300px" });
    this.resized = new ResizeObserver((entries) => entries.forEach((entry) => this.fit(this.plots.find((plot) => plot.div === entry.target))));
    this.rows();
    this.together();
    this.chips();
    document.getElementById("same").addEventListener("change", () => this.redraw((plot) => plot.field === "acceleration"));
    document.getElementById("whole").addEventListener("click", () => this.link(null, [0, data.duration]));
    window.addEventListener("beforeprint", () => this.plots.forEach((plot) => this.draw(plot)));
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.recolour());
  }

  row(parent) {
    const row = document.createElement("div");
    row.className = "row";
    document.getElementById(parent).append(row);
    return row;
  }

  add(row, plot) {
    plot.box = document.createElement("div");
    plot.box.className = "plot";
    plot.box.innerHTML = "<div class='head'><b></b> <span></span></div><div class='draw' role='img'></div><div class='legend'></div>";
    plot.box.querySelector("b").textContent = plot.title;
    [plot.div, plot.says, plot.legend] = [".draw", "span", ".legend"].map((name) => plot.box.querySelector(name));
    plot.div.setAttribute("aria-label", `${plot.title}: ${plot.label}`);
    row.append(plot.box);
    this.plots.push(plot);
    this.seen.observe(plot.box);
    this.resized.observe(plot.div);
  }

  rows() {
    for (const [field, label, first, unit] of ROWS) {
      const row = this.row("plots");
      for (const run of this.data.runs) {
        const names = run[field].y.map((_, i) => `vehicle ${first + i}`);
        this.add(row, {
          field, label, unit, title: run.name, timed: true, first, names,
          range: () => this.range(field, run), table: () => [run[field].t, ...run[field].y],
          colours: () => this.data.palette[dark() ? "dark" : "light"].slice(first - 1), width: this.data.vehicles > 12 ? 1 : 1.6,
        });
      }
    }
  }

  // Gaps and speeds share one scale over the runs; accelerations do where asked.
  range(field, run) {
    const runs = field === "acceleration" && !document.getElementById("same").checked ? [run] : this.data.runs;
    const ends = runs.map((one) => extremes(one[field]));
    const low = Math.min(...ends.map((e) => e[0])), high = Math.max(...ends.map((e) => e[1])), margin = 0.05 * (high - low) || 1;
    return [low - margin, high + margin];
  }

  together() {
    const row = this.row("shared"), runs = this.data.runs, names = runs.map((run) => run.name);
    const joined = (tables) => () => uPlot.join(tables);
    const common = { names, colours: () => this.data.runPalette[dark() ? "dark" : "light"], dashed: true, legend: true, width: 1.8 };
    const periods = [...new Set(runs.map((run) => run.T))];
    this.add(row, { ...common, field: "T_max", label: "T_max [s]", unit: "s", title: "Lemma 1's bound T_max, and T (thin)", timed: true, log: true, levels: periods,
      range: () => [0.7 * Math.min(...periods, ...runs.map((run) => extremes(run.T_max)[0])), 1.4 * Math.max(...periods, ...runs.map((run) => extremes(run.T_max)[1]))],
      table: joined(runs.map((run) => [run.T_max.t, run.T_max.y[0]])) });
    this.add(row, { ...common, field: "J", label: "J so far [1]", unit: "", title: "Objective", timed: true, table: joined(runs.map((run) => [run.J.t, run.J.y[0]])) });
    for (const [field, label, title, unit] of [["V", "V(s) [m²/s²]", "Potential", "m²/s²"], ["slope", "V'(s) [m/s²]", "Its slope", "m/s²"]]) {
      this.add(row, { ...common, field, label, title, unit, below: "spacing s [m]", table: joined(this.data.curves.map((curve) => [curve.s, curve[field]])) });
    }
  }

  options(plot) {
    const font = "11px " + getComputedStyle(document.body).fontFamily, colours = plot.colours();
    const axis = { stroke: ink("--soft"), grid: { stroke: ink("--line"), width: 1 }, ticks: { stroke: ink("--line"), width: 1, size: 4 }, font, labelFont: font, labelGap: 0, gap: 3 };
    const symlog = plot.field === "acceleration" && document.getElementById("same").checked;
    const y = plot.log ? { distr: 3 } : symlog ? { distr: 4, asinh: 1 } : {};
    const series = plot.names.map((label, i) => ({
      label, stroke: colours[i % colours.length], width: plot.width, points: { show: false }, spanGaps: plot.timed,
      dash: plot.dashed ? DASHES[i % 4] : [], show: plot.dashed || !this.hidden.has(plot.first + i),
    }));
    return {
      width: Math.max(plot.div.clientWidth, 50), height: plot.div.clientHeight, legend: { show: false }, focus: { alpha: 1 },
      scales: { x: { time: false, range: plot.timed ? (_, low, high) => [low, high] : undefined }, y: { ...y, ...(plot.range ? { range: plot.range } : {}) } },
      axes: [{ ...axis, label: plot.below || "time [s]", labelSize: 15, size: 22 }, { ...axis, label: plot.label, labelSize: 16, size: 46 }],
      series: [{}, ...series],
      cursor: { drag: { x: true, y: false }, sync: plot.timed ? { key: "time", setSeries: false } : undefined, points: { size: 5 } },
      hooks: { ready: [() => this.place(plot)], setScale: [(_, key) => key === "x" && this.scaled(plot)], setCursor: [() => this.say(plot)], draw: [(chart) => this.levels(plot, chart)] },
    };
  }

  draw(plot) {
    if (plot.chart) return;
    this.seen.unobserve(plot.box);
    plot.chart = new uPlot(this.options(plot), plot.table(), plot.div);
    plot.box.classList.add("drawn");
    if (plot.legend && plot.dashed) {
      plot.legend.innerHTML = plot.names.map((_, i) => `<span><i style="border-top:2px ${BORDERS[i % 4]} ${plot.colours()[i]}"></i></span>`).join("");
      plot.legend.querySelectorAll("span").forEach((span, i) => span.append(plot.names[i]));
    }
    if (!plot.timed) return;
    if (this.window[0] !== 0 || this.window[1] !== this.data.duration) this.zoom(plot, this.window);
    plot.cursor = document.createElement("div");
    plot.cursor.className = "cursor";
    plot.chart.over.append(plot.cursor);
    this.listen(plot);
    this.place(plot);
  }

  // A click, unlike a drag, moves the animation.
  listen(plot) {
    let down = 0;
    plot.chart.over.addEventListener("mousedown", (event) => { down = event.clientX; });
    plot.chart.over.addEventListener("click", (event) => {
      if (Math.abs(event.clientX - down) > 3) return;
      const time = plot.chart.posToVal(event.clientX - plot.chart.over.getBoundingClientRect().left, "x");
      this.road.show(Math.max(0, Math.min(this.data.duration, time)));
    });
  }

  fit(plot) {
    if (!plot.chart || !plot.div.clientWidth) return;
    plot.chart.setSize({ width: plot.div.clientWidth, height: plot.div.clientHeight });
    this.place(plot);
  }

  // What the pointer is on: the line nearest to it, and its value.
  say(plot) {
    const { left, top, idx } = plot.chart.cursor;
    if (idx === null || idx === undefined || left < 0) { plot.says.textContent = ""; return; }
    const x = plot.chart.posToVal(left, "x");
    let nearest = null;
    plot.names.forEach((name, i) => {
      const value = plot.chart.data[i + 1][idx];
      if (!plot.chart.series[i + 1].show || value === null || value === undefined) return;
      const distance = Math.abs(plot.chart.valToPos(value, "y") - top);
      if (!nearest || distance < nearest.distance) nearest = { name, value, distance };
    });
    plot.says.textContent = `${x.toFixed(2)} ${plot.timed ? "s" : "m"}` + (nearest ? `: ${nearest.name} ${nearest.value.toPrecision(4)} ${plot.unit}` : "");
  }

  levels(plot, chart) {
    for (const level of plot.levels || []) {
      const y = chart.valToPos(level, "y", true), { left, width } = chart.bbox;
      chart.ctx.save();
      chart.ctx.strokeStyle = ink("--ink");
      chart.ctx.lineWidth = 1;
      chart.ctx.setLineDash([]);
      chart.ctx.beginPath();
      chart.ctx.moveTo(left, y);
      chart.ctx.lineTo(left + width, y);
      chart.ctx.stroke();
      chart.ctx.restore();
    }
  }

  zoom(plot, [min, max]) {
    this.linking = true;
    plot.chart.batch(() => plot.chart.setScale("x", { min, max }));
    this.linking = false;
    this.place(plot);
  }

  scaled(plot) {
    if (this.linking || !plot.timed || !plot.chart) return;
    const { min, max } = plot.chart.scales.x;
    if (min !== this.window[0] || max !== this.window[1]) this.link(plot, [min, max]);
    this.place(plot);
  }

  link(source, range) {
    this.window = range;
    this.plots.filter((plot) => plot.timed && plot.chart && plot !== source).forEach((plot) => this.zoom(plot, range));
  }

  // The line at the animation's time: an element of its own, so that moving it redraws nothing.
  place(plot) {
    if (!plot.cursor) return;
    const x = plot.chart.valToPos(this.road.time, "x");
    plot.cursor.hidden = !(x >= 0 && x <= plot.chart.over.clientWidth);
    plot.cursor.style.transform = `translateX(${x}px)`;
  }

  time() { this.plots.forEach((plot) => this.place(plot)); }

  redraw(which) {
    for (const plot of this.plots.filter((one) => one.chart && which(one))) {
      plot.chart.destroy();
      plot.chart = plot.cursor = null;
      this.draw(plot);
    }
  }

  recolour() {
    this.chips();
    this.redraw(() => true);
  }

  toggle(numbers, shown) {
    numbers.forEach((number) => (shown ? this.hidden.delete(number) : this.hidden.add(number)));
    for (const plot of this.plots.filter((one) => one.chart && !one.dashed)) {
      plot.chart.batch(() => plot.names.forEach((_, i) => plot.chart.setSeries(i + 1, { show: !this.hidden.has(plot.first + i) })));
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
      chip.innerHTML = `<i style="background:${colours[first - 1]}"></i>${last === 1 ? "vehicle 1, leads" : first === last ? "vehicle " + first : `vehicles ${first} to ${last}`}`;
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
    plots.recolour();
  });
  plots = new Plots(data, road);
  window.psp = { data, road, plots };
  performance.mark("ready");
  document.documentElement.dataset.ready = "yes";
})();
