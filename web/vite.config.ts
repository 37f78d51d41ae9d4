// Two pages, each one file without outside references: `vite build --mode report|viewer`.
import { defineConfig } from "vite";
import { viteSingleFile } from "vite-plugin-singlefile";

export default defineConfig(({ mode }) => ({
  base: "./",
  esbuild: { jsx: "automatic", jsxImportSource: "preact" },
  build: {
    target: "es2022",
    outDir: process.env.SEAM_WEB_OUT ?? "dist",
    emptyOutDir: false,
    reportCompressedSize: false,
    assetsInlineLimit: 1_000_000,
    rollupOptions: { input: `${mode}.html` },
  },
  plugins: [viteSingleFile({ removeViteModuleLoader: true })],
}));
