// node web/workbench_pictures.mjs SHARE SEAM SOURCE OUT: the pictures of the workbench in docs/images, each screen of sets that the
// program makes.
import { spawnSync } from "node:child_process";
import { mkdirSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { launch, openPage, settled } from "./tests/browser.mjs";
import { makeFrames, makeOutcomes, makeRoom, samples, titles } from "./tests/made_sets.mjs";
import { startProgram } from "./tests/program.mjs";

const [share, program, folder, out] = process.argv.slice(2);
if (!out) {
  console.error("usage: node web/workbench_pictures.mjs SHARE SEAM SOURCE OUT");
  process.exit(2);
}
const seam = resolve(program), source = resolve(folder), scratch = join(tmpdir(), "workbench"); // Its name is in the pictures.
const limit_ms = 600_000, wide = { width: 1280, height: 800 }, narrow = { width: 390, height: 844 };
mkdirSync(out, { recursive: true });
mkdirSync(scratch); // It must not be there: it is removed in the end.
const run = (words) => {
  const done = spawnSync(seam, words, { encoding: "utf8" });
  if (done.status !== 0) throw new Error(done.stderr);
};

const toScreen = (page, name) => page.getByRole("navigation").getByRole("button", { name, exact: true }).click();
const plotsShow = (page, preview) => page.locator(`.figures[data-preview="${preview}"]`).waitFor();

async function shot(page, name) {
  await page.locator(".toast").waitFor({ state: "detached" });
  await page.locator(".saved", { hasText: /^saved$/ }).waitFor();
  await page.mouse.move(640, 4);
  await settled(page);
  await page.screenshot({ path: join(out, `workbench_${name}.png`) });
  console.log(name);
}

async function preview(page, effect) {
  await page.locator(`#candidate-${effect}`).waitFor({ state: "attached" });
  await page.locator("[role=listbox]").focus();
  await page.locator(`#candidate-${effect}`).evaluate((option) => option.click());
  await page.locator(".context.previewing[data-how=fit]").waitFor();
  await plotsShow(page, `With ${effect}`);
}

const toTop = (page) => page.evaluate(() => {
  scrollTo(0, 0);
  document.querySelector(".side-body").scrollTo(0, 0);
});
const add = (page) => page.locator(".context.previewing").getByRole("button", { name: /Add/ }).click();
const version = (page, id) => page.locator(`.figures[data-version="${id}"]`).waitFor();

/** The room: Work as it is and dark and narrow, then a step, a branch and a note for the other screens. */
async function room(page) {
  await version(page, "001");
  await preview(page, "rolling_shutter");
  await toTop(page);
  await shot(page, "work");
  await page.emulateMedia({ colorScheme: "dark" });
  await shot(page, "dark");
  await page.setViewportSize(narrow);
  await page.emulateMedia({ colorScheme: "light" });
  await toTop(page);
  await shot(page, "narrow");
  await page.setViewportSize(wide);
  await add(page);
  await version(page, "002");
  await toScreen(page, "Data");
  await shot(page, "data");
  await toScreen(page, "Formula");
  await page.locator(".cm-content").waitFor();
  await page.getByText("The formula can be read").waitFor();
  await shot(page, "formula");
  await toScreen(page, "See it");
  await page.locator(".frames[data-quality=fine]").waitFor();
  await shot(page, "see");
  await toScreen(page, "Plan");
  for (const name of ["rolling_shutter", "frame_latency", "exposure"]) await page.getByLabel(name, { exact: true }).check();
  await page.getByRole("button", { name: "Compute" }).click();
  await page.locator(".plan-screen table.data").first().waitFor();
  await shot(page, "plan");
  await page.getByRole("button", { name: "Undo" }).click();
  await toScreen(page, "Work");
  await version(page, "001");
  await preview(page, "frame_latency");
  await add(page);
  await version(page, "003");
  await toScreen(page, "Session");
  await page.getByLabel("Note on version 002").fill("the rows are read one after another");
  await page.locator("h1").click();
  await shot(page, "session");
}

async function open(page) {
  await page.locator(".brand").click();
  await shot(page, "open");
  await page.locator('input[type=file]:not([webkitdirectory])').setInputFiles([0, 1, 2, 3].map((k) => join(scratch, `frames/frames/${k}.png`)));
  await page.getByRole("form", { name: "Import" }).getByRole("alert").waitFor();
  await shot(page, "import");
}

async function sample(page, name, picture) {
  await page.locator(".brand").click();
  await page.getByRole("button", { name: titles[name] }).first().click();
  await version(page, "001");
  await preview(page, samples[name]);
  await page.locator(".figures").evaluate((figures) => figures.children[1].scrollIntoView({ block: "start" }));
  await page.evaluate(() => scrollBy(0, -document.querySelector(".context").offsetHeight - 60)); // Beneath what stays at the top.
  await shot(page, picture);
}

async function ofSet(browser, set, effect, picture) {
  const server = await startProgram(seam, share, join(scratch, set), join(scratch, `${set}-work`));
  const { page } = await openPage(browser, wide);
  page.setDefaultTimeout(limit_ms);
  await page.emulateMedia({ colorScheme: "light", reducedMotion: "reduce" });
  await page.goto(server.address);
  await version(page, "001");
  await preview(page, effect);
  await toTop(page);
  await page.waitForTimeout(5000); // Frames and runs of the preview come after its residuals.
  await shot(page, picture);
  await page.close();
  await server.end();
}

makeRoom(join(scratch, "recording"), source, run);
makeFrames(join(scratch, "frames"), run);
makeOutcomes(join(scratch, "outcomes"), source, run);
const browser = await launch();
try {
  const server = await startProgram(seam, share, join(scratch, "recording"), join(scratch, "work"));
  const { page } = await openPage(browser, wide);
  page.setDefaultTimeout(limit_ms);
  await page.emulateMedia({ colorScheme: "light", reducedMotion: "reduce" });
  await page.goto(server.address);
  await room(page);
  await open(page);
  for (const [name, picture] of [["servo", "servo"], ["walk", "walk"], ["flats", "flats"]]) await sample(page, name, picture);
  await page.close();
  await server.end();
  await ofSet(browser, "frames", "vignetting", "frames");
  await ofSet(browser, "outcomes", "focal_length_error", "outcomes");
} finally {
  await browser.close();
  rmSync(scratch, { recursive: true, force: true });
}
process.exit(0);
