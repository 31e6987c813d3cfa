"use strict";
// Unpack what the page carries: gzip keeps the file small, and every browser since 2023 can undo it.
async function unpack(id) {
  const text = atob(document.getElementById(id).textContent), packed = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) packed[i] = text.charCodeAt(i);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).text();
}

// Index k of the last time at or before `time`, by bisection.
function before(times, time) {
  let low = 0, high = times.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle; else high = middle;
  }
  return low;
}

// Values of all lines of a table at a time, straight between its points.
function at(table, time) {
  const last = table.t.length - 1;
  if (time >= table.t[last]) return table.y.map((line) => line[last]);
  const k = before(table.t, time), f = Math.max(0, (time - table.t[k]) / (table.t[k + 1] - table.t[k]));
  return table.y.map((line) => line[k] + f * (line[k + 1] - line[k]));
}

const extremes = (table) => {
  let low = Infinity, high = -Infinity;
  for (const line of table.y) for (const value of line) { if (value < low) low = value; if (value > high) high = value; }
  return [low, high];
};

const dark = () => {
  const chosen = document.documentElement.dataset.theme;
  return chosen ? chosen === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
};
// Whether black is easier to read on a colour than white.
const bright = (colour) => {
  const [r, g, b] = [1, 3, 5].map((i) => parseInt(colour.slice(i, i + 2), 16) / 255);
  return 0.2126 * r ** 2.2 + 0.7152 * g ** 2.2 + 0.0722 * b ** 2.2 > 0.3;
};
const ink = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
