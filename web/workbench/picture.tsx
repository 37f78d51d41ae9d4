// The picture that the chosen rows were found in, with where each was seen and where the model expects it.
import { signal } from "@preact/signals";
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
  return (
    <figure class="picture">
      <div style={{ aspectRatio: `${image.width_px} / ${image.height_px}` }}>
        <img src={`api/picture?frame=${encodeURIComponent(frame)}`} alt={`picture ${frame}`} onError={() => (missing.value = frame)} />
        <svg viewBox={`-0.5 -0.5 ${image.width_px} ${image.height_px}`} aria-hidden="true">
          {here.map((i) => (
            <g key={i} fill="none" stroke={palette.pink} stroke-width={unit}>
              <circle cx={u[i]} cy={v[i]} r={3 * unit} />
              {Number.isFinite(du[i]) && <circle cx={u[i] - du[i]} cy={v[i] - dv[i]} r={unit} fill={palette.after} stroke="none" />}
            </g>
          ))}
        </svg>
      </div>
      <figcaption><code>{frame}</code>: rings are where the chosen rows were seen, dots where the model expects them.</figcaption>
    </figure>
  );
}
