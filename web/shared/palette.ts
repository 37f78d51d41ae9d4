// The theme's colours for drawings: "before" is always vermilion, "after" always blue, what the model states
// (formal errors, noise) always grey. Whatever reads them is drawn again when the system turns dark or light.
import { signal } from "@preact/signals";

const names = {
  ink: "--ink", ink2: "--ink-2", ink3: "--ink-3", line: "--line", grid: "--line-2", card: "--card", page: "--page",
  before: "--before", after: "--after", formal: "--formal", dot: "--dot", middle: "--middle",
  green: "--mark-green", amber: "--mark-amber", sky: "--sky", pink: "--pink",
} as const;

export type Colour = keyof typeof names;

const dark = matchMedia("(prefers-color-scheme: dark)");
const known = new Map<string, string>();

/** Whether the page is dark; drawings that read it or a colour follow it. */
export const isDark = signal(dark.matches);
/** The colour of lines that were measured, in words. */
export const inkName = () => (isDark.value ? "White" : "Black");
dark.addEventListener("change", () => {
  known.clear();
  isDark.value = dark.matches;
});

function colourOf(name: string): string {
  isDark.value;
  let colour = known.get(name);
  if (colour === undefined) {
    colour = getComputedStyle(document.documentElement).getPropertyValue(name).trim();
    known.set(name, colour);
  }
  return colour;
}

export const palette = Object.defineProperties({}, Object.fromEntries(Object.entries(names).map(
  ([key, name]) => [key, { enumerable: true, get: () => colourOf(name) }]))) as Readonly<Record<Colour, string>>;

// For lines that stand side by side in one plot; the order is that of greatest contrast.
export const series = () => (isDark.value
  ? ["#4ea9e2", "#f08040", "#45c89f", "#e09bc1", "#e3a83b", "#7cc6f0", "#b7bfca"]
  : ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#4a5462"]);
