// node web/workbench_speed.mjs SHARE SEAM SET EFFECT [TIMES]: how fast the workbench answers for a set whose cause is known, as one
// row of two tables: the median of TIMES starts (3). SET may be servo:RUNSxSAMPLES, a log that is made, or room:N, the tutorial's room
// with N times its points. Measured are the times from the start of the program to residuals, to the list by score, to the linear
// preview of the cause and to its fit; and in a browser from pointing at a candidate to plots that show it, and the longest task of
// the page in the time of its own thread: what other programs take from a busy machine is no fault of the page.
import { spawnSync } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, dirname, join, resolve } from "node:path";
import { launch, openPage } from "./tests/browser.mjs";
import { makeRoom, makeServo } from "./tests/made_sets.mjs";
import { startProgram } from "./tests/program.mjs";

const [share, program, named, effect, times = "3"] = process.argv.slice(2);
if (!effect) {
  console.error("usage: node web/workbench_speed.mjs SHARE SEAM SET EFFECT [TIMES]");
  process.exit(2);
}
const seam = resolve(program), limit_ms = 600_000;
const scratch = mkdtempSync(join(tmpdir(), "seam-speed-"));
const made = /^(?:servo:(\d+)x(\d+)|room:(\d+))$/.exec(named);
const inScratch = (words) => {
  const done = spawnSync(seam, words, { encoding: "utf8" });
  if (done.status !== 0) throw new Error(done.stderr);
};
if (made?.[3]) makeRoom(join(scratch, "set"), dirname(import.meta.dirname), inScratch, Number(made[3]));
else if (made) makeServo(join(scratch, "set"), Number(made[1]), Number(made[2]), inScratch);
const set = made ? join(scratch, "set") : resolve(named);
/** Of so many rows the search takes minutes: pointing is measured by the linear step alone. */
const manyRows = 50_000;
const pause = (ms) => new Promise((done) => setTimeout(done, ms));

/** The program on a new session; `from` is when it was started. */
async function start() {
  const folder = mkdtempSync(join(tmpdir(), "seam-speed-"));
  const from = performance.now();
  const { address, end: stop } = await startProgram(seam, share, set, join(folder, "work"));
  const end = async () => {
    await stop();
    rmSync(folder, { recursive: true, force: true });
  };
  return { address, from, end };
}

const headOf = (bytes) => JSON.parse(bytes.subarray(4, 4 + bytes.readUInt32LE(0)).toString());

/** Asks the interface as the page does. */
async function asker(address, from) {
  const [base, token] = address.split("#token=");
  const entered = await fetch(`${base}api/enter`, { method: "POST", body: JSON.stringify({ token }) });
  const headers = { Cookie: entered.headers.get("set-cookie").split(";")[0] };
  const until = async (path, found) => {
    while (performance.now() - from < limit_ms) {
      const answer = await fetch(base + path, { headers });
      const bytes = Buffer.from(await answer.arrayBuffer());
      if (answer.status === 200 && found(bytes)) return performance.now() - from;
      if (answer.status !== 200 && answer.status !== 202) throw new Error(`${path}: ${bytes}`);
      await pause(5);
    }
    throw new Error(`${path}: no answer within ${limit_ms} ms`);
  };
  return { until, post: (path) => fetch(base + path, { method: "POST", headers }) };
}

/** Milliseconds from the start of the program to each answer, by the interface alone. */
async function answers() {
  const { address, from, end } = await start();
  const { until } = await asker(address, from);
  let n = 0;
  try {
    const rows = await until("api/rows?version=001", (bytes) => (n = headOf(bytes).n) > 0);
    const list = await until("api/search?version=001", (bytes) => {
      const found = JSON.parse(bytes);
      return found.prospects.length + found.candidates.length > 0;
    });
    const linear = await until(`api/preview?version=001&effect=${effect}`, () => true);
    const fit = await until(`api/preview?version=001&effect=${effect}`, (bytes) => headOf(bytes).how === "fit");
    return { n, rows, list, linear, fit };
  } finally {
    await end();
  }
}

/** In the page: points at a candidate; milliseconds until the plots that show it were painted. */
const pointAt = ([id, x]) => new Promise((done) => {
  const from = performance.now();
  document.getElementById(id).dispatchEvent(new PointerEvent("pointerenter", { pointerType: "mouse", clientX: x }));
  const name = id.replace("candidate-", "");
  const painted = () => requestAnimationFrame(() => requestAnimationFrame(() => {
    const { port1, port2 } = new MessageChannel(); // Behind the effects that the frame began.
    port1.onmessage = () => done(performance.now() - from);
    port2.postMessage(0);
  }));
  const look = () => {
    if (document.querySelector(".figures")?.dataset.preview === `With ${name}`) painted();
    else if (performance.now() - from > 60_000) done(NaN);
    else requestAnimationFrame(look);
  };
  look();
});

/** The longest task of the page's main thread, in milliseconds of the thread's own time. */
function longestTask(events) {
  const threads = new Map(events.filter((one) => one.name === "thread_name" && one.args.name === "CrRendererMain")
    .map((one) => [`${one.pid} ${one.tid}`, []]));
  for (const { name, pid, tid, tdur } of events) if (name.endsWith("RunTask") && tdur) threads.get(`${pid} ${tid}`)?.push(tdur / 1000);
  const busiest = [...threads.values()].sort((a, b) => sum(b) - sum(a))[0] ?? [];
  return Math.max(0, ...busiest);
}

const sum = (values) => values.reduce((total, value) => total + value, 0);

/** Pointing at candidates: by the linear step where fits were cancelled as the list came, else by their fits, when the search has ended. */
async function hovers(browser, cancelled) {
  const { address, from, end } = await start();
  if (cancelled) {
    const { until, post } = await asker(address, from);
    let list = [];
    await until("api/search?version=001", (bytes) => (list = JSON.parse(bytes).prospects).length > 0);
    for (const { effect: name } of list) await until(`api/preview?version=001&effect=${name}`, () => true);
    await post("api/cancel");
  }
  const { page } = await openPage(browser);
  const pointed = { linear: [], fit: [] };
  try {
    page.setDefaultTimeout(limit_ms);
    await browser.startTracing(page, { categories: ["toplevel", "__metadata"] });
    await page.goto(address);
    await page.locator("[role=option]").first().waitFor();
    await page.locator(".candidates [role=status]", { hasText: "tested" }).waitFor();
    await page.locator('[data-plot="residual against covariate"] [data-drawn=true]').waitFor();
    const ids = await page.locator("[role=option]").evaluateAll((all) => all.slice(0, 12).map((one) => one.id));
    for (const [i, id] of ids.entries()) {
      const took = await page.evaluate(pointAt, [id, i]); // A mouse that has not moved points at nothing.
      const how = await page.locator(".context.previewing").getAttribute("data-how");
      if (how in pointed) pointed[how].push(took);
      await page.keyboard.press("Escape");
    }
    return { ...pointed, stall: longestTask(JSON.parse((await browser.stopTracing()).toString()).traceEvents) };
  } finally {
    await page.close();
    await end();
  }
}

const median = (values) => [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)];
const seconds = (ms) => `${(ms / 1000).toFixed(2)} s`;
const both = (values) => (values.length ? `${Math.round(median(values))} (${Math.round(Math.max(...values))})` : "-");
const all = [];
for (let i = 0; i < Number(times); ++i) all.push(await answers());
const browser = await launch();
const of = (name) => median(all.map((one) => one[name]));
const linear = await hovers(browser, true), fits = of("n") < manyRows ? await hovers(browser, false) : { fit: [], stall: 0 };
await browser.close();
const called = `${made ? named : basename(set)} (\`${effect}\`)`;
console.log("set,rows,residuals,list by score,linear preview,fit,pointing: linear (ms),pointing: fit (ms)");
console.log([called, of("n"), ...["rows", "list", "linear", "fit"].map((name) => seconds(of(name))), both(linear.linear), both(fits.fit)].join());
console.log("\nset,rows,longest task of the page (ms)");
console.log([called, of("n"), Math.round(Math.max(linear.stall, fits.stall))].join());
rmSync(scratch, { recursive: true, force: true });
