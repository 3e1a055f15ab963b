/* Charts: values at the pointer and by arrow keys, zoom, lines to hide, narrow windows. Without it they are as drawn. */
const all = (part, what) => [...part.querySelectorAll(what)];
const numbers = (text) => text.split(" ").map(Number);
const raised = (power) => [...String(+power)].map((digit) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(digit)]).join("");
const printed = (text) => {
  const [factor, power] = text.split("e"), ten = `10${raised(power)}`;
  const product = /^-?1$/.test(factor) ? factor.replace("1", ten) : `${factor}×${ten}`;
  return (power ? product : text).replace(/^-/, "−");
};
const set = (element, attributes) => {
  Object.entries(attributes).forEach(([name, value]) => element.setAttribute(name, value));
  return element;
};
const add = (parent, name, attributes) =>
  parent.appendChild(set(document.createElementNS("http://www.w3.org/2000/svg", name), attributes));

/* Parts in the units that the page shows. */
const shownIn = () => document.querySelector(".units :checked")?.id ?? "si";
const ofUnits = (part, what) => all(part, what).find((node) => !node.closest(shownIn() === "si" ? ".us" : ".si"));

/* An axis has its ends at the pixels `from` and `to` of the file; what lies between those of `seen` is shown in `place`. */
const axisOf = (svg, what, scale, from, to) => ({ scale, from, to, seen: [from, to], place: [from, to],
  get group() { return ofUnits(svg, what); }, get label() { return this.group.dataset.label; }, get ends() { return numbers(this.group.dataset.ends); } });
const shownAt = ({ seen: [a, b], place: [p, q] }) => (pixel) => p + ((pixel - a) * (q - p)) / (b - a);
const drawnAt = ({ seen: [a, b], place: [p, q] }) => (pixel) => a + ((pixel - p) * (b - a)) / (q - p);
/* Value at a pixel of the file to the digits of its place, which is rounded to `precision`. */
const valueAt = ({ ends, scale, from, to }, pixel, precision) => {
  const part = (pixel - from) / (to - from), [a, b] = ends;
  if (scale === "log") return +(a * (b / a) ** part).toPrecision(4);
  const step = Math.ceil(Math.log10(Math.abs((5 * precision * (b - a)) / (to - from))));
  return +(Math.round((a + part * (b - a)) / 10 ** step) * 10 ** step).toPrecision(12);
};
const pointsOf = (path) => {
  let x = 0, y = 0;
  const points = [];
  for (const [, kind, text] of path.matchAll(/([Ml])([^Mlz]*)/gi)) {
    const steps = text.match(/-?[\d.]+/g)?.map(Number) ?? [];
    for (let i = 0; i < steps.length; i += 2) {
      [x, y] = kind === "M" ? [steps[i], steps[i + 1]] : [x + steps[i], y + steps[i + 1]];
      points.push([x, y]);
    }
  }
  return points;
};
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
  const { box, scales, nearest, fixed } = element.dataset, [left, top, right, bottom] = numbers(box);
  const [across, up] = scales.split(" "), plot = { element, top, right, bottom, nearest, fixed };
  const paths = all(element, ".marks path:not(.moving path)");
  const texts = all(element, ".marks text").map((node) => [node, +node.getAttribute("x"), +node.getAttribute("y")]);
  const lines = paths.filter(({ dataset }) => dataset.label).map((node) => ({ plot, node, label: node.dataset.label,
    isOn: node.parentNode.style.display !== "none",
    get home() { return (this.points ??= pointsOf(node.getAttribute("d"))).slice(0, node.matches(".layer") ? this.points.length / 2 : undefined); },
    get places() { return this.home.map(([x, y]) => [shownAt(plot.x)(x), shownAt(plot.y)(y)]); } }));
  const x = axisOf(element.ownerSVGElement, ".x-axis", across, left, right), y = axisOf(element, ".y-axis", up, bottom, top);
  return Object.assign(plot, { paths, texts, lines: lines.filter(({ node }) => node.getAttribute("d")), x, y });
};
/* Words of a narrow drawing stay inside of it. A name on top that would cover another is a row lower; other words are not shown. */
const isClear = (one, other) => one.right < other.left - 4 || one.left > other.right + 4 || one.top > other.bottom - 3 || one.bottom < other.top + 3;
const boxAt = (node, across, down = 0) => {
  const { left, right, top, bottom } = node.getBoundingClientRect();
  return { left: left + across, right: right + across, top: top + down, bottom: bottom + down };
};
const separate = (element) => {
  const { left, right } = element.ownerSVGElement.getBoundingClientRect(), seen = [], texts = all(element, ".marks text");
  const shifts = texts.map((node) => node.getBoundingClientRect()).map((box) => Math.max(0, left - box.left) - Math.max(0, box.right - right));
  const places = texts.map((node, i) => (node.matches(".halo") ? [0] : [0, 11, 22]).map((lower) => [lower, boxAt(node, shifts[i], lower)]));
  texts.forEach((node, i) => {
    const [lower, box] = places[i].find(([, place]) => seen.every((other) => isClear(place, other))) ?? [0];
    set(node, { x: +node.getAttribute("x") + shifts[i], y: +node.getAttribute("y") + lower });
    if (box) seen.push(box);
    else node.style.display = "none";
  });
};
/* Names of levels are at the right end of their lines, above or below, left of words that they would cover, and not outside of the drawing. */
const placeNames = (names, words, end, [top, bottom], down) => {
  const seen = words.map((node) => node.getBoundingClientRect()).filter(({ width }) => width);
  names.forEach((name) => {
    const height = down(name.dataset.at), lower = height - name.dataset.at, at = (across, other) => `translate(${across} ${lower + other})`;
    const text = name.querySelector("text"), shift = end - 4 - text.getAttribute("x");
    const sides = [0, text.getAttribute("y") < name.dataset.at ? 14 : -14];
    set(name, { transform: at(shift, 0) }).style.display = "";
    const ends = [0, ...seen.map(({ left }) => left - 8 - name.getBoundingClientRect().right)].filter((far) => far <= 0).sort((a, b) => b - a);
    const places = ends.flatMap((by) => sides.map((side) => [by, side]));
    const [far, side] = places.find((place) => seen.every((other) => isClear(boxAt(name, ...place), other)));
    const box = boxAt(name, far, side), isIn = box.left >= name.ownerSVGElement.getBoundingClientRect().left && height > top - 1 && height < bottom + 1;
    if (isIn) seen.push(box);
    set(name, { transform: at(shift + far, side) }).style.display = isIn ? "" : "none";
  });
};
const drawPlot = ({ element, paths, texts, x, y, top }) => {
  const [across, down, [start, end], [bottom]] = [shownAt(x), shownAt(y), x.place, y.place];
  const isWhole = [x, y].every(({ from, to, seen }) => seen[0] === from && seen[1] === to);
  const [left, above] = [across(0), down(0)], matrix = [across(1) - left, 0, 0, down(1) - above, left, above];
  const moving = all(element, ".moving").map((node) => node.closest("g:not(.moving)"));
  [...paths, ...moving].forEach((node) => set(node, { transform: `matrix(${matrix})` }));
  texts.forEach(([node, a, b]) => (set(node, { x: across(a), y: down(b) }).style.display = ""));
  const corners = [[start, top], [end, top], [end, bottom], [start, bottom]].map(([a, b]) => `${a}px ${b}px`);
  element.querySelector(".marks").style.clipPath = isWhole ? "" : `polygon(${corners}) view-box`;
  if (element.querySelector(".frame")) set(element.querySelector(".frame"), { width: end - start, height: bottom - top });
  if (matrix[0] < 1 && isWhole) separate(element);
  placeNames(all(ofUnits(element, ".beside"), "g[data-at]"), texts.map(([node]) => node), end, [top, bottom], down);
  const holder = y.group.querySelector(".ticks g");
  if (y.scale === "named" || !holder.childElementCount) return;
  const ticks = ticksOf(y, 26);
  setTicks(holder, "y", ticks, 4);
  y.group.querySelector(".rows")?.setAttribute("d", ticks.map(([at]) => `M${start} ${at}H${end}`).join(""));
};

/* Width between the margins of A4 [pixels]. */
const PAPER = 700;
const NEAR = 14;
/* Each line with the number of its point nearest to a place, of those about as near as the nearest. */
const nearTo = (plot, x, y) => {
  const weights = ["x", "y"].map((name) => (plot.nearest.includes(name) ? 1 : 1e-3));
  const found = plot.lines.filter((line) => line.isOn).map((line) => {
    const far = line.places.map(([a, b]) => Math.hypot(weights[0] * (a - x), weights[1] * (b - y))), least = Math.min(...far);
    return [line, far.indexOf(least), least];
  });
  const least = Math.min(...found.map(([, , far]) => far));
  return found.filter(([, , far]) => far < least + NEAR);
};
/* Headings and cells of a line: where its points are, and their values, from words or from its path. */
const tableOf = ({ plot: { x, y }, node, label, home, points }) => {
  const [at, values] = ["at", "values"].map((name) => ((shownIn() === "us" && node.dataset[`${name}Us`]) || node.dataset[name])?.split("|"));
  const height = (i) => valueAt(y, points[i][1], 0.001);
  const value = (i) => (node.matches(".layer") ? +(height(i) - height(points.length - 1 - i)).toPrecision(6) : height(i));
  const headings = at ? [[x.label, y.label].filter(Boolean).join("; "), label] : [x.label, y.label ? `${label}: ${y.label}` : label];
  return [headings, ...home.map((place, i) => [at?.[i] ?? valueAt(x, place[0], 0.01), values?.[i] ?? value(i)].map(String))];
};
/* Name of a quantity, and its value with the unit that stands in its heading. */
const said = (heading, text) => {
  const [, name, unit] = heading.match(/^(.*?)(?: \[([^\]]*)\])?$/);
  const value = text && isFinite(text) ? printed(String(+(+text).toPrecision(5))) : text;
  return [name, unit && isFinite(text) ? `${value} ${unit}` : value];
};

const chartOf = (svg) => {
  const figure = svg.closest("figure"), section = svg.closest("section"), note = document.createElement("output");
  const [, , width, height] = numbers(svg.getAttribute("viewBox")), top = Number(svg.dataset.top);
  const plots = all(svg, ".plot").map(plotOf), lines = plots.flatMap((plot) => plot.lines), last = plots.at(-1);
  let from = null, reading = null;
  const clear = () => {
    note.hidden = true;
    all(svg, ".pointer").forEach((each) => each.remove());
  };
  const draw = () => {
    clear();
    plots.forEach(drawPlot);
    const { scale, group, place: [start, end] } = last.x, holder = group.querySelector(".ticks g");
    group.querySelector(".ink text")?.setAttribute("x", (start + end) / 2);
    if (scale === "named" || !holder.childElementCount) return;
    const ticks = ticksOf(last.x, 58);
    setTicks(holder, "x", ticks, 0);
    set(group.querySelector("path"), { d: ticks.map(([at]) => `M${at} ${last.bottom}v3`).join("") });
  };
  /* As wide as its place, drawings to scale at most as wide as drawn; the keys stand above it as buttons. A plot beside
     long names keeps 150 pixels, and the chart is then reduced. */
  const isFixed = plots.some(({ fixed, x }) => fixed === "wide" || (x.scale === "named" && fixed !== "equal")), isEqual = last.fixed === "equal";
  let drawnWide = 0;
  const room = (wide = figure.clientWidth) => (isFixed ? width : wide && Math.max(Math.min(isEqual ? width : Infinity, wide), last.x.from + 150));
  const fit = (wide) => {
    if (!wide || wide === drawnWide) return false;
    const isAsDrawn = !drawnWide && wide === width;
    drawnWide = wide;
    const narrower = (wide - width) / (last.right - last.x.from), lower = isEqual ? narrower * (last.bottom - last.top) : 0;
    set(svg, { viewBox: `0 ${top} ${wide} ${height - top + lower}`, width: wide, height: height - top + lower });
    svg.closest(".large")?.classList.toggle("fitted", !isFixed);
    plots.forEach(({ x, y, right }) => Object.assign(x, { place: [x.from, right + wide - width] }) && (y.place = [y.from + lower, y.to]));
    all(svg, ".x-axis").forEach((axis) => set(axis, { transform: `translate(0 ${lower})` }));
    return !isFixed && !isAsDrawn;
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

  const plotAt = ([x, y]) => plots.find((plot) => x >= plot.x.place[0] && x <= plot.x.place[1] && y >= plot.top && y <= plot.y.place[0]);
  const show = ([x, y], reader) => {
    clear();
    if (!lines.length || !plotAt([x, y])) return;
    lines.forEach((each) => (each.table ??= tableOf(each)));
    const found = reader ? [[reader]] : plots.map((plot) => nearTo(plot, x, y)), [line, i] = found.flat()[0] ?? [];
    if (!line) return;
    const rows = [[said(line.table[0][0], line.table[i + 1][0]).filter(Boolean).join(" ")]];
    found.forEach((near) => near.forEach(([each, n], k) => {
      const [a, b] = each.places[n], { nearest, top, y: { label, place: [bottom] } } = each.plot;
      if (!k && label) rows.push([label.replace(/ \[.*/, "")]);
      const value = said(each.table[0][1], each.table[n + 1][1])[1];
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
    const line = shown[(shown.indexOf(old) + turn) % shown.length], x = old.places[at]?.[0] ?? 0, { places } = line;
    const order = places.map((_, i) => i).sort((i, j) => places[i][0] - places[j][0]);
    const rank = by && line === old ? order.indexOf(at) : order.findIndex((i) => places[i][0] >= x);
    const next = order[Math.max(0, Math.min(order.length - 1, rank + by * (event.shiftKey ? 10 : 1)))];
    reading = [line, next];
    show(places[next], reading);
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
  const files = figure.querySelector("[download$=svg]");
  const toFile = (link, text, type) => (link.href = URL.createObjectURL(new Blob([text], { type })));
  files?.addEventListener("click", () => {
    const shown = drawnWide;
    if (fit(width)) draw();
    const whole = set(svg.cloneNode(true), { viewBox: `0 0 ${width} ${height}`, height });
    all(whole, shownIn() === "si" ? ".us" : ".si").forEach((part) => part.remove());
    all(whole, ".key").forEach((key) => (key.style.display = ""));
    toFile(files, new XMLSerializer().serializeToString(whole), "image/svg+xml");
    if (fit(shown)) draw();
  });
  /* Each line has a column, preceded by its places where these differ from those of the line before. */
  if (lines.length && files && !figure.querySelector("[download$=csv]")) {
    const link = set(files.cloneNode(), { download: files.download.replace(/svg$/, "csv"), href: "#", "aria-label": files.ariaLabel.replace("SVG", "CSV") });
    link.textContent = "CSV";
    link.addEventListener("click", () => {
      const columns = lines.map(tableOf).flatMap((rows) => [0, 1].map((n) => rows.map((row) => quoted(row[n]))));
      const kept = columns.filter((column, i) => i % 2 || i === 0 || column.join() !== columns[i - 2].join());
      const count = Math.max(...kept.map((column) => column.length));
      toFile(link, Array.from({ length: count }, (_, i) => `${kept.map((column) => column[i] ?? "").join(",")}\n`).join(""), "text/csv");
    });
    files.before(link, " ");
  }
  const renew = () => {
    lines.forEach((line) => delete line.table);
    if (drawnWide !== width && !isFixed) draw();
    else clear();
  };
  const print = () => fit(room(figure.closest(".alone, .tall") ? PAPER : 0.48 * PAPER)) && draw();
  return { svg, lines, room, fit, draw, renew, print };
};

/* Keys of the lines as buttons; those of a legend that has no lines are of all charts of its section. */
const addKeys = ({ svg, lines }, section) => {
  const reach = lines.length ? lines : section.flatMap((other) => other.lines);
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
const quoted = (cell) => (/[",]/.test(cell) ? `"${cell.replaceAll('"', '""')}"` : cell);
/* Buttons copy a table as it is shown. */
const ofTex = (cell) => cell.replace(/[&%#$_{}]/g, "\\$&").replaceAll("−", "$-$").replaceAll("^", "\\^{}");
const forms = {
  text: (rows) => rows.map((row) => row.join("\t")),
  CSV: (rows) => rows.map((row) => row.map(quoted).join(",")),
  LaTeX: (rows) => [`\\begin{tabular}{l${"r".repeat(rows[0].length - 1)}}`,
    ...rows.map((row) => `${row.map(ofTex).join(" & ")} \\\\`), "\\end{tabular}"],
};
const addCopies = (table) => {
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
};

/* A section is prepared when it is about to be seen, its charts one by one, so that the page answers in between. */
const charts = [], sections = all(document, "section");
let isPrinted = false;
const fitAll = async (some = charts) => {
  if (isPrinted) return;
  const rooms = some.map(({ room }) => room());
  for (const { draw } of some.filter(({ fit }, i) => fit(rooms[i]))) {
    await new Promise((next) => setTimeout(next));
    draw();
  }
};
const prepare = (section) => (section.prepared ??= prepared(section));
const prepared = (section) => {
  const added = all(section, "svg.chart").map(chartOf);
  added.forEach((chart) => addKeys(chart, added));
  all(section, ".scroll > table").forEach(addCopies);
  section.getAnimations({ subtree: true }).forEach((each) => (each.startTime = document.timeline.currentTime));
  charts.push(...added);
  section.addEventListener("contentvisibilityautostatechange", ({ skipped }) => skipped || fitAll(added));
  return fitAll(added);
};
const prepareAll = () => Promise.all(sections.map(prepare));
const near = new IntersectionObserver((entries) => entries.filter(({ isIntersecting }) => isIntersecting)
  .forEach(({ target }) => prepare(target)), { rootMargin: "400px" });
sections.forEach((section) => near.observe(section));
const resized = new ResizeObserver(() => fitAll());
all(document, "main").forEach((main) => resized.observe(main));
document.querySelector(".units").addEventListener("change", () => charts.forEach(({ renew }) => renew()));

const unfold = (id) => document.getElementById(id)?.querySelectorAll("details").forEach((part) => (part.open = true));
document.querySelectorAll("header a").forEach((link) => link.addEventListener("click", () => unfold(link.hash.slice(1))));
unfold(location.hash.slice(1));
/* Charts are as wide as on paper before it is laid out, as nothing is drawn meanwhile. */
addEventListener("beforeprint", () => {
  document.querySelectorAll("details").forEach((part) => (part.open = true));
  isPrinted = true;
  sections.forEach(prepare);
  charts.forEach(({ print }) => print());
});
addEventListener("afterprint", () => {
  isPrinted = false;
  fitAll();
});
