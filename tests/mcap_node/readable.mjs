// Random access to a file, as @mcap/core asks for it.
export class FileHandleReadable {
  constructor(handle) {
    this.handle = handle;
  }
  async size() {
    return BigInt((await this.handle.stat()).size);
  }
  async read(offset, length) {
    const bytes = new Uint8Array(Number(length));
    const { bytesRead } = await this.handle.read(bytes, 0, bytes.length, Number(offset));
    if (bytesRead !== bytes.length) throw new Error("a read beyond the end of the file");
    return bytes;
  }
}
