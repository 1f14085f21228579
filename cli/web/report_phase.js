// Part of report.js, which includes it (cmake/Web.cmake).
  // ---- phase plot: one output over another ---------------------------------------------------------------------
  const svgNamespace = "http://www.w3.org/2000/svg";
  const phase = {x: -1, y: -1};
  const phaseRange = (curves, side, unit) => {
    let min = Infinity, max = -Infinity;
    for (const curve of curves) for (const value of curve[side]) if (value != null) {
      if (value < min) min = value;
      if (value > max) max = value;
    }
    return room(unit ? largestOf(unit) : 0)(null, min > max ? null : min, max);
  };
  const phaseCurves = () => data.scenes.flatMap((scene, i) => {
    const of = (output) => data.curves.find((c) => c.scene === i && c.output === output);
    const [a, b] = [of(phase.x), of(phase.y)];
    if (!a || !b || hidden.has(i)) return [];
    const [at, bt] = [array(a.t), array(b.t)];
    const times = (at === bt ? [...at] : [...new Set([...at, ...bt])].sort((p, q) => p - q)).filter((t) => t >= view[0] && t <= view[1]);
    return [{scene: i, x: times.map((t) => valueOf(at, array(a.v), t)), y: times.map((t) => valueOf(bt, array(b.v), t))}];
  });
  // The power of a thousand an axis is written in, its ticks and their texts.
  const phaseTicks = ([min, max], most) => {
    const least = (max - min) / most, step = steps(null, 0, min, max).find((s) => s >= least) ?? max - min;
    const unit = Number("1e" + axisPower({min, max}));
    return {power: axisPower({min, max}), at: ticks(null, 0, min, max, step),
      text: (value) => (value / unit).toFixed(digits(-Math.log10(step / unit) - 1e-9)).replace("-", "\u2212")};
  };
  const drawPhase = () => {
    const holder = document.getElementById("phase-plot");
    if (!holder || phase.x < 0 || phase.y < 0) return;
    const outputs = [data.outputs[phase.x], data.outputs[phase.y]], curves = phaseCurves();
    const width = Math.min(holder.clientWidth || 600, 640), height = Math.round(0.75 * width), left = 74, top = 12, right = 16, bottom = 46;
    const ranges = [phaseRange(curves, "x", outputs[0].unit), phaseRange(curves, "y", outputs[1].unit)];
    const px = (v) => left + (v - ranges[0][0]) / (ranges[0][1] - ranges[0][0]) * (width - left - right);
    const py = (v) => height - bottom - (v - ranges[1][0]) / (ranges[1][1] - ranges[1][0]) * (height - top - bottom);
    const svg = document.createElementNS(svgNamespace, "svg");
    const add = (tag, attributes, words = "") => {
      const made = svg.appendChild(document.createElementNS(svgNamespace, tag));
      for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
      made.textContent = words;
      return made;
    };
    for (const [name, value] of Object.entries({viewBox: `0 0 ${width} ${height}`, width, height, role: "img",
      "font-family": "Liberation Sans, Arial, sans-serif", "font-size": 12, "aria-label": `${outputs[1].name} over ${outputs[0].name}`})) svg.setAttribute(name, value);
    add("rect", {width, height, fill: colour("back")});
    const [xs, ys] = [phaseTicks(ranges[0], width / 80), phaseTicks(ranges[1], height / 50)];
    const lines = (path, at) => add("path", {d: path, stroke: at, fill: "none"});
    for (const v of xs.at) {
      lines(`M${px(v)} ${top}V${height - bottom}`, colour("line"));
      add("text", {x: px(v), y: height - bottom + 16, "text-anchor": "middle", fill: colour("soft")}, xs.text(v));
    }
    for (const v of ys.at) {
      lines(`M${left} ${py(v)}H${width - right}`, colour("line"));
      add("text", {x: left - 6, y: py(v) + 4, "text-anchor": "end", fill: colour("soft")}, ys.text(v));
    }
    const title = (output, power) => [withUnit(output), power ? "\u00d7 " + ten(power) : ""].filter(Boolean).join("  ");
    add("text", {x: (left + width - right) / 2, y: height - 10, "text-anchor": "middle", fill: colour("ink")}, title(outputs[0], xs.power));
    add("text", {transform: `translate(16 ${(top + height - bottom) / 2}) rotate(-90)`, "text-anchor": "middle", fill: colour("ink")}, title(outputs[1], ys.power));
    for (const curve of curves) {
      let path = "", down = false;
      curve.x.forEach((x, i) => {
        const there = x != null && curve.y[i] != null;
        if (there) path += (down ? "L" : "M") + px(x).toFixed(2) + " " + py(curve.y[i]).toFixed(2);
        down = there;
      });
      add("path", {class: "phase-curve", d: path, fill: "none", stroke: colour("c" + curve.scene % colours), "stroke-width": 1.6, "stroke-linejoin": "round"})
        .appendChild(document.createElementNS(svgNamespace, "title")).textContent = data.scenes[curve.scene].name;
    }
    holder.replaceChildren(svg);
  };
  const phaseSection = () => {
    const parent = document.getElementById("phase");
    if (!parent || data.outputs.length < 2) return;
    parent.hidden = false;
    const bar = parent.querySelector(".phase-bar");
    for (const side of ["y", "x"]) {
      const choice = bar.appendChild(document.createElement("label"));
      choice.textContent = side === "y" ? "" : " over ";
      const select = choice.appendChild(document.createElement("select"));
      select.setAttribute("aria-label", side === "y" ? "Output upwards" : "Output to the right");
      select.dataset.side = side;
      data.outputs.forEach((output, i) => select.add(new Option(withUnit(output), i)));
      phase[side] = side === "y" ? 1 : 0;
      select.value = phase[side];
      select.addEventListener("change", () => { phase[side] = Number(select.value); drawPhase(); });
    }
    smallButton(bar, "SVG", "Save the phase plot as SVG", () => {
      drawPhase();
      save(data.outputs[phase.y].name + "_over_" + data.outputs[phase.x].name + ".svg", svgOf(parent.querySelector("#phase-plot svg")));
    });
    parent.querySelector("details").addEventListener("toggle", drawPhase);
    addEventListener("resize", drawPhase);
  };
