// Vehicles in space: answer, band, walls of other heights, and views from behind and from above.
const OUTCOMES = ["upright", "on its side", "over the wall"], VERBS = ["remains upright", "rolls on its side", "rolls over a wall"], TOO_FEW = 35, NO_CONTACT = 34, SLOWER = 5;
const isStill = matchMedia("(prefers-reduced-motion: reduce)");
let playing;

const outcomeOf = (number, height, roll) => `The vehicle ${VERBS[number]}${number < 2 ? " on a wall" : ""} of ${measure(height, "m", 3)}`
  + (number ? "." : ` with a roll of ${(Math.abs(roll) * 180 / Math.PI).toFixed(1)} deg.`);

function refusalInSpace(reason, item) {
  // Key and sentence of a rule that the values break.
  const [table, field] = data.places[reason] ?? [], limit = digits(machine.array("space.room.limit")[0], 6);
  const columns = table ? machine.array(`space.parts.${table}`) : machine.array("space.parts.common");
  const place = table ? scene().arrays[`space.parts.${table}`][2][1] * item + field : reason === NO_CONTACT ? 3 : -1;
  const quantity = scene().quantities.find((one) => one.column === Number(columns[place]));
  const [why, allowed] = data.reasons[reason].map((text) => text.replace(/\{\w+[^}]*\}/g, limit));
  return { key: quantity?.key, text: `${why}; allowed: ${allowed}` };
}

function computeInSpace() {
  // With fixed steps at once; the steps are refined behind the band.
  const began = performance.now(), [reason, item, count] = machine.call("space");
  at("space").hidden = reason > 0;
  if (reason) {
    const why = refusalInSpace(reason, item);
    refuse(why.key ? `${why.key}: ${why.text}` : why.text, why.key);
    return;
  }
  mark();
  motion = readInSpace("space", count);
  motion.began = began;
  answerInSpace();
  machine.array("space_band.place")[0] = machine.array("space_wall.place")[0] = 0n;
  at("band").textContent = "";
  at("walls").replaceChildren();
  at("strikes").replaceChildren();
  at("lowest").textContent = "";
  if (!at("time").dataset.moved) at("time").value = Math.round(1000 * motion.answer.roll_time / motion.end);
  draw();
  timer = setTimeout(bandInSpace, 10);
}

function readInSpace(kernel, count) {
  const copy = (name) => machine.array(name).slice(), force = copy(`${kernel}.curves.force`), all = scene().arrays[`${kernel}.curves.force`][2][1];
  const answer = Object.fromEntries(data.answers.map((name, k) => [name, machine.array(`${kernel}.room.answers`)[k]]));
  const table = (name, owners) => {
    const values = copy(`space.room.values.${name}`), width = scene().arrays[`space.room.values.${name}`][2][2];
    const of = owners.map((owner) => machine.array(`space.room.fleet.${owner}`));
    return Array.from({ length: values.length / width }, (_, k) => ({ values: values.slice(k * width, (k + 1) * width), of: of.map((one) => Number(one[k])) }));
  };
  const interval = answer.end / (count - 1), height = machine.array("space.values")[Number(machine.array("space.parts.common")[3])];
  return { count, answer, height, end: answer.end, strikes: [], rows: machine.array(`${kernel}.curves.rows`), width: scene().arrays[`${kernel}.curves.rows`][2][2],
    times: Float64Array.from({ length: count }, (_, k) => k * interval), curves: [0, 1, 2].map((c) => force.subarray(c * all, c * all + count)),
    peaks: copy(`${kernel}.curves.peaks`), step: interval / Number(machine.array("space.room.clock.parts")[0]),
    units: table("units", []), axles: table("axles", ["axle_unit"]), strips: table("strips", ["strip_unit", "strip_axle"]) };
}

function answerInSpace() {
  const { answer, ends, name, refined } = motion;
  const heights = [...new Set((refined?.heights ?? [answer.height]).map((height) => measure(height, "m", 3)))];
  const text = `${refined?.undecided ? `It is undecided whether the vehicle remains upright on a wall of ${measure(motion.height, "m", 3)}: within the numerical error the outcome differs.`
    : outcomeOf(answer.outcome, motion.height, answer.largest_roll)} ${data.force}: ${ends ? bandWords(ends, name) : ""}`;
  at("headline").classList.remove("refused");
  at("headline").textContent = `${text}${force(answer.mean_50ms)}${ends ? "" : ratio(answer.mean_50ms)}, at a height of ${heights.join(" or ")}.`;
  const moment = `${digits(answer.moment * shown("N")[0] * shown("m")[0], 3)} ${shown("N")[1]} ${shown("m")[1]}`;
  at("certainty").textContent = `Rigid vehicle in space; largest moment about the foot of the wall ${moment}, largest pitch ${(answer.largest_pitch * 180 / Math.PI).toFixed(1)} deg. `
    + accuracy();
}

function refineInSpace() {
  // The answer with its error, in place of that with fixed steps.
  const [reason, , count] = machine.call("space_one"), result = machine.array("space_one.motions.result");
  if (!reason) {
    const [parts, , step, strip, other, undecided, heights] = result;
    motion = Object.assign(readInSpace("space_one", count), { began: motion.began, ends: motion.ends, name: motion.name });
    motion.refined = { step, strip, other, undecided, heights: [...machine.array("space_one.motions.heights").slice(0, heights)] };
    motion.step = motion.times[1] / parts;
    answerInSpace();
    draw();
    document.body.dataset.refined = (performance.now() - motion.began).toFixed(1);
  }
  timer = setTimeout(wallsInSpace, 50);
}

function accuracy() {
  // Steps and errors in words.
  const { refined } = motion, percent = (error) => {  // two digits, rounded up
    const power = 10 ** (Math.floor(Math.log10(100 * error)) - 1);
    return error > 0 ? `${digits(Math.ceil(100 * error / power) * power, 2)} %` : "0 %";
  };
  if (!refined) return `Fixed steps of ${digits(1e3 * motion.step, 2)} ms, not yet refined.`;
  const { step, strip, other, undecided } = refined;
  return `Time step ${digits(1e3 * motion.step, 2)} ms; error of ${undecided ? "" : "roll, "}force, height and moment at most ${percent(Math.max(step + strip, other))}: `
    + `${percent(step)} by the step, ${percent(strip)} by the points, ${percent(other)} with other ones than halves.`;
}

function bandInSpace() {
  // The band in blocks, between which the page answers.
  drawBand("space_band.ranges.drawn");
  const [reason, item, count, varied, number] = machine.call("space_band"), total = scene().arrays["space_band.values"][2][1];
  const ranges = scene().ranges, ends = machine.array("space_band.ranges.ends");
  if (reason) {
    at("band").textContent = `Without a band of the force: ${reason === ENDS ? `${ranges[item][0]} (${ranges[item][1]}) is beyond what is allowed` : "too few of the varied inputs have a solution"}`;
  } else if (Number(machine.array("space_band.place")[0]) < total) {
    at("band").textContent = `Band: ${machine.array("space_band.place")[0]} of ${total} vehicles.`;
    timer = setTimeout(bandInSpace, 0);
    return;
  } else {
    const [name, calibrated] = scene().classes[number] ?? [data.band], outcomes = machine.array("space_band.outcomes");
    Object.assign(motion, { ends: machine.array("space_band.percentiles").slice(data.percentiles), name });
    answerInSpace();
    const parts = OUTCOMES.map((text, k) => [outcomes[k], text]).filter(([part]) => part).map(([part, text]) => `${part} ${text}`);
    bandText(ranges, ends, `${decision("space_band")}Band of ${count} rigid vehicles (${parts.join(", ")}) over ${varied} inputs`, calibrated);
    document.body.dataset.band = (performance.now() - motion.began).toFixed(1);
  }
  timer = setTimeout(refineInSpace, 100);
}

function wallsInSpace() {
  const walls = machine.array("space_wall.walls"), count = walls.length / 6, place = Number(machine.array("space_wall.place")[0]);
  machine.call("space_wall");
  if (place < count) {
    timer = setTimeout(wallsInSpace, 0);
    return;
  }
  const rows = Array.from({ length: count }, (_, k) => walls.subarray(6 * k, 6 * k + 6)), [lowest, almost] = machine.array("space_wall.lowest");
  at("lowest").textContent = (Number.isNaN(lowest) ? "No wall up to the highest centre of mass keeps this vehicle upright."
    : `Lowest wall that keeps this vehicle upright, by a search from above: ${measure(lowest, "m", 3)}.`)
    + (almost ? ` It almost tips on a wall of ${measure(almost, "m", 3)}.` : "") + " Walls have the fixed steps; tailslap rigid states their error.";
  drawWalls(rows, lowest);
  const [f, m] = [shown("N")[0], shown("m")[0]], head = [`Wall [${shown("m")[1]}]`, "Outcome", "roll [deg]", `50 ms mean [${shown("N")[1]}]`, `its height [${shown("m")[1]}]`,
    `moment [${shown("N")[1]} ${shown("m")[1]}]`];
  fillTable("Walls of other heights", head, rows.filter((_, k) => k % 3 === 0).map(([height, outcome, roll, mean, at, moment]) => [(height * m).toFixed(2),
    OUTCOMES[outcome], (Math.abs(roll) * 180 / Math.PI).toFixed(1), force(mean, false), (at * m).toFixed(2), digits(moment * f * m, 3)]));
  document.body.dataset.walls = "ready";
}

function axes(x, y, [low, high], most, unit, label, marks) {
  // An SVG with ticks, and marks between [low, high] and [0, most].
  const width = Math.max(280, at("force").clientWidth), height = 190, left = 46, bottom = 30;
  const across = (v) => left + (width - left - 12) * (v - low) / (high - low), up = (v) => 8 + (height - bottom - 8) * (1 - v / most);
  const grid = ticks(most * y, 4).map((v) => `<path class="axis" d="M${left} ${up(v / y)}H${width - 12}"/><text x="${left - 6}" y="${up(v / y) + 4}" text-anchor="end">${v}</text>`);
  const below = ticks(high * x, Math.max(3, width / 110)).filter((v) => v >= low * x && across(v / x) < width - 26).map((v) => `<text x="${across(v / x)}" y="${height - 10}" text-anchor="middle">${v}</text>`);
  return `<svg viewBox="0 0 ${width} ${height}" role="img" aria-label="${label}">${grid.join("")}${below.join("")}${marks(across, up)}`
    + `<text x="${width - 2}" y="${height - 10}" text-anchor="end">${unit}</text></svg>`;
}

function drawWalls(rows, lowest) {
  const range = [rows[0][0], rows.at(-1)[0]], [factor, name] = shown("m");
  const chart = (column, y, label) => axes(factor, y, range, 1.1 * Math.max(...rows.map((row) => row[column])), name, label, (x, up) => {
    const line = (height, kind) => height > range[0] && height < range[1] ? `<path class="${kind}" d="M${x(height)} 8V160"/>` : "";
    const sign = (row) => {
      const [px, py] = [x(row[0]).toFixed(1), up(row[column]).toFixed(1)];
      return row[1] === 2 ? `<path class="sign" d="M${px - 4} ${py - 4}l8 8m0 -8l-8 8"/>` : `<circle class="sign${row[1] ? "" : " full"}" cx="${px}" cy="${py}" r="4"/>`;
    };
    return `${line(motion.height, "axis here")}${line(lowest, "load")}<path class="curve curve2" d="M${rows.map((row) => `${x(row[0]).toFixed(1)} ${up(row[column]).toFixed(1)}`).join("L")}"/>${rows.map(sign).join("")}`;
  });
  at("walls").innerHTML = `<p>${data.force} [${shown("N")[1]}] over the height of the wall</p>${chart(3, shown("N")[0], "Force over the height of the wall")}`
    + `<p>Height of its resultant [${name}]</p>${chart(4, factor, "Height of the resultant over the height of the wall")}`;
  at("walls-caption").textContent = "Walls of other heights. Full point: upright; open: on its side; cross: over the wall. Line: wall of the scene; dashed: lowest wall that keeps it upright.";
}

function column(name, unit, k) {
  return motion.rows[motion.width * k + scene().rows.indexOf(unit ? `${name}_${unit + 1}` : name)];
}

function movedAxle(number, k, [x, y, z]) {
  // A point of an axle in the axes of its unit.
  const roll = column(`axle_roll_${number + 1}`, 0, k), c = Math.cos(roll), s = Math.sin(roll), base = motion.axles[number].values[8];
  return [x, y * c - (z - base) * s, base + column(`heave_${number + 1}`, 0, k) + y * s + (z - base) * c];
}

function moved(unit, k, points, axle = -1) {
  // Points at rest, ahead of the front, to the left and above the ground, at an instant.
  const body = motion.units[unit].values, centre = [-body[3], 0, body[4]];
  const [x, y, z, yaw, pitch, roll] = ["x_g", "y_g", "z_g", "yaw", "pitch", "roll"].map((name) => column(name, unit, k));
  motion.axles.forEach((part, number) => {
    if (part.of[0] !== unit) return;
    const rest = [-part.values[0], 0, part.values[2]];
    movedAxle(number, k, rest).forEach((value, j) => { centre[j] += part.values[3] / body[2] * (value - rest[j]); });
  });
  const [cy, sy, cp, sp, cr, sr] = [yaw, pitch, roll].flatMap((angle) => [Math.cos(angle), Math.sin(angle)]);
  return points.map((point) => {
    const [a, b, c] = (axle < 0 ? point : movedAxle(axle, k, point)).map((value, j) => value - centre[j]);
    return [x + cy * cp * a + (cy * sp * sr - sy * cr) * b + (cy * sp * cr + sy * sr) * c,
      y + sy * cp * a + (sy * sp * sr + cy * cr) * b + (sy * sp * cr - cy * sr) * c, z - sp * a + cp * sr * b + cp * cr * c];
  });
}

function boxOf(unit) {
  // Corners at rest, those of the rear face first; edges by the strips of the body.
  const body = motion.units[unit].values, levels = (ofBody) => motion.strips.filter((one) => one.of[0] === unit && (!ofBody || one.of[1] < 0)).flatMap((one) => [...one.values.slice(2, 4)]);
  const low = levels(true).length ? Math.min(...levels(true)) : body[4] / 2, top = Math.max(1.6 * body[4], ...levels(false)), half = body[1] / 2;
  return [-body[0], 0].flatMap((x) => [[x, -half, low], [x, half, low], [x, half, top], [x, -half, top]]);
}

function wheelOf(number, side, isAbove) {
  const [position, track, radius] = motion.axles[number].values, ends = isAbove ? [[radius, 0], [-radius, 0]] : [[0, radius], [0, -radius]];
  const [out, inner] = [0.15, -0.15].map((part) => side * (track / 2 + part)), [[x0, z0], [x1, z1]] = ends.map(([a, b]) => [a - position, radius + b]);
  return [[x0, out, z0], [x0, inner, z0], [x1, inner, z1], [x1, out, z1]];
}

function wallFace() {
  // Points of the face up to its upper edge.
  const profile = machine.array("space.room.fleet.profile"), points = [];
  for (let k = 0; k + 3 < profile.length; k += 2) {
    const [y0, z0, y1, z1] = profile.subarray(k, k + 4), isLast = k + 4 === profile.length;
    points.push([y0, z0]);
    if (isLast || z1 > motion.height) {
      points.push([y0 + (motion.height - z0) * (y1 - y0) / (z1 - z0), motion.height]);
      break;
    }
  }
  return points;
}

const shape = (points, kind, tag = "polygon") => `<${tag} class="${kind}" vector-effect="non-scaling-stroke" points="${points.map(([x, y]) => `${x.toFixed(3)},${(-y).toFixed(3)}`).join(" ")}"/>`;

function frameOf() {
  // The unit with the largest roll, and the frame of its view from behind at all instants.
  const last = Math.round(motion.answer.roll_time / motion.end * (motion.count - 1)), rolls = motion.units.map((_, unit) => Math.abs(column("roll", unit, last)));
  const unit = rolls.indexOf(Math.max(...rolls)), points = Array.from({ length: 41 }, (_, j) => moved(unit, Math.round(j / 40 * (motion.count - 1)), boxOf(unit))).flat();
  const across = points.map(([, y]) => -y);
  return { unit, west: Math.max(-5, Math.min(...across)) - 0.3, east: Math.max(...across, 0.8) + 0.3, top: Math.max(...points.map(([, , z]) => z)) + 0.2 };
}

function views() {
  const k = Math.round(at("time").value / 1000 * (motion.count - 1)), behind = ([, y, z]) => [-y, z], above = ([x, y]) => [x, y];
  const unit = motion.frame.unit, corners = moved(unit, k, boxOf(unit)).map(behind), face = wallFace().map(([y, z]) => [-y, z]), back = motion.frame.east;
  const wheels = (of, isAbove) => motion.axles.flatMap((axle, number) => axle.of[0] !== of ? [] : [-1, 1].map((side, j) =>
    shape(moved(of, k, wheelOf(number, side, isAbove), number).map(isAbove ? above : behind), column(`load_${["right", "left"][j]}_${number + 1}`, 0, k) > 0 ? "tyre" : "tyre lifted")));
  const strips = motion.strips.filter((one) => one.of[0] === unit).map(({ values, of }) => {
    const side = values[5] - motion.units[unit].values[1] / 2;
    return shape(moved(unit, k, [[-values[0], side, values[2]], [-values[1], side, values[3]]], of[1]).map(behind), "strip", "polyline");
  });
  const { west, east, top } = motion.frame;
  const arrow = `<path class="push" vector-effect="non-scaling-stroke" d="M0 ${-motion.answer.height}h.8m-.2 -.1l.2 .1l-.2 .1"/>`;
  const body = [corners.slice(4), ...[0, 1, 2, 3].map((j) => [corners[j], corners[j + 4]]), corners.slice(0, 4)];
  at("rear").innerHTML = `<svg viewBox="${west} ${-top} ${east - west} ${top + 0.2}" role="img" aria-label="View from behind">`
    + `${shape([...face, [back, face.at(-1)[1]], [back, 0]], "concrete")}<path class="wall" vector-effect="non-scaling-stroke" d="M${west} 0H${east}"/>`
    + `${body.map((points, j) => shape(points, j === 5 ? "body at" : "body")).join("")}${wheels(unit, false).join("")}${strips.join("")}${arrow}</svg>`;
  const all = [], draws = (j, kind) => motion.units.map((_, u) => {
    const points = [0, 1, 5, 4].map((n) => moved(u, j, boxOf(u))[n]).map(above);
    all.push(...points);
    return shape(points, kind);
  }).join("");
  const drawn = `${draws(0, "body")}${draws(motion.count - 1, "body")}${draws(k, "body at")}`, [left, right] = [Math.min, Math.max].map((end) => end(...all.map(([x]) => x)));
  const [south, north] = [Math.min(-0.5, ...all.map(([, y]) => y)), Math.max(...all.map(([, y]) => y))];
  at("plan").innerHTML = `<svg viewBox="${left - 0.5} ${-north - 0.5} ${right - left + 1} ${north - south + 1}" role="img" aria-label="Plan of the motion">`
    + `<path class="wall" vector-effect="non-scaling-stroke" d="M${left - 0.5} 0H${right + 0.5}"/>${drawn}${motion.units.map((_, u) => wheels(u, true).join("")).join("")}</svg>`;
  at("instant").textContent = `${motion.times[k].toFixed(3)} s`;
  at("rear").dataset.roll = (column("roll", unit, k) * 180 / Math.PI).toFixed(2);
  at("rear-caption").textContent = `${motion.units.length > 1 ? `Unit ${unit + 1}` : "Vehicle"} from behind, roll ${at("rear").dataset.roll} deg; red wheels are off the ground; arrow: height of the largest 50 ms mean.`;
}

function drawInSpace() {
  motion.frame = frameOf();
  const most = Math.max(0.02, ...motion.units.map((_, unit) => motion.times.reduce((best, _, k) => Math.max(best, Math.abs(column("roll", unit, k))), 0)));
  at("roll").innerHTML = axes(1, 180 / Math.PI, [0, motion.end], 1.1 * most, "s", "Roll over time", (x, up) => motion.units.map((_, unit) =>
    `<path class="curve curve${unit ? 1 : 2}" d="M${Array.from(motion.times, (t, k) => `${x(t).toFixed(1)} ${up(Math.abs(column("roll", unit, k))).toFixed(1)}`).join("L")}"/>`).join(""));
  at("roll-caption").textContent = `Size of the roll [deg]${motion.units.length > 1 ? "; bold: first unit" : ""}`;
  at("plan-caption").textContent = "Plan: lower edge of the body at first touch, at the end and, filled, at the time below. The wall is the line.";
  views();
}

function play() {
  // From here to the end, slower than in reality; without motion the next of eight pictures.
  if (isStill.matches) {
    at("time").value = (125 * Math.floor(at("time").value / 125) + 125) % 1125;
    at("time").dispatchEvent(new Event("input"));
    return;
  }
  if (playing) return stop();
  if (at("time").value >= 1000) at("time").value = 0;
  const first = Number(at("time").value);
  let began;
  const frame = (now) => {
    began ??= now;
    at("time").value = Math.min(1000, first + (now - began) / (SLOWER * motion.end));
    at("time").dispatchEvent(new Event("input"));
    playing = at("time").value < 1000 ? requestAnimationFrame(frame) : undefined;
    if (!playing) stop();
  };
  at("play").textContent = "Stop";
  playing = requestAnimationFrame(frame);
}

function stop() {
  cancelAnimationFrame(playing);
  playing = undefined;
  at("play").textContent = isStill.matches ? "Next picture" : `Play, ${SLOWER} times slower`;
}
