// A person's whole journey through the program itself, `seam workbench`: from the misfit to a model, on a wide page and on a
// narrow one; then the other kinds of measurements in short. `workbench_real.test.mjs SHARE SEAM SOURCE`.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { existsSync, mkdirSync, mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fits, launch, openPage, skip, until, within } from "./browser.mjs";
import { makeRoom, samples, titles } from "./made_sets.mjs";
import { startProgram } from "./program.mjs";

const [share, seam, source] = process.argv.slice(2);
if (!existsSync(join(share, "workbench/index.html"))) skip(`${share}/workbench was not built`);
const shots = process.env.SEAM_SCREENSHOTS;
const limit_ms = 120_000;
const scratch = mkdtempSync(join(tmpdir(), "seam-workbench-"));

function run(program, words, environment = {}) {
  const done = spawnSync(program, words, { cwd: scratch, encoding: "utf8", env: { ...process.env, ...environment } });
  assert.equal(done.status, 0, `${program} ${words.join(" ")}: ${done.stdout}${done.stderr}`);
}

const option = (page, name) => page.locator(`#candidate-${name}`);
const saved = (session) => JSON.parse(readFileSync(join(session, "session.json"), "utf8"));
const toScreen = (page, name) => page.getByRole("navigation").getByRole("button", { name, exact: true }).click();
const error = async (page) => Number(await page.locator(".figure-of-merit b").first().innerText());
const shot = async (page, name) => shots && page.screenshot({ path: join(shots, `real_${name}_${page.viewportSize().width}.png`) });

/** Until the page shows a version with its error and its plots. */
async function shows(page, id) {
  await page.locator(`.figures[data-version="${id}"]`).waitFor({ timeout: limit_ms });
  await until(page, () => Number.isFinite(parseFloat(document.querySelector(".figure-of-merit b")?.textContent)), undefined, limit_ms);
}

const plotsShow = (page, preview) => page.locator(`.figures[data-preview="${preview}"]`).waitFor({ timeout: limit_ms });

/** Points at a candidate as the size of the page wants it, until its residuals are in the plots. */
async function preview(page, name) {
  await option(page, name).waitFor({ state: "attached", timeout: limit_ms });
  const narrow = page.viewportSize().width < 700;
  if (narrow) await page.getByRole("button", { name: /Structure and candidates/ }).click();
  await option(page, name).click();
  await page.locator(`.context.previewing[data-preview="${name}"]:is([data-how=fit], [data-how=linear])`).waitFor({ timeout: limit_ms });
  await plotsShow(page, `With ${name}`);
}

const add = (page) => page.locator(".context.previewing").getByRole("button", { name: /Add/ }).click();

async function downloaded(page, label) {
  const waiting = page.waitForEvent("download");
  await page.getByRole("link", { name: label, exact: true }).click();
  return readFileSync(await (await waiting).path());
}

/** Structure, preview, add, undo, branch. */
async function findTheCause(page, session) {
  await shows(page, "001");
  const first = await error(page);
  assert.ok(first > 2, `the error without the effect: ${first}`);
  await until(page, () => document.querySelector("[aria-label=Covariate]")?.value === "row*pan_rate");
  await preview(page, "rolling_shutter");
  assert.ok(Math.abs(Number(await page.locator(".error-line").getAttribute("data-ghost")) - 1) < 0.1, "the preview's error");
  await shot(page, "preview");
  await add(page);
  await shows(page, "002");
  assert.ok(Math.abs(await error(page) - 1) < 0.05, `the error with the effect: ${await error(page)}`);
  await page.getByRole("button", { name: "Undo" }).click();
  await shows(page, "001");
  assert.equal(await error(page), first);
  await preview(page, "frame_latency");
  await add(page);
  await shows(page, "003");
  assert.deepEqual(saved(session).versions.map((one) => one.parent), ["", "001", "001"]);
  return first;
}

/** Back to the better branch, without rows that lie far off, with a reason and a note. */
async function leaveRowsOut(page) {
  await toScreen(page, "Session");
  await page.locator(".tree .node", { hasText: "rolling_shutter" }).getByRole("button", { name: "Go there" }).click();
  await toScreen(page, "Work");
  await shows(page, "002");
  await page.getByLabel("Choose rows by a rule").selectOption("3");
  await page.getByRole("heading", { name: /rows chosen/ }).waitFor();
  await page.getByRole("button", { name: "Leave out …" }).click();
  await page.keyboard.type("blurred by hand");
  await page.keyboard.press("Enter");
  await shows(page, "004");
  assert.match(await page.locator(".left-out").innerText(), /blurred by hand/);
  await shot(page, "left_out");
}

/** A picture of each screen. */
async function screens(page) {
  for (const name of ["Data", "Formula", "Plan", "Session", "Open", "Work"]) {
    if (name === "Open") await page.locator(".brand").click();
    else await toScreen(page, name);
    assert.equal(await page.evaluate(() => scrollY), 0, `${name} begins at its top`);
    await page.locator(".toast").waitFor({ state: "detached" });
    await page.waitForTimeout(600);
    assert.equal(await page.evaluate(() => location.hash), `#${name.toLowerCase()}`, "events leave the screen as it is");
    await shot(page, name.toLowerCase());
  }
}

async function exportAndReload(page, session) {
  await toScreen(page, "Session");
  await page.getByLabel("Note on version 004").fill("for the paper");
  await page.locator("h1").click();
  await within("the note is saved", () => saved(session).versions[3].note !== "", limit_ms);
  const kept = saved(session);
  const effectsOf = (model) => model.toString().match(/^  \w+:/gm);
  assert.deepEqual(effectsOf(await downloaded(page, "Model")), effectsOf(readFileSync(join(session, "versions/004.yaml"))));
  await page.reload();
  await page.locator("pre.script").waitFor();
  assert.equal(await page.getByLabel("Note on version 004").inputValue(), "for the paper");
  assert.equal(await page.locator(".tree li").count(), 4);
  assert.deepEqual(saved(session), kept, "a reload changes nothing");
  await shot(page, "session");
}

/** What "copy as script" puts into the clipboard makes the same files. */
async function repeat(page, session) {
  await page.context().grantPermissions(["clipboard-read", "clipboard-write"]);
  await page.getByRole("button", { name: "Copy as script" }).click();
  const clipboard = () => page.evaluate(() => navigator.clipboard.readText());
  await within("the script is in the clipboard", async () => (await clipboard()).startsWith("#!/bin/sh"), limit_ms);
  writeFileSync(`${session}.sh`, await clipboard());
  const again = `${session}-again`;
  run("sh", [`${session}.sh`, again], { SEAM: seam });
  const models = readdirSync(join(session, "versions")).sort();
  assert.deepEqual(readdirSync(join(again, "versions")).sort(), models);
  for (const name of ["left-out.csv", ...models.map((model) => `versions/${model}`)])
    assert.deepEqual(readFileSync(join(again, name)), readFileSync(join(session, name)), name);
}

/** Plots of each kind beside those that all have. */
const plotsOf = {
  servo: [/command and answer/, /phase plane/], flats: [/light levels/, /photon transfer/],
  walk: [/from above/, /drift of the free prediction/],
};

/** Tab, as often as it takes, until what has the focus fits; where that is so from the start, none. */
async function tabTo(page, wanted, most = 80) {
  for (let i = 0; i < most; ++i) {
    const text = await page.evaluate(() => {
      const at = document.activeElement;
      return at === document.body ? "" : `${at?.getAttribute("role") ?? ""} ${at?.getAttribute("aria-label") ?? ""} ${at?.textContent ?? ""}`;
    });
    if (wanted.test(text)) return;
    await page.keyboard.press("Tab");
  }
  throw new Error(`the keyboard does not reach ${wanted}`);
}

/** By arrow keys to a candidate; the list may change its order meanwhile, as fits come. */
async function arrowTo(page, id, most = 80) {
  for (let i = 0; i < most; ++i) {
    const by = await page.evaluate((wanted) => {
      const all = [...document.querySelectorAll("[role=option]")].map((one) => one.id);
      const now = document.querySelector("[role=listbox]").getAttribute("aria-activedescendant");
      return now === wanted ? 0 : now === null ? 1 : Math.sign(all.indexOf(wanted) - all.indexOf(now));
    }, id);
    if (by === 0) return;
    await page.keyboard.press(by > 0 ? "ArrowDown" : "ArrowUp");
  }
  throw new Error(`arrow keys do not reach ${id}`);
}

/** Another kind of measurement in short, by the keyboard alone: the cause is a candidate, and with it the error falls. */
async function inShort(page, name) {
  await page.emulateMedia({ colorScheme: "light", reducedMotion: "reduce" });
  await page.locator(".brand").focus();
  await page.keyboard.press("Enter");
  await tabTo(page, titles[name]);
  await page.keyboard.press("Enter");
  await page.locator(".work").waitFor();
  await shows(page, "001");
  const first = await error(page);
  for (const plot of plotsOf[name]) await page.locator(".figures").getByRole("heading", { name: plot }).first().waitFor();
  await option(page, samples[name]).waitFor({ state: "attached", timeout: limit_ms });
  if (page.viewportSize().width < 700) {
    await tabTo(page, /Structure and candidates/);
    await page.keyboard.press("Enter");
  }
  await tabTo(page, /^listbox/);
  await arrowTo(page, `candidate-${samples[name]}`);
  await page.locator(`.context.previewing[data-preview="${samples[name]}"]:is([data-how=fit], [data-how=linear])`).waitFor({ state: "attached" });
  await plotsShow(page, `With ${samples[name]}`);
  await shot(page, name);
  await page.keyboard.press("Enter");
  await shows(page, "002");
  const second = await error(page);
  assert.ok(first > 1.2 && second < 0.7 * first, `${name}: the error goes from ${first} to ${second}`);
  for (const colorScheme of ["light", "dark"]) {
    await page.emulateMedia({ colorScheme, reducedMotion: "reduce" });
    await fits(page, `${name}, ${page.viewportSize().width} px`, colorScheme);
    await shot(page, `${name}_${colorScheme}`);
  }
  await page.reload();
  await shows(page, "002");
  assert.equal(await error(page), second);
}

/** The frames of the model that rolling_shutter came from, and with it; a slider moves them. */
async function seeIt(page) {
  await toScreen(page, "See it");
  const frames = page.locator(".frames");
  await page.locator(".frames[data-quality=fine]").waitFor();
  const difference = () => page.locator(".frame canvas").last().evaluate((canvas) => canvas.toDataURL());
  assert.equal(await page.getByLabel("Version before").inputValue(), "001");
  await page.locator(".toast").waitFor({ state: "detached" });
  const turning = await difference();
  await shot(page, "see_it");
  await page.getByLabel("head speed").focus();
  // The coarse frame may be gone before a locator looks again, so each that comes is counted.
  await frames.evaluate((element) => {
    window.coarse_ms = [];
    new MutationObserver(() => {
      if (element.dataset.quality === "coarse") window.coarse_ms.push(Number(element.dataset.tookMs));
    }).observe(element, { attributeFilter: ["data-quality"] });
  });
  for (let i = 1; i <= 5; ++i) {
    await page.keyboard.press("ArrowLeft");
    await until(page, (least) => window.coarse_ms.length >= least, i);
    await page.locator(".frames[data-quality=fine]").waitFor();
  }
  const times = await page.evaluate(() => window.coarse_ms);
  console.log(`a slider's frames: ${times.join(", ")} ms`);
  await until(page, () => document.querySelector(".frames").dataset.quality === "fine");
  assert.notEqual(await difference(), turning, "the frames follow the slider");
  await fits(page, `See it, ${page.viewportSize().width} px`, "light");
  if (page.viewportSize().width > 560) return;
  for (const name of ["before", "difference", "after"]) {
    await page.getByRole("group", { name: "Picture" }).getByRole("button", { name }).click();
    const widths = await page.locator(".frame canvas").evaluateAll((all) => all.map((one) => one.clientWidth).filter((width) => width > 0));
    assert.equal(widths.length, 1, "one picture at a time");
    assert.ok(widths[0] > 300, `${name} is ${widths[0]} px wide`);
    await shot(page, `see_${name}`);
  }
}

async function journey(browser, size) {
  const session = join(scratch, `${size.width}`, "work"); // Samples are made beside it.
  mkdirSync(join(scratch, `${size.width}`));
  const server = await startProgram(seam, share, join(scratch, "camera"), session);
  const { page, errors } = await openPage(browser, size);
  try {
    page.setDefaultTimeout(limit_ms);
    await page.emulateMedia({ colorScheme: "light", reducedMotion: "reduce" });
    await page.goto(server.address);
    await findTheCause(page, session);
    await leaveRowsOut(page);
    await screens(page);
    await exportAndReload(page, session);
    await repeat(page, session);
    await seeIt(page);
    for (const name of Object.keys(plotsOf)) await inShort(page, name);
    assert.deepEqual(errors, [], "console");
  } catch (failed) {
    await shot(page, "failed");
    throw failed;
  } finally {
    await page.close();
    await server.end();
  }
}

const browser = await launch();
try {
  makeRoom(join(scratch, "camera"), source, (words) => run(seam, words));
  for (const size of [{ width: 1280, height: 800 }, { width: 390, height: 844 }]) {
    const from = performance.now();
    await journey(browser, size);
    console.log(`${size.width} px: ${((performance.now() - from) / 1000).toFixed(1)} s`);
  }
} finally {
  await browser.close();
  rmSync(scratch, { recursive: true, force: true });
}
process.exit(0);
