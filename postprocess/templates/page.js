/* Charts: values at the pointer and by arrow keys, zoom, lines to hide, narrow windows. Without it they are as drawn. */
const all = (part, what) => [...part.querySelectorAll(what)];
const numbers = (text) => text.split(" ").map(Number);
const raised = (power) => [...String(+power)].map((digit) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(digit)]).join("");
const printed = (text) => {
  const [factor, power] = text.split("e"), ten = `10${raised(power)}`;
  const product = /^-?1$/.test(factor) ? factor.replace("1", ten) : `${factor}×${ten}`;
  return (power ? product : text).replace(/^-/, "−");
};
const cells = (row) => [...row.matchAll(/(?:^|,)(?:"((?:[^"]|"")*)"|([^,]*))/g)].map(([, quoted, plain]) =>
  quoted?.replaceAll('""', '"') ?? plain);
const set = (element, attributes) => {
  Object.entries(attributes).forEach(([name, value]) => element.setAttribute(name, value));
  return element;
};
const add = (parent, name, attributes) =>
  parent.appendChild(set(document.createElementNS("http://www.w3.org/2000/svg", name), attributes));

/* An axis has its ends at the pixels `from` and `to` of the file; what lies between those of `seen` is shown in `place`. */
const axisOf = (ends, scale, from, to) => ({ ends: numbers(ends), scale, from, to, seen: [from, to], place: [from, to] });
const shownAt = ({ seen: [a, b], place: [p, q] }) => (pixel) => p + ((pixel - a) * (q - p)) / (b - a);
const drawnAt = ({ seen: [a, b], place: [p, q] }) => (pixel) => a + ((pixel - p) * (b - a)) / (q - p);
const ticksOf = (axis, room) => {
  const isLog = axis.scale === "log", [start, end] = isLog ? axis.ends.map(Math.log10) : axis.ends;
  const value = (pixel) => start + ((pixel - axis.from) / (axis.to - axis.from)) * (end - start);
  const pixel = (at) => shownAt(axis)(axis.from + ((at - start) / (end - start)) * (axis.to - axis.from));
  const seen = axis.seen.map(value).sort((a, b) => a - b), isDecades = isLog && seen[1] - seen[0] > 1.5;
  const [low, high] = isLog && !isDecades ? seen.map((power) => 10 ** power) : seen;
  const most = Math.max(2, Math.floor(Math.abs(axis.place[1] - axis.place[0]) / room));
  const size = 10 ** Math.floor(Math.log10((high - low) / most));
  const round = size * [1, 2, 5, 10].find((factor) => high - low <= factor * size * most * (1 + 1e-9));
  const step = isDecades ? Math.max(1, Math.ceil(round)) : round, first = Math.ceil(low / step - 1e-9);
  const values = Array.from({ length: Math.floor(high / step + 1e-9) - first + 1 }, (_, i) => (first + i) * step);
  if (isDecades) return values.map((n) => [pixel(n), Math.abs(n) < 4 ? String(+`1e${n}`) : printed(`1e${n}`)]);
  const largest = Math.max(...values.map(Math.abs)), digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const isPlain = largest >= 1e-4 && largest < 1e6;
  const text = (number) => (isPlain ? number.toFixed(digits) : number && (+number.toPrecision(4)).toExponential());
  return values.map((number) => [pixel(isLog ? Math.log10(number) : number), printed(String(text(number)))]);
};
const setTicks = (holder, attribute, ticks, shift) => holder.replaceChildren(...ticks.map(([at, text]) => {
  const node = set(holder.firstElementChild.cloneNode(), { [attribute]: at + shift });
  node.textContent = text;
  return node;
}));

const plotOf = (element) => {
  const { box, x, y, scales, nearest, quantity, fixed } = element.dataset, [left, top, right, bottom] = numbers(box);
  const [across, up] = scales.split(" "), plot = { element, top, right, bottom, nearest, quantity, fixed };
  const parts = all(element, ".marks path:not(.moving path), .marks text").map((node) =>
    ({ node, path: node.getAttribute("d"), at: ["x", "y"].map((name) => +node.getAttribute(name)) }));
  const lines = parts.filter(({ node, path }) => path && node.dataset.label).map(({ node, path }) => {
    const home = path.match(/[ML]-?[\d.]+ -?[\d.]+/g).map((point) => numbers(point.slice(1)));
    return { plot, node, label: node.dataset.label, isOn: node.parentNode.style.display !== "none", home, places: home };
  });
  return Object.assign(plot, { parts, lines, x: axisOf(x, across, left, right), y: axisOf(y, up, bottom, top) });
};
/* Words of a narrow drawing stay inside of it, and those that would cover earlier ones are not shown. */
const separate = (element) => {
  const { left, right } = element.ownerSVGElement.getBoundingClientRect(), seen = [];
  all(element, ".marks text").forEach((node) => {
    node.style.display = "";
    const box = node.getBoundingClientRect(), shift = Math.max(0, left - box.left) - Math.max(0, box.right - right);
    const [start, end] = [box.left + shift, box.right + shift];
    node.setAttribute("x", +node.getAttribute("x") + shift);
    const isFree = seen.every((other) => end < other[0] - 4 || start > other[1] + 4 || box.top > other[3] - 2 || box.bottom < other[2] + 2);
    if (isFree) seen.push([start, end, box.top, box.bottom]);
    else node.style.display = "none";
  });
};
const drawPlot = ({ element, parts, lines, x, y, top, right }) => {
  const [across, down, [start, end], [bottom]] = [shownAt(x), shownAt(y), x.place, y.place];
  const moved = (path) => path.replace(/([MLHV])(-?[\d.]+)(?: (-?[\d.]+))?/g, (_, kind, a, b) =>
    kind + (kind === "V" ? down(a) : across(a)).toFixed(2) + (b === undefined ? "" : ` ${down(b).toFixed(2)}`));
  parts.forEach(({ node, path, at: [a, b] }) => set(node, path ? { d: moved(path) } : { x: across(a), y: down(b) }));
  all(element, ".beside > g").forEach((name) => {
    const at = Number(name.dataset.at), height = down(at);
    set(name, { transform: `translate(${end - right} ${height - at})` }).style.display = "";
    const isCut = name.getBoundingClientRect().left < element.ownerSVGElement.getBoundingClientRect().left;
    name.style.display = isCut || height < top - 1 || height > bottom + 1 ? "none" : "";
  });
  lines.forEach((line) => (line.places = line.home.map(([a, b]) => [across(a), down(b)])));
  const isWhole = [x, y].every(({ from, to, seen }) => seen[0] === from && seen[1] === to);
  const corners = [[start, top], [end, top], [end, bottom], [start, bottom]].map(([a, b]) => `${a}px ${b}px`);
  element.querySelector(".marks").style.clipPath = isWhole ? "" : `polygon(${corners}) view-box`;
  const [left, above] = [across(0), down(0)], matrix = [across(1) - left, 0, 0, down(1) - above, left, above];
  all(element, ".moving").forEach((node) => set(node.closest("g:not(.moving)"), { transform: `matrix(${matrix})` }));
  if (element.querySelector(".frame")) set(element.querySelector(".frame"), { width: end - start, height: bottom - top });
  if (matrix[0] < 1 && isWhole) separate(element);
  const holder = element.querySelector(".ticks g");
  if (y.scale === "named" || !holder.childElementCount) return;
  const ticks = ticksOf(y, 26);
  setTicks(holder, "y", ticks, 4);
  element.querySelector(".rows")?.setAttribute("d", ticks.map(([at]) => `M${start} ${at}H${end}`).join(""));
};

const NEAR = 14;
/* Each line with the number of its point nearest to a place, of those about as near as the nearest. */
const nearTo = (plot, x, y) => {
  const weights = ["x", "y"].map((name) => (plot.nearest.includes(name) ? 1 : 1e-3));
  const far = ([a, b]) => Math.hypot(weights[0] * (a - x), weights[1] * (b - y));
  const found = plot.lines.filter((line) => line.isOn).map((line) =>
    [line, line.places.reduce((best, place, i) => (far(place) < far(line.places[best]) ? i : best), 0)]);
  const least = Math.min(...found.map(([line, i]) => far(line.places[i])));
  return found.filter(([line, i]) => far(line.places[i]) < least + NEAR);
};
/* Name of a quantity, and its value with the unit that stands in its heading. */
const said = (heading, text, least = 0) => {
  const [, name, unit] = heading.match(/^(.*?)(?: \[(.*)\])?$/);
  const value = text && isFinite(text) ? printed(String(Math.abs(text) < least ? 0 : +(+text).toPrecision(5))) : text;
  return [name, unit ? `${value} ${unit}` : value];
};

const chartOf = (svg) => {
  const figure = svg.closest("figure"), section = svg.closest("section"), note = document.createElement("output");
  const [, , width, height] = numbers(svg.getAttribute("viewBox")), top = Number(svg.dataset.top);
  const plots = all(svg, ".plot").map(plotOf), lines = plots.flatMap((plot) => plot.lines), last = plots.at(-1);
  const axis = svg.querySelector(".x-axis"), csv = figure.querySelector("[download$=csv]");
  let from = null, reading = null;
  const clear = () => {
    note.hidden = true;
    all(svg, ".pointer").forEach((each) => each.remove());
  };
  const draw = () => {
    clear();
    plots.forEach(drawPlot);
    const holder = axis.querySelector(".ticks g"), { scale, place: [start, end] } = last.x;
    axis.querySelector(".ink text")?.setAttribute("x", (start + end) / 2);
    if (scale === "named" || !holder.childElementCount) return;
    const ticks = ticksOf(last.x, 58);
    setTicks(holder, "x", ticks, 0);
    set(axis.querySelector("path"), { d: ticks.map(([at]) => `M${at} ${last.bottom}v3`).join("") });
  };
  /* As wide as its place, drawings to scale at most as wide as drawn; the keys stand above it as buttons. */
  const isFixed = plots.some(({ fixed, x }) => fixed === "wide" || (x.scale === "named" && fixed !== "equal")), isEqual = last.fixed === "equal";
  let drawnWide = 0;
  const room = () => (isFixed ? width : Math.min(isEqual ? width : Infinity, figure.clientWidth));
  const fit = (wide) => {
    if (!wide || wide === drawnWide) return;
    drawnWide = wide;
    const narrower = (wide - width) / (last.right - last.x.from), lower = isEqual ? narrower * (last.bottom - last.top) : 0;
    set(svg, { viewBox: `0 ${top} ${wide} ${height - top + lower}`, width: wide, height: height - top + lower });
    svg.closest(".large")?.classList.toggle("fitted", !isFixed);
    plots.forEach(({ x, y, right }) => Object.assign(x, { place: [x.from, right + wide - width] }) && (y.place = [y.from + lower, y.to]));
    set(axis, { transform: `translate(0 ${lower})` });
    if (!isFixed) draw();
  };
  const reset = () => {
    plots.flatMap(({ x, y }) => [x, y]).forEach((each) => (each.seen = [each.from, each.to]));
    draw();
  };
  const zoom = ({ x, y, fixed }, [a, b], [c, d]) => {
    const part = Math.abs(c - a) / (x.place[1] - x.place[0]), half = fixed === "equal" ? (part * (y.place[0] - y.place[1])) / 2 : Math.abs(d - b) / 2;
    const across = [Math.min(a, c), Math.max(a, c)].map(drawnAt(x)), up = [half, -half].map((h) => drawnAt(y)((b + d) / 2 + h));
    if (Math.abs(c - a) > 8 && x.scale !== "named") plots.forEach((plot) => (plot.x.seen = across));
    if (half > 4 && y.scale !== "named") y.seen = up;
    draw();
  };

  const readTable = () => {
    const rows = decodeURIComponent(csv.href.slice(csv.href.indexOf(",") + 1)).split("\n").map(cells);
    let where = 0, column = 0;
    lines.forEach((line) => {
      if (!column || !rows[0][column].startsWith(line.label)) where = column++;
      line.table = rows.map((row) => [row[where], row[column]]);
      column += 1;
    });
  };
  const plotAt = ([x, y]) => plots.find((plot) => x >= plot.x.place[0] && x <= plot.x.place[1] && y >= plot.top && y <= plot.y.place[0]);
  const show = ([x, y], reader) => {
    clear();
    if (!csv || !lines.length || !plotAt([x, y])) return;
    if (!lines[0].table) readTable();
    const found = reader ? [[reader]] : plots.map((plot) => nearTo(plot, x, y)), [line, i] = found.flat()[0] ?? [];
    if (!line) return;
    const rows = [[said(line.table[0][0], line.table[i + 1][0]).filter(Boolean).join(" ")]];
    found.forEach((near) => near.forEach(([each, n], k) => {
      const [a, b] = each.places[n], { quantity, nearest, top, y: { ends, place: [bottom] } } = each.plot;
      if (!k && quantity) rows.push([quantity.replace(/ \[.*/, "")]);
      const value = said(each.table[0][1], each.table[n + 1][1], 1e-6 * Math.abs(ends[1] - ends[0]))[1];
      rows.push([`${each.label} ${value}`, getComputedStyle(each.node).color]);
      if (!k && nearest === "x") add(svg, "path", { class: "pointer", d: `M${a} ${top}V${bottom}` });
      add(svg, "circle", { class: "pointer", cx: a, cy: b, r: 3 });
    }));
    note.replaceChildren(...rows.map(([text, colour]) => {
      const row = document.createElement("div"), dot = document.createElement("b");
      [dot.style.color, dot.textContent] = [colour ?? "", colour ? "● " : ""];
      row.append(dot, text);
      return row;
    }));
    [note.hidden, note.ariaLive] = [false, reader ? "polite" : "off"];
    const foot = new DOMPoint(x, last.y.place[0] + 4).matrixTransform(svg.getScreenCTM()), around = figure.getBoundingClientRect();
    note.style.left = `${Math.max(0, Math.min(foot.x - around.left - note.offsetWidth / 2, around.width - note.offsetWidth))}px`;
    note.style.top = `${foot.y - around.top}px`;
  };
  const step = (event) => {
    const by = { ArrowRight: 1, ArrowLeft: -1, Home: -1e9, End: 1e9, ArrowDown: 0, ArrowUp: 0 }[event.key], shown = lines.filter((line) => line.isOn);
    if (event.key === "Escape") reset();
    if (by === undefined || !shown.length) return;
    event.preventDefault();
    const [old, at] = reading ?? [shown[0], -1], turn = by ? 0 : event.key === "ArrowDown" ? 1 : shown.length - 1;
    const line = shown[(shown.indexOf(old) + turn) % shown.length], x = old.places[at]?.[0] ?? 0;
    const order = line.places.map((_, i) => i).sort((i, j) => line.places[i][0] - line.places[j][0]);
    const rank = by && line === old ? order.indexOf(at) : order.findIndex((i) => line.places[i][0] >= x);
    const next = order[Math.max(0, Math.min(order.length - 1, rank + by * (event.shiftKey ? 10 : 1)))];
    reading = [line, next];
    show(line.places[next], reading);
  };

  const at = ({ clientX, clientY }) => {
    const { x, y } = new DOMPoint(clientX, clientY).matrixTransform(svg.getScreenCTM().inverse());
    return [x, y];
  };
  const drag = (event) => {
    if (event.type === "pointerdown" && event.pointerType === "mouse") from = at(event);
    show(at(event));
    const [[a, b], [c, d]] = [from ?? at(event), at(event)];
    add(svg, "path", { class: "pointer selected", d: `M${a} ${b}H${c}V${d}H${a}Z` });
  };
  const drop = (event) => {
    if (event.type === "pointerup" && from && plotAt(from)) zoom(plotAt(from), from, at(event));
    if (event.type !== "pointerup") clear();
    from = null;
  };
  [note.className, note.hidden] = ["values", true];
  figure.append(note);
  if (lines.length) {
    set(svg, { role: "application", tabindex: 0, "aria-roledescription": "chart" });
    const heard = { pointermove: drag, pointerdown: drag, pointerup: drop, pointerleave: drop, blur: drop, dblclick: reset, keydown: step };
    Object.entries(heard).forEach(([name, act]) => svg.addEventListener(name, act));
  }
  figure.querySelector("[download$=svg]")?.addEventListener("click", ({ currentTarget }) => {
    const shown = drawnWide;
    fit(width);
    const whole = set(svg.cloneNode(true), { viewBox: `0 0 ${width} ${height}`, height });
    all(whole, ".key").forEach((key) => (key.style.display = ""));
    currentTarget.href = URL.createObjectURL(new Blob([new XMLSerializer().serializeToString(whole)], { type: "image/svg+xml" }));
    fit(shown);
  });
  return { svg, section: svg.closest("section"), lines, room, fit };
};

/* Keys of the lines as buttons; those of a legend that has no lines are of all charts of its section. */
let charts = [];
const addKeys = ({ svg, section, lines }) => {
  const reach = lines.length ? lines : charts.filter((other) => other.section === section).flatMap((other) => other.lines);
  const row = document.createElement("div");
  row.className = "keys";
  all(svg, ".key").forEach((key) => {
    const { label, width } = key.dataset, own = reach.filter((line) => line.label === label);
    const button = document.createElement(own.length ? "button" : "span");
    add(button, "svg", { width, height: 14, "aria-hidden": true }).append(...[...key.cloneNode(true).childNodes]);
    if (own.length) set(button, { type: "button", "aria-pressed": own[0].isOn, "aria-label": label });
    button.addEventListener("click", () => own.forEach((line) => {
      line.isOn = !line.isOn;
      line.node.parentNode.style.display = line.isOn ? "" : "none";
      button.ariaPressed = line.isOn;
    }));
    row.append(button);
    key.style.display = "none";
  });
  svg.before(row);
};
const fitAll = () => {
  const rooms = charts.map(({ room }) => room());
  charts.forEach(({ fit }, i) => fit(rooms[i]));
};
const prepare = () => {
  charts = all(document, "svg.chart").map(chartOf);
  charts.forEach(addKeys);
  fitAll();
  document.getAnimations().forEach((each) => (each.startTime = document.timeline.currentTime));
};
/* Charts as drawn in the units of the page, and in the others where these differ. */
const shownIn = document.querySelector(".units :checked")?.id;
const drawings = all(document, "figure:has(svg.chart)").map((now) => {
  const own = now.cloneNode(true), other = now.querySelector("template")?.content.firstElementChild ?? now.cloneNode(true);
  const paths = all(own, "path");
  all(other, "path:not([d])").forEach((path) => set(path, { d: paths[all(other, "path").indexOf(path)].getAttribute("d") }));
  return { now, own, other };
});
document.querySelector(".units")?.addEventListener("change", ({ target }) => {
  drawings.forEach((each) => {
    const next = (target.id === shownIn ? each.own : each.other).cloneNode(true);
    each.now.replaceWith(next);
    each.now = next;
  });
  prepare();
});
prepare();
const observer = new ResizeObserver(fitAll);
all(document, "main").forEach((main) => observer.observe(main));

/* Buttons copy a table as it is shown. */
const quoted = (cell) => (/[",]/.test(cell) ? `"${cell.replaceAll('"', '""')}"` : cell);
const ofTex = (cell) => cell.replace(/[&%#$_{}]/g, "\\$&").replaceAll("−", "$-$").replaceAll("^", "\\^{}");
const forms = {
  text: (rows) => rows.map((row) => row.join("\t")),
  CSV: (rows) => rows.map((row) => row.map(quoted).join(",")),
  LaTeX: (rows) => [`\\begin{tabular}{l${"r".repeat(rows[0].length - 1)}}`,
    ...rows.map((row) => `${row.map(ofTex).join(" & ")} \\\\`), "\\end{tabular}"],
};
all(document, ".scroll > table").forEach((table) => {
  const row = document.createElement("div");
  [row.className, row.textContent] = ["copy", "Copy as"];
  row.append(...Object.entries(forms).map(([name, form]) => {
    const button = set(document.createElement("button"), { type: "button" });
    button.textContent = name;
    button.addEventListener("click", async () => {
      const shown = all(table, "tr:not(.groups)").map((line) => [...line.children].map((cell) => cell.innerText.trim().replace(/\s+/g, " ")));
      await navigator.clipboard.writeText(form(shown).join("\n"));
      button.textContent = `${name} ✓`;
    });
    return button;
  }));
  table.parentNode.after(row);
});

const unfold = (id) => document.getElementById(id)?.querySelectorAll("details").forEach((part) => (part.open = true));
document.querySelectorAll("nav a").forEach((link) => link.addEventListener("click", () => unfold(link.hash.slice(1))));
unfold(location.hash.slice(1));
addEventListener("beforeprint", () => document.querySelectorAll("details").forEach((part) => (part.open = true)));
