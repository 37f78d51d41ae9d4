// The pages' TypeScript has no type errors (Vite alone does not look).
import { spawnSync } from "node:child_process";
import { existsSync } from "node:fs";
import { skip } from "./browser.mjs";

const compiler = "node_modules/typescript/bin/tsc";
if (!existsSync(compiler)) skip("web/node_modules is missing (npm ci)");
const run = spawnSync(process.execPath, [compiler, "--noEmit"], { encoding: "utf8" });
process.stdout.write(run.stdout + run.stderr);
process.exit(run.status ?? 1);
