// What the viewer shows under marks: `marks.mjs ADDRESS` reads [{t, robot, frame, u, v}] and prints [[red, green, blue]],
// the colour at the pixel (u, v) of the frame shown at t, and saves a picture of each where SEAM_SCREENSHOTS is set.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { launch, openPage } from "./browser.mjs";

const [address] = process.argv.slice(2);
const wanted = JSON.parse(readFileSync(0, "utf8"));
const camera = { width_px: 178, height_px: 144 };

/** The colour in the middle of a pixel, where a mark of one point, a ring, covers nothing. */
const colourAt = (page, u, v) => page.locator('canvas[data-name="camera a"]').evaluate((canvas, [u, v, size]) => {
  const copy = document.createElement("canvas");
  [copy.width, copy.height] = [canvas.width, canvas.height];
  const context = copy.getContext("2d", { willReadFrequently: true });
  context.drawImage(canvas, 0, 0);
  const at = [(u + 0.5) / size.width_px * copy.width, (v + 0.5) / size.height_px * copy.height].map(Math.floor);
  return [...context.getImageData(...at, 1, 1).data].slice(0, 3);
}, [u, v, camera]);

/** How many pixels of the ring around it have the colour of marks. */
const ringAt = (page, u, v) => page.locator('canvas[data-name="camera a"]').evaluate((canvas, [u, v, size]) => {
  const copy = document.createElement("canvas");
  [copy.width, copy.height] = [canvas.width, canvas.height];
  const context = copy.getContext("2d", { willReadFrequently: true });
  context.drawImage(canvas, 0, 0);
  const [x, y] = [(u + 0.5) / size.width_px * copy.width, (v + 0.5) / size.height_px * copy.height];
  const data = context.getImageData(Math.floor(x) - 8, Math.floor(y) - 8, 17, 17).data;
  let count = 0;
  for (let i = 0; i < data.length; i += 4) count += data[i] > 220 && data[i + 1] > 190 && data[i + 2] < 130;
  return count;
}, [u, v, camera]);

const browser = await launch();
const { page, errors } = await openPage(browser);
const found = [];
for (const { t, robot, frame, u, v } of wanted) {
  await page.goto(`${address}?t=${t.toFixed(3)}&robot=${robot}`);
  await page.locator(`.camera .caption[data-frame="${frame}"]`).waitFor({ timeout: 20000 });
  const stop = Date.now() + 8000;
  while (await ringAt(page, u, v) < 10) {
    assert.ok(Date.now() < stop, `no mark at (${u}, ${v}) of frame ${frame}`);
    await page.waitForTimeout(50);
  }
  found.push(await colourAt(page, u, v));
  if (process.env.SEAM_SCREENSHOTS) await page.screenshot({ path: join(process.env.SEAM_SCREENSHOTS, `mark_${frame}.png`) });
}
assert.deepEqual(errors, [], "console");
await browser.close();
console.log(JSON.stringify(found));
process.exit(0);
