"use strict";
const EVERY = 2000, COLOURS = 12;
const at = id => document.getElementById(id);
const rows = new Map();
let chosen = null, metric = "", drawn = {}, last = null;

const colour = index => `hsl(${Math.round(index * 360 / COLOURS * 5) % 360} 65% ${38 + 12 * (Math.floor(index / COLOURS) % 3)}%)`;

function choose(name) { chosen = name; drawn = {}; if (last) show(last); }

function rowOf(run, index) {
  if (rows.has(run.name)) return rows.get(run.name);
  const row = at("runs").tBodies[0].insertRow();
  for (let cell = 0; cell < 6; cell++) row.insertCell();
  for (const cell of [2, 3, 4]) row.cells[cell].className = "number";
  row.cells[5].className = "error";
  const key = document.createElement("span"), button = document.createElement("button");
  key.className = "key"; key.style.background = colour(index);
  button.className = "run"; button.type = "button"; button.textContent = run.name;
  button.addEventListener("click", () => choose(run.name));
  row.cells[0].append(key, button); row.cells[0].dataset.value = run.name;
  rows.set(run.name, row);
  return row;
}

function fill(cell, text, value) { if (cell.textContent !== text) cell.textContent = text; cell.dataset.value = value ?? ""; }

function table(runs) {
  runs.forEach((run, index) => {
    const row = rowOf(run, index);
    row.classList.toggle("chosen", run.name === chosen);
    row.cells[1].className = run.state;
    fill(row.cells[1], run.state, run.state);
    fill(row.cells[2], run.progress, run.done);
    fill(row.cells[3], run.coverage_text, run.coverage);
    fill(row.cells[4], run.left, run.seconds_left);
    fill(row.cells[5], run.error, run.error);
  });
}

function picture(id, run, version, text) {
  const image = at(id), there = version !== null;
  at(id + "-text").textContent = text;
  image.hidden = !there;
  const source = there ? `/${id}.png?run=${encodeURIComponent(run)}&version=${encodeURIComponent(version)}` : "";
  if (there && drawn[id] !== source) { image.src = source; drawn[id] = source; }
}

function round(span) {
  const power = 10 ** Math.floor(Math.log10(span / 4));
  return [1, 2, 5, 10].map(times => times * power).find(each => each >= span / 5);
}

function tick(value) { value = Math.abs(value) < 1e-12 ? 0 : value; return Math.abs(value) >= 1000 ? `${+(value / 1000).toPrecision(3)} k` : `${+value.toPrecision(3)}`; }

function curves(runs) {
  const canvas = at("curves"), scale = window.devicePixelRatio || 1, wide = canvas.clientWidth, high = canvas.clientHeight;
  canvas.width = wide * scale; canvas.height = high * scale;
  const pen = canvas.getContext("2d"), all = runs.flatMap(run => run.points);
  pen.scale(scale, scale); pen.font = "12px system-ui, sans-serif";
  if (!all.length) { pen.fillStyle = "#4b5563"; pen.fillText("no values yet", 8, 24); return; }
  const left = 52, low = high - 24, right = wide - 8, top = 8;
  const most = Math.max(1, ...all.map(point => point[0]));
  let floor = Math.min(0, ...all.map(point => point[1])), ceiling = Math.max(...all.map(point => point[1]));
  if (ceiling === floor) ceiling = floor + 1;
  const rise = round(ceiling - floor), run_up = round(most);
  const x = step => left + step / most * (right - left), y = value => low - (value - floor) / (ceiling - floor) * (low - top);
  pen.textAlign = "right"; pen.fillStyle = "#4b5563"; pen.strokeStyle = "#e5e7eb";
  for (let value = Math.ceil(floor / rise) * rise; value <= ceiling; value += rise) {
    pen.beginPath(); pen.moveTo(left, y(value)); pen.lineTo(right, y(value)); pen.stroke();
    pen.fillText(tick(value), left - 6, y(value) + 4);
  }
  for (let step = 0; step <= most; step += run_up) pen.fillText(tick(step), Math.max(left + 8, x(step)), high - 6);
  runs.forEach((run, index) => {
    pen.strokeStyle = colour(index); pen.fillStyle = colour(index); pen.lineWidth = run.name === chosen ? 3 : 1.4;
    pen.beginPath();
    run.points.forEach(([step, value], n) => n ? pen.lineTo(x(step), y(value)) : pen.moveTo(x(step), y(value)));
    pen.stroke();
    const end = run.points.at(-1);
    if (end) { pen.beginPath(); pen.arc(x(end[0]), y(end[1]), run.name === chosen ? 4 : 2.5, 0, 7); pen.fill(); }
  });
}

function metrics(names) {
  const list = at("metric"), known = [...list.options].map(option => option.value);
  if (known.join() !== names.join()) list.replaceChildren(...names.map(name => new Option(name, name)));
  list.value = metric;
}

function show(state) {
  last = state;
  const runs = state.runs;
  if (!runs.some(run => run.name === chosen)) chosen = state.newest;
  metric = state.metric;
  at("summary").textContent = state.summary;
  metrics(state.metrics);
  table(runs);
  curves(runs);
  const run = runs.find(one => one.name === chosen);
  if (!run) return;
  at("shown").textContent = run.label;
  at("about").textContent = [run.state, run.progress, run.coverage_text && `coverage ${run.coverage_text}`, run.left && `${run.left} left`, run.error].filter(Boolean).join(", ");
  picture("heatmap", run.name, run.pictures.heatmap, run.pictures.heatmap_text);
  picture("camera", run.name, run.pictures.camera, run.pictures.camera_text);
  picture("observed", run.name, run.pictures.predicted, run.pictures.observed_text);
  picture("predicted", run.name, run.pictures.predicted, run.pictures.predicted_text);
}

async function update() {
  try {
    const answer = await fetch(`/state.json?metric=${encodeURIComponent(metric)}`);
    if (!answer.ok) throw new Error(await answer.text());
    show(await answer.json());
    at("stale").hidden = true;
  } catch (error) {
    at("stale").textContent = `No answer from curionav watch (${error.message}). What is shown is the last that was read.`;
    at("stale").hidden = false;
  }
}

at("metric").addEventListener("change", event => { metric = event.target.value; update(); });
window.addEventListener("resize", () => last && curves(last.runs));
async function keepUpdating() { if (!document.hidden) await update(); setTimeout(keepUpdating, EVERY); }
keepUpdating();
