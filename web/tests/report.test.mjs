// The report opens offline without a word on the console, and each of its plots is drawn; on a wide page and a telephone's, light
// and dark, without scrolling sideways and without faint text.
// `report.test.mjs SHARE [PAGE.html...]`: pages given are opened instead of those made here.
import assert from "node:assert/strict";
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, join } from "node:path";
import { pathToFileURL } from "node:url";
import { faintTexts, launch, openPage, skip } from "./browser.mjs";
import { fixtures } from "./report_fixtures.mjs";

const [share, ...given] = process.argv.slice(2);
const shots = process.env.SEAM_SCREENSHOTS;
const folder = mkdtempSync(join(tmpdir(), "seam-report-"));

/** What `write_report` does, so that the page can be tested without the command. */
function fill(template, document) {
  const json = JSON.stringify(document).replaceAll("</", "<\\/");
  return template.replace("__SEAM_REPORT_DATA__", () => json);
}

function pagesMadeHere() {
  const path = join(share, "report.html");
  if (!existsSync(path)) skip(`${path} was not built`);
  const template = readFileSync(path, "utf8");
  assert.equal(template.split("__SEAM_REPORT_DATA__").length, 2, "the marker stands once");
  return Object.entries(fixtures).map(([name, make]) => {
    const file = join(folder, `${name}.html`);
    writeFileSync(file, fill(template, make()));
    return file;
  });
}

/** What a page may not say, and what it says once. */
async function checkWords(page, file) {
  const text = await page.locator("main").innerText();
  for (const word of ["NaN", "undefined", "[object", "Infinity", "± 0.0000000"]) {
    assert.ok(!text.includes(word), `${file}: the page says "${word}"`);
  }
  const result = JSON.parse(await page.locator("#data").textContent()).result;
  if (result.headline) assert.ok(text.includes(result.headline), `${file}: the command's first line is not on the page`);
  for (const doubt of result.doubts ?? []) assert.ok(text.includes(doubt.trim()), `${file}: not on the page: ${doubt}`);
  if (result.suggestion) {
    const shown = await page.locator("#formula").innerText();
    for (const part of [result.suggestion.formula, "seam add NAME.yaml", ...result.suggestion.beside])
      assert.ok(shown.includes(part), `${file}: the formula's place does not have ${part}`);
  }
  // On a narrow page each row is a card, which says all of its own.
  for (const table of page.viewportSize().width > 620 ? await page.locator("table.data").all() : []) {
    const cut = (await table.locator("tbody tr:not(.heading)").allInnerTexts()).map((row) => row.includes("< 10"));
    assert.ok(!cut.some((now, i) => now && cut[i - 1]), `${file}: rows on end say that p is below 1e-300`);
  }
}

async function checkPage(browser, file, width, colorScheme) {
  const { page, errors } = await openPage(browser, { width, height: 844 });
  await page.emulateMedia({ colorScheme });
  await page.route(/^https?:/, (route) => {
    errors.push(`asked for ${route.request().url()}`);
    return route.abort();
  });
  await page.goto(pathToFileURL(file).href);
  const plots = page.locator("[data-plot]");
  await page.locator("h1").waitFor();
  const wanted = await plots.count();
  await page.waitForFunction((n) => document.querySelectorAll("[data-drawn=true]").length === n, wanted,
    { timeout: 5000 }).catch(() => undefined);
  for (let i = 0; i < wanted; ++i) {
    const plot = plots.nth(i);
    const name = await plot.getAttribute("data-plot");
    const marks = await plot.locator("svg :is(circle, path, line, rect)").count();
    assert.ok(marks >= 3, `${file}: plot "${name}" has ${marks} marks`);
    const box = await plot.locator("svg").last().boundingBox();
    assert.ok(box && box.width > 200 && box.height > 60, `${file}: plot "${name}" has no size`);
    const sentence = await plot.locator("figcaption").innerText();
    assert.ok(sentence.length > 30, `${file}: plot "${name}" says nothing`);
  }
  await checkWords(page, file);
  // What is significant but does not matter is named in one line, and unfolds.
  const traces = page.locator("details.traces");
  if (await traces.count() > 0) {
    const named = await traces.locator("summary").innerText();
    assert.match(named, /^(one trace|\d+ traces): significant, but below [0-9.]+ of the noise$/, file);
    await traces.locator("summary").click();
    assert.ok((await traces.locator("code, td").count()) > 0, `${file}: traces are empty`);
  }
  const overflow = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  assert.ok(overflow <= 0, `${file}: ${overflow} px wider than the window of ${width} px`);
  assert.deepEqual(await page.evaluate(faintTexts), [], `${file}: faint texts, ${colorScheme}`);
  if (shots) {
    const name = `${basename(file, ".html")}_${width}_${colorScheme}.png`;
    await page.screenshot({ path: join(shots, name), fullPage: true });
  }
  assert.deepEqual(errors, [], `${file}: console`);
  await page.close();
  return wanted;
}

/** What is said of one model's residuals stands beside its own figures alone; drawings fit what they show. */
async function checkMeaning(browser) {
  const { page } = await openPage(browser);
  await page.goto(pathToFileURL(join(folder, "diagnosePoints.html")).href);
  const caption = (name) => page.locator(`[data-plot="${name}"] figcaption`).innerText();
  const own = await caption("residual v_px against column mean");
  assert.match(own, /is the root mean square of the means along column\..* 0\.018\d? px are left, still more than noise/);
  assert.doesNotMatch(own, /follows column/);
  assert.match(await caption("residual u_px against row*pan_rate mean"), /px, .*times the noise .* follows row × pan rate/);
  const plot = (name) => page.locator(`[data-plot="${name}"]`);
  assert.match(await plot("residual u_px against row spread").locator("h3").innerText(), /^spread of the u residual/);
  assert.match(await plot("residual u_px against row*pan_rate mean").locator("svg").innerHTML(), /\(px rad\/s\)/);
  // Nothing lies between the signs: no line joins their means.
  const signs = plot("residual u_px against sign(pan_rate) mean");
  assert.equal(await signs.locator("[data-mark=line] path, [data-mark=area] path").count(), 0);
  // A map of last digits is not in full colour.
  const fills = await plot("lens Standard error").locator("[data-mark=rect] rect").evaluateAll(
    (cells) => new Set(cells.map((cell) => cell.getAttribute("fill"))).size);
  assert.equal(fills, 1);
  assert.match(await caption("lens Standard error"), /below 0\.001 px everywhere/);
  // What an effect is worth agrees with the verdict although the error falls without it; labels are outside of bars.
  const worth = plot("leave one effect out");
  assert.match(await caption("leave one effect out"), /rolling shutter is worth most\. Worth nothing .*: frame latency\./);
  const inside = await worth.locator("svg").evaluate((svg) => {
    const bars = [...svg.querySelectorAll("[data-mark=bar] rect")].map((bar) => bar.getBoundingClientRect());
    return [...svg.querySelectorAll("[data-mark=text] text")].map((text) => text.getBoundingClientRect())
      .filter((text) => bars.some((bar) => text.left < bar.right - 1 && text.right > bar.left + 1
        && text.top < bar.bottom && text.bottom > bar.top)).length;
  });
  assert.equal(inside, 0, "labels in bars");
  const text = await page.locator("main").innerText();
  assert.match(text, /points\s+8 000\s+200 groups/);
  assert.match(text, /with rolling_shutter, lens_blur/);
  const headings = await page.locator("table.candidates tr.heading").allInnerTexts();
  assert.match(headings[0], /Effects of the model found, in the order of its steps/);
  assert.match(headings[1], /Others that help alone, by the log-likelihood/);
  assert.match(await page.locator("#outliers").innerText(), /5210 to 5269\s+60\s+u −65\.4 px/);
  assert.equal((await page.locator("#outliers").innerText()).split("points.csv").length, 2, "the file is named once");
  await page.close();
}

/** The heading over the structure speaks of effects found only where there are some. */
async function checkHeading(browser) {
  const { page } = await openPage(browser);
  const template = readFileSync(join(share, "report.html"), "utf8");
  const file = join(folder, "heading.html");
  for (const [steps, heading] of [[[], "Where the model fails"],
    [[{ effect: "rolling_shutter", error_after: 1 }], "What the effects found leave"]]) {
    const report = fixtures.diagnosePoints();
    report.result = { ...report.result, structure_of: "explanation", explanation: { steps, error: 1 } };
    writeFileSync(file, fill(template, report));
    await page.goto(pathToFileURL(file).href);
    assert.equal(await page.locator("#structure h2").innerText(), heading);
  }
  await page.close();
}

/** What was looked for in vain is folded up; on a narrow page, whose rows are cards, no p is a ditto mark and no cell blank. */
async function checkCards(browser) {
  const { page } = await openPage(browser, { width: 390, height: 800 });
  const report = fixtures.diagnosePoints(), file = join(folder, "cards.html");
  const look = (of, outcome, why) => ({ what: "smooth function", of, outcome, why });
  report.result.looked_for = [look(["row"], "nothing", "log-evidence -4"), look(["time"], "found", "log-evidence +90"),
    look([], "not tested", "")];
  for (const item of report.result.structure.slice(0, 2)) item.p_value = 1e-300;
  writeFileSync(file, fill(readFileSync(join(share, "report.html"), "utf8"), report));
  await page.goto(pathToFileURL(file).href);
  const text = await page.locator("#looked-for").innerText();
  assert.match(text, /time[^]*found[^]*1 without result/);
  assert.doesNotMatch(text, /nothing/);
  assert.equal(await page.locator("#looked-for td:visible").count(), 6, "a blank cell has no line");
  assert.match((await page.locator("table.structure tbody tr").allInnerTexts())[1], /< 10/);
  await page.setViewportSize({ width: 1280, height: 800 });
  assert.match((await page.locator("table.structure tbody tr").allInnerTexts())[1], /″$/);
  await page.close();
}

/** The template alone, or a page that was cut, says so instead of staying white. */
async function checkBroken(browser) {
  const { page, errors } = await openPage(browser);
  await page.goto(pathToFileURL(join(share, "report.html")).href);
  assert.match(await page.locator("#app").innerText(), /holds no readable report data/);
  const report = fixtures.diagnosePoints(), file = join(folder, "damaged.html");
  report.result.looked_for = "what?";
  writeFileSync(file, fill(readFileSync(join(share, "report.html"), "utf8"), report));
  await page.goto(pathToFileURL(file).href);
  assert.match(await page.locator("#app").innerText(), /data is not of the form/);
  assert.deepEqual(errors, []);
  await page.close();
}

const browser = await launch();
try {
  const files = given.length > 0 ? given : pagesMadeHere();
  for (const file of files) {
    for (const [width, scheme] of [[1280, "light"], [1280, "dark"], [390, "light"], [390, "dark"]]) {
      const drawn = await checkPage(browser, file, width, scheme);
      console.log(`${file}, ${width} px, ${scheme}: ${drawn} plots drawn`);
    }
  }
  if (given.length === 0) await checkMeaning(browser);
  if (given.length === 0) await checkHeading(browser);
  if (given.length === 0) await checkCards(browser);
  if (given.length === 0) await checkBroken(browser);
} finally {
  await browser.close();
  rmSync(folder, { recursive: true, force: true });
}
