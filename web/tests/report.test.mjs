// The report opens offline without a word on the console, and each of its plots is drawn.
// `report.test.mjs SHARE [PAGE.html...]`: pages given are opened instead of those made here.
import assert from "node:assert/strict";
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { launch, openPage, skip } from "./browser.mjs";
import { fixtures } from "./report_fixtures.mjs";

const [share, ...given] = process.argv.slice(2);
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

async function checkPage(browser, file) {
  const { page, errors } = await openPage(browser);
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
  const text = await page.locator("main").innerText();
  for (const word of ["NaN", "undefined", "[object", "Infinity"]) {
    assert.ok(!text.includes(word), `${file}: the page says "${word}"`);
  }
  // What is significant but does not matter is named in one line, and unfolds.
  const traces = page.locator("details.traces");
  if (await traces.count() > 0) {
    const named = await traces.locator("summary").innerText();
    assert.match(named, /^(one trace|\d+ traces): significant, but below [0-9.]+ of the noise$/, file);
    await traces.locator("summary").click();
    assert.ok((await traces.locator("code, td").count()) > 0, `${file}: traces are empty`);
  }
  const overflow = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  assert.ok(overflow <= 0, `${file}: ${overflow} px wider than the window`);
  assert.deepEqual(errors, [], `${file}: console`);
  await page.close();
  return wanted;
}

/** The template alone, or a page that was cut, says so instead of staying white. */
async function checkBroken(browser) {
  const { page, errors } = await openPage(browser);
  await page.goto(pathToFileURL(join(share, "report.html")).href);
  assert.match(await page.locator("#app").innerText(), /holds no readable report data/);
  assert.deepEqual(errors, []);
  await page.close();
}

const browser = await launch();
try {
  const files = given.length > 0 ? given : pagesMadeHere();
  for (const file of files) console.log(`${file}: ${await checkPage(browser, file)} plots drawn`);
  if (given.length === 0) await checkBroken(browser);
} finally {
  await browser.close();
  rmSync(folder, { recursive: true, force: true });
}
