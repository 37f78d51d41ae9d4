// A log in the viewer of a real server: `marks.mjs ADDRESS` reads {when, marks: [{t, robot, frame, u, v}]}, finds the first
// moment of the condition `when` as a person would, and looks under each mark. It prints {moment, frame, colours}: what is
// shown at the hit, and [red, green, blue] at the pixel (u, v) of the frame that is shown at each t.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { launch, openPage } from "./browser.mjs";

const [printed] = process.argv.slice(2);
const [address] = printed.split("#");
const { when, marks } = JSON.parse(readFileSync(0, "utf8"));
const camera = { width_px: 178, height_px: 144 };
const limit = { timeout: 20000 };

const browser = await launch();
const { page, errors } = await openPage(browser);

async function shot(name) {
  if (process.env.SEAM_SCREENSHOTS) await page.screenshot({ path: join(process.env.SEAM_SCREENSHOTS, `${name}.png`) });
}

/** The colour in the middle of a pixel, which a mark of one point, a ring, does not cover, and how much of a ring is there. */
const under = (u, v) => page.locator('canvas[data-name="camera a"]').evaluate((canvas, [u, v, size]) => {
  const copy = document.createElement("canvas");
  [copy.width, copy.height] = [canvas.width, canvas.height];
  const context = copy.getContext("2d", { willReadFrequently: true });
  context.drawImage(canvas, 0, 0);
  const [x, y] = [(u + 0.5) / size.width_px * copy.width, (v + 0.5) / size.height_px * copy.height].map(Math.floor);
  const around = context.getImageData(x - 8, y - 8, 17, 17).data;
  let ring = 0;
  for (let i = 0; i < around.length; i += 4) ring += around[i] > 220 && around[i + 1] > 190 && around[i + 2] < 130;
  return { ring, colour: [...context.getImageData(x, y, 1, 1).data].slice(0, 3) };
}, [u, v, camera]);

await page.goto(printed);
await page.locator("canvas[data-name=timeline]").waitFor(limit);
await page.keyboard.press("/");
await page.getByLabel("Condition").fill(when);
await page.keyboard.press("Enter");
await page.locator(".finder .hit button").first().click(limit);
const moment = await page.getByLabel("Time", { exact: true }).inputValue();
await page.locator(".camera .decided").waitFor(limit);
const frame = Number(await page.locator(".camera .caption").getAttribute("data-frame"));
await shot("hit");

const colours = [];
for (const { t, robot, frame: made, u, v } of marks) {
  await page.goto(`${address}?t=${t.toFixed(3)}&robot=${robot}`);
  await page.locator(`.camera .caption[data-frame="${made}"]`).waitFor(limit);
  const stop = Date.now() + limit.timeout;
  while ((await under(u, v)).ring < 10) {
    assert.ok(Date.now() < stop, `no mark at (${u}, ${v}) of frame ${made}`);
    await page.waitForTimeout(50);
  }
  colours.push((await under(u, v)).colour);
  await shot(`mark_${made}`);
}
assert.deepEqual(errors, [], "console");
await browser.close();
console.log(JSON.stringify({ moment, frame, colours }));
process.exit(0);
