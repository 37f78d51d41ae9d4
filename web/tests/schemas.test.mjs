// Results agree with docs/reference/schemas/results.schema.json. `schemas.test.mjs SHARE [RESULT.json...]` looks at the
// files given (a test of a command passes its output), else at the fixtures of the report.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { skip } from "./browser.mjs";
import { fixtures } from "./report_fixtures.mjs";

let Ajv;
try {
  ({ default: { default: Ajv } } = await import("ajv"));
} catch {
  skip("web/node_modules is missing (npm ci)");
}
const schema = JSON.parse(readFileSync(new URL("../../docs/reference/schemas/results.schema.json", import.meta.url)));
const validate = new Ajv({ allErrors: true, allowUnionTypes: true }).compile(schema);

function check(name, result) {
  assert.ok(validate(result), `${name}: ${JSON.stringify(validate.errors, null, 1)}`);
  console.log(`${name}: a valid ${result.format}`);
}

const files = process.argv.slice(3);
for (const file of files) check(file, JSON.parse(readFileSync(file, "utf8")));
if (files.length === 0) {
  for (const [name, make] of Object.entries(fixtures)) {
    const { result } = make();
    if (name !== "headSwing") check(name, result);
  }
  // The schema refuses: a verdict that does not exist, and a missing field.
  const wrong = fixtures.diagnosePoints().result;
  assert.ok(!validate({ ...wrong, verdict: "fine" }));
  assert.ok(!validate({ ...wrong, candidates: undefined }));
}
