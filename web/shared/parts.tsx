// Small drawings and lists that stand in tables: parameters with their errors, gains, strengths.
import { ditto, number, percent, pValue, splitUnit, withSigma } from "./format";
import { Rich } from "./rich";
import { asValue, type Parameters, type Structure } from "./types";

export function ParameterList({ parameters }: { parameters?: Parameters }) {
  const entries = Object.entries(parameters ?? {});
  if (entries.length === 0) return <span class="quiet">none</span>;
  return (
    <ul class="parameters num">
      {entries.map(([name, parameter]) => {
        const { value, sigma } = asValue(parameter);
        return <li key={name}><code>{name}</code> <Rich text={withSigma(value, sigma)} /></li>;
      })}
    </ul>
  );
}

/** An entry of pColumn: on a narrow page, where each row is a card, nothing stands above a ditto mark. */
export function PValue({ text }: { text: string }) {
  if (text !== ditto) return <Rich text={text} />;
  return <><span class="in-rows">{ditto}</span><span class="in-cards"><Rich text={pValue(0)} /></span></>;
}

/** A bar from zero with a whisker of one standard error; a loss is drawn to the left in grey. */
export function Gain({ gain: value, sigma: error }: { gain: number | null | undefined; sigma?: number | null }) {
  const width = 96;
  if (value === null || value === undefined) return <span class="quiet">already at the noise</span>;
  const gain = Math.max(-0.25, Math.min(1, value));
  const zero = 12;
  const scale = width - zero;
  const sigma = error ?? 0;
  const left = Math.max(0, zero + scale * (value - sigma));
  const right = Math.min(width, zero + scale * (value + sigma));
  return (
    <div class="gain num">
      <svg width={width} height="16" aria-hidden="true">
        <rect x={Math.max(0, zero + Math.min(0, gain * scale))} y="3" height="10" rx="1.5"
          width={Math.min(Math.abs(gain) * scale, gain < 0 ? zero : scale)}
          class={gain < 0 ? "loss" : "win"} />
        <line x1={zero} x2={zero} y1="0" y2="16" class="axis" />
        {sigma > 0 && left < right && <line x1={left} x2={right} y1="8" y2="8" class="whisker" />}
      </svg>
      {percent(Math.min(1, value))}
    </div>
  );
}

/** How strong a structure is beside the others of its unit. */
export function Strength({ item, all }: { item: Structure; all: Structure[] }) {
  const { unit } = splitUnit(item.residual);
  const same = all.filter((other) => splitUnit(other.residual).unit === unit);
  const most = Math.max(...same.map((other) => other.strength ?? 0)) || 1;
  const share = Math.max(0, Math.min(1, (item.strength ?? 0) / most));
  return (
    <div class="strength num">
      <svg width="90" height="12" aria-hidden="true">
        <rect x="0" y="2" width={Math.max(1.5, 90 * share)} height="8" rx="1.5" />
      </svg>
      <span><Rich text={number(item.strength)} /> {unit}</span>
    </div>
  );
}
