// Settings that the browser keeps from one visit to the next: language, theme, folded panels, views. They are in a cookie, since each start
// of the program has a port of its own, and all other storage of a browser belongs to a port.

const COOKIE = "isomend";
/** How long settings are kept without a visit, in seconds. */
const KEPT_FOR = 365 * 24 * 3600;

function settings() {
  const text = document.cookie.split("; ").find((part) => part.startsWith(COOKIE + "="))?.slice(COOKIE.length + 1);
  try {
    return JSON.parse(decodeURIComponent(text ?? "{}")) ?? {};
  } catch {
    return {};
  }
}

/** A setting, or `usual` if the browser keeps none. */
export const kept = (name, usual) => settings()[name] ?? usual;

/** Keeps a setting, if the browser allows it. */
export function keep(name, value) {
  const text = encodeURIComponent(JSON.stringify({ ...settings(), [name]: value }));
  document.cookie = `${COOKIE}=${text}; max-age=${KEPT_FOR}; path=/; samesite=strict`;
}
