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

/** A value with its one-sigma error, both to the error's second digit: (2.4010 ± 0.0061) × 10^−4. */
export function withSigma(value: number | null, sigma: number | null | undefined): string {
  if (value === null) return "–";
  if (!sigma || !Number.isFinite(sigma)) return number(value, 4);
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

/** The unit of the covariates that every kind of measurement knows; "" for others. */
export function covariateUnit(name: string): string {
  if (name.includes("*") || name.startsWith("sign(")) return "";
  if (["row", "column"].includes(name)) return "px";
  if (name === "time") return "s";
  if (name === "range") return "m";
  if (["tilt", "pan", "roll", "bearing", "heading"].includes(name)) return "rad";
  return /^(tilt|pan|roll)_rate$/.test(name) ? "rad/s" : "";
}

/** A residual or covariate for a person: `row*pan_rate` -> `row × pan rate`. */
export function words(name: string): string {
  return name.replaceAll("*", " × ").replaceAll("_", " ");
}
