// Whole images: a strip of those measured; of the chosen one what the model predicts, what the preview predicts, and what
// remains.
import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import * as api from "../api";
import { FrameCanvas } from "../frame_canvas";
import { choose, selection } from "../selection";
import { preview, version } from "../store";
import type { View } from "./view";

type Strip = api.Strip | null;
const measured = signal<Strip>(null), predicted = signal<Strip>(null), previewed = signal<Strip>(null);
const chosen = signal(0);

async function read(into: typeof measured, what: Parameters<typeof api.strip>[1]): Promise<void> {
  const id = version.value?.id;
  if (!id) return;
  const found = await api.strip(id, what).catch(() => null);
  if (version.value?.id === id) into.value = found;
}

export function FramePlots({ view }: { view: View }) {
  const id = version.value?.id, effect = preview.value?.residuals ? preview.value.effect : "";
  useEffect(() => {
    void read(measured, { what: "measured" });
    void read(predicted, {});
  }, [id, view.rows]);
  useEffect(() => {
    previewed.value = null;
    if (effect) void read(previewed, { effect });
  }, [id, effect]);
  const seen = measured.value, model = predicted.value;
  if (!seen || !model) return null;
  const at = Math.min(chosen.value, seen.frames.length - 1), frame = seen.frames[at];
  const pick = (k: number) => {
    chosen.value = k;
    choose(view.rows.n, (row) => row === seen.frames[k].row, `frame ${seen.frames[k].name}`);
  };
  const shown = previewed.value ?? model;
  return (
    <section class="figure wide frame-strip" data-plot="frames">
      <h3>frames <span class="quiet">measured, predicted, and what remains</span></h3>
      <div class="strip" role="group" aria-label="Frames">
        {seen.frames.map((one, k) => (
          <button key={one.row} type="button" aria-pressed={k === at} class={selection.value.mask[one.row] ? "marked" : ""}
            onClick={() => pick(k)}><FrameCanvas now={seen.images[k]} label={`frame ${one.name}`} /><span class="num small">{one.name}</span></button>
        ))}
      </div>
      <div class="frames">
        <Part title={`measured: frame ${frame.name}, line ${frame.line}`}><FrameCanvas now={seen.images[at]} label="measured" /></Part>
        <Part title="the model predicts"><FrameCanvas now={model.images[at]} label="predicted" /></Part>
        {previewed.value && <Part title={`with ${effect}`}><FrameCanvas now={shown.images[at]} label="predicted with the preview" /></Part>}
        <Part title={previewed.value ? "what the preview leaves" : "what remains"}>
          <FrameCanvas now={seen.images[at]} less={shown.images[at]} label="measured minus predicted" /></Part>
      </div>
    </section>
  );
}

const Part = ({ title, children }: { title: string; children: preact.ComponentChildren }) => (
  <figure class="frame"><h3>{title}</h3>{children}</figure>
);
