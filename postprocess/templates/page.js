/* Shows the values of the lines and layers of charts at the pointer; without it charts are as they are. */
const powers = (text) => text.replace(/e([-+])0*(\d+)/, (_, sign, power) =>
  "×10" + [...(sign === "-" ? "⁻" : ""), ...[...power].map((digit) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[digit])].join(""));
const shown = (text) => powers(text).replace(/^-/, "−");
const numbers = (text) => text.split(" ").map(Number);

const plotOf = (element) => {
  const [left, top, right, bottom] = numbers(element.dataset.box), [low, high] = numbers(element.dataset.x);
  const lines = [...element.querySelectorAll("[data-label]")].filter((line) => line.dataset.label).map((line) => {
    const values = line.dataset.values.split(" "), path = (line.getAttribute("d").match(/-?[\d.]+/g) || []).map(Number);
    return { label: line.dataset.label, values, places: values.map((_, i) => path.slice(2 * i, 2 * i + 2)) };
  });
  const across = (place) => {
    const share = (place - left) / (right - left);
    return element.dataset.log === "1" ? low * (high / low) ** share : low + share * (high - low);
  };
  const nearest = "nearest" in element.dataset;
  return { element, left, top, right, bottom, lines, nearest, at: (place) => shown(across(place).toPrecision(4)) };
};

const closest = (places, far) => places.reduce((best, place, i) =>
  place.length && far(place) < far(places[best] ?? [Infinity, Infinity]) ? i : best, -1);

const mark = (plot, name, attributes) => {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  Object.entries({ class: "pointer", ...attributes }).forEach(([key, value]) => made.setAttribute(key, value));
  plot.element.append(made);
};

const point = (plot, x, y) => {
  const far = ([a, b]) => (plot.nearest ? (a - x) ** 2 + (b - y) ** 2 : Math.abs(a - x));
  return plot.lines.map(({ label, values, places }) => [label, values, places, closest(places, far)])
    .filter(([, , , i]) => i >= 0)
    .map(([label, values, places, i]) => {
      mark(plot, "circle", { cx: places[i][0], cy: places[i][1], r: 3 });
      return { place: places[i][0], text: `${label}: ${shown(values[i])}` };
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
    const found = plots.flatMap((plot) => point(plot, x, y));
    const place = found[0]?.place ?? x;
    plots.filter((p) => !p.nearest).forEach((p) => mark(p, "path", { d: `M${place} ${p.top}V${p.bottom}` }));
    note.textContent = [`at ${plots[0].at(place)}`, ...found.map(({ text }) => text)].join("\n");
    note.hidden = false;
    const left = Math.min(event.clientX - around.left + 14, around.width - note.offsetWidth);
    note.style.left = `${Math.max(0, left)}px`;
    note.style.top = `${event.clientY - around.top + 16}px`;
  };
  ["pointermove", "pointerdown"].forEach((name) => svg.addEventListener(name, show));
  svg.addEventListener("pointerleave", clear);
});

addEventListener("beforeprint", () => document.querySelectorAll("details").forEach((part) => (part.open = true)));
