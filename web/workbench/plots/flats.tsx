// Flat fields: the mean pixel value at each light level, and the photon transfer: variance against mean.
import * as Plot from "@observablehq/plot";
import { useCallback, useMemo } from "preact/hooks";
import { Figure } from "../../shared/figure";
import { number } from "../../shared/format";
import type { Item } from "../../shared/keys";
import { palette } from "../../shared/palette";
import type { Residuals, Rows } from "../rows";
import { choose } from "../selection";
import type { View } from "./view";

interface Level {
  light: number;
  /** DN. */
  mean: number;
  predicted: number;
  /** DN^2: of single values about their pixel's mean, measured and as the model states it. */
  variance: number;
  stated: number;
}

const spread = "dn spread";

function levelsOf(rows: Rows, of: Residuals): Level[] {
  const light = rows.column("illumination")!, observed = rows.data("observed dn")!, r = of.r.get("dn")!;
  const [dr, ds] = [of.r.get(spread), of.s.get(spread)];
  const found = new Map<number, Level & { n: number; pairs: number }>();
  for (let i = 0; i < rows.n; ++i) {
    if (!Number.isFinite(r[i])) continue;
    let level = found.get(light[i]);
    if (!level) found.set(light[i], level = { light: light[i], mean: 0, predicted: 0, variance: 0, stated: 0, n: 0, pairs: 0 });
    ++level.n;
    level.mean += observed[i];
    level.predicted += observed[i] - r[i];
    if (!dr || !ds || !Number.isFinite(dr[i])) continue;
    ++level.pairs;
    level.variance += dr[i] ** 2;
    level.stated += ds[i] ** 2;
  }
  return [...found.values()].map(({ n, pairs, ...level }) => ({ ...level, mean: level.mean / n, predicted: level.predicted / n,
    variance: level.variance / pairs, stated: level.stated / pairs })).sort((a, b) => a.light - b.light);
}

export function FlatPlots({ view }: { view: View }) {
  const { rows, before, after } = view;
  const first = useMemo(() => levelsOf(rows, before), [rows, before]);
  const second = useMemo(() => after && levelsOf(rows, after), [rows, after]);
  const pick = (of: (level: Level) => [number, number]) => (x: number, y: number, add: boolean) => {
    const distance = (level: Level) => { const [a, b] = of(level); return Math.hypot((a - x) / (Math.abs(x) || 1), (b - y) / (Math.abs(y) || 1)); };
    const nearest = first.reduce((best, level) => (distance(level) < distance(best) ? level : best));
    const light = rows.column("illumination")!;
    choose(rows.n, (i) => light[i] === nearest.light, `light level ${number(nearest.light)}`, add);
  };
  const itemsOf = (of: (level: Level) => [number, number]) => first.map((level) => {
    const [x, y] = of(level);
    return { x, y, label: `light level ${number(level.light)}: mean ${number(level.mean)} DN` };
  }).filter((item) => Number.isFinite(item.x) && Number.isFinite(item.y));
  return (
    <>
      <Levels first={first} second={second} onPick={useCallback(pick((level) => [level.light, level.mean]), [first])}
        items={useMemo(() => itemsOf((level) => [level.light, level.mean]), [first])} />
      {first.some((level) => level.variance > 0) && <PhotonTransfer first={first} second={second}
        onPick={useCallback(pick((level) => [level.mean, level.variance]), [first])}
        items={itemsOf((level) => [level.mean, level.variance])} />}
    </>
  );
}

interface LevelProps {
  first: Level[];
  second?: Level[];
  onPick: (x: number, y: number, add: boolean) => void;
  items: Item[];
}

function Levels({ first, second, onPick, items }: LevelProps) {
  const draw = useCallback((width: number): Plot.PlotOptions => ({
    height: 240, marginLeft: 52, marginBottom: 38,
    x: { label: "light", ticks: width < 420 ? 4 : 6, tickSize: 4, nice: true },
    y: { label: "mean pixel value (DN)", ticks: 5, tickSize: 4, grid: true, nice: true },
    marks: [
      Plot.line(first, { x: "light", y: "predicted", stroke: palette.before, strokeWidth: 1.4 }),
      ...(second ? [Plot.line(second, { x: "light", y: "predicted", stroke: palette.after, strokeWidth: 1.4 })] : []),
      Plot.dot(first, { x: "light", y: "mean", r: 3.5, fill: palette.ink }),
    ],
  }), [first, second]);
  const off = (levels: Level[]) => number(Math.max(...levels.map((level) => Math.abs(level.mean - level.predicted))), 2);
  return (
    <Figure name="light levels" draw={draw} onPick={onPick} items={items} title={<>light levels <span class="quiet">means over all pixels</span></>}
      sentence={`Dots were measured, the orange line is the model: at most ${off(first)} DN off${second
        ? `; the blue line is the preview, at most ${off(second)} DN` : ""}. A curve is a response that is not linear.`} />
  );
}

function PhotonTransfer({ first, second, onPick, items }: LevelProps) {
  const lit = useMemo(() => [first, second].map((levels) => levels?.filter((level) => level.variance > 0 && level.stated > 0)), [first, second]);
  const draw = useCallback((width: number): Plot.PlotOptions => ({
    height: 240, marginLeft: 52, marginBottom: 38,
    x: { label: "mean pixel value (DN)", ticks: width < 420 ? 4 : 6, tickSize: 4, nice: true },
    y: { label: "variance (DN²)", ticks: 5, tickSize: 4, grid: true, nice: true, zero: true },
    marks: [
      Plot.line(lit[0]!, { x: "mean", y: "stated", stroke: palette.before, strokeWidth: 1.4 }),
      ...(lit[1] ? [Plot.line(lit[1], { x: "mean", y: "stated", stroke: palette.after, strokeWidth: 1.4 })] : []),
      Plot.dot(lit[0]!, { x: "mean", y: "variance", r: 3.5, fill: palette.ink }),
    ],
  }), [lit]);
  return (
    <Figure name="photon transfer" draw={draw} onPick={onPick} items={items}
      title={<>photon transfer <span class="quiet">variance against mean</span></>}
      sentence={`The noise of single values at each light level: dots were measured, the orange line is the model${second
        ? ", the blue line the preview" : ""}. Shot noise is a straight line, read noise where it begins, a spread of gains bends it up.`} />
  );
}
