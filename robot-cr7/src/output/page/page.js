"use strict";
// The page of one motion. All data stand in the element "data"; times are in s, lengths in m.
window.addEventListener("error", (event) => { document.body.dataset.error = event.message; });
window.addEventListener("unhandledrejection", (event) => { document.body.dataset.error = String(event.reason); });

const data = JSON.parse(document.getElementById("data").textContent);
const report = data.report;
const at = (id) => document.getElementById(id);
const last = data.t.length - 1;
const duration = report.duration_s;
const colours = ["#3b82c4", "#d97706", "#2f9e63", "#c2416b", "#8257c7", "#7a8791", "#0e9aa7", "#a3a33a"];

// ---- numbers and places

/** Index of the last entry of an increasing list that is not above `value`; at least 0. */
function before(list, value) {
  let low = 0, high = list.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (list[middle] <= value) low = middle; else high = middle - 1;
  }
  return low;
}
/** The value of the list `ys` where the increasing list `xs` passes `x`. */
function along(xs, ys, x) {
  const i = before(xs, x), k = Math.min(i + 1, xs.length - 1);
  // Between a number and none there is none.
  if (ys[i] === null || ys[k] === null) return null;
  const part = xs[k] > xs[i] ? Math.min(Math.max((x - xs[i]) / (xs[k] - xs[i]), 0), 1) : 0;
  return ys[i] + part * (ys[k] - ys[i]);
}
/** The first time at which the motion is at `s` or further on: a dwell there comes later. */
function arrival(s) {
  let low = 0, high = data.s.length - 1;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (data.s[middle] < s) low = middle + 1; else high = middle;
  }
  if (low === 0 || data.s[low] <= data.s[low - 1]) return data.t[low];
  const part = Math.min(Math.max((s - data.s[low - 1]) / (data.s[low] - data.s[low - 1]), 0), 1);
  return data.t[low - 1] + part * (data.t[low] - data.t[low - 1]);
}
const number = (value) => value === null ? "-" : Number(value.toPrecision(4)).toString();
const people = {
  "m": [1e3, "mm"], "m/s": [1e3, "mm/s"], "m/s^2": [1e3, "mm/s²"], "m/s^3": [1e3, "mm/s³"],
  "rad": [180 / Math.PI, "deg"], "rad/s": [180 / Math.PI, "deg/s"], "rad/s^2": [180 / Math.PI, "deg/s²"],
  "rad/s^3": [180 / Math.PI, "deg/s³"], "N m": [1, "N m"], "1": [1, ""],
};
const jointName = (index) => data.joint_names[index] || `J${index + 1}`;
/** What binds when: intervals in time, the limit with the longest first. */
const bindings = report.binding
  .map((line) => ({
    limit: line.limit,
    spans: line.intervals.map(([from, to]) => [along(data.s, data.t, from), Math.max(along(data.s, data.t, from), arrival(to))]),
    length: line.intervals.reduce((sum, [from, to]) => sum + to - from, 0),
  }))
  .sort((a, b) => b.length - a.length)
  .slice(0, 8);

// ---- the arm

const sides = 10;
/** Points and triangles of a capsule for each link. */
function capsules(points, radius) {
  const mesh = { x: [], y: [], z: [], i: [], j: [], k: [] };
  const count = points.length / 3;
  for (let link = 0; link + 1 < count; link++) {
    const a = points.slice(3 * link, 3 * link + 3), b = points.slice(3 * link + 3, 3 * link + 6);
    const d = a.map((v, n) => b[n] - v), length = Math.hypot(...d);
    if (length < 1e-6) continue;
    const w = d.map((v) => v / length);
    const help = Math.abs(w[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0];
    const cross = (p, q) => [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
    let u = cross(w, help);
    const norm = Math.hypot(...u);
    u = u.map((v) => v / norm);
    const v = cross(w, u);
    const r = radius * (link + 2 === count ? 0.5 : 1);
    const base = mesh.x.length;
    // Rings from pole to pole: place along the link, and radius.
    const rings = [[-r, 0.02 * r], [-0.7 * r, 0.7 * r], [0, r], [length, r], [length + 0.7 * r, 0.7 * r], [length + r, 0.02 * r]];
    for (const [along, wide] of rings) {
      for (let side = 0; side < sides; side++) {
        const angle = 2 * Math.PI * side / sides, c = wide * Math.cos(angle), s = wide * Math.sin(angle);
        mesh.x.push(a[0] + along * w[0] + c * u[0] + s * v[0]);
        mesh.y.push(a[1] + along * w[1] + c * u[1] + s * v[1]);
        mesh.z.push(a[2] + along * w[2] + c * u[2] + s * v[2]);
      }
    }
    for (let ring = 0; ring + 1 < rings.length; ring++) {
      for (let side = 0; side < sides; side++) {
        const p = base + ring * sides + side, q = base + ring * sides + (side + 1) % sides;
        mesh.i.push(p, q); mesh.j.push(p + sides, p + sides); mesh.k.push(q, q + sides);
      }
    }
  }
  return mesh;
}
/** The arm at a time, as a mesh: its own meshes and a capsule for the tool where there are some, else capsules. */
function armMesh(t) {
  const points = armAt(t);
  return data.shape ? addShape(capsules(points.slice(-6), data.radius), data.shape, armAt(t, "joints")) : capsules(points, data.radius);
}
const poseTimes = data.poses.map((pose) => pose.t);
/** Points of the arm, or its joint values, at a time: between two poses, on the straight line from one to the next. */
function armAt(t, what = "points") {
  const i = before(poseTimes, t), k = Math.min(i + 1, data.poses.length - 1);
  const [p, q] = [data.poses[i], data.poses[k]];
  if (p[what].length !== q[what].length || q.t <= p.t) return p[what];
  const part = Math.min(Math.max((t - p.t) / (q.t - p.t), 0), 1);
  return p[what].map((v, n) => v + part * (q[what][n] - v));
}
const tips = data.poses.map((pose) => pose.points.slice(-3));
const column = (n) => tips.map((tip) => tip[n]);

function ranges() {
  const all = [[Infinity, -Infinity], [Infinity, -Infinity], [Infinity, -Infinity]];
  const add = (v, n, far) => {
    all[n][0] = Math.min(all[n][0], v - far);
    all[n][1] = Math.max(all[n][1], v + far);
  };
  for (const pose of data.poses) pose.points.forEach((v, n) => add(v, n % 3, 2 * data.radius));
  // Meshes go further: they are looked at in some poses.
  for (let n = 0; data.shape && n <= 10; n++) {
    const { x, y, z } = armMesh(duration * n / 10);
    [x, y, z].forEach((values, axis) => values.forEach((v) => add(v, axis, 0.5 * data.radius)));
  }
  return all;
}

/** Where the eye stands: on the side of the path, so that the arm is behind it. */
function eye() {
  const mean = (values) => values.reduce((sum, v) => sum + v, 0) / values.length;
  const angle = Math.atan2(mean(column(1)), mean(column(0))) + 0.7;
  return { x: 1.75 * Math.cos(angle), y: 1.75 * Math.sin(angle), z: 0.9 };
}

// ---- colours of light and dark

function ink() {
  const style = getComputedStyle(document.documentElement);
  const of = (name) => style.getPropertyValue(name).trim();
  return { ground: of("--ground"), panel: of("--panel"), ink: of("--ink"), line: of("--line"), mark: of("--mark") };
}
function common() {
  const c = ink();
  return {
    paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: c.panel, font: { color: c.ink, size: 12 }, hovermode: "closest",
    legend: { orientation: "h", y: 1.12, x: 0 }, uirevision: "same",
    modebar: { bgcolor: "rgba(0,0,0,0)", color: c.line, activecolor: c.ink },
  };
}
const axis = (title, more) => {
  const c = ink();
  return { title: { text: title }, gridcolor: c.line, zerolinecolor: c.line, linecolor: c.line, ...more };
};
const quiet = { displaylogo: false, responsive: true, modeBarButtonsToRemove: ["lasso2d", "select2d", "toImage"] };

function drawArm() {
  const c = ink(), mesh = armMesh(time), [x, y, z] = ranges();
  const tip = armAt(time).slice(-3);
  const traces = [
    { type: "mesh3d", ...mesh, color: "#8aa4b8", flatshading: Boolean(data.shape), hoverinfo: "skip",
      lighting: { ambient: 0.5, diffuse: 0.8, specular: 0.15, facenormalsepsilon: 1e-15 },
      lightposition: { x: 2000, y: -4000, z: 6000 } },
    { type: "scatter3d", mode: "lines", x: column(0), y: column(1), z: column(2), hoverinfo: "skip",
      line: { width: 5, color: data.poses.map((pose) => 1e3 * pose.feed), colorscale: "Viridis", showscale: true,
        colorbar: { title: { text: "mm/s" }, thickness: 10, len: 0.6, x: 1 } } },
    { type: "scatter3d", mode: "markers", x: [tip[0]], y: [tip[1]], z: [tip[2]], hoverinfo: "skip",
      marker: { size: 5, color: c.mark } },
  ];
  const side = (title, range) => ({ title: { text: title }, range, gridcolor: c.line, showbackground: false, color: c.ink });
  return Plotly.react("arm", traces, {
    ...common(), margin: { l: 0, r: 0, t: 0, b: 0 }, showlegend: false,
    scene: { aspectmode: "data", xaxis: side("x [m]", x), yaxis: side("y [m]", y), zaxis: side("z [m]", z),
      camera: { eye: eye() } },
  }, quiet);
}
function moveArm() {
  const mesh = armMesh(time), tip = armAt(time).slice(-3);
  Plotly.restyle("arm", { x: [mesh.x, [tip[0]]], y: [mesh.y, [tip[1]]], z: [mesh.z, [tip[2]]] }, [0, 2]);
}

// ---- curves

function drawFeed() {
  const c = ink();
  const traces = [
    { x: data.limit.map((p) => p[0]), y: data.limit.map((p) => p[1] === null ? null : 1e3 * p[1]), name: "limit",
      mode: "lines", line: { color: "#9aa5b0", width: 1.2, dash: "dot" }, hoverinfo: "skip" },
    { x: data.t, y: data.feed.map((v) => 1e3 * v), name: "speed", mode: "lines", line: { color: colours[0], width: 1.8 },
      hovertemplate: "%{x:.3f} s: %{y:.4g} mm/s<extra></extra>" },
  ];
  bindings.forEach((binding, row) => {
    const x = [], y = [];
    for (const [from, to] of binding.spans) { x.push(from, to, null); y.push(binding.limit, binding.limit, null); }
    traces.push({ x, y, yaxis: "y2", mode: "lines", line: { width: 7, color: colours[row % colours.length] },
      showlegend: false, hovertemplate: `${binding.limit}: %{x:.3f} s<extra></extra>` });
  });
  const rows = Math.max(bindings.length, 1);
  const fastest = Math.max(...data.feed) * 1e3 || 1;
  return Plotly.react("feed", traces, {
    ...common(), margin: { l: 150, r: 10, t: 24, b: 38 },
    xaxis: axis("t [s]", { range: [0, duration], anchor: "y2" }),
    yaxis: axis("mm/s", { domain: [0.14 + 0.055 * rows, 1], range: [0, 1.25 * fastest] }),
    yaxis2: axis("", { domain: [0, 0.055 * rows + 0.03], type: "category", range: [rows - 0.5, -0.5], fixedrange: true,
      categoryarray: bindings.map((binding) => binding.limit), categoryorder: "array", title: undefined }),
    annotations: bindings.length ? [] : [{ text: "no limit binds for long", showarrow: false, xref: "paper", yref: "paper", x: 0.5, y: 0 }],
    shapes: [], legend: { orientation: "h", y: 1.1, x: 0, font: { color: c.ink } },
  }, quiet);
}
function drawJoints() {
  const quantity = data.quantities[at("quantity").value], shares = at("shares").checked;
  const traces = quantity.values.map((values, k) => {
    // A range that does not lie around 0 is measured from its middle.
    const [least, most] = quantity.limits[k], middle = (least + most) / 2, half = (most - least) / 2;
    const parts = shares && half > 0 && Number.isFinite(half);
    return { x: data.t, y: parts ? values.map((v) => 100 * (v - middle) / half) : values, text: values.map(number),
      name: jointName(k), mode: "lines", line: { color: colours[k % colours.length], width: 1.4 },
      hovertemplate: `${jointName(k)}: %{text} ${quantity.unit} at %{x:.3f} s<extra></extra>` };
  });
  if (!shares) {
    quantity.limits.forEach(([least, most], k) => {
      for (const value of [least, most]) {
        traces.push({ x: [0, duration], y: [value, value], mode: "lines", showlegend: false, hoverinfo: "skip",
          line: { color: colours[k % colours.length], width: 1, dash: "dot" } });
      }
    });
  }
  const bound = (y) => ({ type: "line", xref: "paper", x0: 0, x1: 1, y0: y, y1: y, line: { color: ink().mark, width: 1, dash: "dot" } });
  return Plotly.react("joints", traces, {
    ...common(), margin: { l: 150, r: 10, t: 24, b: 38 }, shapes: shares ? [bound(100), bound(-100)] : [],
    xaxis: axis("t [s]", { range: [0, duration] }),
    yaxis: axis(shares ? `${quantity.name}, % of the limit` : `${quantity.name} [${quantity.unit}]`, shares ? { range: [-112, 112] } : {}),
  }, quiet);
}

// ---- one time for all

let time = 0;
let playing = false;

function placeCursors() {
  for (const id of ["feed", "joints"]) {
    const plot = at(id), layout = plot._fullLayout, cursor = plot.parentElement.querySelector(".cursor");
    if (!layout) continue;
    const x = layout.xaxis, inside = time >= x.range[0] && time <= x.range[1];
    cursor.style.display = inside ? "block" : "none";
    cursor.style.left = `${x._offset + x.l2p(time)}px`;
    cursor.style.top = `${layout.margin.t}px`;
    cursor.style.height = `${layout.height - layout.margin.t - layout.margin.b}px`;
  }
}
/** The highest speed at a place, and the limit that sets it, in words. */
function highest(s) {
  const i = before(data.ceiling.map((from) => from[0]), s);
  const limit = data.limit.length ? along(data.limit.map((p) => p[0]), data.limit.map((p) => p[1]), time) : null;
  if (!data.ceiling.length || limit === null) return "";
  return `; the most here is ${number(1e3 * limit)} mm/s, set by ${data.ceiling[i][1]}`;
}
/** Goes to a time, everywhere. */
function go(t) {
  time = Math.min(Math.max(t, 0), duration);
  at("scrub").value = String(time);
  at("clock").textContent = `${time.toFixed(3)} / ${duration.toFixed(3)} s`;
  const binds = bindings.filter((line) => line.spans.some(([from, to]) => time >= from - 1e-4 && time <= to + 1e-4));
  const limited = binds.length ? `limited by ${binds.map((line) => line.limit).join(", ")}` : "no limit is used up";
  const s = along(data.t, data.s, time);
  at("now").textContent = `at ${number(1e3 * s)} mm: ${number(1e3 * along(data.t, data.feed, time))} mm/s, ${limited}${highest(s)}`;
  placeCursors();
  moveArm();
}
function play(on) {
  playing = on;
  at("play").textContent = on ? "Pause" : "Play";
  if (!on) return;
  if (time >= duration) go(0);
  let from = performance.now();
  const step = (now) => {
    if (!playing) return;
    // A picture that took long does not make the arm leap: it plays slower instead.
    go(time + Number(at("rate").value) * Math.min(Math.max(now - from, 0), 100) / 1e3);
    from = now;
    if (time >= duration) play(false); else requestAnimationFrame(step);
  };
  requestAnimationFrame(step);
}

// ---- text around it

function texts() {
  at("title").textContent = report.name;
  const facts = [
    data.robot, `${number(1e3 * report.length_m)} mm in ${number(duration)} s`, report.planner,
    data.limited_by ? `limited by ${data.limited_by}` : "no limit binds for long",
  ];
  at("summary").textContent = facts.join(" · ");
  for (const text of report.warnings) at("warnings").append(Object.assign(document.createElement("li"), { textContent: text }));
  data.quantities.forEach((quantity, k) => at("quantity").append(new Option(quantity.name, String(k))));
  const worst = new Map();
  for (const line of report.limits) {
    const other = worst.get(line.name);
    if (!other || line.ratio === null || line.ratio > other.ratio) worst.set(line.name, line);
  }
  for (const line of [...worst.values()].sort((a, b) => b.ratio - a.ratio)) {
    const [factor, unit] = people[line.unit] || [1, line.unit];
    const row = document.createElement("tr");
    const cells = [line.name, line.joint ? jointName(line.joint - 1) : "", number(line.value * factor),
      `${number(line.limit * factor)} ${unit}`, `${(100 * line.ratio).toFixed(2)} %`, `${line.at_t_s.toFixed(3)} s`];
    for (const text of cells) row.append(Object.assign(document.createElement("td"), { textContent: text }));
    row.tabIndex = 0;
    row.classList.toggle("bound", line.ratio >= 0.99);
    const choose = () => {
      document.querySelectorAll("tr.chosen").forEach((other) => other.classList.remove("chosen"));
      row.classList.add("chosen");
      play(false);
      const shown = data.quantities.findIndex((quantity) => line.name === `joint ${quantity.name}`);
      if (shown >= 0 && at("quantity").value !== String(shown)) {
        at("quantity").value = String(shown);
        drawJoints().then(placeCursors);
      }
      go(line.at_t_s);
    };
    row.addEventListener("click", choose);
    row.addEventListener("keydown", (event) => { if (event.key === "Enter") choose(); });
    at("limits").tBodies[0].append(row);
  }
}
function theme(dark) {
  document.documentElement.classList.toggle("dark", dark);
}
async function draw() {
  await Promise.all([drawArm(), drawFeed(), drawJoints()]);
  placeCursors();
}

async function begin() {
  const hash = new URLSearchParams(location.hash.slice(1));
  theme(hash.has("dark") || (!hash.has("light") && matchMedia("(prefers-color-scheme: dark)").matches));
  texts();
  at("scrub").max = String(duration);
  await draw();
  for (const id of ["feed", "joints"]) {
    at(id).on("plotly_click", (event) => { play(false); go(event.points[0].x); });
    at(id).on("plotly_relayout", placeCursors);
  }
  at("play").addEventListener("click", () => play(!playing));
  at("scrub").addEventListener("input", () => { play(false); go(Number(at("scrub").value)); });
  at("quantity").addEventListener("change", () => drawJoints().then(placeCursors));
  at("shares").addEventListener("change", () => drawJoints().then(placeCursors));
  at("theme").addEventListener("click", () => { theme(!document.documentElement.classList.contains("dark")); draw(); });
  window.addEventListener("resize", () => setTimeout(placeCursors, 100));
  document.addEventListener("keydown", (event) => {
    if (["INPUT", "SELECT", "BUTTON"].includes(event.target.tagName)) return;
    if (event.key === " ") { event.preventDefault(); play(!playing); }
    if (event.key === "ArrowRight") go(time + duration / 200);
    if (event.key === "ArrowLeft") go(time - duration / 200);
  });
  go(Number(hash.get("t")) || 0);
  document.body.dataset.state = "ready";
  if (hash.has("play")) play(true);
}
begin();
