// The pages: `vite build --mode report` makes one file without outside references; `--mode viewer|workbench` makes a folder,
// whose scripts are files of their own: their server allows no other scripts.
import { defineConfig, type UserConfig } from "vite";
import { viteSingleFile } from "vite-plugin-singlefile";

const out = process.env.SEAM_WEB_OUT ?? "dist";

export default defineConfig(({ mode }): UserConfig => {
  const folder = mode !== "report";
  return {
    base: "./",
    esbuild: { jsx: "automatic", jsxImportSource: "preact" },
    build: {
      target: "es2022",
      outDir: folder ? `${out}/${mode}` : out,
      emptyOutDir: folder,
      reportCompressedSize: false,
      assetsInlineLimit: folder ? 0 : 1_000_000,
      modulePreload: { polyfill: false },
      chunkSizeWarningLimit: 2000,
      rollupOptions: { input: `${mode}.html` },
    },
    plugins: folder ? [] : [viteSingleFile({ removeViteModuleLoader: true })],
  };
});
