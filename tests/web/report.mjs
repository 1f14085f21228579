// Drives the page of `bgsim report` in headless Chromium: node report.mjs BGSIM MODELS [FOLDER FOR SCREENSHOTS]
import assert from "node:assert/strict";
import {execFileSync} from "node:child_process";
import {cpSync, mkdtempSync, readFileSync, rmSync, writeFileSync} from "node:fs";
import {tmpdir} from "node:os";
import {join} from "node:path";
import {chromium} from "playwright-core";

const [bgsim, models, pictures] = process.argv.slice(2);
const folder = mkdtempSync(join(tmpdir(), "bgsim-report-"));
const report = (name, ...options) => {
  const page = join(folder, name);
  execFileSync(bgsim, ["report", ...options, "-o", page, "--quiet"], {stdio: "inherit"});
  return page;
};

const browser = await chromium.launch({
  executablePath: "/usr/bin/chromium",
  args: ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync"],
});

// Opens a page; nothing may go wrong on it, and nothing may be asked for beside it.
const open = async (file, {width = 1366, height = 850, colorScheme = "light", hasTouch = false} = {}) => {
  const page = await browser.newPage({viewport: {width, height}, colorScheme, hasTouch});
  page.setDefaultTimeout(30000);
  page.faults = [];
  page.on("console", (message) => { if (["error", "warning"].includes(message.type())) page.faults.push(message.text()); });
  page.on("pageerror", (error) => page.faults.push(error.message));
  page.on("dialog", (dialog) => page.faults.push("dialog: " + dialog.message()));
  page.on("request", (request) => { if (!/^(file|data|blob):/.test(request.url())) page.faults.push("asked for " + request.url()); });
  const begin = Date.now();
  await page.goto("file://" + file + "#outputs");
  await page.waitForSelector("#outputs canvas");
  page.milliseconds = Date.now() - begin;
  return page;
};
const close = async (page) => {
  assert.deepEqual(page.faults, []);
  await page.close();
};
const picture = async (page, name) => { if (pictures) await page.screenshot({path: join(pictures, name + ".png")}); };
// Plots are made when they come into sight.
const seeAll = async (page) => {
  for (const figure of await page.locator("figure").all()) {
    await figure.scrollIntoViewIfNeeded();
    await figure.locator("canvas").waitFor();
  }
};
const view = (page) => page.evaluate(() => (document.documentElement.dataset.view ?? "").split(" ").map(Number));
// Pixels of the plot that have one of the curves' colours: grid and words are grey.
const inked = (figure) => figure.locator("canvas").evaluate((canvas) => {
  const {data} = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  let count = 0;
  for (let i = 0; i < data.length; i += 4)
    if (data[i + 3] > 128 && Math.max(data[i], data[i + 1], data[i + 2]) - Math.min(data[i], data[i + 1], data[i + 2]) > 60) ++count;
  return count;
});
const legend = (figure, name) => figure.locator(".u-series", {has: figure.page().locator(`.u-label:text-is("${name}")`)});

const checks = {
  async "all plots are there and drawn, and nothing goes wrong"() {
    const page = await open(bellow);
    assert.equal(await page.locator("#plots figure").count(), 5); // outputs
    assert.equal(await page.locator("#energies figure").count(), 8); // terms and residual of four scenes
    await seeAll(page);
    for (const figure of await page.locator("figure").all()) assert.ok(await inked(figure) > 100);
    assert.ok(await page.locator("#equations math").count() > 8);
    await picture(page, "laptop");
    await close(page);
  },

  async "dragging zooms every plot, a double click shows all again"() {
    const page = await open(bellow);
    const over = page.locator("#plots .u-over").first(), box = await over.boundingBox();
    await page.mouse.move(box.x + box.width * 0.25, box.y + 60);
    await page.mouse.down();
    await page.mouse.move(box.x + box.width * 0.5, box.y + 70, {steps: 5});
    await page.mouse.up();
    const [from, to] = await view(page), stop = 4 * Math.PI;
    assert.ok(Math.abs(from - stop / 4) < 0.1 && Math.abs(to - stop / 2) < 0.1, `${from} to ${to}`);
    await picture(page, "zoomed");
    await seeAll(page);
    const scales = await page.evaluate(() => window.bgsimPlots().map((u) => [u.scales.x.min, u.scales.x.max]));
    assert.equal(scales.length, 13);
    for (const scale of scales) assert.deepEqual(scale, [from, to]);
    await over.dblclick();
    assert.deepEqual(await view(page), [0, stop]);
    await close(page);
  },

  async "wheel with Ctrl zooms, wheel alone scrolls, Shift and a drag pan"() {
    const page = await open(bellow);
    const over = page.locator("#plots .u-over").first(), stop = 4 * Math.PI;
    await over.scrollIntoViewIfNeeded();
    await over.hover();
    await page.keyboard.down("Control");
    await page.mouse.wheel(0, -120);
    await page.mouse.wheel(0, -120);
    await page.keyboard.up("Control");
    await page.waitForFunction(() => document.documentElement.dataset.view);
    const [from, to] = await view(page);
    assert.ok(to - from < 0.9 * stop);
    const box = await over.boundingBox();
    await page.keyboard.down("Shift");
    await page.mouse.move(box.x + 200, box.y + 60);
    await page.mouse.down();
    await page.mouse.move(box.x + 150, box.y + 60, {steps: 3});
    await page.mouse.up();
    await page.keyboard.up("Shift");
    const [later] = await view(page);
    assert.ok(Math.abs(later - from - (to - from) * 50 / box.width) < 0.02, `${from} to ${later}`);
    const before = await page.evaluate(() => scrollY);
    await page.mouse.wheel(0, 200);
    await page.waitForFunction((y) => scrollY > y, before);
    await close(page);
  },

  async "values are read with the mouse, and are the trace's"() {
    const page = await open(bellow);
    const figure = page.locator("#plots figure").first(), over = figure.locator(".u-over"), box = await over.boundingBox();
    await page.mouse.move(box.x + box.width * 0.3, box.y + 80);
    const text = async (name) => Number((await legend(figure, name).locator("td").textContent()).replace("\u2212", "-"));
    await page.waitForFunction(() => !document.querySelector(".u-series td").textContent.includes("\u2013"));
    const t = await text("t"), x = await text("tracking");
    const rows = trace.trim().split("\r\n").slice(1).map((line) => line.split(",").map(Number));
    const after = rows.findIndex((row) => row[0] > t), [a, b] = [rows[after - 1], rows[after]];
    // The trace has no row for each of the page's times, which are the reference's as well: between two rows x is nearly
    // straight, to 3e-5 of 0.3 m, a curvature of 0.3 /s^2 over steps of 0.025 s.
    const expected = a[1] + (b[1] - a[1]) * (t - a[0]) / (b[0] - a[0]);
    assert.ok(Math.abs(x - expected) < 1e-4, `x(${t}) = ${x}, not ${expected}`);
    await close(page);
  },

  async "lanes show sides over time, merged where they change too fast, and are read by the cursor"() {
    const page = await open(report("gripper.html", join(folder, "models", "gripper.json")));
    const figure = page.locator("#lanes figure");
    assert.equal(await figure.count(), 1);
    await figure.scrollIntoViewIfNeeded();
    await figure.locator("canvas").waitFor();
    assert.ok(await inked(figure) > 100);
    const box = await figure.locator(".u-over").boundingBox();
    const sides = async (t) => {
      await page.mouse.move(box.x + box.width * t / 1.2, box.y + 20);
      return figure.locator(".u-legend td").evaluateAll((cells) => cells.slice(1).map((cell) => cell.textContent));
    };
    assert.deepEqual(await sides(0.05), ["open", "open", "apart"]);
    assert.deepEqual(await sides(0.3), ["closed", "open", "touches"]); // the object is met at 0.257 s, the valve shuts at 0.4 s
    assert.deepEqual(await sides(1.1), ["open", "closed", "apart"]);
    await picture(page, "lanes");
    await close(page);
    // 10,000 changes are one pale band: no pixel has the full colour of a side.
    const buck = join(folder, "models", "buck.json"), fast = JSON.parse(readFileSync(buck, "utf8"));
    fast.scenes = {long: {stop: 0.1, samples: 101}};
    writeFileSync(buck, JSON.stringify(fast));
    const other = await open(report("buck.html", buck));
    const lanes = other.locator("#lanes figure");
    await lanes.scrollIntoViewIfNeeded();
    await lanes.locator("canvas").waitFor();
    const full = () => lanes.locator("canvas").evaluate((canvas) => {
      const copy = document.createElement("canvas"); // it is read twice, which a canvas on the screen is not for
      [copy.width, copy.height] = [canvas.width, canvas.height];
      const context = copy.getContext("2d", {willReadFrequently: true});
      context.drawImage(canvas, 0, 0);
      const {data} = context.getImageData(0, 0, copy.width, copy.height);
      const wanted = getComputedStyle(document.documentElement).getPropertyValue("--c0").trim().slice(1).match(/../g).map((part) => parseInt(part, 16));
      let count = 0;
      for (let i = 0; i < data.length; i += 4) if (wanted.every((value, k) => Math.abs(data[i + k] - value) < 3)) ++count;
      return count;
    });
    assert.equal(await full(), 0);
    // Zoomed in to a few periods they are told apart.
    const over = await lanes.locator(".u-over").boundingBox();
    for (let i = 0; i < 2; ++i) { // to 40 us, two periods
      await other.mouse.move(over.x + over.width * 0.49, over.y + 30);
      await other.mouse.down();
      await other.mouse.move(over.x + over.width * 0.51, over.y + 30, {steps: 4});
      await other.mouse.up();
    }
    assert.ok(await full() > 100);
    await picture(other, "lanes_zoomed");
    await close(other);
  },

  async "the cursor reads every curve at one time, between the samples of each"() {
    const page = await open(bellow);
    const figure = page.locator("#plots figure").first(), box = await figure.locator(".u-over").boundingBox();
    let between = 0;
    for (let k = 1; k < 40; ++k) {
      await page.mouse.move(box.x + box.width * k / 40 + 0.3, box.y + 70);
      const wrong = await page.evaluate(() => {
        const u = window.bgsimPlots()[0], t = u.posToVal(u.cursor.left, "x");
        const shown = [...u.root.querySelectorAll(".u-legend tr")].map((row) => Number(row.querySelector("td").textContent.replace("\u2212", "-")));
        const faults = [], near = (a, b) => Math.abs(a - b) <= 1e-5 * Math.max(Math.abs(b), 1e-3); // six digits are shown
        if (!near(shown[0], t)) faults.push(`t = ${shown[0]}, not ${t}`);
        let some = 0;
        u.series.forEach((series, i) => {
          if (i === 0 || series.class) return;
          const {xs, ys} = series, after = xs.findIndex((x) => x >= t);
          if (after < 1) return;
          if (xs[after] !== t) ++some;
          const expected = ys[after - 1] + (ys[after] - ys[after - 1]) * (t - xs[after - 1]) / (xs[after] - xs[after - 1]);
          if (!near(shown[i], expected)) faults.push(`${series.label}(${t}) = ${shown[i]}, not ${expected}`);
          const dot = new DOMMatrix(getComputedStyle(series.dot).transform);
          if (series.dot.hidden || Math.abs(dot.e - u.cursor.left) > 0.5 || Math.abs(dot.f - u.valToPos(expected, "y")) > 0.5)
            faults.push(`the dot of ${series.label} stands at ${dot.e}, ${dot.f}`);
        });
        return {faults, some};
      });
      assert.deepEqual(wrong.faults, []);
      between += wrong.some;
    }
    assert.ok(between > 100); // of 39 places on eight curves, most lie between samples
    await close(page);
  },

  async "axes have units, plots follow the drawing, and a submodel's parameters are folded"() {
    const page = await open(bellow);
    await seeAll(page);
    const titles = await page.evaluate(() => window.bgsimPlots().map((u) => u.axes.map((axis, i) => axis.label(u, i).split("  ")[0])));
    for (const [time] of titles) assert.equal(time, "t (s)");
    assert.deepEqual([...new Set(titles.map((title) => title[1]))].sort(), ["J", "Pa", "m", "m^3/s"]);
    const sections = await page.locator("main > section").evaluateAll((all) => all.map((section) => section.id));
    assert.equal(sections.indexOf("outputs"), sections.indexOf("drawing") + 1);
    const folded = page.locator("#parameters details");
    assert.ok(await folded.count() >= 1);
    assert.ok(!await folded.first().evaluate((part) => part.open));
    assert.match(await folded.first().locator("summary").textContent(), /^Submodel packet: \d+ parameters?$/);
    await close(page);
  },

  async "curves, plots and the drawing are saved as files, without a network"() {
    const page = await open(bellow);
    const saved = async (button) => {
      const [download] = await Promise.all([page.waitForEvent("download"), button.click()]);
      return {name: download.suggestedFilename(), bytes: readFileSync(await download.path())};
    };
    const figure = page.locator("#plots figure").first();
    const csv = await saved(figure.getByRole("button", {name: /as CSV/}));
    assert.match(csv.name, /^bellow\..*\.csv$/);
    const lines = csv.bytes.toString().trim().split("\r\n").map((line) => line.split(","));
    assert.equal(lines[0][0], "t");
    assert.ok(lines[0].includes("tracking") && lines[0].includes("tracking ref."));
    const [curve, column] = [await page.evaluate(() => { const s = window.bgsimPlots()[0].series[1]; return {xs: [...s.xs], ys: [...s.ys], label: s.label}; }), 1];
    assert.equal(lines[0][column], curve.label);
    const rows = lines.slice(1).filter((line) => line[column] !== "");
    assert.deepEqual(rows.map((line) => Number(line[0])), curve.xs); // each sample, to the last digit
    assert.deepEqual(rows.map((line) => Number(line[column])), curve.ys);
    const png = await saved(figure.getByRole("button", {name: /as PNG/}));
    assert.equal(png.bytes.subarray(1, 4).toString(), "PNG");
    assert.ok(png.bytes.length > 10_000);
    if (pictures) writeFileSync(join(pictures, "saved.png"), png.bytes);
    const svg = await saved(page.locator("#drawing").getByRole("button", {name: "Save the drawing as SVG"}));
    assert.ok(svg.bytes.toString().startsWith("<svg") && svg.bytes.includes("data-bond="));
    await close(page);
  },

  async "any output is drawn over any other"() {
    const page = await open(bellow);
    await page.locator("#phase summary").click();
    const [up, right] = [page.getByLabel("Output upwards"), page.getByLabel("Output to the right")];
    await up.selectOption({index: 2});
    await right.selectOption({index: 0});
    const names = await up.locator("option").allTextContents();
    const svg = page.locator("#phase-plot svg");
    assert.equal(await svg.locator(".phase-curve").count(), 4); // scenes
    const texts = await svg.locator("text").allTextContents();
    assert.ok(texts.some((text) => text.startsWith(names[0])) && texts.some((text) => text.startsWith(names[2])));
    const whole = (await svg.locator(".phase-curve").first().getAttribute("d")).length;
    await page.locator("#plots .plot").first().focus();
    await page.keyboard.press("+"); // the stretch of time in view
    assert.ok((await svg.locator(".phase-curve").first().getAttribute("d")).length < 0.7 * whole);
    const [download] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", {name: "Save the phase plot as SVG"}).click()]);
    assert.ok(readFileSync(await download.path()).toString().includes("phase-curve"));
    await page.locator("#phase").scrollIntoViewIfNeeded();
    await picture(page, "phase");
    await close(page);
  },

  async "an output that is only rounding is drawn at the scale of its unit"() {
    const file = join(folder, "rounding.json");
    writeFileSync(file, JSON.stringify({
      bgsim: 1, name: "rounding", elements: {source: {kind: "Se", effort: "3*sin(t)"}, load: {kind: "R", resistance: 1}},
      bonds: [{from: "source", to: "load"}],
      outputs: {u: {value: "source.e", unit: "V"}, zero: {value: "source.e/3 - source.e*(1/3)", unit: "V"}, tiny: {value: "1e-9*cos(t)", unit: "m"}},
      scenes: {long: {stop: 10, samples: 101}},
    }));
    const page = await open(report("rounding.html", file));
    await page.locator("#toolbar select").selectOption("each output");
    await seeAll(page);
    const [zero, tiny] = await page.evaluate(() => ["zero", "tiny"].map((name) => {
      const u = window.bgsimPlots().find((plot) => plot.root.closest("figure").querySelector("figcaption").textContent.startsWith(name + " "));
      return [u.scales.y.min, u.scales.y.max];
    }));
    assert.ok(zero[0] < -2.9 && zero[1] > 2.9, `what is zero is drawn from ${zero}`);
    assert.ok(tiny[0] > -2e-9 && tiny[1] < 2e-9, `nanometres are drawn from ${tiny}`);
    await close(page);
  },

  async "curves and scenes are hidden and shown again"() {
    const page = await open(bellow);
    const figure = page.locator("#plots figure").first();
    const shown = () => page.evaluate(() => window.bgsimPlots()[0].series.slice(1).filter((s) => s.show).length);
    assert.equal(await shown(), 16); // four scenes: curve, reference and its two bounds
    await legend(figure, "tracking ref.").locator("th").click();
    assert.equal(await shown(), 13);
    await page.getByRole("button", {name: "Hide or show scene tracking"}).click();
    assert.equal(await shown(), 12);
    await page.getByRole("button", {name: "Hide or show scene tracking"}).click();
    assert.equal(await shown(), 16);
    await page.locator("#toolbar select").selectOption("each unit");
    assert.equal(await page.locator("#plots figure").count(), 3); // m, Pa, m^3/s
    await close(page);
  },

  async "everything works from the keyboard"() {
    const page = await open(bellow);
    const stop = 4 * Math.PI;
    await page.locator("#plots .plot").first().focus();
    await page.keyboard.press("+");
    let [from, to] = await view(page);
    assert.ok(Math.abs(to - from - stop / 2) < 1e-9);
    await page.keyboard.press("Shift+ArrowRight");
    assert.ok(Math.abs((await view(page))[0] - from - stop / 10) < 1e-9);
    await page.keyboard.press("ArrowRight");
    await page.keyboard.press("ArrowRight");
    await page.waitForFunction(() => !document.querySelector(".u-series td").textContent.includes("\u2013"));
    await page.keyboard.press("0");
    assert.deepEqual(await view(page), [0, stop]);
    await page.keyboard.press("Tab"); // the first curve's name
    assert.equal(await page.evaluate(() => document.activeElement.textContent), "tracking");
    await page.keyboard.press("Enter");
    assert.equal(await page.evaluate(() => document.activeElement.getAttribute("aria-pressed")), "false");
    await close(page);
  },

  async "on a phone nothing is wider than the screen, and two fingers zoom"() {
    const page = await open(bellow, {width: 390, height: 800, hasTouch: true});
    await seeAll(page);
    const [wide, screen] = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
    assert.ok(wide <= screen, `${wide} px on a screen of ${screen} px`);
    const over = page.locator("#plots .u-over").first();
    await over.evaluate((element) => {
      const {left, top} = element.getBoundingClientRect();
      const touch = (type, pointerId, x) => element.dispatchEvent(new PointerEvent(type, {pointerId, pointerType: "touch", clientX: left + x, clientY: top + 50, bubbles: true}));
      touch("pointerdown", 1, 100);
      touch("pointerdown", 2, 200);
      touch("pointermove", 1, 50);
      touch("pointermove", 2, 250);
      touch("pointerup", 1, 50);
      touch("pointerup", 2, 250);
    });
    const [from, to] = await view(page);
    assert.ok(Math.abs(to - from - 2 * Math.PI) < 0.1, `${from} to ${to}`);
    await page.locator("#outputs").scrollIntoViewIfNeeded();
    await picture(page, "phone");
    await close(page);
  },

  async "the dark is dark, and can be chosen"() {
    const page = await open(bellow, {colorScheme: "dark"});
    const brightness = () => page.evaluate(() => Number(getComputedStyle(document.body).backgroundColor.match(/\d+/)[0]));
    assert.ok(await brightness() < 60);
    await page.locator("#theme").click();
    assert.ok(await brightness() > 200);
    await page.emulateMedia({colorScheme: "light"});
    await page.locator("#theme").click();
    assert.ok(await brightness() < 60);
    await page.locator("#outputs").scrollIntoViewIfNeeded();
    await picture(page, "dark");
    await close(page);
  },

  async "it prints on paper: light, every plot, everything unfolded"() {
    const page = await open(bellow, {colorScheme: "dark"});
    await page.evaluate(() => addEventListener("beforeprint", () => { window.printed = {
      plots: window.bgsimPlots().length, theme: document.documentElement.dataset.theme,
      folded: document.querySelectorAll("#causality details:not([open])").length}; }));
    const pdf = await page.pdf({format: "A4", ...(pictures ? {path: join(pictures, "printed.pdf")} : {})});
    assert.deepEqual(await page.evaluate(() => window.printed), {plots: 13, theme: "light", folded: 0});
    assert.ok(pdf.length > 50_000);
    await page.waitForFunction(() => document.documentElement.dataset.theme === "dark");
    await close(page);
  },

  async "a million samples open at once, with their extremes"() {
    const file = join(folder, "million.json");
    writeFileSync(file, JSON.stringify({
      bgsim: 1, name: "million", parameters: {w: 100},
      elements: {source: {kind: "Se", effort: "sin(w*t) + if(t > 0.5 and t < 0.500002, 5, 0)"}, load: {kind: "R", resistance: 1}},
      bonds: [{from: "source", to: "load"}], outputs: {u: "source.e", i: "load.f"},
      scenes: {long: {stop: 1, samples: 1000001}},
    }));
    const page = await open(report("million.html", file));
    console.log(`    shown after ${page.milliseconds} ms`);
    assert.ok(page.milliseconds < 3000); // some 0.3 s on a laptop; the rest is for a busy machine
    const most = await page.evaluate(() => Math.max(...window.bgsimPlots()[0].data[1].filter((v) => v != null)));
    assert.ok(most > 4); // the one pulse of two samples
    await close(page);
  },

  async "texts of a model are texts on the page"() {
    const file = join(folder, "nasty.json"), nasty = "</script><script>alert(1)</script><img src=x onerror=alert(2)> & \"'";
    writeFileSync(file, JSON.stringify({
      bgsim: 1, name: nasty, about: nasty, source: nasty, parameters: {r: {value: 1, unit: nasty, about: nasty}},
      elements: {source: {kind: "Se", effort: "sin(t)", about: nasty}, load: {kind: "R", resistance: "r"}},
      bonds: [{from: "source", to: "load"}], outputs: {[nasty]: {value: "source.e", unit: nasty}},
      scenes: {[nasty]: {about: nasty, stop: 1, samples: 11}},
    }));
    const page = await open(report("nasty.html", file));
    assert.equal(await page.locator("h1").textContent(), nasty);
    assert.ok((await page.locator("#plots figcaption").textContent()).startsWith(nasty));
    assert.equal(await page.locator("img").count(), 0);
    await close(page);
  },
};

let failed = 0;
// The bellow with four scenes of 501 records each: what is tested here is the page.
cpSync(models, join(folder, "models"), {recursive: true});
const model = join(folder, "models", "bellow.json"), content = JSON.parse(readFileSync(model, "utf8"));
delete content.scenes.start;
for (const scene of Object.values(content.scenes)) scene.samples = 501;
writeFileSync(model, JSON.stringify(content));
const bellow = report("bellow.html", model, "--all");
execFileSync(bgsim, [model, "--scene", "tracking", "-o", join(folder, "tracking.csv"), "--keep-all", "--quiet"]);
const trace = readFileSync(join(folder, "tracking.csv"), "utf8");
for (const [name, check] of Object.entries(checks)) {
  try {
    await check();
    console.log("passed: " + name);
  } catch (error) {
    ++failed;
    console.log("FAILED: " + name + "\n" + error.stack);
  }
}
await browser.close();
rmSync(folder, {recursive: true});
console.log(`${Object.keys(checks).length - failed} passed, ${failed} failed`);
process.exitCode = failed === 0 ? 0 : 1;
