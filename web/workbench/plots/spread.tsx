// Residuals in units of their stated errors beside the normal curve. A click on a bar chooses its rows.
import { useCallback, useMemo } from "preact/hooks";
import { Figure } from "../../shared/figure";
import { words } from "../../shared/format";
import { beyond, distributionOptions } from "../../shared/histogram";
import { histogram, histogramBin, reach } from "../bins";
import { choose } from "../selection";
import { shownOf, type View } from "./view";

export function SpreadPlot({ view, residual }: { view: View; residual: string }) {
  const { rows, before, after } = view;
  const first = useMemo(() => histogram(residual, before, "before"), [before, residual]);
  const second = useMemo(() => after && histogram(residual, after, "after"), [after, residual]);
  const draw = useCallback(() => distributionOptions(residual, first, second), [first, second]);
  const now = shownOf(view);
  const onPick = useCallback((z: number, _density: number, add: boolean) => {
    const r = now.r.get(residual)!, s = now.s.get(residual)!, bin = histogramBin(z);
    choose(rows.n, (i) => histogramBin(r[i] / s[i]) === bin,
      `${words(residual)} residual near ${z.toFixed(1)} of its errors`, add);
  }, [now, residual, rows]);
  const items = useMemo(() => {
    const { counts, edges } = second ?? first;
    return counts.map((n, k) => ({ x: (edges[k] + edges[k + 1]) / 2, y: 0, label: `${edges[k]} to ${edges[k + 1]} of their errors: ${n} rows` }))
      .filter((_, k) => counts[k] > 0);
  }, [first, second]);
  const share = 100 * beyond(second ?? first, 3);
  return (
    <Figure name="spread of residuals" draw={draw} onPick={onPick} items={items}
      title={<>how residuals are spread <span class="quiet">beside the normal curve</span></>}
      sentence={`${share.toFixed(1)} % lie beyond three of their errors, 0.3 % would if the noise were normal. ` +
        `The outermost bars hold all beyond ${reach}.`} />
  );
}
