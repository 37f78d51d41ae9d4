// One headless Chromium for a test, with what the page says on its console collected.
import assert from "node:assert/strict";
import { existsSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";

export const chromium = process.env.SEAM_CHROMIUM ?? "/usr/bin/chromium";

/** CTest reads exit code 77 as "skipped". */
export function skip(reason) {
  console.log(`SKIPPED: ${reason}`);
  process.exit(77);
}

export async function launch() {
  if (!existsSync(chromium)) skip(`no browser at ${chromium}`);
  let playwright;
  try {
    playwright = await import("playwright-core");
  } catch {
    skip("web/node_modules is missing (npm ci)");
  }
  return playwright.chromium.launch({
    executablePath: chromium,
    args: ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
      "--disable-background-networking", "--disable-component-update", "--disable-sync"],
  });
}

/** A page whose console errors and failed requests are collected in `errors`. */
export async function openPage(browser, size = { width: 1280, height: 800 }) {
  const page = await browser.newPage({ viewport: size });
  const errors = [];
  page.on("console", (message) => {
    if (["error", "warning"].includes(message.type())) errors.push(message.text());
  });
  page.on("pageerror", (error) => errors.push(String(error)));
  page.on("requestfailed", (request) => errors.push(`request failed: ${request.url()}`));
  return { page, errors };
}

/** Until this holds in the page. Asked from here: a page's content policy refuses what `waitForFunction` would evaluate there. */
export async function until(page, holds, given = undefined, limit_ms = 30_000) {
  for (const end = Date.now() + limit_ms; !(await page.evaluate(holds, given));) {
    if (Date.now() > end) throw new Error(`not within ${limit_ms} ms: ${holds}`);
    await page.waitForTimeout(20);
  }
}

/** Until this holds here, outside of the page. */
export async function within(what, holds, limit_ms = 30_000) {
  for (const end = Date.now() + limit_ms; !(await holds());) {
    if (Date.now() > end) throw new Error(`not within ${limit_ms} ms: ${what}`);
    await new Promise((done) => setTimeout(done, 20));
  }
}

/** In the page: each text whose contrast with what is beneath it is less than 4.5:1, or 3:1 where it is large. */
export function faintTexts() {
  const channels = (colour) => colour.match(/[\d.]+/g).map(Number);
  const luminance = ([r, g, b]) => [r, g, b].map((c) => c / 255)
    .map((c) => (c <= 0.03928 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4))
    .reduce((sum, c, i) => sum + c * [0.2126, 0.7152, 0.0722][i], 0);
  const beneath = (element) => {
    for (let at = element; at; at = at.parentElement) {
      const colour = channels(getComputedStyle(at).backgroundColor);
      if (colour.length === 3 || colour[3] > 0.5) return colour;
    }
    return [255, 255, 255];
  };
  const faint = new Set();
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let node = walker.nextNode(); node; node = walker.nextNode()) {
    const element = node.parentElement;
    if (!node.textContent.trim() || !element.getClientRects().length || element.closest("script, style, title")) continue;
    const style = getComputedStyle(element);
    if (style.visibility === "hidden" || element.closest(".save")) continue;
    const colour = channels(element instanceof SVGElement ? style.fill : style.color);
    const [one, other] = [luminance(colour), luminance(beneath(element))].sort((x, y) => y - x);
    const size = parseFloat(style.fontSize);
    const least = size >= 24 || (size >= 18.66 && Number(style.fontWeight) >= 700) ? 3 : 4.5;
    const contrast = (one + 0.05) / (other + 0.05);
    if (contrast < least) faint.add(`${contrast.toFixed(2)} "${node.textContent.trim().slice(0, 40)}"`);
  }
  return [...faint];
}

/** Until the page has drawn what it had to, and nothing moves any more. */
export const settled = (page) => page.evaluate(async () => {
  const moves = (one) => one.playState === "running" && one.effect?.getTiming().iterations !== Infinity;
  for (let still = 0; still < 3;) {
    await new Promise(requestAnimationFrame);
    still = document.documentElement.dataset.drawing || document.getAnimations().some(moves) ? 0 : still + 1;
  }
});

let axe = "";

/** No faint text, nothing wider than the window, no finding of axe. */
export async function fits(page, what, colorScheme) {
  await settled(page);
  const over = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  assert.ok(over <= 0, `${what}: ${over} px wider than the window`);
  assert.deepEqual(await page.evaluate(faintTexts), [], `${what}: faint texts, ${colorScheme}`);
  axe ||= readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
  const found = await page.evaluate(`(() => { ${axe}; return axe.run({ runOnly: ["wcag2a", "wcag2aa", "wcag21aa"] }); })()`);
  assert.deepEqual(found.violations.map((v) => `${v.id}: ${v.nodes.map((n) => n.html.slice(0, 90)).join(" | ")}`), [], what);
}
