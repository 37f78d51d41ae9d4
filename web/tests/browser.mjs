// One headless Chromium for a test, with what the page says on its console collected.
import { existsSync } from "node:fs";

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
