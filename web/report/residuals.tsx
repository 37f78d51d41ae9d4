// Residual against each guilty covariate, with the sentence that says what it means.
import { Figure, Key } from "../shared/figure";
import { number, pValue, splitUnit, words } from "../shared/format";
import { palette } from "../shared/palette";
import { pairs, residualOptions, shown, type Pair } from "../shared/residual_plot";
import type { Bin, ResidualPlot } from "../shared/types";
import { noiseOf, type Report } from "./data";

export function Residuals({ report }: { report: Report }) {
  const all = pairs(report.plots?.residuals ?? []);
  if (all.length === 0) return null;
  const hasAfter = all.some((pair) => pair.after);
  return (
    <section id="residuals">
      <h2>Residuals against what they depend on</h2>
      <p class="lead">
        Held-out residuals (observed minus predicted). A model that is right leaves bin means on the
        zero line within their bars, and as much scatter as it states.
      </p>
      <Key
        items={[
          { label: "one residual", colour: palette.dot, shape: "dot" },
          { label: "mean of a bin ± 2 formal errors", colour: palette.before, shape: "bar" },
          { label: "actual scatter, ± 1 σ", colour: palette.before, shape: "band" },
          { label: "scatter that the model states", colour: palette.formal, shape: "dash" },
          ...(hasAfter
            ? [{ label: "with the effects found", colour: palette.after, shape: "bar" as const }]
            : []),
        ]}
      />
      <div class="figures">
        {all.map((pair) => (
          <ResidualFigure key={sentenceKey(pair)} pair={pair} report={report} />
        ))}
      </div>
    </section>
  );
}

function sentenceKey(pair: Pair): string {
  const plot = (pair.before ?? pair.after)!;
  return `${plot.residual} against ${plot.covariate} ${plot.moment ?? "mean"}`;
}

function ResidualFigure({ pair, report }: { pair: Pair; report: Report }) {
  const plot = (pair.before ?? pair.after)!;
  const residual = splitUnit(plot.residual);
  const spread = plot.moment === "spread";
  const draw = (width: number) => residualOptions(pair, width);
  return (
    <Figure
      name={`residual ${sentenceKey(pair)}`}
      title={<>{spread ? "spread of the " : ""}{words(residual.name)} residual <span class="quiet">against</span>{" "}
        {words(plot.covariate)}</>}
      sentence={spread ? spreadSentence(pair) : meanSentence(pair, noiseOf(report, plot.residual))}
      draw={draw}
    />
  );
}

/** Root mean square of the bin means: what of the residual a curve through them explains. */
function rootMeanSquare(bins: Bin[]): number {
  const used = shown(bins);
  const total = used.reduce((sum, bin) => sum + bin.n, 0);
  return Math.sqrt(used.reduce((sum, bin) => sum + bin.n * bin.mean! ** 2, 0) / Math.max(1, total));
}

function meanSentence(pair: Pair, noise: number | null): string {
  const plot = (pair.before ?? pair.after)!;
  const { name, unit } = splitUnit(plot.residual);
  let text = `${partThatFollows(plot, noise)} of the ${words(name)} residual ` +
    (plot.strength != null ? `follows ${words(plot.covariate)}${relation(plot.p_value)}: noise alone would leave a flat line.`
      : `is the root mean square of the means along ${words(plot.covariate)}.`);
  if (pair.before && pair.after) {
    text += ` With the effects found ${number(pair.after.strength ?? rootMeanSquare(pair.after.bins), 2)} ` +
      `${unit} are left` + (pair.after.strength != null ? `, still more than noise${relation(pair.after.p_value)}.` : ".");
  }
  return text;
}

/** "12.6 px, 84 times the noise of one observation,": of the residuals of the plot's own model. */
function partThatFollows(plot: ResidualPlot, noise: number | null): string {
  const strength = plot.strength ?? rootMeanSquare(plot.bins);
  const times = noise ? `, ${number(strength / noise, 2)} times the noise of one observation,` : "";
  return `${number(strength)} ${splitUnit(plot.residual).unit}${times}`;
}

/** " (p = 10^−9)"; nothing where nothing was tested, nor where p is below 1e-300: that says no more. */
function relation(p: number | null | undefined): string {
  return p === null || p === undefined || p <= 1e-300 ? "" : ` (p = ${pValue(p)})`;
}

function spreadSentence(pair: Pair): string {
  const plot = (pair.before ?? pair.after)!;
  const ratios = plot.bins.filter((b) => b.scatter !== null && b.formal).map((b) => b.scatter! / b.formal!);
  const low = Math.min(...ratios);
  const high = Math.max(...ratios);
  const range = ratios.length === 0 ? "" :
    ` It is ${number(low, 2)} to ${number(high, 2)} times what the model states (dashed).`;
  const name = `The scatter of the ${words(splitUnit(plot.residual).name)} residual`;
  return (plot.strength != null ? `${name} changes with ${words(plot.covariate)}${relation(plot.p_value)}.`
    : `${name} along ${words(plot.covariate)}.`) + `${range} A constant noise would be a flat line.`;
}
