// The screen of work: what matters, where the model fails, what could explain it, and plots that follow.
import { number, splitUnit, words } from "../shared/format";
import { Rich } from "../shared/rich";
import { Candidates, helps, ranked, valueText } from "./candidates";
import { Chosen } from "./chosen";
import { Head } from "./head";
import { Plots } from "./plots/plots";
import { StructureList } from "./structure";
import { addEffect, busy, loading, look, preview, restore, searched, sheetOpen, version, view } from "./store";

export function WorkScreen() {
  return (
    <div class="work">
      <Head />
      <aside class={sheetOpen.value ? "side open" : "side"}>
        <SheetHandle />
        <div class="side-body">
          <StructureList />
          <Candidates />
        </div>
      </aside>
      <div class="bench">
        <Context />
        {view.value ? <Plots /> : <div class="empty big" role="status">{withoutRows()}</div>}
        <Chosen />
      </div>
    </div>
  );
}

function withoutRows(): string {
  if (loading.value) return "Reading the rows …";
  const looked = version.value?.looked ?? "yes";
  return looked === "yes" || looked === "failed" ? "There are no rows to draw." : "Comparing the model with the measurements …";
}

/** On a narrow page the candidates lie in a sheet at the bottom; this is what is seen of it when it is closed. */
function SheetHandle() {
  const best = searched.value ? ranked(searched.value).find(helps) : undefined;
  const progress = searched.value?.progress;
  return (
    <button type="button" class="sheet-handle" aria-expanded={sheetOpen.value} onClick={() => (sheetOpen.value = !sheetOpen.value)}>
      <b>{sheetOpen.value ? "Close" : "Structure and candidates"}</b>
      <span class="quiet">{best ? <>best <code>{best.effect}</code></> : progress ? "searching …" : ""}</span>
    </button>
  );
}

/** One line over the plots: the preview where there is one, else what the plots show. */
function Context() {
  const shown = preview.value, item = look.value, now = version.value;
  if (shown) {
    const help = searched.value && ranked(searched.value).find((one) => one.effect === shown.effect)?.help;
    return (
      <div class="context previewing" data-preview={shown.effect} data-how={shown.how}>
        <div class="says">
          <span class="label">Preview</span> <code class="effect">{shown.effect}</code>
          <span class="values num">
            {Object.entries(shown.parameters).slice(0, 4).map(([name, value]) => (
              <span key={name}><span class="quiet">{name}</span> <Rich text={valueText(value)} /></span>
            ))}
          </span>
          <span class="quiet" role="status">{shown.how === "fitting" ? "fitting …" : shown.how === "linear" ? "by one linear step"
            : shown.how === "first" ? "a first estimate" : shown.how === "failed" ? shown.why : "fitted"}</span>
          {help && <p class="small quiet what">{help}</p>}
        </div>
        <div class="actions">
          {shown.error !== null && <span class="num error-change">error {number(now?.error, 4)} → <b>{number(shown.error, 4)}</b></span>}
          <button type="button" class="primary" disabled={busy.value !== ""} onClick={() => void addEffect(shown.effect)}>
            Add <kbd>Enter</kbd></button>
          <button type="button" onClick={() => restore()}>Restore <kbd>Esc</kbd></button>
        </div>
      </div>
    );
  }
  const found = now?.structure?.find((one) => one.residual === item?.residual && one.covariate === item?.covariate &&
    one.moment === item?.moment);
  const { name, unit } = splitUnit(item?.residual ?? "");
  return (
    <div class="context">
      <div class="says">
        {found ? <>The {found.moment} of the <b>{words(name)}</b> residual varies with <b>{words(found.covariate)}</b>:{" "}
          <span class="num"><Rich text={number(found.strength)} /> {unit}</span>{now?.noise[item!.residual] && found.strength !== null &&
            found.moment === "mean" ? <span class="num">, {number(found.strength / now.noise[item!.residual], 2)} × the noise</span> : ""}</>
          : item ? <>The <b>{words(name)}</b> residual against <b>{words(item.covariate)}</b></> : view.value ? "" : "Comparing …"}
      </div>
    </div>
  );
}
