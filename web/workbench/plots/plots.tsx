// The plots that fit the kind of measurement, all of the same rows: what is chosen in one is marked in all.
import type { ComponentChildren } from "preact";
import { useLayoutEffect, useMemo, useRef, useState } from "preact/hooks";
import { afterTurns, forget, inTurn } from "../../shared/turns";
import { look, lookAt, session, view } from "../store";
import { ArrowPlot } from "./arrows";
import { CovariatePlot } from "./covariate";
import { FlatPlots } from "./flats";
import { FramePlots } from "./frames";
import { GroupPlot } from "./groups";
import { LandmarkPlots } from "./landmarks";
import { MapPlot } from "./map";
import { OutcomePlots } from "./outcomes";
import { ServoPlots } from "./servo";
import { SpreadPlot } from "./spread";
import { WalkPlots } from "./walk";
import { shownOf, type View } from "./view";

const ids = ["line", "held_out", "outlier", "left_out", "u_px", "v_px"];

/** The two covariates of the map: the factors of the structure's product, else the image, else time and another. */
function axesOf({ rows }: View, covariate: string): [string, string] | null {
  const factors = covariate.split("*").map((name) => name.replace(/^sign\((.*)\)$/, "$1"));
  const has = (...names: string[]) => names.every((name) => rows.has(name));
  if (factors.length > 1 && has(...factors)) return [factors[1], factors[0]];
  if (has("column", "row")) return ["column", "row"];
  if (has("u_px", "v_px")) return ["u_px", "v_px"];
  const others = rows.names.filter((name) => !ids.includes(name) && name !== "group" && name !== factors[0] && !name.includes("*"));
  return has(factors[0]) && others.length > 0 ? [factors[0], others.includes("time") ? "time" : others[0]] : null;
}

/** Plots of what was measured, where the set's kind has some. */
function ofKind(now: View) {
  if (now.rows.data("command_rad")) return <ServoPlots view={now} />;
  if (now.rows.data("x_m")) return <WalkPlots view={now} />;
  if (now.rows.data("robot_x_m")) return <LandmarkPlots view={now} />;
  if (now.rows.data("statistic")) return <OutcomePlots view={now} />;
  if (now.rows.data("observed dn")) return <FlatPlots view={now} />;
  return null;
}

interface Shown {
  view: View;
  item: NonNullable<typeof look.value>;
}

/** One plot, which follows what is shown when its turn comes: all at once would stall the page. */
function Turn({ shown, plot }: { shown: Shown; plot: (of: Shown) => ComponentChildren }) {
  const [now, follow] = useState<Shown | null>(null);
  const self = useRef(null);
  useLayoutEffect(() => {
    inTurn(self, () => follow(shown));
    return () => forget(self);
  }, [shown]);
  return <>{now && plot(now)}</>;
}

function covariatePlot({ view: now, item }: Shown) {
  const covariates = [...new Set([...now.rows.names.filter((name) => !ids.includes(name)), item.covariate])];
  return (
    <CovariatePlot view={now} residual={item.residual} covariate={item.covariate} moment={item.moment}
      residuals={[...shownOf(now).r.keys()]} covariates={covariates}
      onChoose={(residual, covariate) => lookAt({ residual, covariate, moment: "mean" })} />
  );
}

function mapPlot({ view: now, item }: Shown) {
  const axes = axesOf(now, item.covariate);
  return axes && !now.rows.data("statistic") && <MapPlot view={now} residual={item.residual} x={axes[0]} y={axes[1]} />;
}

/** Of flat fields: where in the image. */
function imagePlot({ view: now, item }: Shown) {
  const wanted = now.rows.data("observed dn") && now.rows.has("column") && now.rows.has("row") &&
    axesOf(now, item.covariate)?.[1] !== "row";
  return wanted && <MapPlot view={now} residual={item.residual} x="column" y="row" called="map over the image" />;
}

const inImage = ({ view: now }: Shown) => now.before.r.has("u_px") && now.rows.has("u_px");

const all: ((of: Shown) => ComponentChildren)[] = [
  covariatePlot,
  (of) => inImage(of) && <ArrowPlot view={of.view} />,
  (of) => ofKind(of.view),
  mapPlot,
  imagePlot,
  ({ view: now, item }) => <SpreadPlot view={now} residual={item.residual} />,
  ({ view: now }) => <GroupPlot view={now} name={session.value?.set?.group || "group"} labels={now.rows.words.names?.group} />,
];

/** What the plots show, once all of them show it. */
function useDrawn(now: View): { "data-version": string; "data-preview": string } {
  const [drawn, setDrawn] = useState<View | null>(null);
  const self = useRef(null);
  useLayoutEffect(() => {
    afterTurns(self, () => setDrawn(now));
    return () => forget(self);
  }, [now]);
  return { "data-version": drawn?.version ?? "", "data-preview": drawn?.with ?? "" };
}

export function Plots() {
  const now = view.value!, item = look.value;
  const drawn = useDrawn(now);
  const shown = useMemo(() => (item && now.before.r.has(item.residual) && now.rows.has(item.covariate) ? { view: now, item } : null), [now, item]);
  if (session.value?.set?.kind === "frames") return <div class="figures" {...drawn}><FramePlots view={now} /></div>;
  return shown && <div class="figures" {...drawn}>{all.map((plot, i) => <Turn key={i} shown={shown} plot={plot} />)}</div>;
}
