// A binary table of the server: the length of its head (4 bytes, little-endian), the head as JSON, then columns of 32-bit
// floats in the head's order.
import { Rows, type Numbers, type Residuals, type Names } from "./rows";

export interface Table {
  head: { n: number; columns: string[]; channels: string[] } & Names;
  columns: Map<string, Numbers>;
}

/** What a binary answer begins with, and where the rest begins. */
export function headOf<T>(buffer: ArrayBuffer): { json: T; end: number } {
  const length = new DataView(buffer).getUint32(0, true);
  return { json: JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length))) as T, end: 4 + length };
}

export function decode(buffer: ArrayBuffer): Table {
  const { json: head, end } = headOf<Table["head"]>(buffer);
  const columns = new Map<string, Numbers>();
  let at = end;
  for (const name of head.columns) {
    columns.set(name, new Float32Array(buffer, at, head.n));
    at += 4 * head.n;
  }
  return { head, columns };
}

const isResidual = (name: string) => name.startsWith("r:") || name.startsWith("s:");

const isMeasured = (name: string) => name.startsWith("d:");

export function rowsOf({ head, columns }: Table): Rows {
  const all = [...columns];
  return new Rows(head.n, new Map(all.filter(([name]) => !isResidual(name) && !isMeasured(name))),
    new Map(all.filter(([name]) => isMeasured(name)).map(([name, values]) => [name.slice(2), values])), head);
}

/** Of a preview a stated error is left out where it is as `before`. */
export function residualsOf({ head, columns }: Table, before?: Residuals): Residuals {
  const part = (mark: "r" | "s") => new Map(head.channels.map((name) => [name, columns.get(`${mark}:${name}`) ?? before?.[mark].get(name)!]));
  // Radial and tangential parts are the image's residuals once more: they take no part in sums over channels.
  return { channels: head.channels.filter((name) => !/^(radial|tangential)_/.test(name)), r: part("r"), s: part("s") };
}
