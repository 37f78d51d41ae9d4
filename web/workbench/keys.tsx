// Which keys do what: a button beside undo and the key "?" show it.
const all: [string, string][] = [
  ["Alt 1 to Alt 6", "the screens: Data, Work, Formula, See it, Plan, Session"],
  ["Ctrl Z, Ctrl Shift Z", "undo, redo"],
  ["↑ ↓, Home, End", "in the list of candidates: preview the next in all plots"],
  ["Enter, Esc", "add the previewed candidate; back to the model as it is"],
  ["Tab to a plot, arrow keys", "move a rectangle over it, or go from bar to bar; with Shift the rectangle changes its size"],
  ["Enter, Shift Enter", "in a plot: choose these rows, or add them to those chosen"],
  ["Delete", "leave out the chosen rows, with a reason"],
  ["?", "this list"],
];

let dialog: HTMLDialogElement | null = null;

export const showKeys = (): void => dialog?.showModal();

export function Keys() {
  return (
    <>
      <button type="button" class="keys-button" aria-label="Keys" title="Which keys do what (?)" onClick={showKeys}>?</button>
      <dialog ref={(element) => { dialog = element; }} class="keys-list" aria-labelledby="keys-title">
        <h2 id="keys-title">Keys</h2>
        <dl>{all.map(([keys, what]) => <div key={keys + what}><dt>{keys}</dt><dd>{what}</dd></div>)}</dl>
        <button type="button" class="primary" onClick={() => dialog?.close()}>Close</button>
      </dialog>
    </>
  );
}
