"use strict";
const at = (id) => document.getElementById(id);
const POSSIBLE = 0, ENDS = 9, MORE_ROWS = 3, VERDICTS = ["", "The crush does not stop the vehicle: a larger stiffness or plateau force is needed.",
  "The steps of this impact leave too large an error: a smaller stiffness or friction is needed."];
const chosen = { scene: 0, units: 0, filter: 1, values: new Map() };
const MEAN = 2;  // the 50 ms mean among the curves
let data, contents, machine, wasm, motion, timer;

class Machine {
  // Memory and kernels of a scene, from its module and the contents of memory.
  constructor(scene, module, filled) {
    this.scene = scene;
    this.memory = new WebAssembly.Memory({ initial: Math.ceil(scene.size / 65536) });
    const env = {};
    for (const { name, kind } of WebAssembly.Module.imports(module)) {
      env[name] = kind === "memory" ? this.memory
        : kind === "global" ? new WebAssembly.Global({ value: "i32", mutable: true }, data.stack) : Math[name];
    }
    this.exports = new WebAssembly.Instance(module, { env }).exports;
    for (const [place, number] of scene.contents) new Uint8Array(this.memory.buffer).set(filled[number], place);
  }

  array(name) {
    const [place, kind, shape] = this.scene.arrays[name];
    const kinds = { d: Float64Array, l: BigInt64Array, q: BigInt64Array };
    return new kinds[kind](this.memory.buffer, place, shape.reduce((a, b) => a * b, 1));
  }

  call(name) {
    const [result, values] = this.scene.calls[name];
    this.exports[name](result, values);
    return Array.from(new BigInt64Array(this.memory.buffer, result, 5), Number);
  }

  solve() {
    for (;;) {
      const answer = this.call("motion"), rows = this.scene.arrays["motion.outcome.rows"];
      if (answer[2] !== MORE_ROWS) return answer;
      rows[2][1] *= 2;  // more rows, behind all arrays
      rows[0] = this.memory.buffer.byteLength;
      this.memory.grow(Math.ceil(8 * rows[2][1] * rows[2][2] / 65536));
      const slots = new BigInt64Array(this.memory.buffer, rows[3] - 8, 4);
      slots[0] = BigInt(rows[0]);
      slots[2] = BigInt(rows[2][1]);
    }
  }
}

const scene = () => machine.scene;
const shown = (unit) => data.units[unit][chosen.units];
const digits = (value, count) => String(Number(value.toPrecision(count)));
const measure = (value, unit, count = 4) => `${digits(value * shown(unit)[0], count)} ${shown(unit)[1]}`.trim();
function force(value, named = true) {
  // As many digits as in SI, three at least.
  const [factor, name] = shown("N"), si = value >= 1e5 ? (value / 1e3).toFixed(0) : digits(value / 1e3, 3);
  const here = chosen.units ? digits(value * factor, Math.max(3, si.replace(/\D/g, "").replace(/^0+/, "").length)) : si;
  return `${here}${named ? ` ${name}` : ""}`;
}
function span(low, high, scale, [[factor, name], here]) {
  // A range in the words of `tailslap rigid`: four digits in SI, and as many in other units, three at least.
  const texts = [low, high].map((end) => {
    const value = Number((scale * end).toPrecision(4)), si = Math.abs(value) < 1e4 ? digits(factor * value, 4) : (factor * value).toFixed(0);
    return chosen.units && here[1] !== name ? digits(here[0] * value, Math.max(3, si.replace(/\D/g, "").replace(/^0+/, "").length)) : si;
  });
  return `${texts.join(" to ")} ${chosen.units ? here[1] : name}`.trim();
}
function plateaus() {
  // Plateau of the crush of each group of points.
  const sums = new Map(), groups = machine.array("motion.case.0.group");
  machine.array("motion.case.0.plateau_force").forEach((one, p) => sums.set(groups[p], (sums.get(groups[p]) ?? 0) + one));
  return [...sums.values()];
}
const value = (quantity) => chosen.values.get(quantity.key) ?? quantity.value;
const escaped = (text) => text.replace(/[&<>"]/g, (sign) => `&#${sign.charCodeAt(0)};`);

function refusal(reason, item) {
  // Key and sentence of a rule that the values break.
  const columns = (table, width, k) => Number(machine.array(`motion.parts.${table}`)[width * item + k]);
  const points = machine.array("motion.parts.points").length / machine.array("motion.parts.places").length * 3;
  const column = { 1: () => columns("points", points, 5), 2: () => columns("points", points, 6), 3: () => columns("points", points, 7),
    4: () => columns("points", points, 8), 5: () => columns("units", 7, 3), 6: () => columns("units", 7, 4),
    7: () => columns("axles", 3, 0), 8: () => columns("axles", 3, 0) }[reason]();
  const values = machine.array("motion.values"), quantity = scene().quantities.find((one) => one.column === column);
  const unit = reason < 7 ? item : Number(machine.array("motion.case.1.unit")[item]);
  const of = (k) => values[columns("points", points, k)];
  const known = { initial: () => of(4), stiffness: () => of(3), length: () => values[machine.array("motion.parts.units")[7 * unit]],
    load: () => machine.array("motion.case.1.load")[item] };
  const [why, allowed] = data.reasons[reason].map((text) =>
    text.replace(/\{(\w+)[^}]*\}/g, (all, name) => known[name] ? digits(known[name](), 4) : name));
  return { key: quantity?.key, text: `${why}; allowed: ${allowed}` };
}

function mark(key, text) {
  for (const box of document.querySelectorAll(".quantity")) {
    const wrong = box.dataset.key === key, error = box.querySelector(".error");
    error.textContent = wrong ? text : "";
    box.querySelector("input").setAttribute("aria-invalid", wrong);
  }
}

function refuse(text, key) {
  at("headline").textContent = text;
  at("headline").classList.add("refused");
  stop();
  for (const id of ["band", "certainty", "force", "plan", "strikes", "peaks", "keys", "force-caption", "plan-caption"]) at(id).replaceChildren();
  motion = undefined;
  mark(key, key ? text : "");
}

function compute() {
  clearTimeout(timer);
  save();
  for (const quantity of scene().quantities) {
    const number = value(quantity);
    if (!(number >= quantity.least && number <= quantity.most)) {
      refuse(`${quantity.key}: given ${measure(number, quantity.unit, 6)}; ${data.texts[quantity.allowed[chosen.units]]}`, quantity.key);
      return;
    }
    machine.array(scene().rows.length ? "space.values" : "motion.values")[quantity.column] = number;
  }
  if (scene().rows.length) return computeInSpace();
  const [reason, item, verdict, count] = machine.solve();
  if (reason !== POSSIBLE || verdict) {
    const why = reason ? refusal(reason, item) : { text: VERDICTS[verdict] };
    refuse(why.key ? `${why.key}: ${why.text}` : why.text, why.key);
    return;
  }
  mark();
  read(count);
  answer();
  draw();
  timer = setTimeout(band, 10);
}

function read(count) {
  const values = machine.array("motion.motion.values"), width = scene().arrays["motion.motion.values"][2][1];
  const curves = machine.array("motion.motion.curves"), all = scene().arrays["motion.motion.curves"][2][1];
  const rows = machine.array("motion.outcome.strikes"), means = machine.array("motion.motion.strike_means");
  const end = machine.array("motion.case.4.reached")[0], strikes = [];
  for (let k = 0; k * 11 < rows.length; k++) {
    const [group, start, last, peak, impulse, , , , , , cut] = rows.slice(11 * k, 11 * k + 11);
    if (impulse > 0 && start < end) strikes.push({ group, start, end: Math.min(last, end), peak, impulse, mean: means[k], cut });
  }
  strikes.sort((one, other) => one.start - other.start);
  motion = { count, values, width, strikes, end, times: machine.array("motion.motion.times"),
    curves: data.filters.map((_, c) => curves.subarray(c * all, c * all + count)), peaks: machine.array("motion.motion.peaks") };
}

function ratio(mean, span = "") {
  // A force over the design load of the scene, with those of a band.
  const load = scene().compared;
  return load ? `, ${(mean / load[1]).toPrecision(2)}${span} times ${load[0]} (${force(load[1])})` : "";
}

function bandWords(ends, name) {
  const load = scene().compared, span = load ? ` (${[ends[0], ends[2]].map((end) => (end / load[1]).toPrecision(2)).join(" to ")})` : "";
  return `median ${force(ends[1])}; ${name}: ${force(ends[0], false)} to ${force(ends[2])}${ratio(ends[1], span)}. ${data.of_scene}`;
}

function answer(ends, name) {
  // The answer, with lower end, median and upper end of the band where it is there.
  const peak = motion.peaks[MEAN], paper = machine.array("motion.paper.mean")[0], strikes = motion.strikes;
  const largest = strikes.reduce((best, one, k) => one.mean > strikes[best].mean ? k : best, 0), one = strikes[largest];
  const least = strikes.some((strike) => strike.cut) ? "at least " : "", equal = plateaus().some((one) => Math.abs(peak / one - 1) <= data.rounding);
  let text = `${data.force}: ${ends ? bandWords(ends, name) : ""}`;
  text += `${least}${force(peak)} in strike ${largest + 1} (${scene().parts[one?.group]}, from ${one?.start.toFixed(3)} s)`
    + `${equal ? data.equal : ""}${ends || equal ? "" : ratio(peak)}.${Number.isNaN(paper) ? "" : ` Paper's method: ${force(paper)}.`}`;
  at("headline").classList.remove("refused");
  at("headline").textContent = strikes.length ? text : "The vehicle does not strike the wall.";
  const error = machine.array("motion.outcome.error")[0];
  at("certainty").textContent = `Rigid vehicle in the plane; error by the time step at most ${digits(100 * error * 1.05, 2)} %.`;
}

function drawBand(name) {
  // Places within ranges by parts of a Latin hypercube: numbers of PCG64 (O'Neill, HMC-CS-2014-0905) as NumPy draws them.
  if (machine.array(name)[0]) return;
  const [, , [columns, rows]] = scene().arrays[name], drawn = machine.array(name), parts = contents[scene().drawn];
  const [first, increment] = data.random.map(BigInt), half = (1n << 64n) - 1n;
  let state = first;
  for (let i = 0; i < rows; i++) {
    for (let k = 0; k < columns; k++) {
      state = BigInt.asUintN(128, state * 0x2360ed051fc65da44385df649fccf645n + increment);
      const bits = (state >> 64n) ^ (state & half), turn = state >> 122n, turned = bits >> turn | bits << (64n - turn) & half;
      drawn[k * rows + i] = (parts[k * rows + i] + 1 - Number(turned >> 11n) / 2 ** 53) / rows;
    }
  }
}

function speeds() {
  // A lower and a higher speed by text, with two digits in the scene's unit, or in the one shown where it was changed.
  const key = "impact.speed", [factor, unit] = chosen.values.has(key) ? shown("m/s") : scene().speed;
  const [slow, fast] = data.growth.map((part) => Number((part * factor * value(scene().quantities.find((one) => one.key === key))).toPrecision(2)));
  machine.array("band.growth.speeds").set([slow / factor, fast / factor]);
  return `from ${slow} to ${fast} ${unit}`;
}

function decision(kernel, between) {
  // The inputs and the speed that decide the force.
  const fractions = machine.array(`${kernel}.ranges.fractions`), ends = machine.array(`${kernel}.ranges.ends`), growth = between ? machine.array(`${kernel}.growth.ratio`)[0] : 0;
  const inputs = [...fractions.keys()].filter((r) => fractions[r] > data.named[0]).sort((r, q) => fractions[q] - fractions[r]).slice(0, data.named[1]).map((r) => {
    const [key, origin, name, ...forms] = scene().ranges[r], low = ends[2 * r], high = ends[2 * r + 1];
    const range = key.includes("*") ? `${digits(low, 2)} to ${digits(high, 2)} times that of the scene` : span(low, high, ...forms);
    return `${name}, ${origin.includes("assumed") ? "assumed " : ""}${range} (${(100 * fractions[r]).toFixed(0)} %)`;
  });
  const parts = inputs.length ? [`decided most by ${inputs.join(", and ")} of the variance`] : [];
  if (growth) parts.push(`${between} the force grows ${digits(growth, 2)} times`);
  const text = parts.join("; ").replace(") of the variance", " of the variance)");
  return text ? `${text[0].toUpperCase()}${text.slice(1)}. ` : "";
}

function band() {
  drawBand("band.ranges.drawn");
  const between = speeds(), start = performance.now(), [reason, item, verdict, varied, number] = machine.call("band");
  const ranges = scene().ranges, ends = machine.array("band.ranges.ends");
  if (reason || verdict) {
    const why = reason === ENDS ? `${ranges[item][0]} (${ranges[item][1]}) is beyond what is allowed`
      : verdict ? VERDICTS[verdict] : "too few of the varied inputs have a solution";
    at("band").textContent = `Without a band of the force: ${why}`;
    return;
  }
  const found = machine.array("band.percentiles").slice(data.percentiles);
  const [name, calibrated] = scene().classes[number] ?? [data.band];
  answer(found, name);
  bandText(ranges, ends, `${decision("band", between)}Band of ${machine.array("band.forces").length} rigid vehicles over ${varied} inputs`, calibrated);
  document.body.dataset.band = (performance.now() - start).toFixed(1);
}

function bandText(ranges, ends, text, calibrated) {
  // Sentence of a band, and the ranges at their boxes.
  const fixed = ranges.filter((_, r) => Number.isNaN(ends[2 * r])).map(([key]) => key);
  const assumed = ranges.filter(([key, origin]) => origin.includes("assumed") && !fixed.includes(key)).length;
  at("band").textContent = `${text}, ${assumed} with assumed ranges${calibrated ? `; ${calibrated}` : ""}`
    + (fixed.length ? `; not varied, since outside the range: ${fixed.map((key) => `\`${key}\``).join(", ")}.` : ".");
  ranges.forEach(([key, origin], r) => {
    const box = document.querySelector(`.quantity[data-key="${key}"] .range`), quantity = scene().quantities.find((one) => one.key === key);
    if (box) box.textContent = fixed.includes(key) ? `outside the range of the band (${origin})`
      : `band: ${digits(ends[2 * r] * shown(quantity.unit)[0], 4)} to ${measure(ends[2 * r + 1], quantity.unit)} (${origin})`;
  });
}

function ticks(most, count) {
  const raw = most / count, power = 10 ** Math.floor(Math.log10(raw)), step = power * [1, 2, 5, 10].find((k) => k * power >= raw);
  return Array.from({ length: Math.floor(most / step + 1e-9) + 1 }, (_, k) => Number((k * step).toPrecision(6)));
}

function draw() {
  const width = Math.max(280, at("force").clientWidth), height = 280, left = 46, bottom = 30, [factor, name] = shown("N");
  const loads = scene().loads, most = 1.08 * Math.max(motion.peaks[0], ...loads.map(([, load]) => load < 2 * motion.peaks[0] ? load : 0));
  const x = (t) => left + (width - left - 8) * t / motion.end, y = (f) => (height - bottom) * (1 - f / most);
  const grid = ticks(most * factor, 5).map((f) => `<path class="axis" d="M${left} ${y(f / factor)}H${width - 8}"/>`
    + `<text x="${left - 6}" y="${y(f / factor) + 4}" text-anchor="end">${f}</text>`);
  const marks = ticks(motion.end, Math.max(3, width / 110)).filter((t) => x(t) < width - 26).map((t) => `<text x="${x(t)}" y="${height - 10}" text-anchor="middle">${t}</text>`);
  let above = Infinity, side = 0;  // names of lines that are close stand side by side
  const lines = loads.filter(([, load]) => load <= most).sort((one, other) => one[1] - other[1]).map(([label, load]) => {
    side = above - y(load) < 14 ? (side + 1) % 3 : 0;
    above = y(load);
    const place = [width - 10, left + 4, (left + width) / 2][side], anchor = ["end", "start", "middle"][side];
    return `<path class="load" d="M${left} ${y(load)}H${width - 8}"/>`
      + `<text class="load-text" x="${place}" y="${y(load) - 4}" text-anchor="${anchor}">${escaped(label)}</text>`;
  });
  const filter = motion.curves[chosen.filter] ? chosen.filter : 1;  // in space there are means alone
  const curves = [0, filter, MEAN].map((curve, c) => `<path class="curve curve${c}" d="${path(motion.curves[curve], x, y, width)}"/>`);
  at("force").innerHTML = `<svg viewBox="0 0 ${width} ${height}" role="img" aria-label="Lateral force over time">${grid.join("")}${marks.join("")}`
    + `${curves.join("")}${lines.join("")}<text x="${width - 8}" y="${height - 10}" text-anchor="end">s</text></svg>`;
  at("force-caption").textContent = `Lateral force on the wall [${name}]${lines.length ? "; lines across: design forces" : ""}`;
  at("keys").innerHTML = ["force", data.filters[filter][1], data.filters[MEAN][1]].map((text, c) => `<span><i class="curve${c}"></i>${text}</span>`).join("");
  at("plan-caption").textContent = "Plan: positions at first touch, at the strikes and at the end; filled: at the time below. The wall is the line.";
  if (scene().rows.length) return drawInSpace();
  table();
  peaks();
  plan();
}

function path(curve, x, y, width) {
  // The least and greatest value of each column of pixels.
  const a_column = Math.max(1, Math.floor(curve.length / width)), parts = [];
  for (let k = 0; k < curve.length; k += a_column) {
    const piece = curve.subarray(k, Math.min(k + a_column, curve.length));
    let low = 0, high = 0;
    piece.forEach((f, j) => { if (f < piece[low]) low = j; if (f > piece[high]) high = j; });
    for (const j of low < high ? [low, high] : low > high ? [high, low] : [low]) {
      parts.push(`${x(motion.times[k + j]).toFixed(1)} ${y(curve[k + j]).toFixed(1)}`);
    }
  }
  return `M${parts.join("L")}`;
}

function corners(k, unit) {
  // Corners of a unit at an instant, from its state.
  const [length, breadth, centre] = scene().units[unit].map((column) => machine.array("motion.values")[column]);
  const [x, y, theta] = motion.values.subarray(motion.width * k + 6 * unit, motion.width * k + 6 * unit + 3);
  const c = Math.cos(theta), s = Math.sin(theta);
  return [[centre, 1], [centre, -1], [centre - length, -1], [centre - length, 1]].map(([along, side]) => {
    const across = side * breadth / 2;
    return [x + along * c + across * s, y - along * s + across * c];
  });
}

function plan() {
  const now = Math.round(at("time").value / 1000 * (motion.count - 1)), row = (t) => Math.round(t / motion.end * (motion.count - 1));
  const instants = [0, ...motion.strikes.map((strike) => row(strike.start)), motion.count - 1];
  const bodies = (k) => scene().units.map((_, unit) => corners(k, unit)), all = [...instants, now].flatMap(bodies).flat();
  const [west, east] = [Math.min, Math.max].map((end) => end(...all.map(([x]) => x))), top = Math.max(...all.map(([, y]) => y)) + 0.5;
  const draws = (k, kind) => bodies(k).map((body) => `<polygon class="body${kind}" vector-effect="non-scaling-stroke" points="`
    + `${body.map(([x, y]) => `${x.toFixed(3)},${(-y).toFixed(3)}`).join(" ")}"/>`).join("");
  at("plan").innerHTML = `<svg viewBox="${west - 0.5} ${-top} ${east - west + 1} ${top + 0.6}" role="img" aria-label="Plan of the motion">`
    + `<path class="wall" vector-effect="non-scaling-stroke" d="M${west - 0.5} 0H${east + 0.5}"/>`
    + `${instants.map((k) => draws(k, "")).join("")}${draws(now, " at")}</svg>`;
  at("instant").textContent = `${motion.times[now].toFixed(3)} s`;
}

function table() {
  const head = ["Strike", "from [s]", "duration [s]", `peak [${shown("N")[1]}]`, `50 ms mean [${shown("N")[1]}]`, `impulse [${shown("N s")[1]}]`];
  const rows = motion.strikes.map((one, k) => [`${k + 1}: ${scene().parts[one.group]}`, one.start.toFixed(4),
    `${one.cut ? "at least " : ""}${(one.end - one.start).toFixed(4)}`, force(one.peak, false), force(one.mean, false),
    digits(one.impulse * shown("N s")[0], 4)]);
  fillTable("Strikes", head, rows);
}

function fillTable(caption, head, rows) {
  at("strikes").innerHTML = `<caption>${caption}</caption><thead><tr>${head.map((text, k) => `<th scope="col"${k ? ' class="n"' : ""}>${text}</th>`).join("")}</tr></thead>`
    + `<tbody>${rows.map((row) => `<tr><th scope="row">${row[0]}</th>${row.slice(1).map((text) => `<td class="n">${text}</td>`).join("")}</tr>`).join("")}</tbody>`;
}

function peaks() {
  const rows = data.filters.map(([, label], c) => `<tr><th scope="row">${label}</th><td class="n">${force(motion.peaks[c], false)}</td></tr>`);
  at("peaks").innerHTML = `<caption>Lateral force on the wall</caption><thead><tr><th scope="col">Filter</th><th scope="col" class="n">peak [${shown("N")[1]}]</th></tr></thead><tbody>${rows.join("")}</tbody>`;
}

function boxes() {
  const tables = new Map();
  for (const quantity of scene().quantities) {
    const name = quantity.key.slice(0, quantity.key.lastIndexOf("."));
    tables.set(name, [...tables.get(name) ?? [], quantity]);
  }
  at("quantities").innerHTML = [...tables].map(([name, quantities]) => `<fieldset><legend>[${name}]</legend>${quantities.map(box).join("")}</fieldset>`).join("");
  for (const element of document.querySelectorAll(".quantity")) {
    const quantity = scene().quantities.find((one) => one.key === element.dataset.key), [number, slider] = element.querySelectorAll("input");
    const change = (text) => {
      const entered = text.trim() === "" ? NaN : Number(text) / shown(quantity.unit)[0];
      if (entered === quantity.value) chosen.values.delete(quantity.key);
      else chosen.values.set(quantity.key, entered);
      element.classList.toggle("changed", chosen.values.has(quantity.key));
      compute();
    };
    number.addEventListener("input", () => { slider.value = number.value; change(number.value); });
    slider.addEventListener("input", () => { number.value = digits(Number(slider.value), 4); change(number.value); });
  }
}

function box(quantity) {
  const [factor, name] = shown(quantity.unit), here = digits(value(quantity) * factor, 6), [low, high] = [quantity.low * factor, quantity.high * factor];
  const last = quantity.key.slice(quantity.key.lastIndexOf(".") + 1), id = `of-${quantity.key}`;
  return `<div class="quantity${chosen.values.has(quantity.key) ? " changed" : ""}" data-key="${quantity.key}">`
    + `<label for="${id}" title="${escaped(data.texts[quantity.meaning])}">${last.replaceAll("_", " ")}</label>`
    + `<input id="${id}" type="number" step="any" value="${here}" aria-describedby="${id}-error"><span>${name}</span>`
    + `<input type="range" aria-label="${quantity.key}" min="${low}" max="${high}" step="${(high - low) / 200}" value="${here}">`
    + `<small class="range">${quantity.note}</small><small class="error" id="${id}-error" role="alert"></small></div>`;
}

function open(number) {
  chosen.scene = number;
  machine = new Machine(structuredClone(data.scenes[number]), wasm, contents);
  delete at("time").dataset.moved;
  at("space").hidden = !scene().rows.length;
  at("filter").parentElement.hidden = !at("space").hidden;
  for (const id of ["peaks", "walls", "walls-caption", "lowest"]) at(id).replaceChildren();
  at("scene").value = String(number);
  at("footer").textContent = `${scene().name}: ${scene().title}. Kernels ${data.digest.slice(0, 12)}.${scene().rows.length ? "" : " \`tailslap rigid\` computes the same numbers."}`;
  boxes();
  compute();
}

function save() {
  const parts = [`scene=${scene().name}`, ...[...chosen.values].map(([key, number]) => `${key}=${number}`)];
  if (chosen.units) parts.push("units=us");
  if (chosen.filter !== 1) parts.push(`filter=${data.filters[chosen.filter][0]}`);
  history.replaceState(null, "", `#${parts.join("&")}`);
}

function restore() {
  // Read the address; what is unknown is named.
  const unknown = [], entries = new URLSearchParams(location.hash.slice(1)), name = entries.get("scene") ?? data.scenes[0].name;
  const number = data.scenes.findIndex((one) => one.name === name), beyond = data.beyond.find((one) => one.name === name);
  if (number < 0) unknown.push(beyond ? beyond.why : `scene=${name}`);
  chosen.values.clear();
  chosen.units = entries.get("units") === "us" ? 1 : 0;
  const here = data.scenes[Math.max(number, 0)], filter = data.filters.findIndex(([name]) => name === entries.get("filter"));
  chosen.filter = filter > 0 ? filter : 1;
  if (entries.has("filter") && filter <= 0) unknown.push(`filter=${entries.get("filter")}`);
  for (const [key, text] of entries) {
    if (["scene", "units", "filter"].includes(key)) continue;
    const quantity = here.quantities.find((one) => one.key === key), entered = Number(text);
    if (quantity && text.trim() !== "" && Number.isFinite(entered)) chosen.values.set(key, entered);
    else unknown.push(`${key}=${text}`);
  }
  at("units").value = String(chosen.units);
  at("filter").value = String(chosen.filter);
  open(Math.max(number, 0));
  at("note").textContent = unknown.length ? `The address has what this page does not know: ${unknown.join(", ")}.` : "";
}

function tomlOf() {
  // Text of the scene with the changed values, in the units shown.
  const counts = {}, changed = new Map(chosen.values);
  let prefix = "";
  const lines = scene().text.split("\n").map((line) => {
    const header = line.match(/^\s*(\[\[?)([\w.]+)\]/), entry = line.match(/^(\s*)(\w+)(\s*=\s*)("[^"]*"|[^#\s]+)(.*)$/);
    if (header) {
      counts[header[2]] = (counts[header[2]] ?? -1) + 1;
      prefix = header[1] === "[[" ? `${header[2]}.${counts[header[2]]}` : header[2];
    }
    const key = entry && `${prefix}.${entry[2]}`;
    if (!entry || !changed.has(key)) return line;
    const quantity = scene().quantities.find((one) => one.key === key), [factor, name] = shown(quantity.unit);
    const text = digits(changed.get(key) * factor, 10);
    return `${entry[1]}${entry[2]}${entry[3]}${name ? `"${text} ${name}"` : text}${entry[5]}`;
  });
  return lines.join("\n");
}

async function copy(text, what) {
  try {
    await navigator.clipboard.writeText(text);
  } catch {  // a page from disk in some browsers
    const area = document.body.appendChild(document.createElement("textarea"));
    area.value = text;
    area.select();
    document.execCommand("copy");
    area.remove();
  }
  at("note").textContent = `${what} copied.`;
}

async function unpack(id) {
  // Numbers of a part of the page, and the contents of memory behind them.
  if (typeof DecompressionStream !== "function") throw new Error("This browser cannot unpack the page, as those since 2023 can: open it in another one.");
  const text = atob(at(id).textContent), packed = new Uint8Array(text.length);
  for (let k = 0; k < text.length; k++) packed[k] = text.charCodeAt(k);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  const unpacked = await new Response(stream).arrayBuffer(), end = 4 + new DataView(unpacked).getUint32(0, true);
  const numbers = JSON.parse(new TextDecoder().decode(unpacked.slice(4, end)));
  let place = end;
  return [numbers, numbers.sizes.map((size) => new Uint8Array(unpacked, (place += size) - size, size))];
}

async function moduleOf(code, digest) {
  // Compiled kernels, which must have this digest.
  const module = await WebAssembly.compile(code), [section] = WebAssembly.Module.customSections(module, "digest");
  if (!section || new TextDecoder().decode(section) !== digest) {
    throw new Error("The module of this page is not that of its kernels: write the page again with `tailslap explore`.");
  }
  return module;
}

async function begin() {
  [data, contents] = await unpack("data");
  const groups = new Map();  // of scenes, each with its options
  data.scenes.forEach(({ choice: [group, text] }, k) => groups.set(group, `${groups.get(group) ?? ""}<option value="${k}">${escaped(text)}</option>`));
  const beyond = data.beyond.map((one) => `<option value="${escaped(one.why)}">${escaped(one.name)}</option>`).join("");
  if (beyond) groups.set("By the command", beyond);
  at("scene").innerHTML = [...groups].map(([group, options]) => `<optgroup label="${group}">${options}</optgroup>`).join("");
  if (typeof WebAssembly !== "object") throw new Error("This browser has no WebAssembly, by which the page computes: open it in another one.");
  wasm = await moduleOf(contents[data.module], data.digest);
  at("scene").addEventListener("change", () => {
    const number = Number(at("scene").value);
    if (Number.isNaN(number)) {
      at("note").textContent = at("scene").value;
      at("scene").value = String(chosen.scene);
      return;
    }
    at("note").textContent = "";
    chosen.values.clear();
    open(number);
  });
  at("units").addEventListener("change", () => { chosen.units = Number(at("units").value); boxes(); compute(); });
  at("filter").innerHTML = data.filters.map(([, label], c) => c && c !== MEAN ? `<option value="${c}">${label}</option>` : "").join("");
  at("filter").addEventListener("change", () => {
    chosen.filter = Number(at("filter").value);
    save();
    if (motion) draw();
  });
  at("time").addEventListener("input", () => {
    at("time").dataset.moved = "";
    if (motion) (scene().rows.length ? views : plan)();
  });
  at("play").addEventListener("click", () => motion && play());
  stop();
  at("reset").addEventListener("click", () => { chosen.values.clear(); boxes(); compute(); });
  at("copy-scene").addEventListener("click", () => copy(tomlOf(), "Scene"));
  at("copy-link").addEventListener("click", () => copy(location.href, "Link"));
  at("copy-table").addEventListener("click", () => copy([...at("strikes").rows].map((row) => [...row.cells].map((cell) => cell.textContent).join("\t")).join("\n"), "Table"));
  at("quantities").addEventListener("submit", (event) => event.preventDefault());
  addEventListener("hashchange", restore);
  addEventListener("resize", () => motion && draw());
  restore();
  document.body.dataset.ready = performance.now().toFixed(0);
}
