/** A mesh as flat arrays with three numbers for each vertex and face. */
export interface MeshArrays {
  positions: ArrayLike<number>;
  faces: ArrayLike<number>;
}

/** The bytes of a file. */
export type Bytes = Uint8Array | ArrayBuffer | string;

/** A mesh: arrays, a file with its name, a `File` of the browser, or the bytes of a file, whose format is then detected from them. */
export type MeshInput = MeshArrays | { data: Bytes; name?: string } | Blob | Uint8Array | ArrayBuffer;

/**
 * Options of the command line in camel case, as `maxDiameter` for `--max-diameter`; `true` for options without a value, arrays for lists.
 * `docs/options.md` describes them.
 */
export type Options = Record<string, string | number | boolean | readonly (string | number)[] | null | undefined>;

export interface RunControl {
  /** Receives the share of the work that is done, from 0 to 1. */
  progress?: (share: number) => void;
  /** Ends the run; its promise is then rejected with the signal's reason. */
  signal?: AbortSignal;
  /** More files that the command may read, by their names, such as masks, templates and textures. */
  files?: Record<string, Bytes>;
}

/** The JSON report of the program, as `docs/json.md` describes it. */
export type Report = Record<string, any>;

export interface Answer {
  report: Report;
  /** Whether everything was done; for `check`, whether the answer is yes. */
  complete: boolean;
  /** What the program printed. */
  messages: string;
}

export interface Mended extends Answer {
  /** The bytes of the written file. */
  data: Uint8Array<ArrayBuffer>;
  /** Its name. */
  name: string;
  /** The arrays of the result, if arrays were given. */
  mesh?: { positions: Float64Array; faces: Uint32Array };
  /** Other files that were written, such as textures and patches. */
  files: Record<string, Uint8Array<ArrayBuffer>>;
}

type Mending = (mesh: MeshInput, options?: Options & { output?: string }, control?: RunControl) => Promise<Mended>;
type Asking = (mesh: MeshInput, options?: Options, control?: RunControl) => Promise<Answer>;

/** Compiles the program, which the first run does otherwise. */
export function init(source?: WebAssembly.Module | BufferSource | string | URL): Promise<void>;

/** Fills holes. */
export const fill: Mending;
/** Replaces a damaged region, which options such as `faces` or `sphere` choose. */
export const restore: Mending;
/** Smooths the surface, or a region of it. */
export const fair: Mending;
/** Repairs defects until the mesh is watertight without intersections. */
export const repair: Mending;
/** Lists the holes and properties of a mesh. */
export const inspect: Asking;
/** Lists the defects of a mesh, with one verdict. */
export const check: Asking;

/** Runs any command line on files in memory. */
export function run(
  args: readonly (string | number)[],
  control?: RunControl,
): Promise<{ code: number; stdout: string; stderr: string; files: Record<string, Uint8Array<ArrayBuffer>> }>;

/** Ends the workers that have no work. */
export function close(): void;

/** The program refused or failed. */
export class IsomendError extends Error {
  constructor(message: string, code: number);
  /** Its exit code. */
  code: number;
}
