// Open measurements: a folder's path, files dropped or chosen, samples, and what was open before.
import { signal } from "@preact/signals";
import { filesChosen, filesDropped } from "./dropped";
import { ImportForm, importing, receive } from "./import";
import type { Place } from "./model";
import { begin, busy, openPlace, session } from "./store";

const path = signal("");
const over = signal(false);

async function openPath(at: string): Promise<void> {
  if (await openPlace(at)) begin();
}

export function OpenScreen() {
  const now = session.value!;
  return (
    <div class="page open-screen">
      <h1>Which effect is missing in your model?</h1>
      <p class="lead">Open measurements and a model. The workbench shows where the model fails, previews the effects that could explain
        it, and keeps each step as files.</p>
      <div class={over.value ? "drop over" : "drop"} onDragOver={(e) => { e.preventDefault(); over.value = true; }}
        onDragLeave={() => (over.value = false)}
        onDrop={(e) => { e.preventDefault(); over.value = false; void filesDropped(e.dataTransfer).then(receive); }}>
        <p><b>Drop files or a folder here</b>: pictures of a board, logs, tables, a measurement set. Or{" "}
          <label class="file">choose files
            <input type="file" multiple onChange={(e) => void receive(filesChosen(e.currentTarget.files))} /></label> or{" "}
          <label class="file">a folder
            <input type="file" {...{ webkitdirectory: true }} onChange={(e) => void receive(filesChosen(e.currentTarget.files))} /></label>.</p>
        <ImportForm />
        {now.named.length > 0 && (
          <form onSubmit={(e) => { e.preventDefault(); void openPath(path.value.trim()); }}>
            <label><span>Folder of a measurement set, in <code>{now.named.join(", ")}</code></span>
              <input value={path.value} placeholder={now.named[0]} required onInput={(e) => (path.value = e.currentTarget.value)} /></label>
            <button type="submit" disabled={busy.value !== ""}>Open</button>
          </form>
        )}
        {busy.value && !importing() && <p role="status" class="quiet">{busy.value} …</p>}
      </div>
      <Places title="Samples" places={now.samples} empty="No samples are installed beside this program." />
      <Places title="Opened before" places={now.recent} empty="Nothing was opened before." />
    </div>
  );
}

function Places({ title, places, empty }: { title: string; places: Place[]; empty: string }) {
  return (
    <section>
      <h2>{title}</h2>
      {places.length === 0 ? <p class="empty">{empty}</p> : (
        <ul class="places">
          {places.map((place) => (
            <li key={place.path}><button type="button" disabled={busy.value !== ""} onClick={() => void openPath(place.path)}>
              <b>{place.title ?? place.name}</b>
              <span class="quiet">{place.kind}{!place.path.startsWith("sample:") && ` · ${place.path}`}</span>
            </button></li>
          ))}
        </ul>
      )}
    </section>
  );
}
