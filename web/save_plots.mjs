// node web/save_plots.mjs REPORT.html OUT: every plot of a report as SVG and PNG, for documents.
import { mkdirSync, writeFileSync } from "node:fs";
import { basename, join } from "node:path";
import { pathToFileURL } from "node:url";
import { launch, openPage, until } from "./tests/browser.mjs";

const [report, out] = process.argv.slice(2);
if (!out) {
  console.error("usage: node web/save_plots.mjs REPORT.html OUT");
  process.exit(2);
}
mkdirSync(out, { recursive: true });
const browser = await launch();
const { page } = await openPage(browser);
await page.goto(pathToFileURL(report).href);
const plots = page.locator("[data-plot]:has([data-drawn=true])");
await until(page, () => document.querySelector("[data-drawn]") && !document.querySelector("[data-plot] .plot:not([data-drawn])"));
for (let i = 0; i < await plots.count(); ++i) {
  const plot = plots.nth(i);
  await plot.hover();
  const [download] = await Promise.all([page.waitForEvent("download"), plot.locator(".save").click()]);
  const path = join(out, download.suggestedFilename());
  await download.saveAs(path);
  await page.mouse.move(0, 0);
  await plot.screenshot({ path: path.replace(/\.svg$/, ".png") });
  console.log(path);
}
await page.screenshot({ path: join(out, `${basename(report, ".html")}.png`) });
await browser.close();
