// A table of data. On a narrow page each row becomes a card whose cells carry the names of their columns.
import type { ComponentChildren } from "preact";

export interface Column {
  label: string;
  right?: boolean;
  class?: string;
}

export interface Row {
  cells: ComponentChildren[];
  class?: string;
  /** Instead of cells: a heading over the rows that follow. */
  heading?: ComponentChildren;
}

export function DataTable({ columns, rows, class: name = "" }: { columns: Column[]; rows: Row[]; class?: string }) {
  const classOf = (column: Column) =>
    [column.right ? "r num" : "", column.class ?? ""].filter(Boolean).join(" ") || undefined;
  return (
    <table class={`data ${name}`.trim()}>
      <thead><tr>{columns.map((c) => <th key={c.label} class={c.right ? "r" : undefined}>{c.label}</th>)}</tr></thead>
      <tbody>
        {rows.map((row, i) => (row.heading !== undefined
          ? <tr key={i} class="heading"><th colSpan={columns.length}>{row.heading}</th></tr>
          : <tr key={i} class={row.class}>
            {row.cells.map((cell, c) => (
              <td key={c} class={classOf(columns[c])} data-label={columns[c].label}><div>{cell}</div></td>
            ))}
          </tr>))}
      </tbody>
    </table>
  );
}
