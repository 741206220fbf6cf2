// What follows the # of the address; the browser never sends it to anybody by itself.
export function token() {
  return new URLSearchParams(location.hash.slice(1)).get("token");
}
