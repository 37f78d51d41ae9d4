// The rows of a measurement set as columns, and the residuals of one model (or of a preview) over the same rows.

export type Numbers = Float32Array | Float64Array | Int32Array;

/** Left-out rows and rows without a prediction have NaN as residual. */
export interface Residuals {
  channels: string[];
  r: Map<string, Numbers>;
  /** The standard error that the model states. */
  s: Map<string, Numbers>;
}

/**
 * Rows by rising value, equal ones as they stand: a radix sort in two passes of 16 bits. Sorting 100,000 rows by comparing them
 * stalls a page for a tenth of a second, this for a few milliseconds.
 */
function orderOf(values: Numbers): Uint32Array {
  const keys = new Uint32Array(values.length), bits = new Uint32Array(new Float32Array(values).buffer);
  let order = new Uint32Array(values.length), n = 0;
  for (let i = 0; i < values.length; ++i) {
    if (!Number.isFinite(values[i])) continue;
    // As whole numbers in the order of the values; -0 equals 0.
    keys[i] = values[i] < 0 ? ~bits[i] : bits[i] | 0x80000000;
    order[n++] = i;
  }
  order = order.subarray(0, n);
  for (const shift of [0, 16]) {
    const starts = new Uint32Array(65537), next = new Uint32Array(n);
    for (let k = 0; k < n; ++k) ++starts[((keys[order[k]] >>> shift) & 65535) + 1];
    for (let digit = 0; digit < 65536; ++digit) starts[digit + 1] += starts[digit];
    for (let k = 0; k < n; ++k) next[starts[(keys[order[k]] >>> shift) & 65535]++] = order[k];
    order = next;
  }
  return order;
}

export interface Names {
  names?: Record<string, string[]>;
  places?: { name: string; x: number; y: number }[];
}

export class Rows {
  readonly n: number;
  /** Names that columns of numbers stand for, and landmarks. */
  readonly words: Names;
  private readonly columns: Map<string, Numbers>;
  private readonly measured: Map<string, Numbers>;
  private readonly orders = new Map<string, Uint32Array>();

  constructor(n: number, columns: Map<string, Numbers>, measured = new Map<string, Numbers>(), words: Names = {}) {
    this.n = n;
    this.columns = columns;
    this.measured = measured;
    this.words = words;
  }

  /** What was measured or commanded, by its name in the set's files. */
  data(name: string): Numbers | undefined {
    return this.measured.get(name);
  }

  get names(): string[] {
    return [...this.columns.keys()];
  }

  has(name: string): boolean {
    return this.column(name) !== undefined;
  }

  /** A column, or a product or a sign of columns, such as row*sign(pan_rate). */
  column(name: string): Numbers | undefined {
    const known = this.columns.get(name);
    if (known) return known;
    const made = name.includes("*") ? this.product(name.split("*"))
      : name.startsWith("sign(") ? this.signs(name.slice(5, -1)) : undefined;
    if (made) this.columns.set(name, made);
    return made;
  }

  private product(factors: string[]): Numbers | undefined {
    const columns = factors.map((factor) => this.column(factor));
    if (columns.some((column) => column === undefined)) return undefined;
    const product = new Float32Array(this.n).fill(1);
    for (const column of columns) for (let i = 0; i < this.n; ++i) product[i] *= column![i];
    return product;
  }

  private signs(name: string): Numbers | undefined {
    const column = this.column(name);
    return column && Float32Array.from(column, Math.sign);
  }

  /** Rows by rising value of a column; rows without a value are left out. */
  order(name: string): Uint32Array {
    let order = this.orders.get(name);
    if (!order) {
      order = orderOf(this.column(name)!);
      this.orders.set(name, order);
    }
    return order;
  }
}
