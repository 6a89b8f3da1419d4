// The unfinished work of a page, by kind, for programs that wait for it. The page's root element has the attribute `data-pending` with the
// kinds of unfinished work, and `data-ready` while there is none.

/** The number of unfinished pieces of work of each kind. */
const unfinished = new Map();

/** Adds to the number of unfinished pieces of work of a kind, and sets the attributes if the kinds change. */
function tally(kind, by) {
  const number = (unfinished.get(kind) ?? 0) + by, changes = (number === 0) === unfinished.has(kind);
  if (number) unfinished.set(kind, number);
  else unfinished.delete(kind);
  if (!changes) return;
  const root = document.documentElement;
  root.dataset.pending = [...unfinished.keys()].sort().join(" ");
  root.toggleAttribute("data-ready", !unfinished.size);
}

/** Whether work of a kind is unfinished. */
export const isPending = (kind) => unfinished.has(kind);

/** Begins a piece of work: frame, motion, flight, labels, request, worker or job. Returns a function that ends it; later calls do nothing. */
export function begun(kind) {
  let ends = false;
  tally(kind, 1);
  return () => {
    if (!ends) tally(kind, -1);
    ends = true;
  };
}

/** Runs asynchronous work that is pending until its promise is settled. */
export async function during(kind, work) {
  const end = begun(kind);
  try {
    return await work();
  } finally {
    end();
  }
}
