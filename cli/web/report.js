// The plots of a report: curves over each other, zoomed and panned together. Drawing is uPlot's.
"use strict";
(() => {
  const page = document.documentElement;
  const data = JSON.parse(document.getElementById("data").textContent);
  const decoded = [];
  const array = (i) => decoded[i] ??= new Float64Array(
    Uint8Array.from(atob(data.arrays[i]), (c) => c.charCodeAt(0)).buffer);
  const full = [Math.min(...data.scenes.map((s) => s.start)), Math.max(...data.scenes.map((s) => s.stop))];
  if (!(full[1] > full[0])) full[1] = full[0] + 1;

  const timeTitle = "t" + (data.time ? " (" + data.time + ")" : "");

  // What all plots share: the stretch of time that they show, and the scenes that are hidden.
  let view = full;
  const hidden = new Set();
  let plots = [];

  // ---- numbers -------------------------------------------------------------------------------------------------
  const text = (value) => {
    if (value == null) return "\u2013";
    const size = Math.abs(value);
    if (size !== 0 && (size >= 1e6 || size < 1e-4)) return value.toExponential(4).replace("-", "\u2212").replace("e+", "e");
    return String(Number(value.toPrecision(6))).replace("-", "\u2212");
  };
  const superscript = (n) => String(n).replace(/./g, (c) => c === "-" ? "\u207b" : "\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079"[c]);
  const ten = (n) => "10" + superscript(n);
  // The power of a thousand that an axis is written in: none for handy numbers.
  const axisPower = (scale) => {
    const most = Math.max(Math.abs(scale.min), Math.abs(scale.max));
    const power = most > 0 ? Math.floor(Math.log10(most) + 1e-9) : 0;
    return power >= 5 || power < -2 ? 3 * Math.floor(power / 3) : 0;
  };
  const digits = (n) => Math.min(Math.max(Math.ceil(n), 0), 20);
  // 1, 2, 5 times powers of ten around what the range asks for, at any magnitude.
  const steps = (u, axis, min, max) => {
    const least = Math.floor(Math.log10(max - min)) - 3;
    const list = [];
    for (let power = least; power < least + 6; ++power) for (const digit of [1, 2, 5]) list.push(Number(digit + "e" + power));
    return list;
  };
  const ticks = (u, axis, min, max, step) => {
    const list = [];
    for (let k = Math.ceil(min / step - 1e-9); k <= Math.floor(max / step + 1e-9); ++k) list.push(Number((k * step).toPrecision(15)));
    return list;
  };
  const labels = (u, at, axis, space, step) => {
    const unit = Number("1e" + axisPower(u.scales[u.axes[axis].scale]));
    return at.map((value) => (value / unit).toFixed(digits(-Math.log10(step / unit) - 1e-9)).replace("-", "\u2212"));
  };
  const bare = (unit) => unit && unit !== "1" ? unit : "";
  const axisTitle = (name) => (u, axis) => {
    const power = axisPower(u.scales[u.axes[axis].scale]);
    return [name, power === 0 ? "" : "\u00d7 " + ten(power)].filter(Boolean).join("  ");
  };
  // A little room above and below; a constant stands in the middle. What is rounding beside the other outputs of its
  // unit is drawn at their scale.
  const rounded = 4096 * Number.EPSILON;
  const room = (least) => (u, min, max) => {
    if (min == null) return [0, 1];
    const size = Math.max(Math.abs(min), Math.abs(max));
    if (size <= rounded * least) return [-least, least];
    if (max - min <= rounded * size) return size === 0 ? [-1, 1] : [min - 0.1 * size, max + 0.1 * size];
    return [min - 0.05 * (max - min), max + 0.05 * (max - min)];
  };

  // ---- colours -------------------------------------------------------------------------------------------------
  const colours = 8;
  const colour = (name) => getComputedStyle(page).getPropertyValue("--" + name).trim();
  const curveColour = (i) => () => colour("c" + i % colours);
  const dashes = [[], [8, 4], [2, 3], [10, 3, 2, 3]];
  const dark = matchMedia("(prefers-color-scheme: dark)");
  let chosen = "auto";
  // The drawing has colours of its own, which follow the system; here they follow the page.
  const darkRules = [...document.styleSheets].filter((sheet) => sheet.ownerNode.closest("svg"))
    .flatMap((sheet) => [...sheet.cssRules]).filter((rule) => rule.media?.mediaText.includes("dark"));
  const useTheme = (theme) => {
    page.dataset.theme = theme !== "auto" ? theme : dark.matches ? "dark" : "light";
    for (const rule of darkRules) rule.media.mediaText = page.dataset.theme === "dark" ? "all" : "not all";
    for (const plot of plots) plot.u?.redraw(false, true);
    drawPhase();
  };
  dark.addEventListener("change", () => useTheme(chosen));
  const themeButton = document.getElementById("theme");
  const themes = {auto: "light", light: "dark", dark: "auto"};
  const nameTheme = () => {
    themeButton.textContent = {auto: "\u25d0", light: "\u25cb", dark: "\u25cf"}[chosen];
    themeButton.title = "Theme: " + chosen;
    themeButton.setAttribute("aria-label", themeButton.title);
  };
  themeButton.hidden = false;
  themeButton.addEventListener("click", () => { chosen = themes[chosen]; nameTheme(); useTheme(chosen); });
  nameTheme();

  // ---- the shared view -----------------------------------------------------------------------------------------
  const show = (from, to) => {
    const least = 1e-9 * (full[1] - full[0]);
    const width = Math.min(Math.max(to - from, least), full[1] - full[0]);
    const start = Math.min(Math.max(from + (to - from - width) / 2, full[0]), full[1] - width);
    view = width >= full[1] - full[0] ? full : [start, start + width];
    page.dataset.view = view.join(" ");
    for (const plot of plots) plot.u?.setScale("x", {min: view[0], max: view[1]});
    drawPhase();
  };
  const zoom = (factor, about = (view[0] + view[1]) / 2) =>
    show(about - factor * (about - view[0]), about + factor * (view[1] - about));
  const pan = (part) => {
    const by = part * (view[1] - view[0]);
    const shift = Math.min(Math.max(by, full[0] - view[0]), full[1] - view[1]);
    show(view[0] + shift, view[1] + shift);
  };
  const showAll = () => show(...full);

  // ---- values between samples ------------------------------------------------------------------------------------
  // Linear between the samples beside t; null before the first and after the last one, and beside what is not a number.
  const valueOf = (xs, ys, t) => {
    let low = 0, high = xs.length - 1;
    if (!(t >= xs[low] && t <= xs[high])) return null;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (xs[middle] <= t) low = middle; else high = middle;
    }
    if (xs[high] === t) low = high;
    const value = xs[low] === t ? ys[low] : ys[low] + (ys[high] - ys[low]) * ((t - xs[low]) / (xs[high] - xs[low]));
    return Number.isFinite(value) ? value : null;
  };
  // Curves have their own times. The legend and the dots show all of them at the cursor's.
  const readValues = (u) => {
    const t = u.cursor.left >= 0 ? u.posToVal(u.cursor.left, "x") : null;
    const rows = u.root.querySelectorAll(".u-legend tr");
    u.series.forEach((series, i) => {
      const y = t == null || i > 0 && !series.show ? null : i === 0 ? t : valueOf(series.xs, series.ys, t);
      const cell = rows[i]?.querySelector("td");
      if (cell) cell.textContent = series.lane ? sideText(series.lane, t) : text(y);
      if (!series.dot) return;
      series.dot.hidden = y == null;
      if (y != null) series.dot.style.transform = `translate(${u.cursor.left}px, ${u.valToPos(y, "y")}px)`;
    });
  };
  const addDots = (u) => {
    for (const series of u.series.slice(1)) {
      if (series.class || series.lane) continue;
      series.dot = u.over.appendChild(document.createElement("div"));
      series.dot.className = "dot";
      series.dot.hidden = true;
      series.dot.style.background = `var(--c${series.colour % colours})`;
    }
  };

  // ---- one plot ------------------------------------------------------------------------------------------------
  // A plot: {title, unit, about, tables}; a table: {x, curves}, a curve: {name, y, colour, dash, scene, low, high}.
  const seriesOf = (plot) => {
    const series = [{label: "t", value: (u, value) => text(value)}];
    const bands = [];
    for (const [xs, curve] of plot.tables.flatMap((table) => table.curves.map((curve) => [table.x, curve]))) {
      const at = series.length;
      const stroke = curveColour(curve.colour);
      const shared = {show: !hidden.has(curve.scene), scene: curve.scene, colour: curve.colour, xs, ys: curve.y};
      series.push({...shared, label: curve.name, stroke, dash: curve.dash, width: curve.low ? 1.2 : 1.6, points: {show: false},
        value: (u, value) => text(value), followers: curve.low ? [at + 1, at + 2] : [], ...(curve.lane && {lane: curve.lane, paths: () => null})});
      if (!curve.low) continue;
      const bound = {...shared, label: "", class: "bound", stroke: "transparent", width: 0, points: {show: false}, leader: at};
      series.push({...bound}, {...bound});
      bands.push({series: [at + 2, at + 1], fill: () => stroke() + "22"});
    }
    return {series, bands};
  };
  const dataOf = (plot) =>
    uPlot.join(plot.tables.map((table) => [table.x, ...table.curves.flatMap((c) => c.low ? [c.y, c.low, c.high] : [c.y])]));

  const followers = (u, i, options) => {
    if (i == null || options.show == null) return;
    const leader = u.series[u.series[i].leader];
    if (leader && leader.show !== options.show) return u.setSeries(i, {show: leader.show}, false);
    for (const j of u.series[i].followers ?? []) u.setSeries(j, {show: options.show}, false);
    u.root.querySelectorAll(".u-legend th")[i]?.setAttribute("aria-pressed", String(options.show));
  };
  const optionsOf = (plot) => {
    const {series, bands} = seriesOf(plot);
    const ink = () => colour("soft"), grid = {stroke: () => colour("line"), width: 1}, font = "12px " + getComputedStyle(document.body).fontFamily;
    const like = plot.lanes ? laneOptions : (plot, options) => options;
    const axis = {stroke: ink, grid, ticks: {...grid, size: 4}, font, labelFont: font, incrs: steps, splits: ticks, values: labels, labelSize: 20};
    return like(plot, {
      ...sizeOf(plot), series, bands,
      scales: {x: {time: false, range: (u, min, max) => [min, max]}, y: {range: room(plot.least ?? 0)}},
      axes: [{...axis, label: axisTitle(timeTitle), space: 64, gap: 2, size: 30},
        {...axis, label: axisTitle(bare(plot.unit)), space: 34, gap: 4, size: (u, values) => 16 + 7 * Math.max(2, ...(values ?? []).map((v) => v.length))}],
      padding: [10, 14, 0, 0],
      legend: {live: true, markers: {stroke: (u, i) => `var(--c${u.series[i].colour % colours})`, fill: "transparent", dash: (u, i) => u.series[i].dash?.length ? "dashed" : "solid", width: 2}},
      cursor: {drag: {x: true, y: false, setScale: false, dist: 4}, sync: {key: "t", scales: ["x", null], setSeries: false},
        focus: {prox: -1}, y: false, points: {show: false},
        bind: {dblclick: () => () => { showAll(); return null; }, mousedown: (u, over, handler) => (e) => e.shiftKey ? dragPan(u, e) : handler(e)}},
      hooks: {setSelect: [selected], setSeries: [followers, readValues], setCursor: [readValues], setLegend: [readValues],
        ready: [(u) => { addDots(u); equip(u, plot); }]},
    });
  };
  const sizeOf = (plot) => ({width: Math.max(plot.holder.clientWidth, 240), height: plot.lanes ? laneHeight * plot.lanes.length + 66 : matchMedia("(max-width: 40rem)").matches ? 230 : 270});
  const selected = (u) => {
    if (u.select.width < 4) return;
    const [from, to] = [u.posToVal(u.select.left, "x"), u.posToVal(u.select.left + u.select.width, "x")];
    u.setSelect({left: 0, top: 0, width: 0, height: 0}, false);
    show(from, to);
  };
  const dragPan = (u, e) => {
    let last = e.clientX;
    const move = (now) => { pan((last - now.clientX) / u.over.clientWidth); last = now.clientX; };
    const up = () => { removeEventListener("mousemove", move); removeEventListener("mouseup", up); };
    addEventListener("mousemove", move);
    addEventListener("mouseup", up);
    return null;
  };
  const valueAt = (u, clientX) => u.posToVal(clientX - u.over.getBoundingClientRect().left, "x");
  // Ctrl and the wheel (which is what a pinch on a touchpad gives) zoom, sideways pans; plain scrolling stays the page's.
  const wheel = (u, e) => {
    if (e.ctrlKey || e.metaKey) {
      e.preventDefault();
      zoom(Math.exp(0.002 * Math.sign(e.deltaY) * Math.min(Math.abs(e.deltaY), 120)), valueAt(u, e.clientX));
    } else if (Math.abs(e.deltaX) > Math.abs(e.deltaY) && view !== full) {
      e.preventDefault();
      pan(e.deltaX / u.over.clientWidth);
    }
  };
  // One finger shows values, two fingers zoom and pan; up and down scrolls the page.
  const touch = (u) => {
    const fingers = new Map();
    const spread = () => {
      const [a, b] = [...fingers.values()];
      return {centre: (a + b) / 2, width: Math.max(Math.abs(a - b), 20)};
    };
    const put = (x) => u.setCursor({left: x - u.over.getBoundingClientRect().left, top: u.over.clientHeight / 2});
    u.over.addEventListener("pointerdown", (e) => {
      if (e.pointerType !== "touch") return;
      fingers.set(e.pointerId, e.clientX);
      if (fingers.size === 1) put(e.clientX);
    });
    u.over.addEventListener("pointermove", (e) => {
      if (!fingers.has(e.pointerId)) return;
      if (fingers.size === 1) return put(fingers.set(e.pointerId, e.clientX).get(e.pointerId));
      const before = spread();
      fingers.set(e.pointerId, e.clientX);
      const now = spread();
      const held = valueAt(u, before.centre);
      zoom(before.width / now.width, held);
      pan((before.centre - now.centre) / u.over.clientWidth);
    });
    for (const end of ["pointerup", "pointercancel"]) u.over.addEventListener(end, (e) => fingers.delete(e.pointerId));
  };
  const moveCursor = (u, by) => {
    const xs = u.data[0];
    const [from, to] = [u.valToIdx(view[0]), u.valToIdx(view[1])];
    const now = u.cursor.left >= 0 ? u.valToIdx(u.posToVal(u.cursor.left, "x")) : by > 0 ? from - 1 : to + 1;
    const stride = Math.max(1, Math.round((to - from) / 200));
    const next = Math.min(Math.max(now + by * stride, from), to);
    u.setCursor({left: u.valToPos(xs[next], "x"), top: u.over.clientHeight / 2});
  };
  const about = (u) => u.cursor.left >= 0 ? u.posToVal(u.cursor.left, "x") : undefined;
  const keys = {
    "+": (u) => zoom(0.5, about(u)), "=": (u) => zoom(0.5, about(u)), "-": (u) => zoom(2, about(u)), "0": showAll, Home: showAll,
    ArrowLeft: (u, e) => e.shiftKey ? pan(-0.2) : moveCursor(u, -1), ArrowRight: (u, e) => e.shiftKey ? pan(0.2) : moveCursor(u, 1),
    Escape: (u) => u.setCursor({left: -10, top: -10}),
  };
  const equip = (u, plot) => {
    u.over.addEventListener("wheel", (e) => wheel(u, e), {passive: false});
    touch(u);
    plot.holder.addEventListener("keydown", (e) => {
      if (e.target !== plot.holder || !keys[e.key] || e.ctrlKey || e.metaKey || e.altKey) return;
      e.preventDefault();
      keys[e.key](u, e);
    });
    u.root.querySelectorAll(".u-legend tr").forEach((row, i) => {
      const name = row.querySelector("th");
      if (i === 0 || row.classList.contains("bound")) return;
      name.tabIndex = 0;
      name.setAttribute("role", "button");
      name.setAttribute("aria-pressed", String(u.series[i].show));
      name.title = u.series[i].label + ": hide or show; with Ctrl, this one alone";
      name.addEventListener("keydown", (e) => {
        if (e.key !== "Enter" && e.key !== " ") return;
        e.preventDefault();
        name.click();
      });
    });
  };

  //@include report_files.js
  //@include report_lanes.js

  // Plots are made when they come near the screen: a report may have hundreds.
  const make = (plot) => {
    if (plot.u) return;
    watcher.unobserve(plot.holder);
    plot.u = new uPlot(optionsOf(plot), dataOf(plot), plot.holder);
    plot.u.setScale("x", {min: view[0], max: view[1]});
    resizer.observe(plot.holder);
  };
  const of = (holder) => plots.find((plot) => plot.holder === holder);
  const watcher = new IntersectionObserver((entries) => {
    for (const entry of entries) if (entry.isIntersecting && of(entry.target)) make(of(entry.target));
  }, {rootMargin: "400px"});
  const resizer = new ResizeObserver((entries) => {
    for (const entry of entries) {
      const plot = of(entry.target);
      const size = plot && sizeOf(plot);
      if (size && (size.width !== plot.u.width || size.height !== plot.u.height)) plot.u.setSize(size);
    }
  });
  const place = (parent, plot) => {
    const figure = document.createElement("figure");
    const caption = figure.appendChild(document.createElement("figcaption"));
    caption.appendChild(document.createElement("span")).textContent = plot.title;
    smallButton(caption, "CSV", "Save the curves of " + plot.title + " as CSV", () => save(plot.name + ".csv", csvOf(plot)));
    smallButton(caption, "PNG", "Save the plot of " + plot.title + " as PNG", async () => { make(plot); save(plot.name + ".png", await pngOf(plot)); });
    plot.holder = figure.appendChild(document.createElement("div"));
    plot.holder.className = "plot";
    plot.holder.tabIndex = 0;
    plot.holder.setAttribute("role", "group");
    plot.holder.setAttribute("aria-label", "Plot of " + plot.title + " over time. Arrow keys read values, with Shift they pan; plus, minus and zero zoom.");
    parent.append(figure);
    plots.push(plot);
    watcher.observe(plot.holder);
  };

  // For scripts that drive the page.
  window.bgsimPlots = () => plots.flatMap((plot) => plot.u ?? []);

  // ---- which plots there are -----------------------------------------------------------------------------------
  const many = data.scenes.length > 1;
  const label = (output, scene, several) =>
    [several ? data.outputs[output].name : "", many || !several ? data.scenes[scene].name : ""].filter(Boolean).join(", ");
  const outputPlot = (outputs, title, unit) => {
    const several = outputs.length > 1;
    const look = (item) => {
      const place = outputs.indexOf(item.output), index = several ? item.scene * outputs.length + place : item.scene;
      return {colour: several ? place : item.scene, dash: dashes[(several ? item.scene : Math.floor(index / colours)) % dashes.length]};
    };
    const tables = [];
    for (const curve of data.curves.filter((c) => outputs.includes(c.output))) {
      const x = array(curve.t);
      const table = tables.find((t) => t.x === x) ?? tables[tables.push({x, curves: []}) - 1];
      table.curves.push({...look(curve), name: label(curve.output, curve.scene, several), y: array(curve.v), scene: curve.scene});
    }
    for (const reference of data.references.filter((r) => outputs.includes(r.output)))
      tables.push({x: array(reference.t), curves: [{...look(reference), dash: [3, 3], scene: reference.scene,
        name: label(reference.output, reference.scene, several) + " ref.", y: array(reference.v), low: array(reference.low), high: array(reference.high)}]});
    return {title, unit, tables, least: unit ? largestOf(unit) : 0, name: outputs.map((i) => data.outputs[i].name).join("_")};
  };
  // The largest magnitude of all outputs of a unit.
  const largest = new Map();
  const largestOf = (unit) => {
    if (!largest.has(unit))
      largest.set(unit, data.curves.filter((c) => data.outputs[c.output].unit === unit).reduce((most, curve) =>
        array(curve.v).reduce((m, v) => Math.abs(v) > m ? Math.abs(v) : m, most), 0));
    return largest.get(unit);
  };
  const withUnit = (output) => output.name + (output.unit ? " (" + output.unit + ")" : "");
  const groupings = {
    "each output": () => data.outputs.map((output, i) => outputPlot([i], withUnit(output), output.unit)),
    "each unit": () => {
      const units = [...new Set(data.outputs.map((output) => output.unit))];
      return units.map((unit) => {
        const group = data.outputs.flatMap((output, i) => output.unit === unit ? [i] : []);
        return outputPlot(group, group.map((i) => data.outputs[i].name).join(", ") + (unit ? " (" + unit + ")" : ""), unit);
      });
    },
  };
  const outputPlots = (grouping) => {
    const parent = document.getElementById("plots");
    for (const plot of plots.filter((p) => parent.contains(p.holder))) {
      watcher.unobserve(plot.holder);
      resizer.unobserve(plot.holder);
      plot.u?.destroy();
    }
    plots = plots.filter((plot) => !parent.contains(plot.holder));
    parent.replaceChildren();
    for (const plot of groupings[grouping]()) place(parent, plot);
  };
  const energyPlots = () => {
    const parent = document.getElementById("energies");
    for (const energy of data.energy) {
      const scene = data.scenes[energy.scene].name, x = array(energy.t);
      const curves = energy.terms.map((term, i) => ({name: term.name, y: array(term.v), colour: i, scene: energy.scene}));
      place(parent, {title: scene + ": energy supplied, stored, dissipated", unit: energy.unit, name: scene + "_energy", tables: [{x, curves}]});
      place(parent, {title: scene + ": residual", unit: energy.unit, name: scene + "_residual", tables: [{x, curves: [{name: "residual", y: array(energy.residual), colour: 6, scene: energy.scene}]}]});
    }
  };

  //@include report_phase.js

  // ---- toolbar -------------------------------------------------------------------------------------------------
  const toolbar = document.getElementById("toolbar");
  const button = (name, title, act) => {
    const made = toolbar.appendChild(document.createElement("button"));
    made.type = "button";
    made.textContent = name;
    made.title = title;
    made.setAttribute("aria-label", title);
    made.addEventListener("click", act);
    return made;
  };
  const sceneButtons = () => {
    if (!many) return;
    data.scenes.forEach((scene, i) => {
      const made = button(scene.name, "Hide or show scene " + scene.name, () => {
        const shown = hidden.delete(i) || !hidden.add(i);
        made.setAttribute("aria-pressed", String(shown));
        for (const plot of plots)
          plot.u?.series.forEach((series, j) => {
            if (series.scene === i && !series.class) plot.u.setSeries(j, {show: shown});
          });
        drawPhase();
      });
      made.setAttribute("aria-pressed", "true");
      const swatch = document.createElement("span");
      swatch.className = "swatch";
      swatch.style.background = "var(--c" + i % colours + ")";
      made.prepend(swatch);
    });
  };
  const groupingChoice = () => {
    const first = many ? "each output" : "each unit";
    if (data.outputs.length > 1) {
      const choice = toolbar.appendChild(document.createElement("label"));
      choice.textContent = "A plot for ";
      const select = choice.appendChild(document.createElement("select"));
      for (const name of Object.keys(groupings)) select.add(new Option(name, name, name === first, name === first));
      select.addEventListener("change", () => outputPlots(select.value));
    }
    outputPlots(data.outputs.length > 1 ? first : "each output");
  };
  sceneButtons();
  toolbar.appendChild(document.createElement("span")).className = "gap";
  button("\u2212", "Zoom out", () => zoom(2));
  button("+", "Zoom in", () => zoom(0.5));
  button("\u25c0", "Earlier", () => pan(-0.3));
  button("\u25b6", "Later", () => pan(0.3));
  button("All", "Show the whole time", showAll);
  useTheme(chosen);
  groupingChoice();
  lanePlots();
  energyPlots();
  phaseSection();
  const drawing = document.querySelector(".drawing svg");
  if (drawing) smallButton(document.querySelector("#drawing .files"), "SVG", "Save the drawing as SVG", () => save("svg", svgOf(drawing)));

  // ---- formulas: those too wide are set smaller, down to what can still be read, and scroll beyond --------------
  const fitFormulas = () => {
    const sides = [...document.querySelectorAll(".equations .right")];
    for (const side of sides) side.style.fontSize = "";
    const parts = sides.map((side) => side.clientWidth / Math.max(side.scrollWidth, 1));
    sides.forEach((side, i) => { if (parts[i] < 1) side.style.fontSize = Math.max(parts[i] * 0.99, 0.7) + "em"; });
  };
  fitFormulas();
  addEventListener("resize", fitFormulas);

  // ---- paper: light, everything unfolded, plots of the paper's width ----------------------------------------------
  const paper = 660, sheet = document.getElementById("main");
  let folded = [];
  addEventListener("beforeprint", () => {
    folded = [...document.querySelectorAll("details:not([open])")].filter((part) => !part.closest("#reproduce"));
    for (const part of folded) part.open = true;
    for (const plot of plots) make(plot);
    for (const plot of plots) plot.u.setSize({width: paper, height: plot.lanes ? sizeOf(plot).height : 250});
    useTheme("light");
    sheet.style.width = paper + "px";
    fitFormulas();
  });
  addEventListener("afterprint", () => {
    for (const part of folded) part.open = false;
    sheet.style.width = "";
    for (const plot of plots) plot.u.setSize(sizeOf(plot));
    useTheme(chosen);
    fitFormulas();
  });

  // ---- where the reader is -------------------------------------------------------------------------------------
  const links = new Map([...document.querySelectorAll("nav a")].map((link) => [link.hash.slice(1), link]));
  const reader = new IntersectionObserver((entries) => {
    for (const entry of entries) {
      if (!entry.isIntersecting) continue;
      for (const [section, link] of links) link.classList.toggle("here", section === entry.target.id);
    }
  }, {rootMargin: "-20% 0px -75% 0px"});
  for (const section of links.keys()) reader.observe(document.getElementById(section));
})();
