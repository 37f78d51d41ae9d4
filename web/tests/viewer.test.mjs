// The viewer, driven as a person would: open, play, seek, step, switch robot, compare two. With an
// address (`viewer.test.mjs SHARE http://127.0.0.1:PORT/`) it drives a real server instead of the mock.
import assert from "node:assert/strict";
import { existsSync } from "node:fs";
import { join } from "node:path";
import { faintTexts, launch, openPage, settled, skip } from "./browser.mjs";
import { serve } from "./mock_server.mjs";

const [share, real] = process.argv.slice(2);
const pagePath = join(share, "viewer/index.html");
if (!real && !existsSync(pagePath)) skip(`${pagePath} was not built`);
const shots = process.env.SEAM_SCREENSHOTS;

const clockText = async (page) => page.getByLabel("Time", { exact: true }).inputValue();

const seconds = (text) => text.split(":").map(Number).reduce((sum, part) => sum * 60 + part, 0);

/** The moment shown, in seconds. */
async function moment(page) {
  return seconds(await clockText(page));
}

async function endOf(page) {
  return seconds((await page.locator(".clock .quiet").innerText()).replace("/", "").trim());
}

async function typeTime(page, t) {
  await page.getByLabel("Time", { exact: true }).fill(String(t));
  await page.keyboard.press("Enter");
  await until("the time typed is shown", async () => Math.abs(await moment(page) - t) < 1e-3);
  await page.locator("h1").click();
}

async function canvasHash(page, name) {
  return page.locator(`canvas[data-name="${name}"]`).evaluate((canvas) => {
    // Read from a copy: reading the page's own canvas would change how it is drawn.
    const copy = document.createElement("canvas");
    [copy.width, copy.height] = [canvas.width, canvas.height];
    const context = copy.getContext("2d", { willReadFrequently: true });
    context.drawImage(canvas, 0, 0);
    const data = context.getImageData(0, 0, copy.width, copy.height).data;
    let hash = 0;
    const colours = new Set();
    for (let i = 0; i < data.length; i += 4) {
      hash = (Math.imul(hash, 31) + data[i] + 256 * data[i + 1] + 65536 * data[i + 2]) | 0;
      if (i % 404 === 0) colours.add(`${data[i]} ${data[i + 1]} ${data[i + 2]}`);
    }
    return { hash, colours: colours.size };
  });
}

async function until(what, condition, timeout = 30_000) {
  const stop = Date.now() + timeout;
  for (;;) {
    const value = await condition();
    if (value) return value;
    if (Date.now() > stop) assert.fail(`not within ${timeout} ms: ${what}`);
    await new Promise((done) => setTimeout(done, 50));
  }
}

const drawn = (page, name, colours) => until(`${name} is drawn`, async () =>
  (await canvasHash(page, name)).colours >= colours);

async function shot(page, name) {
  if (shots) await page.screenshot({ path: join(shots, `${name}.png`) });
}

async function open(page, url, query = "") {
  await page.goto(url + query);
  await page.locator("canvas[data-name=timeline]").waitFor();
  await drawn(page, "field a", 4);
  await drawn(page, "camera a", 8);
}

async function seekAndStep(page) {
  const from = Math.min(5, await endOf(page) / 4);
  await typeTime(page, from);
  const step = 0.008;
  await page.keyboard.press("ArrowRight");
  await until("one step on", async () => {
    const t = await moment(page);
    return t > from && t <= from + 4 * step + 1e-3;
  });
  const field = await canvasHash(page, "field a");
  const box = await page.locator("canvas[data-name=timeline]").boundingBox();
  await page.mouse.click(box.x + 72 + (box.width - 80) / 2, box.y + 30);
  await until("a click on the timeline seeks", async () => await moment(page) > from + 0.1);
  await until("the field has moved", async () => (await canvasHash(page, "field a")).hash !== field.hash);
}

async function playAndPause(page) {
  const end = await endOf(page);
  const before = Math.min(5, end / 8);
  await typeTime(page, before);
  await page.getByRole("button", { name: "Play", exact: true }).click();
  await until("time runs", async () => await moment(page) > Math.min(before + 0.3, end - 0.5));
  await page.getByRole("button", { name: "Pause" }).click();
  const paused = await moment(page);
  await page.waitForTimeout(300);
  assert.equal(await moment(page), paused, "a paused match stands still");
  await page.getByLabel("Speed").selectOption("8");
  await page.locator("h1").click();
  await page.keyboard.press("Space");
  await until("eight times as fast", async () => await moment(page) > Math.min(paused + 1.5, end - 0.01));
  if (await page.getByRole("button", { name: "Pause" }).count()) await page.keyboard.press("Space");
  await page.getByLabel("Speed").selectOption("1");
}

async function switchRobotAndStage(page) {
  const robots = page.getByRole("group", { name: "Robot" }).getByRole("button");
  if (await robots.count() > 1) {
    await page.locator("h1").click();
    await page.keyboard.press("2");
    await until("the second robot is chosen", async () =>
      (await robots.nth(1).getAttribute("aria-pressed")) === "true");
  }
  const stages = page.getByRole("group", { name: /Stage/ }).getByRole("button");
  const before = await canvasHash(page, "camera a");
  if (await stages.count() > 1) {
    await stages.last().click();
    await until("another stage is another picture", async () =>
      (await canvasHash(page, "camera a")).hash !== before.hash);
    await stages.first().click();
  }
  await until("row times are drawn", async () => (await canvasHash(page, "rows a")).colours >= 2);
}

async function readPanels(page) {
  await page.getByRole("tab", { name: "State" }).click();
  await page.locator(".state details").first().waitFor();
  assert.match(await page.locator(".state").first().innerText(), /step \d+/);
  await page.getByRole("tab", { name: "Events" }).click();
  await page.keyboard.press("?");
  await page.getByRole("dialog", { name: "Keys" }).waitFor();
  await page.keyboard.press("Escape");
  await until("the keys are gone", async () => (await page.getByRole("dialog").count()) === 0);
  const series = page.locator("[data-series] canvas");
  assert.ok(await series.count() >= 4, "four plots");
  const size = await series.first().boundingBox();
  assert.ok(size.width > 150 && size.height > 50, "the plots have a size");
}

/** The camera shows the frame that a decision was made from, not the newest one, and steps by decision. */
async function decisionsOfTheMock(page, url) {
  await open(page, url, "?t=50.19&robot=blue1");
  const shown = (frame) => until(`frame ${frame}`, async () =>
    (await page.locator(".camera .caption").first().getAttribute("data-frame")) === String(frame));
  await shown(1248);
  assert.match(await page.locator(".camera .decided").innerText(), /50\.000 s/);
  await page.keyboard.press("f");
  await shown(1254);
  await page.keyboard.press("f");
  await page.keyboard.press(".");
  await until("the next decision", async () => Math.abs(await moment(page) - 50.2) < 1e-6);
  await shown(1253);
  await page.keyboard.press(",");
  await until("the decision before", async () => Math.abs(await moment(page) - 50) < 1e-6);
}

/** Stepping by events and a link to a moment: what the mock holds is known. */
async function eventsOfTheMock(page, url) {
  await open(page, url, "?t=50&robot=blue1");
  assert.ok(Math.abs(await moment(page) - 50) < 1e-6, "?t= opens at that moment");
  await page.keyboard.press("Shift+ArrowRight");
  await until("the next event", async () => Math.abs(await moment(page) - 80) < 1e-6);
  await page.keyboard.press("Shift+ArrowLeft");
  await until("the event before", async () => Math.abs(await moment(page) - 47) < 1e-6);
  await page.getByLabel("Kind of event").selectOption("printed");
  await until("printed lines alone", async () => {
    const names = await page.locator(".events .name").allInnerTexts();
    return names.length > 5 && names.every((name) => name === "printed");
  });
  await page.getByLabel("blue1 alone").check();
  await until("none of blue1", async () => (await page.locator(".events li").count()) === 0);
  await page.getByLabel("blue1 alone").uncheck();
  await page.getByLabel("Kind of event").selectOption("");
  await page.locator(".events .fault button").first().click();
  await until("a click on a fault goes there", async () => Math.abs(await moment(page) - 312.4) < 1e-6);
  await page.keyboard.press("End");
  await until("the end of twenty minutes", async () => await moment(page) === 1200);
  await until("the address names the moment", async () => page.url().includes("t=1200.000"));
  await page.getByRole("tab", { name: "Client" }).click();
  await until("the client's values", async () =>
    (await page.locator(".client").innerText()).includes("ball distance"));
  await page.mouse.move(700, 740);
  await page.mouse.wheel(0, -1500);
  await shot(page, "viewer_end");
}

/** The same search as the command's: a hit is gone to, an error stands at the box, a link keeps the condition. */
async function findOfTheMock(page, url, errors) {
  await open(page, url, "?t=50&robot=blue1");
  await page.keyboard.press("/");
  const box = page.getByLabel("Condition");
  const count = page.locator(".finder .count");
  await until("names are offered", async () => await page.locator("#find-names option").count() === 3);
  await box.fill("red2.event.goal");
  await page.keyboard.press("Enter");
  await until("all hits are counted", async () => (await count.innerText()) === "19 hits");
  await page.locator(".finder .hit button").nth(1).click();
  await until("a click on a hit goes there", async () => Math.abs(await moment(page) - 160) < 1e-6);
  assert.equal(await page.locator(".finder [aria-current=true] .when").innerText(), "2:40.000");
  assert.equal(await page.locator(".robots [aria-pressed=true]").innerText(), "red2", "whom the condition is about");
  assert.match(await page.locator(".timeline").getAttribute("data-lanes"), /^found referee/);
  await box.fill("red2.x_m = 3");
  await page.keyboard.press("Enter");
  await until("what is wrong stands at the box", async () =>
    (await page.locator(".finder [role=alert]").innerText().catch(() => "")).includes("expected an expression"));
  assert.equal(await page.locator(".finder .hit").count(), 0);
  assert.match(errors.pop(), /status of 400/);
  await box.fill("event.kick");
  await page.getByRole("button", { name: "First", exact: true }).click();
  await until("the first one", async () => Math.abs(await moment(page) - 100) < 1e-6);
  assert.equal(await count.innerText(), "1 hit");
  await until("the address has the condition", async () => page.url().includes("find=event.kick"));
  await shot(page, "viewer_find");
  await page.goto(page.url());
  await until("a link searches again", async () => (await count.innerText().catch(() => "")) === "1 hit");
}

/** How many pixels of this colour a lane of the timeline has. */
async function inLane(page, name, colour) {
  return page.locator("canvas[data-name=timeline]").evaluate((canvas, [name, colour]) => {
    const lanes = canvas.parentElement.dataset.lanes.split(" ");
    const copy = document.createElement("canvas");
    [copy.width, copy.height] = [canvas.width, canvas.height];
    const context = copy.getContext("2d", { willReadFrequently: true });
    context.drawImage(canvas, 0, 0);
    const height = (canvas.height - 20) / lanes.length;
    const data = context.getImageData(73, Math.floor((lanes.indexOf(name) + 0.5) * height), canvas.width - 73, 1).data;
    let count = 0;
    for (let i = 0; i < data.length; i += 4) count += colour.every((part, k) => Math.abs(part - data[i + k]) < 30);
    return count;
  }, [name, colour]);
}

async function lanesOfTheMock(page, url) {
  await open(page, url, "?t=50&robot=blue1");
  const names = "referee contacts kicks faults texts decisions frames radio";
  assert.equal(await page.locator(".timeline").getAttribute("data-lanes"), names);
  const colours = [[0, 114, 178], [230, 159, 0], [204, 121, 167], [200, 80, 10], [0, 158, 115], [74, 84, 98], [86, 180, 233],
    [138, 147, 160]];
  const least = [10, 20, 20, 1, 300, 300, 300, 100];
  for (const [i, name] of names.split(" ").entries()) {
    await until(`marks of ${name}`, async () => await inLane(page, name, colours[i]) >= least[i]);
  }
  const box = await page.locator("canvas[data-name=timeline]").boundingBox();
  const x = (t) => box.x + 72 + (t / 1200) * (box.width - 80);
  const middle = (lane) => box.y + (lane + 0.5) * (box.height - 20) / 8;
  await page.mouse.click(x(21) + 2, middle(1));
  await until("a click goes to the begin of a contact", async () => Math.abs(await moment(page) - 21) < 1e-6);
  await page.mouse.click(x(22.5) - 2, middle(2));
  await until("a click goes to a kick", async () => Math.abs(await moment(page) - 22.5) < 1e-6);
}

/** No text is faint, on a light page and on a dark one. */
async function isReadable(page, name) {
  for (const colorScheme of ["dark", "light"]) {
    await page.emulateMedia({ colorScheme });
    await settled(page);
    if (colorScheme === "dark") await shot(page, `${name}_dark`);
    assert.deepEqual(await page.evaluate(faintTexts), [], `${name}, ${colorScheme}: faint texts`);
  }
}

/** On a telephone the page scrolls down and nowhere sideways. */
async function fitsNarrow(page, url, name) {
  await page.setViewportSize({ width: 390, height: 844 });
  await open(page, url, "?t=100.5&robot=red2&find=event.goal");
  await page.locator(".finder .hit").first().waitFor();
  const over = await page.evaluate(() => {
    const right = [...document.querySelectorAll("#app *")].filter((part) => part.getBoundingClientRect().right > innerWidth + 0.5);
    return [document.documentElement.scrollWidth - innerWidth, ...right.map((part) => part.className)];
  });
  assert.deepEqual(over, [0], `${name}: nothing is wider than a telephone`);
  await page.locator(".panels").scrollIntoViewIfNeeded();
  await shot(page, name);
  await isReadable(page, name);
  await page.setViewportSize({ width: 1280, height: 800 });
}

const plotOf = (page, name) => page.locator(`.chosen [data-series="${name}"]`);

/** All values are there by name; the client's first ones are shown, and a link keeps the choice. */
async function plotsOfTheMock(page, url) {
  await open(page, url, "?t=50&robot=blue1");
  await page.getByRole("tab", { name: "Plots" }).click();
  await page.getByText("Choose values").click();
  await until("every value has a name to choose", async () => await page.locator(".chosen li").count() === 15);
  await until("the client's first four", async () => await page.locator(".chosen [data-lines='1'] canvas").count() === 4);
  await page.getByLabel("Part of a value's name").fill("dist");
  await until("one name is left", async () => await page.locator(".chosen li").count() === 1);
  await page.getByLabel("ball distance").check();
  await plotOf(page, "ball distance").locator("canvas").waitFor();
  await page.getByLabel("Part of a value's name").fill("");
  await page.getByLabel("effort").uncheck();
  await until("a value that is not wanted goes", async () => await plotOf(page, "effort").count() === 0);
  await page.getByText("Choose values").click();
  await shot(page, "viewer_plots");
  if (shots) {
    await page.setViewportSize({ width: 390, height: 844 });
    await page.locator(".chosen").scrollIntoViewIfNeeded();
    await settled(page);
    await page.screenshot({ path: join(shots, "viewer_plots_390.png"), fullPage: true });
    await page.setViewportSize({ width: 1280, height: 800 });
  }
  await page.locator("h1").click();
  await page.keyboard.press("l");
  const link = await until("a link with the choice", async () => page.url().includes("plots=debug.ball") && page.url());
  await page.goto(link);
  await plotOf(page, "ball distance").locator("canvas").waitFor();
  assert.equal(await page.locator(".chosen [data-series]").count(), 4);
}

async function compareTwo(browser) {
  const server = await serve(pagePath, 2);
  const { page, errors } = await openPage(browser);
  await open(page, server.url);
  await drawn(page, "field b", 4);
  await drawn(page, "camera b", 8);
  await page.getByRole("button", { name: /First difference/ }).click();
  await until("the first difference", async () => Math.abs(await moment(page) - 100.008) < 1e-6);
  const decision = page.locator(".difference");
  assert.match(await decision.innerText(), /red1, made from frame 2498 in a, 2498 in b: the same pixels/);
  assert.deepEqual(await decision.locator("table.decision td").allInnerTexts(), ["-0.889", "0.59", "–", "leg_forward"]);
  await page.getByRole("button", { name: /First other decision/ }).click();
  await until("the first other decision", async () => Math.abs(await moment(page) - 100) < 1e-6);
  await page.getByRole("tab", { name: "Plots" }).click();
  await until("both logs in one plot", async () =>
    (await plotOf(page, "effort").getAttribute("data-lines").catch(() => "")) === "2");
  assert.equal(await plotOf(page, "effort").locator(".legend").innerText(), "a\nb dashed");
  const over = await page.locator(".panels").evaluate((panel) =>
    Math.max(...[panel, ...panel.children].map((part) => part.scrollWidth - part.clientWidth)));
  assert.ok(over <= 0, `the panel is ${over} px too wide`);
  await shot(page, "viewer_two_plots");
  await page.getByRole("tab", { name: "Difference" }).click();
  await page.getByLabel("Time", { exact: true }).fill("110");
  await page.keyboard.press("Enter");
  await until("both fields are drawn, and differ", async () =>
    (await canvasHash(page, "field a")).hash !== (await canvasHash(page, "field b")).hash);
  await shot(page, "viewer_two_1280");
  await page.setViewportSize({ width: 1920, height: 1080 });
  await settled(page);
  await shot(page, "viewer_two_1920");
  await page.getByLabel("Time", { exact: true }).fill("1000");
  await page.keyboard.press("Enter");
  await page.locator("[data-side=b] .ended").waitFor();
  await fitsNarrow(page, server.url, "viewer_two_390");
  assert.deepEqual(errors, [], "console");
  await page.close();
  server.close();
}

/** The whole fits the window: nothing to scroll to, no text cut off at the right. */
async function fits(page, width, height) {
  await page.setViewportSize({ width, height });
  await settled(page);
  const over = await page.evaluate(() => [document.documentElement.scrollWidth - innerWidth,
    document.documentElement.scrollHeight - innerHeight]);
  assert.deepEqual(over.map((n) => Math.max(0, n)), [0, 0], `fits ${width} x ${height}`);
  await shot(page, `viewer_one_${width}`);
  await isReadable(page, `viewer_one_${width}`);
}

const browser = await launch();
const server = real ? { url: real, close() {} } : await serve(pagePath, 1);
try {
  const { page, errors } = await openPage(browser);
  await open(page, server.url);
  await seekAndStep(page);
  await playAndPause(page);
  await switchRobotAndStage(page);
  await readPanels(page);
  await fits(page, 1280, 800);
  await fits(page, 1920, 1080);
  await page.setViewportSize({ width: 1280, height: 800 });
  if (!real) await decisionsOfTheMock(page, server.url);
  if (!real) await eventsOfTheMock(page, server.url);
  if (!real) await plotsOfTheMock(page, server.url);
  if (!real) await findOfTheMock(page, server.url, errors);
  if (!real) await lanesOfTheMock(page, server.url);
  if (!real) await fitsNarrow(page, server.url, "viewer_one_390");
  assert.deepEqual(errors, [], "console");
  if (!real) await compareTwo(browser);
  console.log("the viewer was driven");
} finally {
  await browser.close();
  server.close();
}
process.exit(0);
