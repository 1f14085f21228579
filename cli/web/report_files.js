// Part of report.js, which includes it (cmake/Web.cmake).
  // ---- files ---------------------------------------------------------------------------------------------------
  // Made here, from what is on the page: nothing is asked of a network.
  const save = (name, blob) => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(blob);
    link.download = (document.title.split(" - ")[0] + "." + name).replace(/[^A-Za-z0-9_.-]+/g, "_");
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60000);
  };
  const csvField = (name) => /[",\r\n]/.test(name) ? '"' + name.replaceAll('"', '""') + '"' : name;
  // All curves of a plot; a cell is empty where a curve has no sample at that time.
  const csvOf = (plot) => {
    const names = plot.tables.flatMap((table) => table.curves.flatMap((c) => c.low ? [c.name, c.name + " low", c.name + " high"] : [c.name]));
    const columns = dataOf(plot), lines = [["t", ...names].map(csvField).join(",")];
    for (let i = 0; i < columns[0].length; ++i) lines.push(columns.map((column) => column[i] ?? "").join(","));
    return new Blob([lines.join("\r\n") + "\r\n"], {type: "text/csv"});
  };
  // The plot as it is shown, with its title above and its curves' names below.
  const pngOf = (plot) => {
    const shown = plot.u.series.slice(1).filter((series) => series.show && !series.class);
    const scale = plot.u.ctx.canvas.width / plot.u.width, font = getComputedStyle(document.body).fontFamily;
    const canvas = document.createElement("canvas"), c = canvas.getContext("2d");
    c.font = "12px " + font;
    const rows = [[]];
    let x = 12;
    for (const series of shown) {
      const wide = c.measureText(series.label).width + 44;
      if (x + wide > plot.u.width && rows.at(-1).length) { rows.push([]); x = 12; }
      rows.at(-1).push([x, series]);
      x += wide;
    }
    canvas.width = plot.u.ctx.canvas.width;
    canvas.height = plot.u.ctx.canvas.height + scale * (34 + 20 * rows.length);
    c.fillStyle = colour("back");
    c.fillRect(0, 0, canvas.width, canvas.height);
    c.drawImage(plot.u.ctx.canvas, 0, 28 * scale);
    c.scale(scale, scale);
    c.textBaseline = "middle";
    c.fillStyle = colour("ink");
    c.font = "bold 14px " + font;
    c.fillText(plot.title, 12, 16, plot.u.width - 24);
    c.font = "12px " + font;
    rows.forEach((row, r) => row.forEach(([left, series]) => {
      const y = plot.u.ctx.canvas.height / scale + 40 + 20 * r;
      c.strokeStyle = colour("c" + series.colour % colours);
      c.lineWidth = 2;
      c.setLineDash(series.dash ?? []);
      c.beginPath();
      c.moveTo(left, y);
      c.lineTo(left + 22, y);
      c.stroke();
      c.fillText(series.label, left + 28, y, plot.u.width - left - 30);
    }));
    return new Promise((done) => canvas.toBlob(done));
  };
  const svgOf = (element) => new Blob([new XMLSerializer().serializeToString(element)], {type: "image/svg+xml"});
  const smallButton = (parent, name, title, act) => {
    const made = parent.appendChild(document.createElement("button"));
    made.type = "button";
    made.className = "small";
    made.textContent = name;
    made.title = title;
    made.setAttribute("aria-label", title);
    made.addEventListener("click", act);
    return made;
  };
