// The formula that explains what no effect of the catalogue does: what it says, what it leaves, and how to keep it.
import { number } from "../shared/format";
import { Rich } from "../shared/rich";
import { save } from "../shared/save";
import type { Report } from "./data";

const file = "NAME.yaml";

export function Formula({ report }: { report: Report }) {
  const found = report.result.suggestion;
  if (!found) return null;
  const beside = found.beside ?? [], mimics = found.mimics ?? [];
  const words = ["seam", "add", file, "--model", report.model?.file ?? "MODEL", "--data", report.data?.folder ?? "SET", "--out",
    "with_NAME.yaml"];
  return (
    <section id="formula" class="proposed-formula">
      <h2>A formula explains what no known effect does</h2>
      <pre class="command">{found.formula ?? (found.terms ?? []).join("\n")}</pre>
      <p>
        The error falls from <Rich text={number(found.error_before, 4)} /> to <Rich text={number(found.error, 4)} /> on held-out
        groups{beside.length > 0 && <>, beside {beside.join(", ")}</>}.
        {mimics.length > 0 && <> {mimics.join(", ")} only {mimics.length === 1 ? "imitates" : "imitate"} it.</>} What the formula
        means is for you to find.
      </p>
      {found.yaml && (
        <>
          <p>
            To keep it: <button type="button" onClick={() => save(found.yaml!, "application/yaml", file)}>Save as {file}</button>,
            write a name for <code>{found.effect}</code> in it,{beside.length > 0 && <> add {beside.join(", ")} first,</>} then:
          </p>
          <pre class="command">{words.join(" ")}</pre>
          <details><summary>The file</summary><pre>{found.yaml}</pre></details>
        </>
      )}
    </section>
  );
}
