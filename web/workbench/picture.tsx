// The picture that the chosen rows were found in, with where each was seen and where the model expects it.
import { signal } from "@preact/signals";
import { number, roundScale } from "../shared/format";
import { palette } from "../shared/palette";
import { rowsOf, selection } from "./selection";
import type { View } from "./plots/view";
import { shownOf } from "./plots/view";

const mostMarks = 400;
const missing = signal("");

/** Of the first chosen row's frame. */
export function Picture({ view }: { view: View }) {
  const { rows, image } = view;
  const chosen = rowsOf(selection.value, mostMarks);
  const group = rows.column("group"), frame = group && rows.words.names?.group?.[group[chosen[0]]];
  const [u, v] = [rows.column("u_px"), rows.column("v_px")];
  if (!image || !group || !frame || !u || !v || !/\.(png|jpe?g)$/i.test(frame) || missing.value === frame) return null;
  const now = shownOf(view), [du, dv] = [now.r.get("u_px")!, now.r.get("v_px")!];
  const here = chosen.filter((i) => group[i] === group[chosen[0]]);
  const unit = image.width_px / 300;
  const longest = Math.max(...here.map((i) => Math.hypot(du[i], dv[i])).filter(Number.isFinite), 0);
  // So that the longest is seen beside its ring, as long as a twelfth of the image at most.
  const times = longest > 0 ? Math.max(1, roundScale(image.width_px / 12 / longest)) : 1;
  return (
    <figure class="picture">
      <div style={{ aspectRatio: `${image.width_px} / ${image.height_px}` }}>
        <img src={`api/picture?frame=${encodeURIComponent(frame)}`} alt={`picture ${frame}`} onError={() => (missing.value = frame)} />
        <svg viewBox={`-0.5 -0.5 ${image.width_px} ${image.height_px}`} aria-hidden="true">
          {here.map((i) => (
            <g key={i} fill="none" stroke={palette.pink} stroke-width={unit}>
              <circle cx={u[i]} cy={v[i]} r={2 * unit} />
              {Number.isFinite(du[i]) && <line x1={u[i]} y1={v[i]} x2={u[i] + times * du[i]} y2={v[i] + times * dv[i]}
                stroke={palette.after} stroke-width={1.4 * unit} />}
            </g>
          ))}
        </svg>
      </div>
      <figcaption><code>{frame}</code>: rings are where the chosen rows were seen; lines show observed minus predicted, {number(times, 2)} times as long.</figcaption>
    </figure>
  );
}
