// A frame as pixels, or how its brightness differs from another's.
import { useEffect, useRef, useState } from "preact/hooks";
import { number } from "../shared/format";
import { isDark, palette } from "../shared/palette";
import type { SeenFrame } from "./api";
import { channels } from "./paint";

/** At least 8 of 255 has full colour: below it nobody sees a change. */
const leastReach = 8;

function differenceOf(a: SeenFrame, b: SeenFrame): { values: Float32Array; reach: number } {
  const values = new Float32Array(a.rgb.length / 3);
  if (a.rgb.length !== b.rgb.length) return { values, reach: leastReach };
  for (let i = 0; i < values.length; ++i)
    values[i] = (a.rgb[3 * i] + a.rgb[3 * i + 1] + a.rgb[3 * i + 2] - b.rgb[3 * i] - b.rgb[3 * i + 1] - b.rgb[3 * i + 2]) / 3;
  const sizes = values.map(Math.abs).sort();
  return { values, reach: Math.max(leastReach, sizes[Math.floor(0.99 * sizes.length)]) };
}

function paint(canvas: HTMLCanvasElement, now: SeenFrame, less?: SeenFrame): string {
  [canvas.width, canvas.height] = [now.width_px, now.height_px];
  const context = canvas.getContext("2d")!;
  const image = context.createImageData(now.width_px, now.height_px);
  const difference = less ? differenceOf(now, less) : null;
  const [low, middle, high] = [palette.after, palette.middle, palette.before].map(channels);
  for (let i = 0; i < now.width_px * now.height_px; ++i) {
    const share = difference ? Math.max(-1, Math.min(1, difference.values[i] / difference.reach)) : 0;
    for (let c = 0; c < 3; ++c)
      image.data[4 * i + c] = difference ? middle[c] + Math.abs(share) * ((share < 0 ? low : high)[c] - middle[c]) : now.rgb[3 * i + c];
    image.data[4 * i + 3] = 255;
  }
  context.putImageData(image, 0, 0);
  if (difference?.values.every((value) => value === 0)) return "The two are equal.";
  return difference ? `Orange is brighter, blue darker; full colour from ${number(difference.reach, 2)} of 255 on.` : "";
}

/** `less`: the frame that is taken away. */
export function FrameCanvas({ now, less, label }: { now: SeenFrame; less?: SeenFrame; label: string }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const [says, setSays] = useState("");
  useEffect(() => setSays(paint(canvas.current!, now, less)), [now, less, isDark.value]);
  return <><canvas ref={canvas} role="img" aria-label={label} />{says && <figcaption>{says}</figcaption>}</>;
}
