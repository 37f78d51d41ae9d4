// The workbench, driven as a person would, against a made session: preview, add, undo, branch, formula, leave out with a reason,
// reload; with the mouse, on a narrow page, and by the keyboard alone. Each screen is looked at light and dark, wide and narrow.
// `workbench.test.mjs SHARE`.
import assert from "node:assert/strict";
import { existsSync } from "node:fs";
import { join } from "node:path";
import { fits, launch, openPage, settled, skip, until, within } from "./browser.mjs";
import { MockSession, serve } from "./mock_workbench.mjs";

const share = process.argv[2];
if (!existsSync(join(share, "workbench/index.html"))) skip(`${share}/workbench was not built`);
const shots = process.env.SEAM_SCREENSHOTS;
const screens = ["Data", "Work", "Formula", "See it", "Plan", "Session"];
const wide = { width: 1280, height: 800 }, narrow = { width: 390, height: 844 };

async function opened(browser, server, size, colorScheme = "light") {
  const { page, errors } = await openPage(browser, size);
  await page.emulateMedia({ colorScheme, reducedMotion: "reduce" });
  await page.goto(server.url);
  await page.locator('[data-plot="residual against covariate"] [data-drawn=true]').waitFor();
  await page.locator("[role=option]").first().waitFor({ state: "attached" });
  return { page, errors };
}

const toScreen = (page, name) => page.getByRole("navigation").getByRole("button", { name, exact: true }).click();
const headline = (page) => page.locator(".head .headline").innerText();
const error = async (page) => Number(await page.locator(".figure-of-merit b").first().innerText());
const option = (page, name) => page.locator(`#candidate-${name}`);
const plotsShow = (page, preview) => page.locator(`.figures[data-preview="${preview}"]`).waitFor();

async function lookAtScreens(browser, size, colorScheme) {
  const server = await serve(share);
  const { page, errors } = await opened(browser, server, size, colorScheme);
  for (const name of [...screens, "Open"]) {
    if (name === "Open") await page.locator(".brand").click();
    else await toScreen(page, name);
    if (name === "Session") await page.locator("pre.script").waitFor();
    if (name === "See it") await page.locator(".frames[data-quality=fine]").waitFor();
    if (name === "Formula") await page.locator(".cm-content").waitFor();
    await fits(page, `${name}, ${size.width} px`, colorScheme);
    if (shots) await page.screenshot({ path: join(shots, `workbench_${name}_${size.width}_${colorScheme}.png`) });
  }
  assert.equal(await page.locator("img").count(), 0, "a set's title is text");
  assert.deepEqual(errors, [], "console");
  await page.close();
  server.close();
}

async function previewAddUndo(page, server) {
  assert.match(await headline(page), /rolling_shutter is missing/);
  assert.equal(await page.getByLabel("Covariate", { exact: true }).inputValue(), "row*pan_rate", "the strongest structure is chosen first");
  const before = await error(page);
  await until(page, () => performance.getEntriesByType("resource").some((one) => /preview.*effect=rolling_shutter$/.test(one.name))); // Ahead.
  await option(page, "rolling_shutter").hover();
  await page.locator(".context.previewing[data-how=linear]").waitFor();
  await plotsShow(page, "With rolling_shutter");
  assert.ok(Number(await page.locator(".error-line").getAttribute("data-ghost")) < 1.1, "the error's line has a ghost point");
  await page.keyboard.press("Escape");
  await page.locator(".context:not(.previewing)").waitFor();
  await plotsShow(page, ""); // Escape restores.
  await page.mouse.move(700, 20);
  await option(page, "rolling_shutter").hover();
  await plotsShow(page, "With rolling_shutter");
  await settled(page);
  await page.locator(".context.previewing").getByRole("button", { name: /Add/ }).click(); // The mouse can leave the list for it.
  await until(page, () => document.querySelector(".headline")?.textContent.startsWith("Adequate"));
  assert.ok(await error(page) < 1.1);
  assert.match(await page.locator(".command code").innerText(), /^seam add rolling_shutter /);
  await page.keyboard.press("Control+z");
  await until(page, (was) => Number(document.querySelector(".figure-of-merit b").textContent) > was - 0.01, before);
  await page.getByRole("button", { name: "Redo" }).click();
  await until(page, () => document.querySelector(".headline")?.textContent.startsWith("Adequate"));
  await page.getByRole("button", { name: "Undo" }).click();
  await until(page, () => !document.querySelector(".headline")?.textContent.startsWith("Adequate"));
  // Acting from an older version branches.
  await option(page, "frame_latency").click();
  await page.locator(".context.previewing").getByRole("button", { name: /Add/ }).click();
  await until(page, () => document.querySelector(".command code").textContent.includes("frame_latency"));
  assert.deepEqual(server.session.versions.map((one) => one.parent), [null, "1", "1"]);
}

/** Ties stand in a bracket with what separates them, untestable ones with the reason. */
async function ties(page) {
  const tie = page.getByRole("group", { name: "Not separated by these data" });
  assert.equal(await tie.getByRole("option").count(), 2);
  assert.match(await tie.innerText(), /Swing the head at two more rates/);
  await page.getByText("1 not testable with these data").click();
  assert.match(await page.locator(".untestable").innerText(), /the recording lasts 8 s only/);
}

async function chooseAndLeaveOut(page, server) {
  const plot = page.locator('[data-plot="residual against covariate"] svg');
  // A plot is drawn anew when the rows of another version come.
  await page.locator(`.figures[data-version="${server.session.current}"]`).waitFor();
  await page.evaluate(() => scrollTo(0, 0));
  await settled(page);
  await plot.waitFor();
  const box = await plot.boundingBox();
  await page.mouse.move(box.x + box.width * 0.4, box.y + box.height * 0.2);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width * 0.8, box.y + box.height * 0.75, { steps: 4 });
  await page.mouse.up();
  await page.getByRole("heading", { name: /rows chosen/ }).waitFor();
  await within("the server keeps the selection", () => server.session.selection.length > 0);
  // By the keyboard: a rule, a reason, Enter.
  await page.getByLabel("Choose rows by a rule").selectOption("10");
  await page.getByRole("button", { name: "Leave out …" }).click();
  await page.keyboard.type("the head was pushed");
  await page.keyboard.press("Enter");
  await page.locator(".left-out").waitFor();
  assert.match(await page.locator(".left-out").innerText(), /the head was pushed/);
  const unfitted = server.session.current;
  await page.getByRole("button", { name: "Fit again" }).click();
  await until(page, () => document.querySelector(".command code").textContent.startsWith("seam fit "));
  await page.getByRole("button", { name: "Undo" }).click();
  await within("the fit is undone", () => server.session.current === unfitted);
  await page.getByRole("button", { name: "Undo" }).click();
  await until(page, () => !document.querySelector(".left-out"));
}

async function formulaAndSession(page, server) {
  await toScreen(page, "Formula");
  await page.locator(".cm-content").click();
  await page.keyboard.type("u: k ? row");
  await page.getByText("'?' is no operator").first().waitFor();
  await page.keyboard.press("Control+a");
  await page.keyboard.type("u: k * row");
  await page.getByText("The formula can be read; to be fitted: k.").waitFor();
  // A name is checked as the text is.
  await page.getByLabel("Name", { exact: true }).fill("Skew");
  await page.getByText("name: expected a letter first").waitFor();
  await page.getByLabel("Name", { exact: true }).fill("my_effect");
  await page.getByText("The formula can be read; to be fitted: k.").waitFor();
  await page.getByRole("button", { name: "Fit and add" }).click();
  await until(page, () => document.querySelector(".command code").textContent.includes("my_effect"));
  await page.getByText(/my_effect does not help: the error was [\d.]+ without. Undo takes it back/).waitFor();
  await toScreen(page, "Session");
  await page.getByLabel(/^Note on version 1$/).fill("as the data sheet has it");
  server.emit("state", { ...server.session.state(), job: { what: "plan", doing: "planning: effects planned", done: 1, of: 9 } });
  await page.getByText("1 of 9").waitFor(); // A state that arrives leaves what is typed as it is.
  await page.locator("h1").click();
  await within("the note is saved", () => server.session.find("1").note !== "");
  await page.reload();
  await page.locator("pre.script").waitFor();
  assert.equal(await page.getByLabel(/^Note on version 1$/).inputValue(), "as the data sheet has it", "a reload loses nothing");
  assert.match(await page.locator("pre.script").innerText(), /seam add formulas\/my_effect.yaml/);
  assert.equal(await page.locator(".tree li").count(), server.session.versions.length);
  await page.getByRole("button", { name: "compare with the shown" }).first().click();
  assert.ok((await page.getByRole("region", { name: "Two versions" }).innerText()).includes("absent"));
}

/** A model for another program; what it cannot hold is refused with the reason, and left out by consent. */
async function exportModel(page, errors) {
  await toScreen(page, "Session");
  const section = page.getByRole("region", { name: "Export" });
  const saved = async (button) => {
    const waiting = page.waitForEvent("download");
    await section.getByRole("button", { name: button }).click();
    return (await waiting).suggestedFilename();
  };
  assert.match(await saved("ROS"), /^points-a-\d+-ros.yaml$/);
  await section.getByRole("button", { name: "OpenCV", exact: true }).click();
  await section.getByText(/opencv cannot hold effect 'rolling_shutter'/).waitFor();
  assert.match(errors.pop(), /status of 400/, "the browser says what was refused, too");
  await fits(page, "a refused export", "light");
  assert.match(await saved("Leave out what OpenCV cannot hold"), /-opencv.yaml$/);
  await section.getByText("without rolling_shutter: up to 6 px").waitFor();
}

/** What has the focus: its role and name. */
const focused = (page) => page.evaluate(() => `${document.activeElement.getAttribute("role")} ${document.activeElement.getAttribute("aria-label")}`);

/** One group is chosen in its plot and left out with a reason, by keys alone; Escape closes the form. */
async function leaveOutByKeys(page, server) {
  const plot = page.getByRole("group", { name: "error by group: choose rows by the keyboard" });
  await page.locator(`.figures[data-version="${server.session.current}"]`).waitFor();
  await settled(page);
  await plot.focus();
  for (const key of ["Home", "ArrowRight", "ArrowRight", "Enter"]) await page.keyboard.press(key);
  await page.getByRole("heading", { name: "20 rows chosen" }).waitFor();
  await within("the rows of the third group", () => JSON.stringify(server.session.selection) === "[[40,59]]");
  await fits(page, "a plot by keys", "light");
  await page.keyboard.press("Delete");
  await page.getByLabel("Why these rows are left out").waitFor();
  await page.keyboard.press("Escape");
  await page.getByLabel("Why these rows are left out").waitFor({ state: "detached" });
  await page.keyboard.press("Delete");
  await page.keyboard.type("the board moved");
  await page.keyboard.press("Enter");
  await page.locator(".left-out", { hasText: "the board moved" }).waitFor();
  await page.keyboard.press("Control+z");
  await page.locator(".left-out").waitFor({ state: "detached" });
  const arrows = page.getByRole("group", { name: "arrows in the image: choose rows by the keyboard" });
  await arrows.focus();
  for (const key of ["Shift+ArrowRight", "ArrowUp", "Enter"]) await page.keyboard.press(key);
  await page.getByText(/^u 70.7 to 115 px, v /).waitFor();
  await page.keyboard.press("?");
  await page.getByRole("dialog", { name: "Keys" }).waitFor();
  await fits(page, "the keys", "light");
  await page.keyboard.press("Escape");
  await page.getByRole("dialog", { name: "Keys" }).waitFor({ state: "hidden" });
}

async function byKeyboard(browser) {
  const server = await serve(share);
  const { page, errors } = await opened(browser, server, wide);
  await leaveOutByKeys(page, server);
  await page.locator("[role=listbox]").focus();
  await page.keyboard.press("Home");
  await page.locator(".context.previewing[data-preview=rolling_shutter]").waitFor();
  await page.keyboard.press("ArrowDown");
  await page.locator(".context.previewing[data-preview=frame_latency]").waitFor();
  await page.keyboard.press("Home");
  await page.locator(".context.previewing[data-preview=rolling_shutter][data-how=linear]").waitFor();
  await page.keyboard.press("Enter");
  await until(page, () => document.querySelector(".headline")?.textContent.startsWith("Adequate"));
  assert.equal(await focused(page), "listbox Candidates", "the focus stays where a step was made");
  await page.keyboard.press("Alt+6");
  await page.locator(".tree").waitFor();
  assert.deepEqual(errors, [], "console");
  await page.close();
  server.close();
}

async function onTelephone(browser) {
  const server = await serve(share);
  const { page, errors } = await opened(browser, server, narrow);
  await page.getByRole("button", { name: /Structure and candidates/ }).click();
  await option(page, "rolling_shutter").click();
  await page.locator(".context.previewing[data-how=linear]").waitFor();
  assert.ok(!(await option(page, "rolling_shutter").isVisible()), "the sheet closes over the preview");
  await page.locator(".context.previewing").getByRole("button", { name: /Add/ }).click();
  await until(page, () => document.querySelector(".headline")?.textContent.startsWith("Adequate"));
  await fits(page, "Work after a step, 390 px", "light");
  assert.deepEqual(errors, [], "console");
  await page.close();
  server.close();
}

/** Files of another program: too many, with an error by file and line, with a map of their columns. */
async function importFiles(page) {
  const choose = (bytes) => page.getByLabel("choose files").setInputFiles({ name: "points.csv", mimeType: "text/csv",
    buffer: Buffer.alloc(bytes, "x") });
  await choose(6000);
  await page.getByText(/at most 0 MB can be dropped/).waitFor();
  await choose(10);
  const form = page.getByRole("form", { name: "Import" });
  await form.getByText("points.csv:17: column u_px: found 'x', expected a number").waitFor();
  assert.equal(await form.getByLabel("These files are").inputValue(), "kalibr", "the import is recognised");
  for (const scheme of ["light", "dark"]) {
    await page.emulateMedia({ colorScheme: scheme, reducedMotion: "reduce" });
    await fits(page, "Import", scheme);
  }
  if (shots) await page.screenshot({ path: join(shots, "workbench_Import_1280.png") });
  await form.getByLabel(/--map/).fill("u=x,v=y");
  await page.keyboard.press("Enter");
  await page.locator(".head .headline").waitFor();
}

/** A second tab, a search under way, what cannot be opened. */
async function otherStates(browser) {
  const session = new MockSession();
  session.slow = true;
  const server = await serve(share, session);
  const { page } = await opened(browser, server, wide);
  assert.match(await page.locator(".progress").innerText(), /2 of 9/);
  const waiting = page.locator("[role=option]", { hasText: ", linear" });
  assert.ok(await waiting.count() > 0, "what waits for its fit is in the list");
  session.slow = false;
  session.suggestion = { effect: "proposed", formula: "u: 0.0006 * (u - cx) * t", error: 1.01, error_before: 2.25, beside: ["rolling_shutter"],
    stage: "geometry", text: "u: \"u + k * (u - cx) * t\"\nparameters:\n  k: {neutral: 0}\n" };
  server.emit("search", session.search());
  await page.getByText("9 tested").waitFor();
  assert.equal(await waiting.count(), 0, "all are fitted");
  const formula = page.locator(".proposed");
  assert.match(await formula.innerText(), /2.25 → 1.01[^]*0.0006 \* \(u - cx\) \* t[^]*beside rolling_shutter/);
  await fits(page, "Work with a formula", "light");
  await formula.getByRole("button", { name: /Name it/ }).click();
  await page.getByLabel("Name", { exact: true }).waitFor();
  assert.equal(await page.getByLabel("Name", { exact: true }).inputValue(), "proposed");
  assert.match(await page.locator(".cm-content").innerText(), /\(u - cx\) \* t/);
  server.emit("job", { what: "plan", doing: "planning: effects planned", done: 3, of: 9 });
  const job = page.getByRole("group", { name: "What is being computed" });
  await job.getByText("planning: effects planned, 3 of 9").waitFor();
  await fits(page, "a job", "light");
  server.emit("job", null);
  await job.waitFor({ state: "detached" });
  await toScreen(page, "Work");
  ++session.revision;
  await page.getByRole("listbox").focus();
  await page.keyboard.press("ArrowDown");
  await page.keyboard.press("Enter");
  await page.getByText(/Another tab changed the session/).waitFor();
  await page.getByRole("button", { name: "close" }).click();
  await page.locator(".brand").click();
  await page.getByLabel("Folder of a measurement set").fill("nothing");
  await page.getByRole("button", { name: "Open", exact: true }).click();
  await page.getByText("nothing: there is no such folder").waitFor();
  assert.equal(await page.locator(".saved").innerText(), "saved", "the session that is open stays as it is saved");
  await importFiles(page);
  await page.close();
  server.close();
}

/** Versions of two sets have the same names: nothing of one is shown beside the other. */
async function anotherSet(browser) {
  const server = await serve(share);
  const { page, errors } = await opened(browser, server, wide);
  await option(page, "rolling_shutter").hover();
  await plotsShow(page, "With rolling_shutter");
  await toScreen(page, "See it");
  await page.locator(".frames[data-quality=fine]").waitFor();
  await page.locator(".brand").click();
  await page.getByLabel("Folder of a measurement set").fill("other");
  await page.getByRole("button", { name: "Open", exact: true }).click();
  await page.locator('[data-plot="arrows in the image"] figcaption', { hasText: "of 3000 points" }).waitFor();
  assert.equal(await focused(page), "listbox Candidates", "the work on another set begins at its candidates");
  await plotsShow(page, "");
  await option(page, "rolling_shutter").hover();
  await plotsShow(page, "With rolling_shutter");
  const asked = server.session.seen;
  await toScreen(page, "See it");
  await page.locator(".frames[data-quality=fine]").waitFor();
  assert.ok(server.session.seen > asked, "a frame of this set's camera is asked for");
  assert.deepEqual(errors, [], "console");
  await page.close();
  server.close();
}

/** Says how long a preview takes to be drawn in all plots; the limit is wide, since the tests share a busy machine. */
async function speed(browser, n, most) {
  const server = await serve(share, new MockSession(n));
  const { page } = await opened(browser, server, wide);
  const times = await page.evaluate(async () => {
    const frame = () => new Promise((done) => requestAnimationFrame(() => setTimeout(done)));
    const list = document.querySelector("[role=listbox]");
    const shown = () => document.querySelector(".figures").dataset.preview;
    const found = [];
    for (const key of ["ArrowDown", "ArrowDown", "ArrowUp", "ArrowDown", "ArrowUp"]) {
      const was = shown(), from = performance.now();
      list.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true }));
      while (shown() === was && performance.now() - from < 5000) await frame();
      await frame();
      found.push(Math.round(performance.now() - from));
    }
    return found;
  });
  console.log(`previews of ${n} rows: ${times.join(", ")} ms; the last two were fetched before`);
  assert.ok(Math.min(...times.slice(3)) < most, `a preview of ${n} rows takes ${times} ms`);
  await page.close();
  server.close();
}

const browser = await launch();
try {
  for (const size of [wide, narrow]) for (const scheme of ["light", "dark"]) await lookAtScreens(browser, size, scheme);
  const server = await serve(share);
  const { page, errors } = await opened(browser, server, wide);
  await ties(page);
  await previewAddUndo(page, server);
  await chooseAndLeaveOut(page, server);
  await formulaAndSession(page, server);
  await exportModel(page, errors);
  assert.deepEqual(errors, [], "console");
  await page.close();
  server.close();
  await byKeyboard(browser);
  await onTelephone(browser);
  await otherStates(browser);
  await anotherSet(browser);
  await speed(browser, 8000, 1500);
  await speed(browser, 100000, 5000);
} finally {
  await browser.close();
}
process.exit(0);
