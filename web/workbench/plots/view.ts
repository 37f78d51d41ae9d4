// What the plots of one moment show: the rows, the residuals of the model, and those of a preview where there is one.
import type { Numbers, Residuals, Rows } from "../rows";

export interface View {
  version: string;
  rows: Rows;
  before: Residuals;
  after?: Residuals;
  /** What the second residuals are of, for captions: "with rolling_shutter". */
  with?: string;
  image?: { width_px: number; height_px: number };
  noise: Record<string, number>;
}

/** Of the camera's image; where the set does not say it, what holds all points. Undefined where points are none of an image. */
export function imageOf({ rows, image }: View): { width_px: number; height_px: number } | undefined {
  const [u, v] = [rows.column("u_px"), rows.column("v_px")];
  if (!u || !v) return undefined;
  const most = (values: Numbers) => {
    let high = 0;
    for (const value of values) if (value > high) high = value;
    return high + 1;
  };
  return image ?? { width_px: most(u), height_px: most(v) };
}

/** The height of a plot of the image, with the margins that its axes need. */
export const imageHeight = (width: number, image: { width_px: number; height_px: number }): number =>
  Math.round((width - 52) * (image.height_px / image.width_px)) + 62;

/** The residuals that dots, arrows and selections are of: the preview's where there is one. */
export const shownOf = (view: View): Residuals => view.after ?? view.before;

/** Every k-th row, so that at most so many are drawn. */
export function everyFew(rows: Rows, most: number): Uint32Array {
  const step = Math.max(1, Math.ceil(rows.n / most));
  return Uint32Array.from({ length: Math.floor((rows.n + step - 1) / step) }, (_, i) => i * step);
}
