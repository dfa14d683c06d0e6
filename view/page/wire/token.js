// The right to control: a token in the URL's fragment, which browsers send to nobody. It is exchanged for a cookie and leaves the address bar.

/** Empty when there is none.
 * @param {string} hash of the page's address, as "#token=12ab" */
export function token_of(hash) {
  return new URLSearchParams(hash.replace(/^#/, "")).get("token") ?? "";
}

/** Hands the token in. The server says in its hello whether it was right. */
export async function redeem_token() {
  const token = token_of(location.hash);
  if (!token) return;
  history.replaceState(null, "", location.pathname + location.search);
  await fetch("/token", { method: "POST", body: token });
}
