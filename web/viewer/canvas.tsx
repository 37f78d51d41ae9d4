// A canvas that fills its box at the screen's own resolution and is drawn again when a signal that
// its drawing reads has changed.
import { effect, signal, type Signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";

export interface Size {
  width: number;
  height: number;
}

export interface CanvasProps {
  name: string;
  draw: (context: CanvasRenderingContext2D, size: Size) => void;
  onPointer?: (event: PointerEvent, size: Size) => void;
  onWheel?: (event: WheelEvent, size: Size) => void;
  onDoubleClick?: () => void;
}

export function Canvas({ name, draw, onPointer, onWheel, onDoubleClick }: CanvasProps) {
  const ref = useRef<HTMLCanvasElement>(null);
  const size = useRef<Signal<Size>>(signal({ width: 0, height: 0 })).current;
  useEffect(() => {
    const canvas = ref.current!;
    const observer = new ResizeObserver(() => {
      size.value = { width: canvas.clientWidth, height: canvas.clientHeight };
    });
    observer.observe(canvas);
    const stop = effect(() => {
      const { width, height } = size.value;
      if (width < 2 || height < 2) return;
      const ratio = window.devicePixelRatio || 1;
      if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
        canvas.width = Math.round(width * ratio);
        canvas.height = Math.round(height * ratio);
      }
      const context = canvas.getContext("2d")!;
      context.setTransform(ratio, 0, 0, ratio, 0, 0);
      context.clearRect(0, 0, width, height);
      draw(context, { width, height });
      canvas.dataset.drawn = String(Number(canvas.dataset.drawn ?? 0) + 1);
    });
    return () => {
      observer.disconnect();
      stop();
    };
  }, [draw]);
  // Not a JSX handler: those are passive for wheels, and the page must not scroll instead.
  useEffect(() => {
    const canvas = ref.current!;
    if (!onWheel) return;
    const turn = (event: WheelEvent) => {
      event.preventDefault();
      onWheel(event, size.value);
    };
    canvas.addEventListener("wheel", turn, { passive: false });
    return () => canvas.removeEventListener("wheel", turn);
  }, [onWheel]);
  const pointer = onPointer && ((event: PointerEvent) => onPointer(event, size.value));
  return (
    <canvas ref={ref} class="canvas" data-name={name} onPointerDown={pointer} onPointerMove={pointer}
      onDblClick={onDoubleClick} />
  );
}

export const font = (px: number, weight = 400) => `${weight} ${px}px Inter, system-ui, sans-serif`;
