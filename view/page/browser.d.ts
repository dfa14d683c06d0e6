// What browsers have and TypeScript 4.8's library lacks. For tsc only.
interface OffscreenCanvasRenderingContext2D extends CanvasState, CanvasTransform, CanvasCompositing, CanvasImageSmoothing, CanvasFillStrokeStyles, CanvasRect,
  CanvasDrawPath, CanvasText, CanvasDrawImage, CanvasImageData, CanvasPathDrawingStyles, CanvasTextDrawingStyles, CanvasPath {}
declare class OffscreenCanvas {
  constructor(width: number, height: number);
  width: number;
  height: number;
  getContext(kind: "2d", options?: { willReadFrequently?: boolean }): OffscreenCanvasRenderingContext2D | null;
  transferToImageBitmap(): ImageBitmap;
}
interface CanvasDrawImage {
  drawImage(image: OffscreenCanvas, x: number, y: number): void;
  drawImage(image: OffscreenCanvas, x: number, y: number, width: number, height: number): void;
}
interface Window {
  arkmesh: any;
}
