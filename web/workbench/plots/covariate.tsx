// A residual against a covariate, both chosen in the title: dots of all rows, bin means with their formal errors, scatter.
import { useCallback, useMemo } from "preact/hooks";
import { Figure, type Frame } from "../../shared/figure";
import type { Box } from "../../shared/brush";
import { covariateUnit, number, splitUnit, words } from "../../shared/format";
import { palette } from "../../shared/palette";
import { residualOptions, type Pair } from "../../shared/residual_plot";
import type { Bin } from "../../shared/types";
import { binned, isLabel } from "../bins";
import { paintChosen, paintDots } from "../paint";
import type { Residuals, Rows } from "../rows";
import { choose, selection } from "../selection";
import { imageHeight, imageOf, shownOf, type View } from "./view";

export interface CovariateProps {
  view: View;
  residual: string;
  covariate: string;
  moment: string;
  residuals: string[];
  covariates: string[];
  onChoose: (residual: string, covariate: string) => void;
}

function plotOf(rows: Rows, of: Residuals, stage: "before" | "after", residual: string, covariate: string, moment: string) {
  const unit = covariateUnit(covariate), names = rows.words.names?.[covariate];
  return { residual, covariate, moment, stage, ...(unit ? { x_unit: unit } : {}), ...(names ? { x_names: names } : {}),
    discrete: isLabel(covariate),
    bins: binned(rows, covariate, of.r.get(residual)!, of.s.get(residual)!) };
}

export function CovariatePlot({ view, residual, covariate, moment, residuals, covariates, onChoose }: CovariateProps) {
  const { rows, before, after } = view;
  const first = useMemo(() => plotOf(rows, before, "before", residual, covariate, moment),
    [rows, before, residual, covariate, moment]);
  const pair: Pair = useMemo(() => ({ before: first,
    ...(after ? { after: plotOf(rows, after, "after", residual, covariate, moment) } : {}) }), [first, after]);
  const image = useMemo(() => imageOf(view), [rows, view.image]);
  const draw = useCallback((width: number) => ({ ...residualOptions(pair, width),
    ...(image ? { height: imageHeight(width, image) } : {}) }), [pair, image?.width_px, image?.height_px]);
  const chosen = selection.value;
  const x = rows.column(covariate)!, y = shownOf(view).r.get(residual)!;
  const paint = useCallback((context: CanvasRenderingContext2D, frame: Frame) => {
    if (moment === "spread") return;
    paintDots(context, frame, x, y, palette.dot);
    paintChosen(context, frame, x, y, chosen.mask, palette.pink);
  }, [x, y, chosen, moment]);
  const onBrush = useCallback((box: Box | null, add: boolean) => {
    if (!box || moment === "spread") return;
    choose(rows.n, (i) => x[i] >= box.x[0] && x[i] <= box.x[1] && y[i] >= box.y[0] && y[i] <= box.y[1],
      `${words(covariate)} ${number(box.x[0])} to ${number(box.x[1])}, ${words(splitUnit(residual).name)} residual ` +
      `${number(box.y[0])} to ${number(box.y[1])}`, add);
  }, [rows, x, y, covariate, residual, moment]);
  return (
    <Figure name="residual against covariate" draw={draw} paint={paint} onBrush={moment === "spread" ? undefined : onBrush}
      title={<>
        {moment === "spread" && "spread of "}
        <Choice label="Residual" value={residual} names={residuals} onChange={(name) => onChoose(name, covariate)}
          text={(name) => words(splitUnit(name).name)} />
        {" "}residual <span class="quiet">against</span>{" "}
        <Choice label="Covariate" value={covariate} names={covariates} onChange={(name) => onChoose(residual, name)}
          text={words} />
      </>}
      sentence={moment === "spread" ? spreadSentence(first.bins, pair.after?.bins, residual, view)
        : sentenceOf(first.bins, pair.after?.bins, residual, view)} />
  );
}

function Choice({ label, value, names, text, onChange }: { label: string; value: string; names: string[];
  text: (name: string) => string; onChange: (name: string) => void }) {
  return (
    <select class="inline" aria-label={label} value={value} onChange={(e) => onChange(e.currentTarget.value)}>
      {names.map((name) => <option key={name} value={name}>{text(name)}</option>)}
    </select>
  );
}

/** Root mean square of the bin means, and what of it the noise of the means would bring. */
function follows(bins: Bin[]): number {
  const total = bins.reduce((sum, bin) => sum + bin.n, 0) || 1;
  return Math.sqrt(bins.reduce((sum, bin) => sum + bin.n * (bin.mean ?? 0) ** 2, 0) / total);
}

function spreadSentence(before: Bin[], after: Bin[] | undefined, residual: string, view: View): string {
  const { unit } = splitUnit(residual);
  const span = (bins: Bin[]) => {
    const all = bins.map((bin) => bin.scatter ?? 0).filter((scatter) => scatter > 0);
    return all.length > 0 ? `${number(Math.min(...all), 2)} to ${number(Math.max(...all), 2)} ${unit}` : "not known";
  };
  return `How much residuals scatter in each bin: ${span(before)}.${after ? ` ${view.with ?? "Preview"}: ${span(after)}.` : ""} Dashes are ` +
    "the scatter that the model states: where dots leave them, the noise depends on this.";
}

function sentenceOf(before: Bin[], after: Bin[] | undefined, residual: string, view: View): string {
  const { unit } = splitUnit(residual);
  const noise = view.noise[residual];
  const times = noise ? `, ${number(follows(before) / noise, 2)} × the noise` : "";
  const now = after ? ` ${view.with ?? "Preview"}: ${number(follows(after), 2)} ${unit}.` : "";
  return `Bin means: ${number(follows(before))} ${unit} rms${times}.${now} Bars are two formal errors, the band is the scatter, ` +
    "dashes are the scatter that the model states.";
}
