// What a match of any length is read by: pieces of a few seconds, loaded when the time comes near
// them, the least recently used forgotten.
import { signal } from "@preact/signals";

interface Entry<T> {
  value?: T;
  error?: string;
  used: number;
}

export class Chunks<T> {
  /** Counts arrivals: what draws from chunks reads it, to be drawn again. */
  readonly arrivals = signal(0);
  private readonly entries = new Map<number, Entry<T>>();
  private clock = 0;

  constructor(
    readonly length_s: number,
    private readonly load: (from: number, to: number) => Promise<T>,
    private readonly most = 24,
  ) {}

  /** The chunk that holds `t`, or undefined while it is on its way. */
  at(t: number): T | undefined {
    return this.get(Math.floor(Math.max(0, t) / this.length_s));
  }

  /** All loaded chunks that touch [from, to]; the missing ones are asked for. */
  within(from: number, to: number): T[] {
    const found: T[] = [];
    const last = Math.floor(Math.max(0, to) / this.length_s);
    for (let i = Math.floor(Math.max(0, from) / this.length_s); i <= last; ++i) {
      const value = this.get(i);
      if (value !== undefined) found.push(value);
    }
    return found;
  }

  /** True when `t` cannot be shown yet, but may be soon. */
  pending(t: number): boolean {
    const entry = this.entries.get(Math.floor(Math.max(0, t) / this.length_s));
    return entry === undefined || (entry.value === undefined && entry.error === undefined);
  }

  private get(index: number): T | undefined {
    let entry = this.entries.get(index);
    if (!entry) {
      entry = { used: 0 };
      this.entries.set(index, entry);
      this.fill(index, entry);
      this.forget();
    }
    entry.used = ++this.clock;
    return entry.value;
  }

  private fill(index: number, entry: Entry<T>): void {
    this.load(index * this.length_s, (index + 1) * this.length_s)
      .then((value) => {
        entry.value = value;
      })
      .catch((error: Error) => {
        entry.error = error.message;
      })
      .finally(() => {
        this.arrivals.value += 1;
      });
  }

  private forget(): void {
    if (this.entries.size <= this.most) return;
    const [oldest] = [...this.entries].sort((a, b) => a[1].used - b[1].used)[0];
    this.entries.delete(oldest);
  }
}
