// CodeMirror for formulas: completion of the stage's variables, and what is wrong underlined where it is.
import { autocompletion, completionKeymap, type CompletionContext } from "@codemirror/autocomplete";
import { defaultKeymap, history, historyKeymap } from "@codemirror/commands";
import { linter, type Diagnostic } from "@codemirror/lint";
import { EditorState, StateEffect } from "@codemirror/state";
import { EditorView, keymap, lineNumbers, placeholder, type ViewUpdate } from "@codemirror/view";

export interface Editor {
  set: (text: string) => void;
  /** Checks the same text once more: what it is checked with has changed. */
  checkAgain: () => void;
  destroy: () => void;
}

interface Fault {
  line: number;
  column: number;
  text: string;
}

interface Variable {
  name: string;
  unit?: string;
  meaning?: string;
}

const look = EditorView.theme({
  "&": { backgroundColor: "var(--card)", color: "var(--ink)", fontSize: "14px" },
  "&.cm-focused": { outline: "2px solid var(--blue)", outlineOffset: "1px" },
  ".cm-content": { fontFamily: "var(--mono)", padding: "10px 0", caretColor: "var(--ink)", minHeight: "120px" },
  ".cm-gutters": { backgroundColor: "var(--card)", color: "var(--ink-3)", border: "none" },
  ".cm-cursor": { borderLeftColor: "var(--ink)" },
  ".cm-tooltip": { backgroundColor: "var(--card)", color: "var(--ink)", border: "1px solid var(--line)" },
  ".cm-tooltip-autocomplete ul li[aria-selected]": { backgroundColor: "var(--chosen)", color: "var(--ink)" },
  ".cm-placeholder": { color: "var(--ink-3)" },
});

const again = StateEffect.define<null>();

export function makeEditor(parent: HTMLElement, text: string, variables: () => Variable[],
  check: (text: string) => Promise<Fault[]>): Editor {
  const complete = (context: CompletionContext) => {
    const word = context.matchBefore(/[a-zA-Z_][a-zA-Z0-9_]*/);
    if (!word && !context.explicit) return null;
    return { from: word?.from ?? context.pos, options: variables().map(({ name, unit, meaning }) =>
      ({ label: name, detail: unit, info: meaning, type: "variable" })) };
  };
  const lint = async (view: EditorView): Promise<Diagnostic[]> => {
    const faults = await check(view.state.doc.toString());
    return faults.map(({ line, column, text: message }) => {
      const at = view.state.doc.line(Math.max(1, Math.min(line, view.state.doc.lines)));
      const from = Math.min(at.to, at.from + Math.max(0, column - 1));
      return { from, to: Math.min(view.state.doc.length, from + 1), severity: "error", message };
    });
  };
  const refresh = (update: ViewUpdate) => update.transactions.some((one) => one.effects.some((effect) => effect.is(again)));
  const view = new EditorView({
    parent,
    state: EditorState.create({ doc: text, extensions: [
      lineNumbers(), history(), autocompletion({ override: [complete] }), linter(lint, { delay: 250, needsRefresh: refresh }), look,
      keymap.of([...completionKeymap, ...defaultKeymap, ...historyKeymap]),
      EditorView.contentAttributes.of({ "aria-label": "Formula" }), placeholder("parameters: {k: {scale: 1}}\nu_px: k * row * pan_rate"),
    ] }),
  });
  return {
    set: (next) => {
      if (next === view.state.doc.toString()) return;
      view.dispatch({ changes: { from: 0, to: view.state.doc.length, insert: next } });
    },
    checkAgain: () => view.dispatch({ effects: again.of(null) }),
    destroy: () => view.destroy(),
  };
}
