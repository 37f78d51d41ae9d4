// What the residuals depend on, strongest first; the chosen one is what the plots show.
import { signal } from "@preact/signals";
import { number, splitUnit, words } from "../shared/format";
import { Strength } from "../shared/parts";
import type { Structure } from "../shared/types";
import { strongestFirst } from "./model";
import { look, lookAt, version } from "./store";

const firstShown = 5;
const allShown = signal(false);

export const structureText = (item: Structure) =>
  `${item.moment} of ${words(splitUnit(item.residual).name)} with ${words(item.covariate)}`;

const sameAs = (a: Structure, b: { residual: string; covariate: string; moment: string } | null) =>
  b !== null && a.residual === b.residual && a.covariate === b.covariate && a.moment === b.moment;

export function StructureList() {
  const now = version.value;
  const items = now?.structure && strongestFirst(now.structure, now.noise);
  if (!now) return null;
  if (now.trouble && !items) return null; // The head has it.
  if (!items) return <p class="empty" role="status">Testing what the residuals depend on …</p>;
  const shown = allShown.value ? items : items.slice(0, firstShown);
  return (
    <section class="where" aria-label="Where the model fails">
      <header class="side-head">
        <h2>Where the model fails</h2>
        {items.length > 0 && <span class="quiet num">{items.length} found</span>}
      </header>
      {items.length === 0 && <p class="empty">No structure is left in the residuals that matters.</p>}
      <ul class="structures">
        {shown.map((item, i) => (
          <li key={i}>
            <button type="button" aria-pressed={sameAs(item, look.value)} onClick={() => lookAt(item)}>
              <span>{item.moment === "spread" && <em>spread of </em>}{words(splitUnit(item.residual).name)}
                {" "}<span class="quiet">with</span> {item.covariate === "neighbour" ? "that of its neighbours" : words(splitUnit(item.covariate).name)}</span>
              <Strength item={item} all={items} />
              <span class="quiet num times">{times(item, now.noise)}</span>
            </button>
          </li>
        ))}
      </ul>
      {items.length > firstShown && (
        <button type="button" class="link" aria-expanded={allShown.value} onClick={() => (allShown.value = !allShown.value)}>
          {allShown.value ? "show fewer" : `and ${items.length - firstShown} more`}
        </button>
      )}
    </section>
  );
}

function times(item: Structure, noise: Record<string, number>): string {
  const one = noise[item.residual] ?? Object.values(noise)[0];
  return one && item.strength !== null && item.moment === "mean" ? `${number(item.strength / one, 2)} × noise` : "";
}
