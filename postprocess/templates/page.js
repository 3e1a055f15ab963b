/* Shows the values of the lines, layers and boxes of charts at the pointer; without it charts are as they are. */
const powers = (text) => text.replace(/e([-+])0*(\d+)/, (_, sign, power) =>
  "×10" + [...(sign === "-" ? "⁻" : ""), ...[...power].map((digit) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[digit])].join(""));
const shown = (text) => powers(text).replace(/^-/, "−");
const NEAR = 14;
const numbers = (text) => text.split(" ").map(Number);

const plotOf = (element) => {
  const [left, top, right, bottom] = numbers(element.dataset.box), [low, high] = numbers(element.dataset.x);
  const lines = [...element.querySelectorAll("[data-label]")].filter((line) => line.dataset.label).map((line) => {
    const [values, where] = [line.dataset.values, line.dataset.at ?? ""].map((texts) => texts.split(" "));
    const path = (line.getAttribute("d").match(/-?[\d.]+/g) || []).map(Number);
    return { label: line.dataset.label, values, where, places: values.map((_, i) => path.slice(2 * i, 2 * i + 2)) };
  });
  const across = (place) => {
    const share = (place - left) / (right - left);
    return element.dataset.log === "1" ? low * (high / low) ** share : low + share * (high - low);
  };
  const { nearest } = element.dataset;
  const at = (place) => shown(across(place).toPrecision(4));
  return { element, left, top, right, bottom, lines, nearest, at, label: element.dataset.y };
};

const closest = (places, far) => places.reduce((best, place, i) =>
  place.length && far(place) < far(places[best] ?? [1e9, 1e9]) ? i : best, -1);

const mark = (plot, name, attributes) => {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  Object.entries({ class: "pointer", ...attributes }).forEach(([key, value]) => made.setAttribute(key, value));
  plot.element.append(made);
};

const point = (plot, x, y) => {
  const along = (axis) => (plot.nearest.includes(axis) ? 1 : 1e-3);
  const far = ([a, b]) => Math.hypot(along("x") * (a - x), along("y") * (b - y));
  const found = plot.lines.map((line) => [line, closest(line.places, far)]).filter(([, i]) => i >= 0);
  const least = Math.min(...found.map(([{ places }, i]) => far(places[i])));
  return found.filter(([{ places }, i]) => far(places[i]) < least + NEAR)
    .map(([{ label, values, where, places }, i]) => {
      mark(plot, "circle", { cx: places[i][0], cy: places[i][1], r: 3 });
      return { at: where[i] || plot.at(places[i][0]), place: places[i][0], text: `${label}: ${shown(values[i])}` };
    });
};

document.querySelectorAll("svg.chart").forEach((svg) => {
  const figure = svg.closest("figure"), note = document.createElement("output");
  const plots = [...svg.querySelectorAll(".plot")].map(plotOf);
  note.className = "values";
  note.hidden = true;
  figure.append(note);
  const clear = () => {
    note.hidden = true;
    svg.querySelectorAll(".pointer").forEach((each) => each.remove());
  };
  const show = (event) => {
    clear();
    const box = svg.getBoundingClientRect(), around = figure.getBoundingClientRect();
    const scale = svg.viewBox.baseVal.width / box.width;
    const x = (event.clientX - box.left) * scale, y = (event.clientY - box.top) * scale;
    const inside = (p) => p.lines.length && x >= p.left && x <= p.right && y >= p.top && y <= p.bottom;
    if (!plots.some(inside)) return;
    const each = plots.map((plot) => point(plot, x, y)), found = each.flat();
    const place = found[0]?.place ?? x;
    plots.filter((p) => p.nearest === "x").forEach((p) => mark(p, "path", { d: `M${place} ${p.top}V${p.bottom}` }));
    const texts = (part) => part.map(({ text }) => text);
    const said = each.flatMap((part, i) => (part.length && each[1] ? [plots[i].label, ...texts(part)] : texts(part)));
    note.textContent = [`at ${found[0]?.at ?? plots[0].at(place)}`, ...said].join("\n");
    note.hidden = false;
    const left = Math.min(event.clientX - around.left + 14, around.width - note.offsetWidth);
    note.style.left = `${Math.max(0, left)}px`;
    note.style.top = `${event.clientY - around.top + 16}px`;
  };
  ["pointermove", "pointerdown"].forEach((name) => svg.addEventListener(name, show));
  svg.addEventListener("pointerleave", clear);
});

const unfold = (id) => document.getElementById(id)?.querySelectorAll("details").forEach((part) => (part.open = true));
document.querySelectorAll("nav a").forEach((link) => link.addEventListener("click", () => unfold(link.hash.slice(1))));
unfold(location.hash.slice(1));
addEventListener("beforeprint", () => document.querySelectorAll("details").forEach((part) => (part.open = true)));
