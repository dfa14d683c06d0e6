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
interface VideoEncoderConfig {
  codec: string;
  width: number;
  height: number;
  framerate: number;
  bitrate: number;
  latencyMode: string;
  avc: { format: string };
}
declare class VideoFrame {
  constructor(image: OffscreenCanvas, how: { timestamp: number });
  close(): void;
}
declare class VideoEncoder {
  constructor(to: { output: (chunk: { byteLength: number; copyTo(bytes: Uint8Array): void }) => void; error: (why: DOMException) => void });
  static isConfigSupported(config: VideoEncoderConfig): Promise<{ supported: boolean }>;
  encodeQueueSize: number;
  configure(config: VideoEncoderConfig): void;
  encode(frame: VideoFrame, how: { keyFrame: boolean }): void;
  flush(): Promise<void>;
}
interface OffscreenCanvasRenderingContext2D {
  readonly canvas: OffscreenCanvas;
}
interface Window {
  VideoEncoder?: typeof VideoEncoder;
  arkmesh: any;
}
