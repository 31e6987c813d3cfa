"use strict";
// Unpack what the page carries: gzip keeps the file small, and every browser since 2023 can undo it.
async function unpack(id) {
  const packed = Uint8Array.from(atob(document.getElementById(id).textContent), (c) => c.charCodeAt(0));
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

// The last known values of a table whose lines are steps: accelerations and T_max are held between sampling instants,
// but thinned points may lie further apart, so straight lines are what the page promises for them too.
const extremes = (table) => {
  let low = Infinity, high = -Infinity;
  for (const line of table.y) for (const value of line) { if (value < low) low = value; if (value > high) high = value; }
  return [low, high];
};

const dark = () => {
  const chosen = document.documentElement.dataset.theme;
  return chosen ? chosen === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
};
const ink = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
