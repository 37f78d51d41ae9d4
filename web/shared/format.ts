// Numbers as people read them: few digits, true minus signs, powers of ten written out.

/** Powers are written 10^−4; `Rich` sets what follows the ^ higher. */
function power(exponent: number): string {
  return `10^${minus(String(exponent))}`;
}

/** A number to `digits` significant digits; very large and small ones with a power of ten. */
export function number(value: number | null | undefined, digits = 3): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e-4 && size < 1e6) {
    const places = Math.max(0, digits - 1 - Math.floor(Math.log10(size)));
    return minus(value.toFixed(Math.min(places, 12)));
  }
  const [mantissa, exponent] = value.toExponential(digits - 1).split("e");
  return `${minus(mantissa)} × ${power(Number(exponent))}`;
}

function minus(text: string): string {
  return text.replace("-", "−");
}

/** A value with its one-sigma error, both to the error's second digit: (2.4010 ± 0.0061) × 10^−4. An error below the
 * ninth digit of the value is what a computation's last digits leave: the value then stands alone. */
export function withSigma(value: number | null, sigma: number | null | undefined): string {
  if (value === null) return "–";
  if (!sigma || !Number.isFinite(sigma)) return number(value, 4);
  if (sigma < 1e-9 * Math.abs(value)) return number(value, 6);
  const size = Math.max(Math.abs(value), sigma);
  const scale = size < 1e-3 || size >= 1e5 ? Math.floor(Math.log10(size)) : 0;
  const places = Math.max(0, Math.min(9, 1 - Math.floor(Math.log10(sigma / 10 ** scale))));
  const mantissa = minus((value / 10 ** scale).toFixed(places));
  const error = (sigma / 10 ** scale).toFixed(places);
  return scale ? `(${mantissa} ± ${error}) × ${power(scale)}` : `${mantissa} ± ${error}`;
}

/** A p-value; the analysis writes what is below 1e-300 as 1e-300. */
export function pValue(p: number | null | undefined): string {
  if (p === null || p === undefined) return "–";
  if (p <= 1e-300) return `< ${power(-300)}`;
  if (p < 1e-3) return power(Math.round(Math.log10(p)));
  return number(p, 2);
}

export const ditto = "″";

/** The p-values of a table's rows: in rows on end what is below 1e-300 is said once, then by ditto marks. */
export function pColumn(values: (number | null | undefined)[]): string[] {
  const cut = (p: number | null | undefined) => p !== null && p !== undefined && p <= 1e-300;
  return values.map((p, i) => (cut(p) && i > 0 && cut(values[i - 1]) ? ditto : pValue(p)));
}

export function percent(fraction: number | null | undefined): string {
  if (fraction === null || fraction === undefined || !Number.isFinite(fraction)) return "–";
  const value = fraction * 100;
  const places = Math.abs(value) >= 99.95 || Math.abs(value) < 10 ? 2 : 1;
  return `${minus(value.toFixed(places))} %`;
}

export function count(n: number | undefined): string {
  return n === undefined ? "–" : n.toLocaleString("en-US").replaceAll(",", " ");
}

const units = ["px", "mps", "radps", "rad", "dn", "mm", "m", "s", "hz", "v", "nm"];
const unitText: Record<string, string> = {
  mps: "m/s", radps: "rad/s", dn: "DN", hz: "Hz", v: "V", nm: "N m",
};

/** Splits `u_px` into name and unit: names carry their unit as ending. */
export function splitUnit(name: string): { name: string; unit: string } {
  if (name === "dn") return { name: "pixel value", unit: "DN" };
  const cut = name.lastIndexOf("_");
  const ending = name.slice(cut + 1);
  if (cut > 0 && units.includes(ending)) {
    return { name: name.slice(0, cut), unit: unitText[ending] ?? ending };
  }
  return { name, unit: "" };
}

const unitOfCovariate: Record<string, string> = {
  row: "px", column: "px", radius: "", illumination: "", time: "s", time_since_change: "s", range: "m", distance: "m", x_moved: "m",
  y_moved: "m", speed: "m/s", tilt: "rad", pan: "rad", roll: "rad", bearing: "rad", heading: "rad", turn: "rad",
};

/** The unit of one factor: "" has none (signs, labels, shares); undefined is not known. */
function factorUnit(name: string): string | undefined {
  if (name.startsWith("sign(")) return "";
  if (name.endsWith("_rate")) return "rad/s";
  return unitOfCovariate[name] ?? (splitUnit(name).unit || undefined);
}

/** The unit of a covariate or of a product of two: px rad/s for row*pan_rate; "" where it is not known. */
export function covariateUnit(name: string): string {
  const units = name.split("*").map(factorUnit);
  if (units.includes(undefined)) return "";
  return units.filter(Boolean).join(" ");
}

/** Rounded down to 1, 2 or 5 times a power of ten. */
export function roundScale(x: number): number {
  const power = 10 ** Math.floor(Math.log10(x));
  const lead = x / power;
  return (lead >= 5 ? 5 : lead >= 2 ? 2 : 1) * power;
}

/** The value below which a share q of the values lies; 0 of none. */
export function quantile(values: number[], q: number): number {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted.length === 0 ? 0 : sorted[Math.min(sorted.length - 1, Math.floor(q * sorted.length))];
}

/** The least that a colour or an arrow stands for: below are a computation's last digits, which no scale enlarges. */
export function leastShown(unit: string): number {
  return { px: 1e-3, DN: 1e-2, m: 1e-5, rad: 1e-6 }[unit] ?? 0;
}

/** A residual or covariate for a person: `row*pan_rate` -> `row × pan rate`. */
export function words(name: string): string {
  return name.replaceAll("*", " × ").replaceAll("_", " ");
}
