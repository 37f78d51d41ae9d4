// The plots of landmarks, of whole images and of whole runs in the workbench, drawn from sets that the program makes: what is
// painted where, and what a click chooses. `workbench_plots.test.mjs SHARE SEAM SOURCE`.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { existsSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fits, launch, openPage, skip, within } from "./browser.mjs";
import { makeFrames, makeLandmarks, makeOutcomes } from "./made_sets.mjs";
import { startProgram } from "./program.mjs";

const [share, seam, source] = process.argv.slice(2);
if (!existsSync(join(share, "workbench/index.html"))) skip(`${share}/workbench was not built`);
const shots = process.env.SEAM_SCREENSHOTS;
const limit_ms = 120_000;
const scratch = mkdtempSync(join(tmpdir(), "seam-plots-"));
const run = (words) => {
  const done = spawnSync(seam, words, { encoding: "utf8" });
  assert.equal(done.status, 0, `${words.join(" ")}: ${done.stdout}${done.stderr}`);
};

/** The share of a plot's canvas in which something is painted, in the left and the right half. */
const paintedOf = (canvas) => canvas.evaluate((element) => {
  const { width, height } = element, { data } = element.getContext("2d").getImageData(0, 0, width, height);
  const half = [0, 0];
  for (let i = 0; i < width * height; ++i) half[Number(i % width >= width / 2)] += data[4 * i + 3] > 0 ? 2 / (width * height) : 0;
  return half;
});

/** The middle of what is painted, as a share of the height. */
const middleOf = (canvas) => canvas.evaluate((element) => {
  const { width, height } = element, { data } = element.getContext("2d").getImageData(0, 0, width, height);
  let rows = 0, painted = 0;
  for (let i = 0; i < width * height; ++i) {
    if (data[4 * i + 3] === 0) continue;
    rows += Math.floor(i / width) / height;
    ++painted;
  }
  return rows / painted;
});

const pixels = (canvas) => canvas.evaluate((element) => element.toDataURL());
const figure = (page, name) => page.locator(`[data-plot="${name}"]`);
const plotsShow = (page, preview) => page.locator(`.figures[data-preview="${preview}"]`).waitFor();

async function opened(browser, set) {
  const program = await startProgram(seam, share, join(scratch, set), join(scratch, `${set}-work`));
  const { page, errors } = await openPage(browser);
  page.setDefaultTimeout(limit_ms);
  await page.emulateMedia({ colorScheme: "light", reducedMotion: "reduce" });
  await page.goto(program.address);
  await page.locator('.figures[data-version="001"]').waitFor();
  const close = async () => {
    if (shots) await page.screenshot({ path: join(shots, `plots_${set}.png`), fullPage: true });
    await fits(page, set, "light");
    assert.deepEqual(errors, [], "console");
    await page.close();
    await program.end();
  };
  return { page, close };
}

async function landmarks(browser) {
  const { page, close } = await opened(browser, "landmarks");
  const map = figure(page, "map with lines of sight"), cloud = figure(page, "along and across the line of sight");
  for (const half of await paintedOf(map.locator("canvas"))) assert.ok(half > 0.02, "rays and arrows on both sides of the map");
  assert.equal(await map.locator("svg text", { hasText: /^[0-4]$/ }).count() >= 5, true, "each landmark has its name");
  // Ranges are too long by a tenth: along the line of sight all residuals lie above zero.
  const high = await middleOf(cloud.locator("canvas"));
  assert.ok(high < 0.3, `the middle of the cloud is at ${high}, far above zero`);
  const bars = figure(page, "error by landmark"), before = await pixels(cloud.locator("canvas"));
  const box = await bars.locator("svg").boundingBox();
  await bars.locator("svg").click({ position: { x: box.width / 2, y: box.height - 60 } });
  await page.getByRole("heading", { name: /rows chosen/ }).waitFor();
  await page.getByText(/^landmark [0-4]$/).waitFor();
  await within("the rows of one landmark are marked in the cloud", async () => await pixels(cloud.locator("canvas")) !== before, limit_ms);
  await page.locator("#candidate-range_scale").click();
  await plotsShow(page, "With range_scale");
  // Both clouds are painted, the preview's about zero.
  const both = await middleOf(cloud.locator("canvas"));
  assert.ok(both > high + 0.05, `with the cause the middle goes from ${high} to ${both}`);
  await close();
}

async function frames(browser) {
  const { page, close } = await opened(browser, "frames");
  const strip = page.getByRole("group", { name: "Frames" }).getByRole("button");
  await strip.first().waitFor();
  assert.equal(await strip.count(), 4);
  const of = (label) => page.getByRole("img", { name: label, exact: true });
  await page.locator(".frames figcaption", { hasText: "Orange is brighter" }).waitFor(); // It is painted last.
  const [measured, predicted] = await Promise.all(["measured", "predicted"].map((label) => pixels(of(label))));
  assert.notEqual(measured, predicted, "noise and a cause lie between them");
  await strip.last().click();
  await within("another frame is shown", async () => await pixels(of("measured")) !== measured, limit_ms);
  assert.equal(await strip.last().getAttribute("aria-pressed"), "true");
  await close();
}

async function outcomes(browser) {
  const { page, close } = await opened(browser, "outcomes");
  const seen = figure(page, "predicted and seen"), runs = figure(page, "distribution of runs");
  const dots = (k) => seen.locator('[data-mark="dot"]').nth(k).locator("circle").evaluateAll((all) => all.map((dot) => Number(dot.getAttribute("cx"))));
  const off = (some, others) => some.reduce((sum, x, i) => sum + Math.abs(x - others[i]), 0);
  const before = off(await dots(0), await dots(1));
  assert.equal((await dots(0)).length, 8, "each number");
  await runs.locator('[data-mark="rect"] rect').first().waitFor();
  // A fit makes some hundred runs of the simulator.
  await page.locator("#candidate-focal_length_error").click({ timeout: 3 * limit_ms });
  await page.locator('.figures[data-preview="With focal_length_error"]').waitFor({ timeout: 3 * limit_ms });
  await within("the preview's runs are drawn", async () => await runs.locator('[data-mark="rect"]').count() === 2, limit_ms);
  const after = off(await dots(0), await dots(2));
  assert.ok(after < 0.5 * before, `with the cause the numbers go from ${before} to ${after} px off`);
  await seen.getByRole("group").focus();
  await page.keyboard.press("ArrowDown");
  await page.keyboard.press("Enter");
  await page.getByRole("heading", { name: "1 row chosen" }).waitFor();
  await close();
}

const browser = await launch();
try {
  makeLandmarks(join(scratch, "landmarks"), run);
  makeFrames(join(scratch, "frames"), run);
  makeOutcomes(join(scratch, "outcomes"), source, run);
  await landmarks(browser);
  await frames(browser);
  await outcomes(browser);
} finally {
  await browser.close();
  rmSync(scratch, { recursive: true, force: true });
}
process.exit(0);
