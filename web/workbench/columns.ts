// A binary table of the server: the length of its head (4 bytes, little-endian), the head as JSON, then columns of 32-bit
// floats in the head's order.
import { Rows, type Numbers, type Residuals } from "./rows";

export interface Table {
  head: { n: number; columns: string[]; channels: string[] };
  columns: Map<string, Numbers>;
}

export function decode(buffer: ArrayBuffer): Table {
  const length = new DataView(buffer).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length))) as Table["head"];
  const columns = new Map<string, Numbers>();
  let at = 4 + length;
  for (const name of head.columns) {
    columns.set(name, new Float32Array(buffer, at, head.n));
    at += 4 * head.n;
  }
  return { head, columns };
}

const isResidual = (name: string) => name.startsWith("r:") || name.startsWith("s:");

export function rowsOf({ head, columns }: Table): Rows {
  return new Rows(head.n, new Map([...columns].filter(([name]) => !isResidual(name))));
}

export function residualsOf({ head, columns }: Table): Residuals {
  const part = (mark: string) => new Map(head.channels.map((name) => [name, columns.get(`${mark}:${name}`)!]));
  // Radial and tangential parts are the image's residuals once more: they take no part in sums over channels.
  return { channels: head.channels.filter((name) => !/^(radial|tangential)_/.test(name)), r: part("r"), s: part("s") };
}
