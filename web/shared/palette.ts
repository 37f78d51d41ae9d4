// Colours of Okabe and Ito, darkened where they carry text. "Before" is always vermilion, "after"
// always blue, what the model states (formal errors, noise) always grey.
export const palette = {
  ink: "#18202b",
  ink2: "#4a5462",
  ink3: "#626c79",
  line: "#e2e5e9",
  before: "#c8500a",
  after: "#0072b2",
  formal: "#8a93a0",
  green: "#009e73",
  amber: "#e69f00",
  sky: "#56b4e9",
  pink: "#cc79a7",
} as const;

// For lines that stand side by side in one plot; the order is that of greatest contrast.
export const series = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#4a5462"];
