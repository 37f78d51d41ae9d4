// All rows of a set, of which only those in sight are in the page.
import { elementScroll, observeElementOffset, observeElementRect, Virtualizer } from "@tanstack/virtual-core";
import { signal } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";
import { number } from "../shared/format";
import { Rich } from "../shared/rich";
import type { Rows } from "./rows";

const shownColumns = 9;
const cell = (value: number) => (Number.isInteger(value) ? String(value) : number(value, 5));

export function RowList({ rows }: { rows: Rows }) {
  const scroll = useRef<HTMLDivElement>(null);
  const turn = useMemo(() => signal(0), [rows]);
  const list = useMemo(() => new Virtualizer<HTMLDivElement, HTMLDivElement>({
    count: rows.n, estimateSize: () => 26, overscan: 8, getScrollElement: () => scroll.current,
    scrollToFn: elementScroll, observeElementRect, observeElementOffset, onChange: () => (turn.value += 1),
  }), [rows]);
  useEffect(() => {
    const stop = list._didMount();
    list._willUpdate();
    turn.value += 1;
    return stop;
  }, [list]);
  void turn.value;
  const names = rows.names.filter((name) => !name.includes("*") && !name.startsWith("sign(")).slice(0, shownColumns);
  return (
    <div class="rows" ref={scroll} tabIndex={0} role="table" aria-rowcount={rows.n} aria-label="Rows of the set">
      <div class="row head" role="row">{names.map((name) => <span key={name} role="columnheader">{name}</span>)}</div>
      <div role="rowgroup" style={{ height: `${list.getTotalSize()}px`, position: "relative" }}>
        {list.getVirtualItems().map((item) => (
          <div key={item.key} class="row num" role="row" aria-rowindex={item.index + 1}
            style={{ position: "absolute", top: 0, transform: `translateY(${item.start}px)` }}>
            {names.map((name) => <span key={name} role="cell"><Rich text={cell(rows.column(name)![item.index])} /></span>)}
          </div>
        ))}
      </div>
    </div>
  );
}
