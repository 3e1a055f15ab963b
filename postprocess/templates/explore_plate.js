
// The plate of a constrained corner, by the same time loop.
let plates, plateContents, plateRun;

const signed = (x) => `${x < 0 ? "−" : "+"}${Math.abs(x).toExponential(1).replace(/e([+-])(\d)$/, "e$10$2").replace("e-", "e−")}`;
const five = (x) => x.toPrecision(5).replace("-", "−");

function showPlate() {
  const plate = plates.plates[at("plate-scene").value], ran = plateRun?.plate === plate ? plateRun : undefined;
  at("plate-text").innerHTML = `${escaped(plate.text[chosen.units])} This plate, this scene: mesh, masses, stiffness, start and time step are of its plan. `
    + `Of other values, in a whole impact, on a deformable wall or of more than ${data.most_elements} elements: <code>tailslap run ${escaped(plate.name)} --set KEY=VALUE</code>.`;
  for (const part of at("plate").querySelectorAll(".scroll, figure")) part.hidden = !ran?.values;
  at("plate-answer").textContent = ran?.text ?? "";
  if (!ran?.values) return;
  const rows = plate.quantities.map(([title, symbol, exact, key, ...units]) => {
    const [factor, unit] = units[chosen.units], value = key === "t" ? ran.t : ran.values[plate.columns.indexOf(key)];
    const cells = [symbol.replace(/_(\w+)/, "<sub>$1</sub>"), five(factor * value), five(factor * exact), unit, signed(value / exact - 1)];
    return `<tr><th scope="row">${title}</th>${cells.map((cell, k) => `<td${[1, 2, 4].includes(k) ? ' class="n"' : ""}>${cell}</td>`).join("")}</tr>`;
  });
  at("plate-table").innerHTML = `<caption>Tail-slap</caption><thead><tr>${["Quantity", "", "FE", "Rigid, exact", "Unit", "FE/rigid − 1"].map((text, k) =>
    `<${text ? 'th scope="col"' : "td"}${[2, 3, 5].includes(k) ? ' class="n"' : ""}>${text}</${text ? "th" : "td"}>`).join("")}</tr></thead><tbody>${rows.join("")}</tbody>`;
  drawPlate(plate, ran);
}

function drawPlate(plate, ran) {
  // v_GY over time: the plate as a line, the exact motion as points.
  const width = Math.max(280, at("plate-chart").clientWidth), height = 200, left = 46, bottom = 30;
  const [factor, unit] = plate.quantities.find((one) => one[3] === "v_gy").slice(4)[chosen.units], [instants, exact] = plate.exact;
  const column = plate.columns.indexOf("v_gy"), size = plate.columns.length, last = Math.max(ran.t, instants.at(-1));
  const fe = Array.from({ length: ran.count - 1 }, (_, k) => [k * plate.interval, ran.rows[k * size + column]]).concat([[ran.t, ran.values[column]]]);
  const speeds = [...exact, ...fe.map(([, v]) => v)], low = Math.min(...speeds), high = Math.max(...speeds), room = 0.06 * (high - low);
  const x = (t) => left + (width - left - 8) * t / last, y = (v) => 8 + (height - bottom - 8) * (high + room - v) / (high - low + 2 * room);
  const step = ticks((high - low) * factor, 4)[1], first = Math.ceil(low * factor / step);
  const grid = Array.from({ length: Math.floor(high * factor / step) - first + 1 }, (_, k) => Number((step * (first + k)).toPrecision(6)))
    .map((v) => `<path class="axis" d="M${left} ${y(v / factor)}H${width - 8}"/><text x="${left - 6}" y="${y(v / factor) + 4}" text-anchor="end">${String(v).replace("-", "−")}</text>`);
  const marks = ticks(last, Math.max(3, width / 110)).map((t) => `<text x="${x(t)}" y="${height - 10}" text-anchor="middle">${t}</text>`);
  const circles = instants.map((t, k) => `<circle class="exact" cx="${x(t).toFixed(1)}" cy="${y(exact[k]).toFixed(1)}" r="3.5"/>`);
  at("plate-chart").innerHTML = `<svg viewBox="0 0 ${width} ${height}" role="img" aria-label="v_GY over time">${grid.join("")}${marks.join("")}`
    + `<path class="curve curve2" d="M${fe.map(([t, v]) => `${x(t).toFixed(1)} ${y(v).toFixed(1)}`).join("L")}"/>${circles.join("")}`
    + `<text x="${width - 8}" y="${height - 10}" text-anchor="end">s</text></svg>`;
  at("plate-caption").textContent = `Velocity of the centre of mass across the wall, v_GY [${unit}]; line: finite elements; circles: rigid body, exact`;
}

async function runPlate() {
  const plate = plates.plates[at("plate-scene").value];
  plateRun = { plate, text: "Running ..." };
  showPlate();
  try {
    const machine = new Machine(plate, await moduleOf(plateContents[plate.module], plate.digest), plateContents);
    const start = performance.now(), [result, values] = plate.calls.plate;
    machine.exports.plate(result, values);
    const spent = (performance.now() - start) / 1e3, count = Number(new BigInt64Array(machine.memory.buffer, result, 1)[0]);
    const t = new Float64Array(machine.memory.buffer, result + 8, 1)[0], strike = [...machine.array("plate.strike")];
    plateRun.text = "No tail-slap within the run.";
    if (!Number.isNaN(t)) {
      const [, , exact, , ...units] = plate.quantities.find((one) => one[3] === "v_gy"), v = strike[plate.columns.indexOf("v_gy")], [factor, unit] = units[chosen.units];
      plateRun = { plate, t, count, rows: [...machine.array("plate.rows")], values: strike, text: `v_GY at the tail-slap: ${five(factor * v)} ${unit} by finite elements, `
        + `${five(factor * exact)} ${unit} exact; FE/rigid − 1: ${signed(v / exact - 1)}. ${Math.ceil(t / plate.step)} steps in ${spent.toFixed(2)} s.` };
    }
    at("plate").dataset.spent = spent.toFixed(3);
  } catch (error) {
    plateRun.text = error.message;
  }
  showPlate();
}

async function beginPlates() {
  [plates, plateContents] = await unpack("plates");
  at("plate-scene").innerHTML = plates.plates.map(({ name }, k) => `<option value="${k}">${name}</option>`).join("");
  at("plate-scene").addEventListener("change", showPlate);
  at("run-plate").addEventListener("click", runPlate);
  at("units").addEventListener("change", showPlate);
  addEventListener("resize", showPlate);
  at("plate").hidden = !plates.plates.length;
  if (plates.plates.length) showPlate();
}

begin().then(beginPlates).catch((error) => {
  at("headline").textContent = error.message;
  at("headline").classList.add("refused");
});
