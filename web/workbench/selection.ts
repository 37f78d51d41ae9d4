// The rows that a person has chosen: one selection for all plots. Kept by the server, so that a reload has it again.
import { signal } from "@preact/signals";

export type Range = [number, number];

export interface Selection {
  mask: Uint8Array;
  count: number;
  /** What was chosen, in words. */
  what: string;
}

const none: Selection = { mask: new Uint8Array(0), count: 0, what: "" };

export const selection = signal<Selection>(none);

export function clearSelection(): void {
  selection.value = none;
}

/** Chooses the rows for which `wants` holds, besides those chosen already where `add` is set. */
export function choose(n: number, wants: (row: number) => boolean, what: string, add = false): void {
  const old = selection.peek();
  const keep = add && old.mask.length === n;
  const mask = keep ? old.mask.slice() : new Uint8Array(n);
  let count = keep ? old.count : 0;
  for (let i = 0; i < n; ++i) {
    if (mask[i] || !wants(i)) continue;
    mask[i] = 1;
    ++count;
  }
  selection.value = count > 0 ? { mask, count, what: keep && old.what ? `${old.what}; ${what}` : what } : none;
}

/** The rows as ranges, first and last included. */
export function rangesOf({ mask }: Selection): Range[] {
  const ranges: Range[] = [];
  for (let i = 0; i < mask.length; ++i) {
    if (!mask[i]) continue;
    const last = ranges[ranges.length - 1];
    if (last && last[1] === i - 1) last[1] = i;
    else ranges.push([i, i]);
  }
  return ranges;
}

export function fromRanges(n: number, ranges: Range[], what: string): void {
  const mask = new Uint8Array(n);
  let count = 0;
  for (const [from, to] of ranges) {
    for (let i = Math.max(0, from); i <= Math.min(n - 1, to); ++i) {
      count += mask[i] ? 0 : 1;
      mask[i] = 1;
    }
  }
  selection.value = count > 0 ? { mask, count, what } : none;
}

export function rowsOf({ mask, count }: Selection, most: number): number[] {
  const rows: number[] = [];
  for (let i = 0; i < mask.length && rows.length < Math.min(count, most); ++i) if (mask[i]) rows.push(i);
  return rows;
}
