"use strict";
// The platoon on the road: one lane per run, all at the same time and scale.
class Road {
  constructor(data, onTime) {
    this.data = data;
    this.onTime = onTime;
    this.time = 0;
    this.playing = false;
    this.lanes = data.runs.map((run, k) => this.lane(run, k));
    const ends = data.runs.map((run) => extremes(run.place));
    this.low = Math.min(...ends.map((e) => e[0])) - 8;
    this.high = Math.max(...ends.map((e) => e[1])) + 4;
    this.element = Object.fromEntries(["play", "scrub", "clock", "rate", "zoom", "centre"].map((id) => [id, document.getElementById(id)]));
    this.listen();
    this.show(0);
  }

  lane(run, k) {
    const figure = document.createElement("figure");
    figure.innerHTML = "<figcaption><b></b><span></span><span></span><span></span></figcaption><canvas role='img'></canvas>";
    figure.querySelector("b").textContent = run.name;
    const canvas = figure.querySelector("canvas");
    canvas.setAttribute("aria-label", "vehicles of " + run.name);
    document.getElementById("lanes").append(figure);
    const spans = figure.querySelectorAll("span");
    ["spacing", "acceleration", "T_max"].forEach((field, i) => { spans[i].id = `now-${k}-${field}`; });
    new ResizeObserver(() => this.element && this.draw(k)).observe(canvas);
    return { run, canvas, spans };
  }

  listen() {
    const { play, scrub, rate, zoom, centre } = this.element;
    play.addEventListener("click", () => this.toggle());
    scrub.addEventListener("input", () => this.show(Number(scrub.value)));
    zoom.addEventListener("input", () => this.show(this.time));
    centre.addEventListener("input", () => this.show(this.time));
    document.addEventListener("keydown", (event) => {
      if (event.code !== "Space" || event.target.closest("button, input, select, summary")) return;
      event.preventDefault();
      this.toggle();
    });
  }

  toggle() {
    this.playing = !this.playing;
    this.element.play.textContent = this.playing ? "Pause" : "Play";
    this.element.play.setAttribute("aria-pressed", this.playing);
    if (!this.playing) return;
    if (this.time >= this.data.duration) this.show(0);
    let last = performance.now();
    const frame = (now) => {
      if (!this.playing) return;
      const time = Math.min(this.data.duration, this.time + ((now - last) / 1000) * Number(this.element.rate.value));
      last = now;
      this.show(time);
      if (time >= this.data.duration) this.toggle(); else requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  show(time) {
    this.time = time;
    this.element.scrub.value = time;
    this.element.clock.textContent = time.toFixed(2) + " s";
    this.lanes.forEach((_, k) => this.draw(k));
    this.onTime(time);
  }

  // Left and right end of what is seen, in metres of the moving frame.
  view(places) {
    const full = this.high - this.low, closest = Math.min(60, full);
    const width = full * Math.pow(closest / full, Number(this.element.zoom.value));
    const i = Math.min(places.length, Math.max(1, Number(this.element.centre.value) || 1)) - 1;
    const middle = this.low + full / 2;
    const share = Number(this.element.zoom.value) > 0 ? 1 : 0;
    const left = share ? Math.min(Math.max(places[i] - width / 2, this.low), this.high - width) : middle - width / 2;
    return [left, left + width];
  }

  draw(k) {
    const { run, canvas, spans } = this.lanes[k];
    const width = canvas.clientWidth, height = canvas.clientHeight, ratio = window.devicePixelRatio || 1;
    if (!width) return;
    if (canvas.width !== Math.round(width * ratio)) { canvas.width = Math.round(width * ratio); canvas.height = Math.round(height * ratio); }
    const pen = canvas.getContext("2d");
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    const places = at(run.place, this.time), spacings = at(run.spacing, this.time), pushes = at(run.acceleration, this.time);
    const [left, right] = this.view(places), scale = width / (right - left), x = (metres) => (metres - left) * scale;
    this.dashes(pen, x, left, right, scale, height);
    const colours = this.data.palette[dark() ? "dark" : "light"];
    const length = Math.max(0.84 * this.data.L * scale, 2);
    places.forEach((place, i) => this.car(pen, x(place), height, length, colours[i], pushes[i] < -0.5, i + 1));
    this.spacingLabels(pen, places, spacings, x, scale, height, length);
    spans[0].textContent = "smallest spacing " + Math.min(...spacings).toFixed(2) + " m";
    spans[1].textContent = "largest |acceleration| " + Math.max(...pushes.map(Math.abs)).toFixed(2) + " m/s²";
    spans[2].textContent = "T_max " + at(run.T_max, this.time)[0].toFixed(4) + " s";
  }

  // Lane markings stand still on the road, so they pass by at v*.
  dashes(pen, x, left, right, scale, height) {
    const period = 12, travelled = (this.data.v_star * this.time) % period;
    pen.fillStyle = ink("--mark");
    if (period * scale < 5) { pen.fillRect(0, 4, x(right), 1); pen.fillRect(0, height - 5, x(right), 1); return; }
    for (let m = Math.floor(left / period) * period - travelled; m < right; m += period) {
      pen.fillRect(x(m), 4, 4 * scale, 2);
      pen.fillRect(x(m), height - 6, 4 * scale, 2);
    }
  }

  // A vehicle's place is its front.
  car(pen, front, height, length, colour, brakes, number) {
    const thick = Math.min(22, Math.max(8, length * 0.6)), top = (height - thick) / 2;
    pen.fillStyle = colour;
    pen.beginPath();
    pen.roundRect(front - length, top, length, thick, Math.min(4, length / 3));
    pen.fill();
    if (brakes) { pen.fillStyle = ink("--brake"); pen.fillRect(front - length - 1, top - 2, Math.max(2, length * 0.12), thick + 4); }
    if (length > 13) {
      pen.fillStyle = bright(colour) ? "#000000" : "#ffffff";
      pen.font = "600 11px system-ui, sans-serif";
      pen.textAlign = "center";
      pen.textBaseline = "middle";
      pen.fillText(number, front - length / 2, height / 2 + 0.5);
    }
  }

  spacingLabels(pen, places, spacings, x, scale, height, length) {
    if (spacings[0] === undefined || 9 * scale - length < 4) return;
    pen.fillStyle = ink("--soft");
    pen.font = "10px system-ui, sans-serif";
    pen.textAlign = "center";
    spacings.forEach((spacing, i) => {
      if (spacing * scale - length > 34) pen.fillText(spacing.toFixed(1) + " m", (x(places[i]) - length + x(places[i + 1])) / 2, height / 2);
    });
  }
}
